// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Opens the outputs of a print: the sink that the options select, with previews as observers.

#include <filesystem>
#include <memory>
#include <string>

#include "backends/common/format.h"
#include "program/output_options.h"
#include "runtime/pipeline/print_statistics.h"
#include "runtime/pipeline/slice_sink.h"
#include "world/printer.h"

namespace openfab::program {

struct GridOptions;

/// Returns whether the format is one of boundary meshes; false for null.
bool is_mesh_format(const backends::Format* format);

/// Returns whether a print in the format has its mixtures: their colours on its faces, which the machine takes, or filaments that
/// a slicer mixes.
bool has_mesh_colors(const backends::Format* format, const world::Printer& printer);

/// Returns the warning for mixtures that the meshes of an output do not have, or whose colours they estimate; empty where
/// none were lost, or the rule of the dither, `dither`, was chosen.
std::string lost_mixtures(const pipeline::PrintStatistics& statistics, const std::string& dither,
                          const backends::Format* format, const world::Printer& printer);

/// Returns the warning for materials of the print that are not in its grey pictures, which are of one; empty where
/// there are none, or that one, `grey_material`, was chosen.
std::string left_out_of_grey(const pipeline::PrintStatistics& statistics,
                             const pipeline::PrintInfo& info, const std::string& grey_material,
                             const backends::Format* format);

/// Returns the format of the output: from --format, else by OUT's extension, else the printer's
/// own; null where only previews are written. Fails with a usage error for an extension that
/// contradicts, an unknown format, or what the format cannot do.
Result<const backends::Format*> choose_format(const OutputOptions& options,
                                              const world::Printer& printer);

/// Fails where a pitch of meshes is given to an output that is none.
Result<void> check_mesh_pitch(const GridOptions& options, const backends::Format* format);

/// Opens the output; an existing one is replaced, or resumed. Once `interrupt` is set, if there is one,
/// it waits for nobody. Through `mixtures`, if there is one, it gets the fractions of the print, for their colours.
Result<std::unique_ptr<pipeline::SliceSink>> open_output(
    const OutputOptions& options, const world::Printer& printer,
    const std::atomic<bool>* interrupt = nullptr, backends::MixtureInlet* mixtures = nullptr);

/// Returns a sink that encodes slices as that of open_output does and keeps none, for outputs whose
/// slices are encoded in other processes than the one that writes them. Fails for formats that are
/// not slice by slice.
Result<std::unique_ptr<pipeline::SliceSink>> make_encoder(const OutputOptions& options,
                                                          const world::Printer& printer,
                                                          const backends::Format& format);

/// Returns whether `--resume` can continue a print into this output: a file, a folder of slices, or
/// a receiver.
bool can_be_resumed(const OutputOptions& options, const backends::Format& format);

/// Returns the path of an output of this format in a folder of its own.
std::string output_in(const std::filesystem::path& folder, const backends::Format& format);

/// Returns the memory of the output for each voxel of a slice, for so many materials; 0 for null.
int64_t output_bytes_per_column(const backends::Format* format, size_t materials);

/// Returns the memory of slices that wait for a receiver.
int64_t queue_bytes(const OutputOptions& options);

/// Returns the memory of the previews; the pipeline gets the rest of --memory.
int64_t preview_bytes(const OutputOptions& options);

}  // namespace openfab::program
