// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "backends/boundary/stl_facet.h"
#include "base/hash.h"
#include "base/input_file.h"
#include "base/jail.h"
#include "base/say.h"
#include "base/text.h"
#include "mesh/read/zip_file.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/verify_files.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

using Header = std::array<uint8_t, boundary::kStlHeaderBytes>;

Result<size_t> read_header(const InputFile& file, Header* header) {
    return file.read(0, header->data(), header->size());
}

/// What stands behind the name of the output in that of a file of it, or what its title has room for; empty in the
/// titles of others.
std::string material_of(const Header& header) {
    constexpr std::string_view kWhole = "STL in mm, material ", kPart = "STL in mm, slices ";
    std::string_view title(reinterpret_cast<const char*>(header.data()),
                           boundary::kStlOwnTitleBytes);
    size_t at = title.starts_with(kWhole) ? kWhole.size() : std::string_view::npos;
    if (title.starts_with(kPart)) {
        const size_t comma = title.find(", ", kPart.size());
        if (comma != std::string_view::npos) at = comma + 2;
    }
    if (at == std::string_view::npos) return {};
    title.remove_prefix(at);
    title = title.substr(0, title.find_last_not_of(std::string_view(" \0", 2)) + 1);
    return boundary::safe_file_name(std::string(title));
}

/// The length of the output's name in that of a file of it.
std::optional<size_t> length_of_output(const fs::path& file, const Header& header) {
    const std::string material = material_of(header);
    const size_t at =
        material.empty() ? std::string::npos : file.stem().string().rfind("_" + material);
    return at == std::string::npos ? std::nullopt : std::optional(at);
}

/// Returns a file beside this one that has a name of the same output, and is of another print.
std::optional<fs::path> other_beside(const fs::path& file, const Header& header) {
    const std::optional<size_t> length = length_of_output(file, header);
    const std::optional<boundary::StlMarks> own = boundary::stl_marks(header);
    if (!length || !own) return {};
    const std::string output = file.stem().string().substr(0, *length);
    const fs::path folder = file.parent_path().empty() ? "." : file.parent_path();
    std::error_code ended;
    for (fs::directory_iterator at(folder, ended); !ended && at != fs::directory_iterator();
         at.increment(ended)) {
        const fs::path& other = at->path();
        if (other.extension() != file.extension() ||
            other.stem().string().substr(0, *length) != output)
            continue;
        const Result<InputFile> opened = InputFile::open(other);
        Header its{};
        if (!opened) continue;
        const Result<size_t> read = read_header(*opened, &its);
        if (!read || *read != its.size() || length_of_output(other, its) != length) continue;
        const std::optional<boundary::StlMarks> marks = boundary::stl_marks(its);
        if (marks && marks->print != own->print) return other;
    }
    return {};
}

/// What a mesh says of itself: the title of an STL, the beginning of a 3MF's model.
Result<std::string> words_of(const std::string& name, int64_t memory_bytes) {
    const Result<InputFile> file = InputFile::open(name);
    if (!file) return file.error();
    if (!lower_ascii(name).ends_with(".3mf")) {
        Header header{};
        const Result<size_t> read = read_header(*file, &header);
        if (!read) return read.error();
        return std::string(reinterpret_cast<const char*>(header.data()), *read);
    }
    const Result<std::string> bytes = file->read_all(memory_bytes);
    if (!bytes) return bytes.error();
    const Result<mesh::ZipFile> zip = mesh::ZipFile::open(*bytes, name);
    if (!zip) return zip.error();
    const Result<std::string> model = zip->read("3D/3dmodel.model", memory_bytes);
    constexpr size_t kHead = 1 << 12;
    return model ? model->substr(0, kHead) : model;
}

}  // namespace

std::string part_of_mesh(const std::string& name, int64_t memory_bytes) {
    const Result<std::string> words = read_in_jail<std::string>(
        name, limits_of_header(name, memory_bytes), [&]() { return words_of(name, memory_bytes); });
    if (!words) return {};
    int begin = 0, end = 0, of = 0;
    constexpr int kNumbers = 3;
    constexpr const char* kDescription = "name=\"Description\">slices ";
    const size_t at = words->find(kDescription);
    if (at != std::string::npos) {
        const char* const text = words->c_str() + at + std::strlen(kDescription);
        if (std::sscanf(text, "%d to %d of %d<", &begin, &end, &of) != kNumbers) return {};
        ++end;
    } else if (std::sscanf(words->c_str(), "STL in mm, slices %d:%d of %d,", &begin, &end, &of) !=
               kNumbers) {
        return {};
    }
    return fmt::format(messages::kAreSlicesOfWhole, begin, end - 1, of);
}

Result<void> verify_stl(const std::string& name) {
    const Result<InputFile> file = InputFile::open(name);
    if (!file) return with_context(file.error(), fmt::format(messages::kCannotReadFile, name));
    Header header{};
    const Result<size_t> read = read_header(*file, &header);
    if (!read) return read.error();
    uint32_t triangles = 0;
    std::memcpy(&triangles, header.data() + boundary::kStlTitleBytes, sizeof triangles);
    const int64_t bytes = static_cast<int64_t>(boundary::kStlHeaderBytes) +
                          int64_t{triangles} * static_cast<int64_t>(boundary::kStlFacetBytes);
    if (*read != header.size() || file->bytes() != bytes)
        return user_error(fmt::format(messages::kMeshTooShort, name, file->bytes(), bytes));
    const std::optional<boundary::StlMarks> recorded = boundary::stl_marks(header);
    if (!recorded) {
        say(fmt::format(messages::kMeshWithoutDigest, printable(name), triangles));
        return {};
    }
    Hasher hash;
    std::vector<uint8_t> piece(1 << 20);
    for (int64_t at = boundary::kStlHeaderBytes; at < bytes;) {
        const Result<size_t> some = file->read(at, piece.data(), piece.size());
        if (!some) return some.error();
        if (*some == 0) return user_error(fmt::format(messages::kMeshTooShort, name, at, bytes));
        hash.add_bytes(piece.data(), *some);
        at += static_cast<int64_t>(*some);
    }
    if (hash.value() != recorded->digest)
        return user_error(fmt::format(messages::kMeshDiffers, name));
    if (const std::optional<fs::path> other = other_beside(name, header))
        return user_error(fmt::format(messages::kMeshOfOtherPrint, other->string(), name));
    say(fmt::format(messages::kMeshWhole, printable(name), triangles));
    return {};
}

}  // namespace openfab::tools
