// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The rows of the table: every kind of geometry, as a world holds it, in every form of a build; each with its twin, a mesh
// of the same solid.

#include <map>
#include <span>
#include <string>
#include <vector>

#include "runtime/solid/kinds/kinds.h"

namespace openfab::testing {

/// Which solid of runtime/solid/kinds a row makes.
enum class SolidKind : uint8_t { kGrow, kShape, kBeams, kMesh };
static_assert(solid::kKindCount == 4, "a new kind of solids needs a row in rows.cpp");

struct Kind {
    std::string id;    ///< a word
    std::string what;  ///< as the page says it
    SolidKind solid;
    std::string source;  ///< the key of `meshes` that it shows
    std::string mesh;    ///< JSON
    std::string fablet = "skin";
    std::string fablet_uniforms{}, object_uniforms{}, item_uniforms{},
        group_uniforms{};                ///< members of JSON
    std::vector<std::string> options{};  ///< of every command that prints it
    std::map<std::string, std::string> files{};
    std::string item{};  ///< members of its placement, before those of the row's form
    std::string more_meshes{}, more_objects{};
};

enum class Form : uint8_t { kWhole, kPieces, kPiecesOfFile, kTouching };
constexpr Form kForms[] = {Form::kWhole, Form::kPieces, Form::kPiecesOfFile, Form::kTouching};
const char* name_of(Form form);

std::span<const Kind> kinds();
/// The mesh of the same solid.
const Kind& twin_of(const Kind& kind);

/// What a column changes in a world.
struct Change {
    std::string placement{};  ///< members of the placement of everything, such as `"scale": 2`
    std::string world{};      ///< more members of the world, after a comma
    std::string items{};      ///< more placements beside the solid's, after a comma
    std::string build{};      ///< instead of the one placement of everything
    std::vector<std::string> options{};  ///< of its prints
    std::map<std::string, std::string> files{};
    /// A cube far below and before everything, where grids begin then: voxels of all kinds lie alike.
    bool anchor = true;
};

/// The file `cuts.json` of pieces of a file: they have a peg of a material.
std::string cuts_file();
/// The text of a world with the group `all`, which holds the solid.
std::string world_text(const Kind& kind, Form form, const Change& change);

}  // namespace openfab::testing
