// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the faces of an OBJ text belong to: objects, groups and materials, each from its statement
// on.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "mesh/model/mesh_source.h"
#include "mesh/read/mtl.h"

namespace openfab::mesh {

class ObjNames {
  public:
    /// `out` gets groups, bodies and looks; libraries take `memory_bytes` at most.
    ObjNames(const std::string& file, int64_t memory_bytes, MeshSource* out)
        : file_(file), libraries_(file, memory_bytes, out), out_(*out) {}

    /// Takes a statement `o`, `g`, `usemtl` or `mtllib`: its first word, the rest of its line, and
    /// the words of a `g`, which may go on in further lines.
    Result<void> take(std::string_view word, std::string_view rest,
                      const std::vector<std::string_view>& words, int32_t line);

    /// Returns the index of the group that faces are in now.
    int32_t group();

    /// Adds bodies and looks, when all faces are in `out`.
    void finish();

    /// Returns how pictures are moved, by look; may be shorter than the looks.
    const std::vector<const MtlMaterial*>& materials() const { return material_of_look_; }
    /// Returns what all of it takes beside the groups.
    int64_t bytes() const { return bytes_ + libraries_.bytes(); }

  private:
    template <typename Names>
    int32_t number_of(const Names& names, std::map<Names, int32_t>* numbers);
    int32_t look_of_material();
    int32_t body_of_names();
    void name_bodies();
    void tell_unknown();

    struct Key {
        int32_t object, groups, material;
        auto operator<=>(const Key&) const = default;
    };
    struct Material {
        std::string name;
        int32_t line = 0, look = -1;
    };
    struct BodyNames {
        int32_t object;  ///< the number of its statement
        std::string object_name, group_names;
    };

    const std::string& file_;
    MtlLibraries libraries_;
    MeshSource& out_;
    int64_t bytes_ = 0;
    std::string object_;
    std::vector<std::string> groups_;
    int32_t object_number_ = 0, groups_number_ = 0;  ///< 0: none
    size_t material_number_ = 0;
    std::vector<Material> materials_ = {{}};  ///< the first one: none
    std::map<std::vector<std::string>, int32_t> groups_numbers_;
    std::map<std::string, int32_t> material_numbers_;
    std::map<Key, int32_t> group_of_;
    std::map<std::pair<int32_t, int32_t>, int32_t> body_of_;  ///< by object and groups
    std::vector<BodyNames> body_names_;
    std::vector<size_t> material_of_look_number_;
    std::vector<const MtlMaterial*> material_of_look_;
    std::optional<int32_t> group_;  ///< of the current names
};

}  // namespace openfab::mesh
