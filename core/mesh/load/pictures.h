// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The pictures of a mesh file of any format.

#include <filesystem>
#include <span>
#include <string>

#include "base/result.h"
#include "mesh/model/look.h"

namespace openfab::mesh {

/// Calls take(index, bytes or error) for each of `sources` (PictureUse::source) in order. Files that
/// the mesh names stand in its folder or below. A picture that takes more than `memory_bytes` is an
/// error of its own; an error of this function is one of the file.
Result<void> read_pictures(const std::filesystem::path& file, std::span<const std::string> sources,
                           int64_t memory_bytes, const TakePicture& take);

}  // namespace openfab::mesh
