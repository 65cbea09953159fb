// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Level sets and volumetric data of a 3MF file in the world that an import makes.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/result.h"
#include "mesh/load/load_mesh.h"
#include "tools/fields/fablet_text.h"
#include "tools/openfab/import_materials.h"
#include "tools/openfab/import_pictures.h"
#include "tools/openfab/import_text.h"

namespace openfab::tools {

struct ImportedFields {
    std::vector<FieldFablet> level_sets;
    std::vector<FieldFablet> volumes;
    std::vector<int32_t> volume_of;  ///< by body of the file: its entry of these, -1 for none
    bool has_meshes = true;          ///< the build places meshes, too
    double unit_mm = 1;
    std::vector<mesh::LeftOut> left_out;

    bool empty() const { return level_sets.empty() && volumes.empty(); }
    /// The pictures of the file that are sheets of volumes.
    void add_sources(std::set<std::string>* sources) const;
};

/// Finds the level sets of a file, and the volumetric data of its bodies (null: it has none), and writes
/// their fablets. Of a file that is no 3MF, nothing.
Result<ImportedFields> load_fields(const std::filesystem::path& file,
                                   const mesh::MeshOptions& options,
                                   const mesh::LoadedBodies* bodies);

/// Takes what readers of meshes told of fields out of the list, as they are objects of the world.
void without_fields(std::vector<mesh::LeftOut>* left_out);

/// Adds objects of fields to a world.
class FieldBinder {
  public:
    FieldBinder(ImportMaterials* materials, ImportPictures* pictures, Names* names,
                std::vector<ImportedFile>* files, WorldText* world)
        : materials_(*materials),
          pictures_(*pictures),
          names_(*names),
          files_(*files),
          world_(*world) {}

    /// Binds the uniforms of a fablet to its object, and adds its source; meshes and beams that it asks about become
    /// objects of void, and are appended to `helpers`.
    Result<void> bind(const FieldFablet& field, ObjectText* object,
                      std::vector<ObjectText>* helpers);

  private:
    ImportMaterials& materials_;
    ImportPictures& pictures_;
    Names& names_;
    std::vector<ImportedFile>& files_;
    WorldText& world_;
    std::set<std::string> sources_;
};

/// Adds the inks to the world, and to an object's uniforms.
void bind_inks(ImportMaterials* materials, UniformTexts* uniforms);

}  // namespace openfab::tools
