// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The beam lattice of an object of a 3MF file, as written (beam lattice extension, 2017/02, with balls).

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/xml.h"

namespace openfab::mesh {

enum class ThreemfCap : uint8_t { kSphere, kHemisphere, kButt };

struct ThreemfBeam {
    std::array<int32_t, 2> vertices{-1, -1};
    std::array<float, 2> radii{};
    std::array<ThreemfCap, 2> caps{};
};

struct ThreemfLattice {
    double radius = 0;
    double least_length = 0;
    ThreemfCap cap = ThreemfCap::kSphere;
    std::string clipping;  ///< `inside`, `outside` or empty
    bool has_representation = false;
    bool has_properties = false;  ///< colours or materials of beams
    enum class Balls { kNone, kListed, kAll } all_balls = Balls::kNone;
    double ball_radius = 0;
    std::vector<ThreemfBeam> beams;
    std::vector<std::pair<int32_t, float>> balls;  ///< vertex and radius
    std::vector<std::string> sets;
    std::vector<std::pair<int32_t, int32_t>> members;  ///< beam and set
};

/// Reads the elements in `beamlattice`.
class ThreemfLatticeReader {
  public:
    /// Returns whether an element is one of them.
    static bool takes(std::string_view name);
    /// Reads one; `beamlattice` itself begins `out` anew. Decreases `*memory_bytes`.
    static Complaint read(std::string_view name, const XmlAttributes& a, ThreemfLattice* out,
                          int64_t* memory_bytes);

  private:
    static Complaint begin(const XmlAttributes& a, ThreemfLattice* out);
    static Complaint beam(const XmlAttributes& a, ThreemfLattice* out);
    static Complaint ball(const XmlAttributes& a, ThreemfLattice* out);
};

}  // namespace openfab::mesh
