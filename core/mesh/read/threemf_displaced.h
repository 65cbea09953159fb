// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Displaced meshes of a 3MF file (displacement extension, 2023/10), as written.

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "base/xml.h"
#include "mesh/model/look.h"

namespace openfab::mesh {

struct ThreemfDisplacementMap {
    std::string path;
    int channel = 1;  ///< 0: red … 3: alpha
    std::array<PictureWrap, 2> wrap{};
    bool nearest = false;
};

/// Where a corner looks a map up, and where it moves.
struct ThreemfDisplacementPoint {
    double u = 0, v = 0, factor = 1;
    int64_t direction = 0;
};

struct ThreemfDisplacementGroup {
    int64_t map = -1, directions = -1;
    double height = 0, offset = 0;  ///< in the file's unit
    std::vector<ThreemfDisplacementPoint> points;
};

struct ThreemfDisplacements {
    std::map<int64_t, ThreemfDisplacementMap> maps;
    std::map<int64_t, std::vector<Vec3d>> directions;
    std::map<int64_t, ThreemfDisplacementGroup> groups;

    /// Returns the group that a triangle names. Some files name its directions instead, where those are of one
    /// group alone; 0 where there is none.
    int64_t group_of(int64_t named) const;
};

/// How the triangles of an object are displaced.
struct ThreemfDisplaced {
    struct Triangle {
        int64_t group = -1;                         ///< -1: that of all
        std::array<int64_t, 3> points{-1, -1, -1};  ///< of the group; -1: it stays where it is
    };
    int64_t group = -1;
    std::vector<Triangle> triangles;  ///< as many as the object has
};

class ThreemfDisplacementReader {
  public:
    /// Returns whether an element is one of the resources.
    static bool takes(std::string_view name);
    /// Reads one. Decreases `*memory_bytes`.
    Complaint read(std::string_view name, const XmlAttributes& a, ThreemfDisplacements* out,
                   int64_t* memory_bytes);
    static Complaint read_triangle(const XmlAttributes& a, ThreemfDisplaced* out);

  private:
    ThreemfDisplacementGroup* group_ = nullptr;  ///< the last one
    std::vector<Vec3d>* directions_ = nullptr;   ///< the last ones
};

}  // namespace openfab::mesh
