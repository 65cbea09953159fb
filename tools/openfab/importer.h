// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Binds the fablets, materials and pictures of an import, and writes its world.

#include <array>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "base/result.h"
#include "mesh/load/load_mesh.h"
#include "tools/openfab/import.h"
#include "tools/openfab/import_choice.h"
#include "tools/openfab/import_fields.h"
#include "tools/openfab/import_lists.h"
#include "tools/openfab/import_materials.h"
#include "tools/openfab/import_pictures.h"
#include "tools/openfab/import_text.h"
#include "tools/openfab/stock.h"

namespace openfab::tools {

/// Makes the world of one import.
class Importer {
  public:
    Importer(const mesh::LoadedBodies& loaded, const Pictures& pictures, const std::string& file,
             const ImportOptions& options);

    Result<Import> run();

  private:
    bool is_part(size_t b) const { return loaded_.bodies[b].role == mesh::BodyRole::kPart; }
    bool alone() const;
    /// The file, and the body where there are several, for messages.
    std::string what(const mesh::LoadedMesh& body) const;

    // --- what is bound -------------------------------------------------------------------------

    Result<void> bind_body(size_t b);

    /// The fablet of a body's volumetric data, or null.
    const FieldFablet* field_of(size_t b) const;

    Result<void> bind_field(const FieldFablet& field, ObjectText* object);

    /// One material, or one for each beam set and for beams in none.
    void bind_lattice(const mesh::LatticeInfo& lattice);

    int32_t most_depth() const;

    void uniform(const std::string& name, const std::string& value);
    void material(const char* name, const char* wanted, const LinearColor& color);

    Result<void> bind_void();

    /// Binds the uniforms of a stock fablet: one function a row of the table of them.
    using Bind = Result<void> (Importer::*)(const mesh::LoadedMesh&, BodyLook*);
    static const std::array<Bind, std::size(kStockFablets)> kBinds;

    Result<void> bind_fablet(const mesh::LoadedMesh& body, BodyLook* look);

    /// Of a body in part space.
    Box3d box_of(const mesh::LoadedMesh& body) const;

    std::string material_of(const mesh::LoadedMesh& body, const GroupLook& group);

    Result<void> bind_solid(const mesh::LoadedMesh& body, BodyLook* look);

    Result<void> bind_graded(const mesh::LoadedMesh& body, BodyLook*);

    Result<void> bind_shell(const mesh::LoadedMesh&, BodyLook*);

    Result<void> bind_lattice(const mesh::LoadedMesh&, BodyLook*);

    Result<void> bind_infill(const mesh::LoadedMesh& body, BodyLook*);

    Result<void> bind_relief(const mesh::LoadedMesh& body, BodyLook*);

    Result<void> bind_mixed(const mesh::LoadedMesh& body, BodyLook* look);

    /// Textured or painted.
    Result<void> bind_skins(const mesh::LoadedMesh& body, BodyLook* look);

    std::string white() { return materials_.of("white", "white", kWhite); }

    Error no_picture(const mesh::LoadedMesh& body) const;

    /// The texture of a group; empty where it has none.
    Result<std::string> texture_of(const GroupLook& group);

    /// Chooses the side with the largest area of the mesh's box; on ties the top, then the front.
    int planar_side(const Vec3d& size) const;

    /// The picture spans the mesh's box on each side, or has a size and repeats.
    Result<void> bind_mapped(const mesh::LoadedMesh& body, BodyLook*);

    /// Binds the picture of the first group that has one.
    Result<void> bind_first_picture(const mesh::LoadedMesh& body, bool clamp, bool luminance);

    /// The requested picture, which replaces the mesh's own.
    Result<std::string> own_picture(bool clamp, bool luminance);

    /// Adds the table of inks to the world.
    Result<void> bind_profile();

    // --- the text ------------------------------------------------------------------------------

    /// A list of materials by group.
    void bind_materials(const std::string& fablet, const std::vector<std::string>& names);

    std::string source_of(const std::string& fablet) const;

    std::string unit_text() const;

    std::string mesh_text(const mesh::LoadedMesh& body) const;

    std::string world();

    // --- what is told --------------------------------------------------------------------------

    Error too_many_materials() const;

    static constexpr size_t kMostMaterials = 254;
    static constexpr LinearColor kWhite{1, 1, 1};
    /// Same as in stdlib/mapping.fl.
    static constexpr std::array<const char*, 6> kSides{"front", "right", "back",
                                                       "left",  "top",   "bottom"};
    static constexpr int kFront = 0, kRight = 1, kTop = 4;

    const mesh::LoadedBodies& loaded_;
    const std::string& file_;
    const ImportOptions& options_;
    Box3d box_, negative_box_;
    double scale_ = 1;
    std::vector<BodyLook> looks_;  ///< by body
    ImportMaterials materials_;
    ImportPictures pictures_;
    Names object_names_;
    std::vector<ObjectText> objects_;
    UniformTexts* uniforms_ = nullptr;  ///< of the object that is bound
    ImportLists lists_;
    std::map<const mesh::LoadedMesh*, std::string> own_;  ///< materials of bodies
    SharedBytes own_picture_;
    std::string profile_;
    bool shares_one_ = false, mapping_told_ = false;
    Import out_;
    WorldText text_;
    FieldBinder fields_{&materials_, &pictures_, &object_names_, &out_.files, &text_};
};

}  // namespace openfab::tools
