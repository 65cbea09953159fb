// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the slices go: the sink that the options ask for, with previews as observers.

#include <memory>
#include <string>

#include "program/options.h"
#include "runtime/pipeline/slice_sink.h"
#include "world/printer.h"

namespace openfab::print {

/// Whether it is boundary meshes ("stl", "3mf") that are written.
bool is_mesh_format(const std::string& format);

/// "ofr", "png", "stl" or "3mf": what was asked for, else by OUT's extension, else the printer's
/// own. An extension that contradicts, or a format that there is not, is a usage error. Empty where
/// nothing is written but previews.
Result<std::string> choose_format(const Options& options, const scene::Printer& printer);

/// Opens the output; an existing one is replaced, or resumed.
Result<std::unique_ptr<backends::SliceSink>> open_output(const Options& options,
                                                         const scene::Printer& printer);

/// Whether `--resume` can go on with what a print into this output leaves: it is a file or a folder
/// of slices.
bool can_be_resumed(const Options& options, const std::string& format);

/// What of --memory the output takes for each voxel of a slice.
int64_t output_bytes_per_column(const std::string& format);

/// The same, while a slice is encoded.
int64_t encode_bytes_per_column(const Options& options, const std::string& format);

/// What of --memory the previews take; the rest is the pipeline's.
int64_t preview_bytes(const Options& options);

}  // namespace openfab::print
