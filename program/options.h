// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The command line of print binaries and of `openfab print`.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "backends/preview/preview_spec.h"
#include "base/result.h"
#include "base/units.h"
#include "base/vec.h"
#include "program/progress.h"

namespace openfab::program {

/// The best instruction set that fablets are compiled for, unless more is asked for:
/// docs/measurements/avx512.md tells why it is not AVX-512.
constexpr openfab_isa kUsualIsa = OPENFAB_ISA_AVX2;

/// A file or folder that a command writes, with the option that named it: "`-o`".
struct NamedOutput {
    std::string option;
    std::filesystem::path path;
};

/// The largest --fractions-supersample: 32768 times as many voxels are enough.
constexpr int32_t kMostSupersampling = 32;

struct Options {
    std::string input;   ///< a world (.fab.json) or a mesh
    std::string output;  ///< empty: none; `-` standard output; or an address (stream/address.h)
    std::string process_file;    ///< items of the machine's process that replace the profile's
    std::string bleed = "undo";  ///< or show, both, off
    std::string nozzles_file;    ///< dead nozzles; read again where it changes during a print
    std::string token_file;      ///< of a receiver that wants a token
    std::string tls_ca;          ///< certificates to trust; empty: the system's
    std::string printer;
    std::string format;  ///< empty: from the output's extension, else the printer's own
    std::optional<double> voxel_mm;
    std::optional<Vec2<double>> dpi;
    std::optional<double> layer_mm;
    std::optional<double> mesh_pitch_mm;  ///< for stl and 3mf
    std::optional<Vec3d> pitch_mm;        ///< of a print that was made already; no draft of it
    std::optional<Vec3d> probe_mm;        ///< evaluate the voxel at this point of build space alone
    int32_t draft = 1;
    std::optional<Vec2<double>> z_range_mm;
    std::optional<Vec2<int32_t>> slices;
    int64_t memory_bytes = kDefaultMemoryBytes;
    bool memory_given =
        false;  ///< otherwise a print that needs more gets it, if the machine has it
    int32_t threads = 0;
    std::string dither;  ///< empty: majority for meshes, else the pipeline's own
    uint64_t seed = 0;
    std::vector<std::string> settings;  ///< `OBJECT.UNIFORM=VALUE`, read by part::bind
    std::string support;  ///< on, off or a material of the world; empty: as world and printer say
    bool crop_tray = false;  ///< the grid is the tray, not the box of the parts
    /// Folders that the world may read besides its own, and kProgramsWord where its programs may run.
    std::vector<std::string> allow;
    std::vector<preview::PreviewSpec> previews;
    program::ProgressMode progress = program::ProgressMode::kAuto;
    std::string stats_file;
    std::string fractions_file;  ///< takes mixtures before the dither; empty: none
    /// Parts of a voxel's side that they are the means of; 0: as `sampling` says.
    int32_t fractions_supersample = 0;
    bool sample_centres = false;      ///< --sampling centre: fractions are those at voxels' centres
    std::vector<std::string> inputs;  ///< files besides the world's that outputs must not overwrite
    std::vector<NamedOutput> more_outputs;  ///< files that the host writes at its end
    std::string grey_material;              ///< that grey pictures are of; empty: the first
    bool png_indexed = false;               ///< with a palette instead of RGBA
    bool flip_x = false;
    bool resume = false;  ///< continues an interrupted print in the output
    bool estimate = false;
    bool dry_run = false;
    bool culling = true;  ///< this and the next two are for tests; the output never depends on them
    int32_t slabs_in_flight = 0;
    std::optional<openfab_isa> isa;  ///< the best to use
    bool help = false;               ///< show `text` and do nothing else
    std::string text;
};

/// Parses the command line; `argv[0]` is the program. Errors have the code kUsage; so has a command
/// line without any output, unless the host takes the slices itself; then the help leaves out what asks
/// for outputs.
Result<Options> parse_options(int argc, const char* const* argv, const std::string& program,
                              bool needs_output = true);

/// Default pitch of the voxels that meshes are made from.
constexpr double kMeshPitchMm = 0.1;

/// Returns whether any option sets a pitch.
bool pitch_is_given(const Options& options);

/// Returns the pitch of a print: from the options, else the printer's, times --draft. Printers that
/// take meshes do not print the voxels these are made from, so meshes have a pitch of their own.
Vec3d print_pitch(const Options& options, const Vec3d& printer_pitch_mm, bool to_meshes = false);

}  // namespace openfab::program
