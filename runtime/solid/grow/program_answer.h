// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads what a program of the user's answers: lines of beams, meshes, places of objects, and boxes in which there is
// more. docs/how-to/programs.md has them.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "mesh/model/mesh.h"

namespace openfab::solid {

/// What the world says of the numbers and names in lines.
struct AnswerLayout {
    int32_t floats = 0, ints = 0;  ///< of attributes
    std::vector<std::string> places;
};

struct ProgramAnswer {
    enum class Kind : uint8_t { kBeam, kFlat, kPlace, kMesh };
    struct Item {
        Kind kind = Kind::kBeam;
        int32_t line = 0;               ///< from 1
        std::array<Vec3f, 2> end;       ///< of a beam; a place stands at the first
        std::array<float, 2> radius{};  ///< of a beam
        std::array<Vec3f, 3> axes;      ///< of a place
        int32_t which = 0;              ///< among the places, or the meshes
    };
    struct More {
        int32_t line = 0;
        std::string key;
        Box3f box;
    };
    std::vector<Item> items;
    std::vector<float> floats;   ///< [item][end][component]
    std::vector<uint32_t> ints;  ///< [item][component]
    std::vector<mesh::Mesh> meshes;
    std::vector<More> more;
};

/// Keys have fewer bytes.
constexpr size_t kKeyBytes = 64;

/// Reads the lines of an answer, without the last one, `done`. A line `error TEXT` is an error of that text. Messages
/// begin with the number of a line.
Result<ProgramAnswer> read_program_answer(std::string_view text, const AnswerLayout& layout);

}  // namespace openfab::solid
