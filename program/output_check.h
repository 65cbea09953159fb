// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Checks that no output of a print overwrites an input or another output.

#include <filesystem>
#include <string>
#include <vector>

#include "backends/common/format.h"
#include "base/result.h"
#include "program/output_options.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::program {

/// Lists every file that a print with these options writes, temporary names included; `format` as of
/// choose_format. The slices of a folder are not listed, see check_outputs.
std::vector<NamedOutput> outputs_of(const OutputOptions& options, const backends::Format* format,
                                    const std::vector<pipeline::SliceMaterial>& materials);

/// Fails with a user error where an output is the same file as an input or as an output of another
/// option: compared by device and inode, so that links and other spellings count, and where the
/// file does not exist yet by folder and name. Must be called before anything is opened. Devices
/// and pipes may be named repeatedly.
Result<void> check_outputs(const std::vector<NamedOutput>& outputs,
                           const std::vector<std::filesystem::path>& inputs);

/// Same for a print: all outputs of outputs_of, and the files of its folder of slices. Fails with
/// kOutside where a file of the host, which it writes at its end, has no folder that can be written to.
Result<void> check_outputs(const OutputOptions& options, const backends::Format* format,
                           const std::vector<pipeline::SliceMaterial>& materials,
                           const std::vector<std::filesystem::path>& inputs);

}  // namespace openfab::program
