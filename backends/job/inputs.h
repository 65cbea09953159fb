// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The files that a print read: which, and their digests.

#include <filesystem>
#include <string>
#include <vector>

#include "backends/job/record.h"

namespace openfab::job {

/// Returns the modules that a source of OpenFL imports from beside it, and they in turn; of a schedule what it includes.
std::vector<std::filesystem::path> imported_files(const std::filesystem::path& source);

/// Reads each file once and returns its digest, with absolute paths; without folders, and with the imports of sources and
/// schedules. What cannot be read has an empty digest.
std::vector<Input> read_inputs(const std::vector<std::filesystem::path>& files);

/// Reads a file and returns its digest, as read_inputs does.
Input read_input(const std::filesystem::path& file);

/// Returns the inputs of the earlier record that are others now, or not among `now`.
std::vector<std::string> changed_inputs(const JsonValue& record, const std::vector<Input>& now);

/// Returns those whose size or time is no longer what it was.
std::vector<std::string> changed_since(const std::vector<Input>& inputs);

/// Returns the inputs of a record.
std::vector<Input> inputs_of(const JsonValue& record);

}  // namespace openfab::job
