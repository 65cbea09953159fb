// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/part/bind_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abi/grow_table.h"
#include "abi/shape_distance.h"
#include "base/near_miss.h"
#include "base/talking_program.h"
#include "runtime/part/messages.h"
#include "runtime/part/node_member.h"
#include "runtime/part/stretch.h"

namespace openfab::part {

namespace {

constexpr std::array<double, 9> kUnmoved{1, 0, 0, 0, 1, 0, 0, 0, 1};

bool queries(const openfab_segments& segments, int32_t object) {
    return std::any_of(segments.queries, segments.queries + segments.query_count,
                       [&](const openfab_query& query) { return query.object == object; });
}

bool reads(const openfab_kernel& kernel, int32_t object) {
    return std::any_of(kernel.args, kernel.args + kernel.arg_count, [&](const openfab_arg& arg) {
        return arg.kind == abi::kShapeDistance && arg.a == object;
    });
}

/// Returns how many components others read of an output: of a node's array of two floats one.
int32_t attribute_components(const openfab_shape& shape, const openfab_varying& output) {
    return openfab_grows(&shape) && has_two_ends(output) ? output.components / 2
                                                         : output.components;
}

}  // namespace

const openfab_fablet kGeometry = [] {
    openfab_fablet fablet{};
    fablet.abi_version = OPENFAB_ABI_VERSION;
    fablet.name = "geometry";
    return fablet;
}();

bool volume_asks(const openfab_fablet& fablet, int32_t object) {
    return queries(fablet.volume_segments, object);
}

bool shape_asks(const openfab_fablet& fablet, int32_t object) {
    const openfab_shape* shape = fablet.shape;
    return shape != nullptr && (places_objects(*shape) || queries(shape->value_segments, object) ||
                                queries(shape->attribute_segments, object) ||
                                reads(shape->values, object) || reads(shape->attributes, object));
}

std::array<double, 3> scales_along_axes(const std::array<double, 9>& stretch) {
    constexpr double kSlack = 1e-6;
    const std::array<double, 3> scales{stretch[0], stretch[4], stretch[8]};
    const double least = std::min({scales[0], scales[1], scales[2]});
    for (const size_t other : {1, 2, 3, 5, 6, 7}) {
        if (std::fabs(stretch[other]) > kSlack * least) return {0, 0, 0};
    }
    return scales;
}

bool ShapeGeometry::stretches_whole(const StretchBy& by) {
    return scales_along_axes(by)[0] == 0;
}

Result<void> check_stretch(const openfab_fablet* stage, const std::array<double, 9>& stretch,
                           bool displaced) {
    if (stretch == kUnmoved) return Ok{};
    if (stage != nullptr && stage->shape != nullptr && openfab_grows(stage->shape)) {
        return check_uneven_stretch(stretch, messages::kGrownScaledHelp);
    }
    if (scales_along_axes(stretch)[0] != 0) return Ok{};
    if (!displaced && check_uneven_stretch(stretch, "")) return Ok{};
    return user_error(messages::kShapeScaled, messages::kShapeScaledHelp);
}

mesh::Mesh box_of_shape(const mesh::Mesh& box, const openfab_fablet* stage) {
    mesh::Mesh out = box;
    out.attributes.clear();
    const openfab_shape* shape = stage != nullptr ? stage->shape : nullptr;
    for (int32_t i = 0; shape != nullptr && i < shape->output_count; ++i) {
        const openfab_varying& output = shape->outputs[i];
        mesh::MeshAttribute attribute;
        attribute.name = output.name;
        attribute.components = attribute_components(*shape, output);
        attribute.is_int = output.scalar != OPENFAB_FLOAT;
        if (attribute.is_int) {
            attribute.faces.assign(out.triangles.size() * static_cast<size_t>(attribute.components),
                                   0);
        } else {
            attribute.values.assign(static_cast<size_t>(attribute.components), 0.0f);
            attribute.corners.assign(out.triangles.size(), {0, 0, 0});
        }
        out.attributes.push_back(std::move(attribute));
    }
    return out;
}

Result<std::shared_ptr<const PartMesh>> ShapeBinder::own_box(const world::Object& object,
                                                             const std::array<double, 9>& stretch,
                                                             const Part& part) const {
    if (stretch == kUnmoved) return part.mesh;
    return sources_.mesh(object, *part.fablet, kUnmoved);
}

Result<Geometry> ShapeBinder::bind(const world::StageRef& ref, const world::Object& object,
                                   const std::array<double, 9>& stretch,
                                   const BoundUniforms& uniforms, const Part& part) {
    Result<std::shared_ptr<const PartMesh>> box = own_box(object, stretch, part);
    if (!box) return box.error();
    if (*box == nullptr) return Geometry{};
    auto stage = std::make_shared<ShapeStage>();
    stage->name = object.name;
    stage->location = ref.location;
    stage->mesh = std::move(*box);
    std::vector<int32_t> objects = uniforms.objects;
    if (ref.fablet == object.fablet) {
        stage->fablet = part.fablet;
        stage->has_values_of_part = true;
        stage->uniform_values = part.uniform_values;
        stage->textures = part.textures;
    } else {
        world::Object as;
        as.name = object.name;
        as.fablet = ref.fablet;
        as.location = ref.location;
        as.uniforms = world_.fablets.at(ref.fablet).uniforms;
        const Result<const openfab_fablet*> fablet = sources_.fablet_of(as);
        if (!fablet) return fablet.error();
        Result<BoundUniforms> bound = sources_.uniforms(as, **fablet, false);
        if (!bound) {
            Error error = bound.error();
            // A value that is wrong is where it stands.
            if (error.location == ref.location)
                error.help += fmt::format(messages::kOfShapesFablet, ref.fablet, object.fablet);
            return error;
        }
        Result<std::vector<std::shared_ptr<const texture::Pyramid>>> textures =
            sources_.textures(*bound);
        if (!textures) return textures.error();
        stage->fablet = *fablet;
        stage->uniform_values = std::move(bound->values);
        stage->textures = std::move(*textures);
        objects = std::move(bound->objects);
    }
    if (stage->fablet->shape == nullptr) {
        return error_at(ref.location, fmt::format(messages::kNoShapeStage, stage->fablet->name),
                        messages::kNoShapeStageHelp);
    }
    // Others are stretched as a whole.
    const bool grows = openfab_grows(stage->fablet->shape);
    const std::array<double, 3> along_axes = scales_along_axes(stretch);
    if (stretch != kUnmoved && along_axes[0] != 0 && !grows) stage->stretch = along_axes;
    if (Result<void> done = bind_bodies(objects, stage.get()); !done) return done.error();
    if (grows) return Geometry{GrownGeometry{same_stage(std::move(stage)), nullptr}};
    return Geometry{ShapeGeometry{same_stage(std::move(stage))}};
}

const std::shared_ptr<const ProgramTable>& ShapeBinder::table_of(
    const std::shared_ptr<const world::ProgramRef>& of) {
    std::shared_ptr<const ProgramTable>& known = programs_[of.get()];
    if (known == nullptr) known = make_program_table(of, world_.roots);
    return known;
}

Result<Geometry> ShapeBinder::bind(const std::shared_ptr<const world::ProgramRef>& of,
                                   const world::Object& object,
                                   const std::array<double, 9>& stretch,
                                   const BoundUniforms& /*uniforms*/, const Part& part) {
    const world::ProgramRef& program = *of;
    Result<std::shared_ptr<const PartMesh>> box = own_box(object, stretch, part);
    if (!box) return box.error();
    if (*box == nullptr) return Geometry{};
    if (!world_.programs_allowed) {
        return error_at(
            program.location,
            fmt::format(messages::kProgramNotAllowed, object.name, fmt::join(program.command, " ")),
            fmt::format(messages::kProgramNotAllowedHelp, kProgramsWord));
    }
    const std::shared_ptr<const ProgramTable>& table = table_of(of);
    auto stage = std::make_shared<ShapeStage>();
    stage->name = object.name;
    stage->location = program.location;
    stage->mesh = std::move(*box);
    stage->fablet = &table->fablet;
    for (const std::string& name : program.places) {
        const auto found = std::ranges::find(world_.objects, name, &world::Object::name);
        if (found == world_.objects.end()) {
            std::vector<std::string> names;
            for (const world::Object& other : world_.objects)
                names.push_back(other.name);
            return error_at(program.places_location, fmt::format(messages::kNoSuchObject, name),
                            suggest(name, names));
        }
        Result<std::shared_ptr<const Part>> body =
            body_of(static_cast<int32_t>(found - world_.objects.begin()), program.places_location);
        if (!body) return body.error();
        stage->bodies.push_back(std::move(*body));
    }
    return Geometry{GrownGeometry{same_stage(std::move(stage)), table}};
}

Result<void> ShapeBinder::bind_bodies(const std::vector<int32_t>& objects, ShapeStage* stage) {
    for (size_t i = 0; i < objects.size(); ++i) {
        if (!shape_asks(*stage->fablet, static_cast<int32_t>(i))) continue;
        Result<std::shared_ptr<const Part>> body = body_of(objects[i], stage->location);
        if (!body) return body.error();
        stage->bodies.resize(objects.size());
        stage->bodies[i] = std::move(*body);
    }
    return Ok{};
}

/// Returns the geometry of an object, in its own place: a part without volume and without placement.
/// Null where memory is used up, which the caller reports.
Result<std::shared_ptr<const Part>> ShapeBinder::body_of(int32_t object,
                                                         const SourceLocation& asked) {
    if (const auto known = bodies_.find(object); known != bodies_.end()) return known->second;
    const world::Object& of = world_.objects[static_cast<size_t>(object)];
    if (std::ranges::find(asking_, object) != asking_.end()) {
        return error_at(asked, fmt::format(messages::kAsksForItself, of.name),
                        messages::kAsksForItselfHelp);
    }
    const Result<const openfab_fablet*> fablet = sources_.fablet_of(of);
    if (!fablet) return fablet.error();
    if ((*fablet)->has_surface != 0 && of.max_displacement_mm != 0) {
        return error_at(asked, fmt::format(messages::kAskedIsDisplaced, of.name),
                        messages::kAskedIsDisplacedHelp);
    }
    asking_.push_back(object);
    auto body = std::make_shared<Part>();
    body->name = of.name;
    body->fablet = &kGeometry;
    body->location = of.location;
    Result<std::shared_ptr<const PartMesh>> mesh = sources_.mesh(of, kGeometry, kUnmoved);
    if (!mesh) return mesh.error();
    if (*mesh == nullptr) return std::shared_ptr<const Part>();
    body->mesh = std::move(*mesh);
    body->local_to_build.t = body->mesh->center_part_mm;
    Part as = *body;
    BoundUniforms uniforms;
    if (world_.is_made(of.mesh)) {
        Result<BoundUniforms> bound = sources_.uniforms(of, **fablet, true);
        if (!bound) return bound.error();
        Result<std::vector<std::shared_ptr<const texture::Pyramid>>> textures =
            sources_.textures(*bound);
        if (!textures) return textures.error();
        as.fablet = *fablet;
        as.uniform_values = bound->values;
        as.textures = std::move(*textures);
        uniforms = std::move(*bound);
    }
    Result<Geometry> geometry = sources_.geometry(of, kUnmoved, uniforms, as);
    if (!geometry) return geometry.error();
    body->geometry = std::move(*geometry);
    asking_.pop_back();
    bodies_[object] = body;
    return std::shared_ptr<const Part>(std::move(body));
}

/// Returns an equal stage that another part has, if there is one: such parts have one geometry.
std::shared_ptr<const ShapeStage> ShapeBinder::same_stage(std::shared_ptr<const ShapeStage> stage) {
    std::vector<std::shared_ptr<const ShapeStage>>& known = stages_[stage->mesh.get()];
    for (const std::shared_ptr<const ShapeStage>& other : known) {
        if (other->fablet == stage->fablet && other->uniform_values == stage->uniform_values &&
            other->textures == stage->textures && other->stretch == stage->stretch &&
            other->bodies == stage->bodies)
            return other;
    }
    known.push_back(stage);
    return stage;
}

}  // namespace openfab::part
