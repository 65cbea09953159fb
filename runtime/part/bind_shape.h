// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The @Shape stages of a world's parts: whose uniforms they have, how they are scaled, and the objects
// that they ask for distances.

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/part/program_stage.h"
#include "runtime/part/shape_stage.h"
#include "runtime/part/uniforms.h"
#include "world/world.h"

namespace openfab::part {

/// Returns whether the volume stage, or else the shape stage, asks for the distance to an object.
bool volume_asks(const openfab_fablet& fablet, int32_t object);
bool shape_asks(const openfab_fablet& fablet, int32_t object);

/// Returns the scale along each axis of the stretch of a placement; 0, all, where it is along others.
std::array<double, 3> scales_along_axes(const std::array<double, 9>& stretch);

/// Checks that a placement may scale the geometry of a stage so, which a @Surface stage may displace. The
/// message names no object.
Result<void> check_stretch(const openfab_fablet* stage, const std::array<double, 9>& stretch,
                           bool displaced);

/// Returns the mesh of a shape, its box, with the outputs of its stage as attributes, so that names
/// and types are checked as those of meshes are; their values come from the stage.
mesh::Mesh box_of_shape(const mesh::Mesh& box, const openfab_fablet* stage);

/// Stands for the fablet of what is asked for its geometry alone.
extern const openfab_fablet kGeometry;

class ShapeBinder {
  public:
    /// What the binder of the world makes, which must outlive this one.
    struct Sources {
        std::function<Result<const openfab_fablet*>(const world::Object&)> fablet_of;
        /// `sets`: with those of `--set`.
        std::function<Result<BoundUniforms>(const world::Object&, const openfab_fablet&, bool sets)>
            uniforms;
        std::function<Result<std::vector<std::shared_ptr<const texture::Pyramid>>>(
            const BoundUniforms&)>
            textures;
        /// Null where memory is used up.
        std::function<Result<std::shared_ptr<const PartMesh>>(
            const world::Object&, const openfab_fablet&, const std::array<double, 9>&)>
            mesh;
        /// What an object's part is made of, stretched so; `uniforms` are those of the part.
        std::function<Result<Geometry>(const world::Object&, const std::array<double, 9>&,
                                       const BoundUniforms&, const Part&)>
            geometry;
    };

    ShapeBinder(const world::World& world, Sources sources)
        : world_(world), sources_(std::move(sources)) {}

    /// Makes the geometry of an object's part, which has all but that; `uniforms` are those of the part. The
    /// stage has the object's uniforms where the object has the stage's fablet, else those of the fablet.
    Result<Geometry> bind(const world::StageRef& of, const world::Object& object,
                          const std::array<double, 9>& stretch, const BoundUniforms& uniforms,
                          const Part& part);
    Result<Geometry> bind(const std::shared_ptr<const world::ProgramRef>& of,
                          const world::Object& object, const std::array<double, 9>& stretch,
                          const BoundUniforms& uniforms, const Part& part);

    const std::shared_ptr<const ProgramTable>& table_of(
        const std::shared_ptr<const world::ProgramRef>& of);

  private:
    /// Returns the box of a part before it is stretched; null where memory is used up.
    Result<std::shared_ptr<const PartMesh>> own_box(const world::Object& object,
                                                    const std::array<double, 9>& stretch,
                                                    const Part& part) const;
    Result<void> bind_bodies(const std::vector<int32_t>& objects, ShapeStage* stage);
    Result<std::shared_ptr<const Part>> body_of(int32_t object, const SourceLocation& asked);
    std::shared_ptr<const ShapeStage> same_stage(std::shared_ptr<const ShapeStage> stage);

    const world::World& world_;
    Sources sources_;
    std::map<const PartMesh*, std::vector<std::shared_ptr<const ShapeStage>>> stages_;
    std::map<const world::ProgramRef*, std::shared_ptr<const ProgramTable>> programs_;
    std::map<int32_t, std::shared_ptr<const Part>> bodies_;  ///< by object
    std::vector<int32_t> asking_;                            ///< objects whose bodies are made
};

}  // namespace openfab::part
