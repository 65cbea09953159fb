// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A plain implementation of dicing as defined in runtime/surface/surface.h: one micro-vertex at a
// time, shared micro-vertices found by search, everything in memory. The surface stage is any
// function; which base triangles are identities is given.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/vec.h"
#include "runtime/part/part.h"

namespace openfab::reference {

/// Inputs of the surface stage at one micro-vertex. Gradients are changes per lattice step along
/// the two lattice axes.
struct MicroInputs {
    Vec3f p, n, ng, dpdu, dpdv;
    std::array<float, 2> uv{};
    std::array<std::array<float, 2>, 3> p_gradient{}, n_gradient{};
    std::array<std::array<float, 2>, 2> uv_gradient{};
    std::vector<std::vector<float>>
        floats;  ///< [surface input][component]; empty for inputs of other types
    std::vector<std::vector<uint32_t>> flats;                  ///< likewise for other types
    std::vector<std::vector<std::array<float, 2>>> gradients;  ///< [surface input][component][axis]
};

struct MicroOutputs {
    Vec3f position;                              ///< displaced, part-local
    std::vector<std::vector<uint32_t>> outputs;  ///< bits, [surface output][component]
};

using EvaluateMicro = std::function<MicroOutputs(const MicroInputs&)>;

struct DicedTriangle {
    int32_t patch = 0;     ///< number of the patch in the order of surface.h
    int32_t in_patch = 0;  ///< index among the patch's triangles
    bool query = true, coverage = true;
    std::array<Vec3f, 3> positions;
    std::array<std::vector<float>, 3>
        floats;                  ///< [corner][float @nearest component]; empty where query is false
    std::vector<uint32_t> ints;  ///< other @nearest components; empty where query is false
};

/// `identity[t]` nonzero: base triangle t is an identity. `evaluate` is not called if all are.
std::vector<DicedTriangle> dice(const part::Part& part, double micro_edge_mm,
                                const std::vector<uint8_t>& identity,
                                const EvaluateMicro& evaluate);

}  // namespace openfab::reference
