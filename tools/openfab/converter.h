// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Files that `openfab import` has another program read, which links a library that not every machine has.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"

namespace openfab::tools {

/// A program beside this one, and what is said where it is missing.
struct Converter {
    const char* program;
    const char* missing;
    const char* missing_help;
    const char* library;  ///< for a file that ended it
};

extern const Converter kStepConverter, kVrmlConverter, kScanConverter;

bool is_step_file(const std::filesystem::path& file);
bool is_vrml_file(const std::filesystem::path& file);
bool is_usd_file(const std::filesystem::path& file);
/// The extensions of these and of meshes, for messages.
std::string importable_meshes();

/// Lets a converter read `file`, which its arguments name. What it says goes to standard error, and the
/// error has no text then. Errors: it was not built, cannot be started, was ended by a signal.
Result<void> run_converter(const Converter& converter, std::vector<std::string> arguments,
                           const std::filesystem::path& file);

/// Lets USD's own library, in the Python on the PATH, make the Wavefront file `obj` of `file`, with its materials and
/// pictures beside it. Errors as of run_converter; `pxr` is missing.
Result<void> run_usd_reader(const std::filesystem::path& file, const std::filesystem::path& obj,
                            int64_t memory_bytes);

}  // namespace openfab::tools
