// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/load/load_beams.h"

#include <fmt/format.h>

#include "base/input_file.h"
#include "base/text.h"
#include "mesh/load/jailed.h"
#include "mesh/model/messages.h"
#include "mesh/read/beams_npz.h"
#include "mesh/read/beams_text.h"
#include "mesh/read/threemf_beams.h"

namespace openfab::mesh {

namespace {

void scale(double unit_mm, Beams* beams) {
    for (Vec3d& node : beams->nodes)
        node = node * unit_mm;
    for (Beam& beam : beams->beams) {
        for (float& r : beam.radii)
            r = static_cast<float>(static_cast<double>(r) * unit_mm);
    }
}

Result<std::string> read_bytes(const std::filesystem::path& file, int64_t memory_bytes) {
    const auto with_name = [&](const Error& error) {
        return with_context(error, file.string() + ": ");
    };
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return with_name(opened.error());
    Result<std::string> bytes = opened->read_all(memory_bytes);
    if (!bytes) return with_name(bytes.error());
    return bytes;
}

bool is_threemf(const std::filesystem::path& file) {
    return lower_ascii(file.extension().string()) == ".3mf";
}

Result<ReadBeams> parse(std::string_view bytes, const std::filesystem::path& file,
                        const BeamOptions& options) {
    if (is_threemf(file))
        return parse_threemf_beams(bytes, file.string(), options.body, options.memory_bytes);
    if (!options.body.empty())
        return user_error(fmt::format(messages::kLatticeNamesOf3mf, file.string()),
                          messages::kLatticeNamesOf3mfHelp);
    // Archives are told by their first bytes.
    if (lower_ascii(file.extension().string()) == ".npz" || bytes.starts_with("PK"))
        return parse_beams_npz(bytes, file.string(), options.memory_bytes);
    return parse_beams(bytes, file, options.memory_bytes);
}

Result<LoadedLattices> read_lattices(const std::filesystem::path& file,
                                     const BeamOptions& options) {
    LoadedLattices out;
    const Result<std::string> bytes = read_bytes(file, options.memory_bytes);
    if (!bytes) return bytes.error();
    Result<ReadThreemfBeams> read =
        parse_threemf_beams(*bytes, file.string(), options.memory_bytes);
    if (!read) return read.error();
    out.unit_mm = options.unit_mm.value_or(read->unit_mm);
    out.has_meshes = read->has_meshes;
    out.left_out = std::move(read->left_out);
    for (ThreemfBeams& one : read->lattices) {
        if (out.unit_mm != 1) scale(out.unit_mm, &one.beams);
        out.lattices.push_back({std::move(one.name), std::move(one.sets), box_of(one.beams),
                                static_cast<int64_t>(one.beams.beams.size())});
    }
    return out;
}

}  // namespace

Result<LoadedBeams> load_beams(const std::filesystem::path& file, const BeamOptions& options) {
    return beams_from_jail(file, options.memory_bytes, [&]() -> Result<LoadedBeams> {
        const Result<std::string> bytes = read_bytes(file, options.memory_bytes);
        if (!bytes) return bytes.error();
        Result<ReadBeams> read = parse(*bytes, file, options);
        if (!read) return read.error();
        const double unit = options.unit_mm.value_or(read->unit_mm);
        if (unit != 1) scale(unit, &read->beams);
        return LoadedBeams{std::move(read->beams), std::move(read->warnings)};
    });
}

Result<LoadedLattices> load_lattices(const std::filesystem::path& file,
                                     const BeamOptions& options) {
    if (!is_threemf(file)) return LoadedLattices{};
    return lattices_from_jail(file, options.memory_bytes,
                              [&] { return read_lattices(file, options); });
}

}  // namespace openfab::mesh
