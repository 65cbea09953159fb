// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The keys of a world file, by kind of object: what the loader accepts, and what
// fab_world.schema.json must list (a test compares the two).

#include <string_view>
#include <vector>

namespace openfab::world {

struct KeySet {
    std::string_view
        kind;  ///< also the name under "$defs" in the schema; "world" is the schema's root
    std::vector<std::string_view> keys;
    std::vector<std::string_view> required;
};

/// Where a world names a file or a folder, which counts from the world's folder.
struct WorldPath {
    std::vector<std::string_view> keys;  ///< from the root; `*` is any member, `[]` any item
    std::string_view ends;               ///< what ends otherwise is a name
};
const std::vector<WorldPath>& world_paths();

const std::vector<KeySet>& world_key_sets();
const KeySet& world_keys(std::string_view kind);

}  // namespace openfab::world
