// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The model part of a 3MF file of functions, level sets and volumetric data, as text.
//
// Shares of materials: the volumetric extension has `composite` for mixtures, which lib3mf 2.5 does not
// know: in strict mode it refuses the file. Unless asked for it, shares are properties `openfab:share.N`
// of the object's own materials, which `openfab import` reads, beside a colour for who shows the part.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"
#include "mesh/model/beams.h"

namespace openfab::tools {

struct ModelMaterial {
    std::string name;
    std::array<uint8_t, 4> color{};
};

/// A value of an object: a function, which of its outputs, and the way there.
struct ModelField {
    int function = 0;
    std::string channel;
    std::string transform;  ///< empty: the object's own space
};

struct ModelVolume {
    std::vector<ModelField> shares;  ///< of each material of the group
    std::vector<ModelField> color;   ///< one, or none
};

class FieldModel {
  public:
    explicit FieldModel(bool composite) : composite_(composite) {}

    int next_id() { return ++last_id_; }
    /// Adds an element that has the next id already.
    void add(const std::string& text) { resources_ += text; }
    int add_materials(const std::vector<ModelMaterial>& materials);
    int add_image(const std::vector<std::string>& sheets, int32_t columns, int32_t rows);
    /// Of `offset + scale * value`, between 0 and 1 in each direction.
    int add_image_function(int image, double offset, double scale);
    int add_volume(const ModelVolume& volume, int materials);
    /// Adds an object of a mesh. `materials`: of which it has the first; `volume`: 0 where it has none.
    int add_mesh(const std::string& name, const std::vector<Vec3d>& points,
                 const std::vector<std::array<int32_t, 3>>& triangles, int materials, int volume);
    /// Adds an object of a lattice of beams, each node of which ends a beam.
    int add_beams(const std::string& name, const mesh::Beams& beams, int materials);
    int add_box(const Box3d& box);
    int add_level_set(const std::string& name, const ModelField& level, int mesh, bool box_only,
                      int materials, int volume);
    void add_item(int object, const Affine3d& place);

    std::string text(const std::string& title) const;

  private:
    bool composite_;
    bool has_functions_ = false, has_beams_ = false, has_balls_ = false;
    int last_id_ = 0;
    std::string resources_, items_;
};

/// Returns a transform as 3MF writes it: the columns of the matrix, one after another.
std::string transform_text(const Affine3d& map);

}  // namespace openfab::tools
