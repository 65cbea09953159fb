// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a print is asked for. The command line of print binaries and of `openfab print` makes Options
// of words, the Python package of arguments; either has them checked by validate_options.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "backends/job/option_words.h"
#include "base/result.h"
#include "base/vec.h"
#include "program/grid_options.h"
#include "program/output_options.h"
#include "program/run_options.h"

namespace openfab::program {

/// The largest --around.
constexpr int32_t kMostAround = 64;

/// For programs that ask about a world what is not in its file.
struct AlteredWorld {
    bool solid = false;  ///< all voxels are of the first material
    int32_t around = 0;  ///< so many voxels more lie around the grid
    /// Of the only object: its fablet fills a box of this size in place of the build, moved there.
    std::optional<Vec3d> cell_mm, cell_at_mm;
    std::string field;  ///< `NAME=FILE`: the texture is that volume, clamped and trilinear
    std::optional<Vec3d> field_origin_mm, field_spacing_mm;
    std::optional<Vec3d> lattice_mm;  ///< as PrintInput
};

struct Options : GridOptions, OutputOptions, RunOptions {
    std::string input;  ///< a world (.fab.json) or a mesh
    /// Folders that the world may read besides its own, and kProgramsWord where its programs may run.
    std::vector<std::string> allow;
    std::string only_object;            ///< the one whose voxels are printed; empty: all
    std::vector<std::string> settings;  ///< `OBJECT.UNIFORM=VALUE`, read by part::bind
    std::string printer;
    std::string process_file;  ///< items of the machine's process that replace the profile's
    /// What the machine will make of the print, not what is sent to it: without the process' scale and
    /// field, and with effects on voxels as their options say.
    bool as_built = false;
    AlteredWorld altered;
    std::map<std::string, std::string>
        effects;          ///< what is asked of those of the machine, by option
    std::string support;  ///< on, off or a material of the world; empty: as world and printer say
    std::string dither;   ///< empty: majority for meshes, else the pipeline's own
    uint64_t seed = 0;
    std::vector<job::OptionWords> words;  ///< as given, INPUT too; none where no command line was
    bool help = false;                    ///< show `text` and do nothing else
    std::string text;
};

/// Parses the command line; `argv[0]` is the program. Errors have the code kUsage; so has a command
/// line without any output, unless the host takes the slices itself; then the help leaves out what asks
/// for outputs.
Result<Options> parse_options(int argc, const char* const* argv, const std::string& program,
                              bool needs_output = true);

/// Fails with a usage error where a value is out of its range, or options exclude each other, whoever made
/// them. Messages name options as the command line does.
Result<void> validate_options(const Options& options);

}  // namespace openfab::program
