// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// No output of a print takes the place of what the print is made from, or of another output.

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "program/options.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::print {

/// A file that a command writes, or a folder that it fills, as it was named: "`-o`".
struct NamedOutput {
    std::string option;
    std::filesystem::path path;
};

/// Every file that a print with these options writes, temporary names included; of `format` stl one
/// for each material. The slices of a folder are not listed, see check_outputs.
std::vector<NamedOutput> outputs_of(const Options& options, const std::string& format,
                                    const std::vector<backends::SliceMaterial>& materials);

/// A user error where an output is the same file as an input or as an output of another option:
/// by device and number, so that links and differing spellings count, and where there is no such
/// file yet by folder and name. To be asked before anything is opened. Devices and pipes may be
/// named as often as one likes.
Result<void> check_outputs(const std::vector<NamedOutput>& outputs,
                           const std::vector<std::filesystem::path>& inputs);

/// The same for a print: all that outputs_of lists, and the files of its folder of slices.
Result<void> check_outputs(const Options& options, const std::string& format,
                           const std::vector<backends::SliceMaterial>& materials,
                           const std::vector<std::filesystem::path>& inputs);

}  // namespace openfab::print
