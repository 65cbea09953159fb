// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/optional_converter.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <system_error>
#include <vector>

#include "base/input_file.h"
#include "base/jail.h"
#include "base/start_program.h"
#include "base/text.h"
#include "texture/volume.h"
#include "texture/xdmf_grid.h"
#include "tools/texture/hdf5_kind.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr OptionalConverter kDicom{"openfab-texture-dicom", "DICOM", messages::kSetupDicom};
constexpr OptionalConverter kOpenVdb{"openfab-texture-vdb", "OpenVDB", messages::kSetupVdb};

constexpr OptionalConverter kHdf5{"openfab-texture-hdf5", "HDF5", messages::kSetupHdf5};

bool has_hdf(const fs::path& path, const texture::VolumeOptions& options) {
    const texture::ReadLimits limits;
    const Result<bool> has = read_in_jail<bool>(
        path, limits_of_header(path, limits.memory_bytes), [&]() -> Result<bool> {
            const Result<InputFile> file = InputFile::open(path);
            if (!file) return file.error();
            const Result<texture::XdmfGrid> grid =
                texture::read_xdmf_grid(*file, options.time, options.field, limits);
            return grid ? Result<bool>(grid->has_hdf()) : grid.error();
        });
    return has && *has;
}

const OptionalConverter* by_content(const fs::path& path) {
    constexpr size_t kDicomMark = 128;
    std::array<char, kDicomMark + 4> head{};
    const Result<InputFile> file = InputFile::open(path);
    if (!file) return nullptr;
    const Result<size_t> got = file->read(0, head.data(), head.size());
    if (!got) return nullptr;
    const std::string_view bytes(head.data(), *got);
    if (bytes.starts_with(" BDV")) return &kOpenVdb;
    return bytes.ends_with("DICM") && bytes.size() == head.size() ? &kDicom : nullptr;
}

}  // namespace

const OptionalConverter* optional_converter(const fs::path& volume,
                                            const texture::VolumeOptions& options) {
    const Result<std::vector<fs::path>> files = texture::volume_files(volume);
    if (!files) return nullptr;
    // Any of them: a scan's folder may begin with dozens of notes and pictures.
    for (const fs::path& file : *files) {
        if (const OptionalConverter* found = by_content(file)) return found;
    }
    if (texture::is_xdmf(files->front()))
        return has_hdf(files->front(), options) ? &kHdf5 : nullptr;
    if (const Result<InputFile> file = InputFile::open(files->front()); file && is_vtk_hdf(*file))
        return &kHdf5;
    const std::string kind = lower_ascii(files->front().extension().string());
    if (kind == ".vdb") return &kOpenVdb;
    return kind == ".dcm" ? &kDicom : nullptr;
}

Error execute(const OptionalConverter& converter, char** argv) {
    const Result<fs::path> folder = program_folder();
    if (!folder) return folder.error();
    const fs::path program = *folder / converter.program;
    if (::access(program.c_str(), X_OK) != 0) {
        Error error = outside_error(fmt::format(messages::kBuiltWithoutReader, converter.what));
        error.help = converter.remedy;
        return error;
    }
    ::execv(program.c_str(), argv);
    return outside_error(
        fmt::format(messages::kCannotStart, program.string(), std::strerror(errno)));
}

}  // namespace openfab::tools
