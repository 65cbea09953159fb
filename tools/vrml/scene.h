// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads what VRML files show as triangles. The one file behind it is the only one that uses Coin.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::tools {

struct SceneCorner {
    Vec3d position;                ///< in the file's unit and axes, in the place of its shape
    std::array<float, 3> color{};  ///< sRGB, 0 … 1
    std::array<float, 2> uv{};     ///< of the picture
};

/// Triangles of a shape, in the order of the file.
struct SceneShape {
    std::string name;     ///< of its DEF, or of the nearest node around it; may be empty
    std::string picture;  ///< a file, relative to the scene's folder; empty: none
    bool clamps = false;  ///< the picture does not repeat
    float opacity = 1;
    std::vector<std::array<SceneCorner, 3>> triangles;  ///< counter-clockwise from outside
};

struct Scene {
    std::vector<SceneShape> shapes;
    std::vector<std::string> notes;  ///< what was left out
};

/// Reads VRML 2.0 (VRML97), also VRML 1.0: shapes of all kinds as triangles, with the colours of their
/// materials, faces or vertices and the file names of their pictures. Nothing of other files is taken.
/// Errors: no VRML, damaged, with the line where the library says one; no faces.
Result<Scene> read_scene(const std::filesystem::path& file);

}  // namespace openfab::tools
