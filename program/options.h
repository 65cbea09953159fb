// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The command line of print binaries, which `openfab print` shares.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "backends/preview/preview_spec.h"
#include "base/result.h"
#include "base/vec.h"
#include "program/progress.h"

namespace openfab::print {

struct Options {
    std::string input;   ///< a world (.fab.json) or a mesh
    std::string output;  ///< empty: none; `-` standard output
    std::string printer;
    std::string format;  ///< empty: from the output's extension, else the printer's own
    std::optional<double> voxel_mm;
    std::optional<Vec2<double>> dpi;
    std::optional<double> layer_mm;
    std::optional<double> mesh_pitch_mm;  ///< of stl and 3mf
    int32_t draft = 1;
    std::optional<Vec2<double>> z_range_mm;
    std::optional<Vec2<int32_t>> slices;
    int64_t memory_bytes = 1'500'000'000;
    int32_t threads = 0;
    std::string dither;  ///< empty: majority for meshes, else the pipeline's own
    uint64_t seed = 0;
    std::vector<std::string> settings;  ///< `OBJECT.UNIFORM=VALUE`, read by scene::bind
    std::string support;  ///< on, off or a material of the world; empty: as world and printer say
    bool crop_tray = false;          ///< the grid is the tray, not the box of the parts
    std::vector<std::string> allow;  ///< folders that the world may read besides its own
    std::vector<preview::PreviewSpec> previews;
    report::ProgressMode progress = report::ProgressMode::kAuto;
    std::string stats_file;
    std::vector<std::string> inputs;  ///< files that outputs must leave alone besides the world's
    bool png_indexed = false;
    bool flip_x = false;
    bool resume = false;  ///< continues what an earlier print has left in the output
    bool estimate = false;
    bool dry_run = false;
    bool culling = true;  ///< this and the next two are for tests; the output never depends on them
    int32_t groups_in_flight = 0;
    openfab_isa isa = OPENFAB_ISA_AVX2;
    bool help = false;  ///< `text` is to be shown, nothing else done
    std::string text;
};

/// `argv[0]` is the program. Errors have the code kUsage.
Result<Options> parse_options(int argc, const char* const* argv, const std::string& program);

/// Of the voxels that meshes are made from, unless told.
constexpr double kMeshPitchMm = 0.1;

/// Whether any option says a pitch.
bool pitch_is_given(const Options& options);

/// The pitch of a print: what was asked for, else the printer's, times --draft. Printers that take
/// meshes do not print the voxels that these are made from, so meshes have a pitch of their own.
Vec3d print_pitch(const Options& options, const Vec3d& printer_pitch_mm, bool to_meshes = false);

}  // namespace openfab::print
