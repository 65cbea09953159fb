// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Meshes, beams and pictures of strangers' files come out of a jail (base/jail.h). What came is checked here: that numbers
// name what there is, since all that follows trusts them.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "base/jail.h"
#include "mesh/load/load_beams.h"
#include "mesh/load/pictures.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// What a reader of a mesh may take: its file, and what lies in its folder or below.
JailLimits reading_limits(const std::filesystem::path& file, int64_t memory_bytes);

Result<MeshSource> mesh_from_jail(const std::filesystem::path& file, int64_t memory_bytes,
                                  const std::function<Result<MeshSource>()>& read);
Result<LoadedBeams> beams_from_jail(const std::filesystem::path& file, int64_t memory_bytes,
                                    const std::function<Result<LoadedBeams>()>& read);
Result<LoadedLattices> lattices_from_jail(const std::filesystem::path& file, int64_t memory_bytes,
                                          const std::function<Result<LoadedLattices>()>& read);

/// Calls `read` in a jail, and `take` here for each picture that it took.
Result<void> pictures_from_jail(const std::filesystem::path& file, int64_t memory_bytes,
                                size_t count, const TakePicture& take,
                                const std::function<Result<void>(const TakePicture&)>& read);

/// What is told of a file beside its mesh.
void pass(JailLine* line, LeftOut* left_out);

/// Returns whether all numbers of a mesh name what it has.
bool makes_sense(const MeshSource& source);
bool makes_sense(const Beams& beams);

}  // namespace openfab::mesh
