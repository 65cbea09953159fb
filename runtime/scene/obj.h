// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Wavefront OBJ. Our own reader: the libraries take a bad number for 0 and know no line, and a
// print that is subtly wrong costs a day.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/result.h"
#include "runtime/scene/mesh.h"

namespace openfab::scene {

struct ObjOptions {
    std::string name;    ///< the mesh's name in the world, for messages
    double unit_mm = 1;  ///< length of one unit of the file
    std::optional<std::map<std::string, int32_t>>
        groups;  ///< `g` and `usemtl` names to values of an int attribute
    std::string groups_attribute = "face";
};

struct LoadedMesh {
    Mesh mesh;
    std::vector<std::string> warnings;
};

/// Reads positions, `vt` as "uv" (2), `vn` as "n" (3), vertex colours as "color" (3), groups as an
/// int attribute. Polygons are triangulated: convex ones as a fan from their first corner, others
/// by ear clipping. The mesh is checked by prepare_mesh. An attribute that only some faces have is
/// left out with a warning. Errors name file:line:column.
Result<LoadedMesh> load_obj(const std::filesystem::path& file, const ObjOptions& options);
/// The same from text; `name` stands for the file in messages.
Result<LoadedMesh> parse_obj(std::string_view text, const std::string& name,
                             const ObjOptions& options);

}  // namespace openfab::scene
