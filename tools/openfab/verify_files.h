// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Checks outputs of a print that are not .ofr files against what the print recorded of them.

#include <filesystem>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "base/result.h"

namespace openfab::tools {

/// The files of the slices of a folder, by its manifest.
struct FolderFiles {
    std::vector<std::string> names;    ///< slice by slice
    std::vector<std::string> missing;  ///< those of them that are not there
};
FolderFiles look_for_files(const std::filesystem::path& folder, const JsonValue& manifest);

/// Checks the files of a folder of slices by their digests, and its voxels by their hash. `memory_bytes`:
/// what may be taken.
Result<void> verify_folder(const std::filesystem::path& folder, int64_t memory_bytes);
/// Checks an array of codes or of fractions by the text beside it.
Result<void> verify_array(const std::string& file);
/// Checks a binary STL by the digest in its header, if it has one, and that files of the same output beside it are of the
/// same print.
Result<void> verify_stl(const std::string& file);
/// Returns a line with the slices that a mesh of ours is of, where it is of a part of a print; else nothing.
std::string part_of_mesh(const std::string& file, int64_t memory_bytes);
/// Checks the parts of a package (3MF, GCVF) by their checksums, and the slices of a GCVF by the hash that it has of them.
Result<void> verify_package(const std::string& file, int64_t memory_bytes);

}  // namespace openfab::tools
