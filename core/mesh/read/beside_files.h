// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Files that a mesh names: they stand in its folder or below. Many meshes name them by paths of the
// machine that wrote them, or in other letters.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/result.h"
#include "mesh/model/look.h"

namespace openfab::mesh {

/// Returns the folder of a mesh file.
std::filesystem::path folder_of(const std::filesystem::path& mesh);

/// Returns the path of a name that stands in a file in `folder`, relative to that or absolute: as it
/// is, else its last part in `folder`, else a file whose name differs in upper and lower case alone;
/// else all these with the codes of addresses (%20) decoded. If there is none, the error says why.
Result<std::filesystem::path> find_beside(const std::filesystem::path& mesh,
                                          const std::filesystem::path& folder,
                                          std::string_view name);

/// Returns a name without the codes of addresses, `%20`; what is not a code stays as it is.
std::string percent_decoded(std::string_view name);

/// Returns a name in the form of a path: programs on Windows write backslashes.
std::filesystem::path with_slashes(std::string_view name);

/// Calls take(i, …) for each of the sources, names as find_beside takes them, relative to the mesh's
/// folder. Together they take `memory_bytes` at most.
void read_beside(const std::filesystem::path& mesh, std::span<const std::string> sources,
                 int64_t memory_bytes, const TakePicture& take);

}  // namespace openfab::mesh
