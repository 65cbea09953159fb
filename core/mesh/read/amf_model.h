// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The XML of an AMF file (ISO/ASTM 52915), as written.

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "mesh/model/look.h"
#include "mesh/read/threemf_extensions.h"

namespace openfab::mesh {

/// Red, green, blue, alpha; sRGB, 0 … 1.
using AmfColor = std::array<double, 4>;

/// Indices in AmfModel::colors; -1: none.
using AmfColorIndex = int32_t;

struct AmfTriangle {
    std::array<int32_t, 3> vertices{-1, -1, -1};
    AmfColorIndex color = -1;
};

struct AmfVolume {
    std::string name;
    int64_t material = -1;
    BodyRole role = BodyRole::kPart;
    std::string use;       ///< what it is for, if it is not printed
    int32_t extruder = 0;  ///< of PrusaSlicer, from 1; 0: not said
    AmfColorIndex color = -1;
    std::vector<AmfTriangle> triangles;
};

struct AmfObject {
    int64_t id = -1;
    std::string name;
    int32_t extruder = 0;
    AmfColorIndex color = -1;
    std::vector<Vec3d> vertices;
    std::vector<AmfColorIndex> vertex_colors;  ///< by vertex; shorter where the last have none
    std::vector<AmfVolume> volumes;
};

struct AmfMaterial {
    std::string name;
    AmfColorIndex color = -1;
    std::vector<std::pair<int64_t, double>> parts;  ///< materials and their shares
    bool has_formula = false;                       ///< in a share: it varies in space
};

/// Where a constellation has an object, or another constellation. Slicers scale, mirror and switch off.
struct AmfInstance {
    int64_t id = -1;
    Vec3d delta, rotation_deg, scale{1, 1, 1}, mirror{1, 1, 1};
    bool printable = true;
};

struct AmfModel {
    double unit_mm = 1;
    std::vector<AmfColor> colors;
    std::vector<AmfObject> objects;
    std::map<int64_t, AmfMaterial> materials;
    std::map<int64_t, std::vector<AmfInstance>> constellations;
    ThreemfTold told;  ///< what is left out
};

/// Parses a file's text. Errors are `file:line:column: …`, at the end of what is wrong. Vertices of
/// triangles exist; other ids are not checked. Decreases `*memory_bytes` by the size of the model; an
/// error if it is not enough.
Result<AmfModel> parse_amf_model(std::string_view text, const std::string& file,
                                 int64_t* memory_bytes);

}  // namespace openfab::mesh
