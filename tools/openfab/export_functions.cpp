// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/export_functions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "base/color.h"
#include "base/input_file.h"
#include "base/overloaded.h"
#include "base/own_folder.h"
#include "base/polar.h"
#include "base/say.h"
#include "base/start_program.h"
#include "base/text.h"
#include "client/child.h"
#include "program/output_check.h"
#include "tools/fields/fablet_ir.h"
#include "tools/fields/field_model.h"
#include "tools/fields/function_nodes.h"
#include "tools/fields/uniform_values.h"
#include "tools/fields/volume_shares.h"
#include "tools/openfab/export_stack.h"
#include "tools/openfab/field_package.h"
#include "tools/openfab/messages.h"
#include "world/world.h"

namespace openfab::tools {

namespace {

/// Why no function of 3MF is what a geometry is made by; nullptr where there is one.
const char* why_no_function(const world::Geometry& geometry) {
    using Beams = std::shared_ptr<const mesh::Beams>;
    using Program = std::shared_ptr<const world::ProgramRef>;
    return std::visit(Overloaded{
                          [](std::monostate /*itself*/) -> const char* { return nullptr; },
                          [](const Beams&) -> const char* { return nullptr; },
                          [](const world::StageRef&) -> const char* { return nullptr; },
                          [](const Program&) -> const char* { return messages::kMadeByProgram; },
                      },
                      geometry);
}

constexpr int64_t kLargestIr = 256'000'000;
/// Of a stack of images along the longest side of what is printed.
constexpr double kStackVoxels = 256;

ModelMaterial model_material(const world::Material& material) {
    return {material.name, material.preview};
}

/// Whether all directions are scaled alike; beams of a 3MF that are not are none to its readers.
bool is_alike(const std::array<double, 3>& scale) {
    constexpr double kRounding = 1e-9;
    const auto [least, most] = std::ranges::minmax(scale);
    return most - least <= kRounding * most;
}

/// Whether there are beams of different radii between balls.
bool has_hulls(const mesh::Beams& beams) {
    return std::ranges::any_of(beams.beams, [](const mesh::Beam& beam) {
        return beam.radii[0] != beam.radii[1] && beam.ends[0] == mesh::BeamEnd::kBall;
    });
}

/// Whether a ball is where no beam ends, which 3MF does not allow.
bool has_lonely_balls(const mesh::Beams& beams) {
    std::vector<bool> ended(beams.nodes.size(), false);
    for (const mesh::Beam& beam : beams.beams) {
        if (beam.nodes[0] == beam.nodes[1]) continue;
        for (const int32_t node : beam.nodes)
            ended[static_cast<size_t>(node)] = true;
    }
    return std::ranges::any_of(beams.beams, [&](const mesh::Beam& beam) {
        return beam.nodes[0] == beam.nodes[1] && !ended[static_cast<size_t>(beam.nodes[0])];
    });
}

class FunctionsExport {
  public:
    FunctionsExport(const FunctionsArguments& arguments, world::World world,
                    std::filesystem::path folder)
        : arguments_(arguments),
          world_(std::move(world)),
          folder_(std::move(folder)),
          model_(arguments.composite) {}

    Result<void> run() {
        if (world_.build.empty())
            return user_error(fmt::format(messages::kBuildEmpty, arguments_.world));
        std::string why;
        for (const world::Placement& placement : world_.build) {
            const Result<int> made = object_of(placement, &why);
            if (!made) return made.error();
            if (!why.empty()) break;
            model_.add_item(*made, placement.transform);
        }
        if (!why.empty()) return stack(why);
        for (const std::string& text : notes_)
            note(text);
        FieldPackage package;
        Result<void> done = package.begin(arguments_.output);
        return done ? package.end(model_.text(title())) : done;
    }

  private:
    using Scale = std::array<double, 3>;

    std::string title() const {
        std::string name = std::filesystem::path(arguments_.world).filename().string();
        constexpr std::string_view kEnd = ".fab.json";
        if (name.ends_with(kEnd)) name.resize(name.size() - kEnd.size());
        return name;
    }

    /// Runs the compiler; what it says of a mistake is the user's.
    Result<const FabletIr*> fablet_of(const std::string& name) {
        auto known = fablets_.find(name);
        if (known != fablets_.end()) return &known->second;
        const world::FabletRef& ref = world_.fablets.at(name);
        const Result<std::filesystem::path> programs = program_folder();
        if (!programs) return programs.error();
        const std::vector<std::string> argv{
            (*programs / "openflc").string(), "emit", "--as", "ir", "--fablet", ref.fablet,
            as_argument(ref.source)};
        const std::filesystem::path out = folder_ / "fablet.ir", err = folder_ / "fablet.err";
        if (const Result<void> done = client::run(argv, out, err); !done) return done.error();
        const Result<InputFile> file = InputFile::open(out);
        if (!file) return file.error();
        const Result<std::string> text = file->read_all(kLargestIr);
        if (!text) return text.error();
        Result<FabletIr> read = read_fablet_ir(*text);
        if (!read) return read.error();
        return &fablets_.emplace(name, std::move(*read)).first->second;
    }

    world::UniformBindings bindings_of(const world::Object& object,
                                       const world::Placement& placement) const {
        world::UniformBindings all = object.uniforms;
        for (const auto& [name, binding] : placement.overrides)
            all.insert_or_assign(name, binding);
        return all;
    }

    /// Returns the id of the object that a placement places; sets `why` where functions cannot say it.
    Result<int> object_of(const world::Placement& placement, std::string* why) {
        const world::Object& object = world_.objects[static_cast<size_t>(placement.object)];
        const Result<PolarFactors> polar = polar_factors(placement.transform.m);
        if (!polar) return error_at(placement.location, polar.error().message, polar.error().help);
        const std::array<double, 9>& s = polar->s;
        const Scale scale{s[0], s[4], s[8]};
        const auto key = std::make_pair(placement.object, s);
        if (placement.overrides.empty() && made_.contains(key)) return made_[key];
        const auto say_why = [&](const std::string& what) {
            *why = fmt::format(messages::kOfObject, object.name, what);
            return 0;
        };
        if (placement.piece >= 0) return say_why(messages::kCutIntoPieces);
        const mesh::Beams* beams = world_.beams_of(object.mesh);
        if (beams != nullptr && has_lonely_balls(*beams))
            return say_why(messages::kBallsThatEndNoBeam);
        if (beams != nullptr && !is_alike(scale)) return say_why(messages::kBeamsAreStretched);
        const Result<const FabletIr*> fablet = fablet_of(object.fablet);
        if (!fablet) return fablet.error();
        if ((*fablet)->has_surface) return say_why(messages::kDisplacesSurface);
        if ((*fablet)->object_count > 0) return say_why(messages::kFabletAsksObjects);
        if ((*fablet)->has_dither)
            note_once(fmt::format(messages::kDitherRuleLeftOut, (*fablet)->name));
        const Result<part::BoundUniforms> bound = bind_uniforms(
            world_, **fablet, bindings_of(object, placement), object.name, object.location);
        if (!bound) return bound.error();
        Shape shape;
        if (const char* why = why_no_function(world_.geometry_of(object.mesh)); why != nullptr)
            return say_why(why);
        if (const world::StageRef* stage = world_.stage_of(object.mesh); stage != nullptr) {
            const Result<void> found = shape_of(stage->fablet, object, *bound, **fablet, &shape);
            if (!found) return found.error();
            if (shape.fablet->grows) return say_why(messages::kGrowsByRules);
            if (shape.fablet->object_count > 0) return say_why(messages::kShapeAsksObjects);
        }
        const bool even = s[1] == 0 && s[2] == 0 && s[5] == 0;
        if (!even) return say_why(messages::kSheared);
        const Result<int> id = make(object, **fablet, *bound, shape, scale);
        if (!id && id.error().code == ErrorCode::kUserInput) return say_why(id.error().message);
        if (id && placement.overrides.empty()) made_[key] = *id;
        return id;
    }

    struct Shape {
        const FabletIr* fablet = nullptr;
        std::vector<uint32_t> values;
    };

    /// The stage has the object's uniforms where the object has the shape's fablet.
    Result<void> shape_of(const std::string& name, const world::Object& object,
                          const part::BoundUniforms& bound, const FabletIr& of_object,
                          Shape* shape) {
        const Result<const FabletIr*> fablet = fablet_of(name);
        if (!fablet) return fablet.error();
        shape->fablet = *fablet;
        if (*fablet == &of_object) {
            shape->values = bound.values;
            return {};
        }
        if ((*fablet)->object_count > 0) return {};
        const Result<part::BoundUniforms> own = bind_uniforms(
            world_, **fablet, world_.fablets.at(name).uniforms, object.name, object.location);
        if (!own) return own.error();
        shape->values = own->values;
        return {};
    }

    /// The distance to the surface of a shape that is one, in mm of the part.
    std::optional<NodeValue> distance_of(const Shape& shape, const std::optional<NodeValue>& level,
                                         const Scale& scale, FunctionNodes* nodes) const {
        const bool alike = scale[0] == scale[1] && scale[0] == scale[2];
        if (shape.fablet == nullptr || !shape.fablet->shape_is_distance || !alike) return {};
        return nodes->binary("multiplication", *level,
                             {true, static_cast<float>(scale[0]), {}, false});
    }

    Result<int> make(const world::Object& object, const FabletIr& fablet,
                     const part::BoundUniforms& bound, const Shape& shape, const Scale& scale) {
        const mesh::Mesh& mesh = world_.meshes[static_cast<size_t>(object.mesh)];
        Box3d box;
        for (const Vec3d& p : mesh.positions)
            box.add(p);
        FunctionNodes nodes({around(box), scale});
        std::optional<NodeValue> level;
        if (shape.fablet != nullptr) {
            nodes.use(shape.values);
            const Result<std::vector<NodeValue>> made =
                nodes.add(shape.fablet->shape, {value_of_shape(*shape.fablet)}, {});
            if (!made) return made.error();
            level = (*made)[0];
        }
        nodes.use(bound.values);
        // What is not void, by materials of the world.
        std::vector<uint32_t> amounts, void_amounts;
        std::vector<size_t> of_material;
        for (const IrOutput& output : fablet.volume.outputs) {
            if (output.kind != "weight") continue;
            const uint8_t material = bound.slot_material[static_cast<size_t>(output.index)];
            (material == 0 ? void_amounts : amounts).push_back(output.value);
            if (material > 0) of_material.push_back(material - 1U);
        }
        const bool has_void = !void_amounts.empty() || may_be_void(fablet.volume, amounts);
        const int only = only_amount(fablet.volume, amounts);
        const mesh::Beams* beams = world_.beams_of(object.mesh);
        if (beams != nullptr && (only < 0 || has_void))
            return user_error(messages::kBeamsOfSeveralMaterials);
        const bool mixed =
            only < 0 && std::set<size_t>(of_material.begin(), of_material.end()).size() > 1;
        int volume = 0, materials = 0;
        std::vector<std::pair<std::string, NodeValue>> outputs;
        std::vector<size_t> order;
        if (mixed || has_void) {
            std::vector<uint32_t> all = amounts;
            all.insert(all.end(), void_amounts.begin(), void_amounts.end());
            const Result<std::vector<NodeValue>> made =
                nodes.add(fablet.volume, all, distance_of(shape, level, scale, &nodes));
            if (!made) return made.error();
            std::map<size_t, NodeValue> shares;
            const NodeValue none{};
            NodeValue total, empty;
            for (size_t i = 0; i < all.size(); ++i) {
                // Negative amounts count as 0.
                const NodeValue amount = nodes.binary("max", (*made)[i], none);
                NodeValue& sum = i < amounts.size() ? total : empty;
                sum = nodes.binary("addition", sum, amount);
                if (i >= amounts.size()) continue;
                if (!shares.contains(of_material[i])) order.push_back(of_material[i]);
                NodeValue& share = shares[of_material[i]];
                share = nodes.binary("addition", share, amount);
            }
            if (has_void) {
                const NodeValue one{true, 1, {}, false};
                const NodeValue inside = level ? *level : NodeValue{true, -1, {}, false};
                level = nodes.select(empty, total, inside, one);
                if (!void_amounts.empty())
                    note_once(fmt::format(messages::kPartlyVoidIsSolid, object.name));
            }
            if (mixed) add_shares(order, shares, total, &nodes, &outputs);
        }
        if (!mixed)
            order = {of_material.empty() ? 0 : of_material[static_cast<size_t>(std::max(only, 0))]};
        if (of_material.empty()) return user_error(messages::kAllVoid);
        std::vector<ModelMaterial> group;
        for (const size_t one : order)
            group.push_back(model_material(world_.materials[one]));
        materials = model_.add_materials(group);
        int function = 0;
        if (level) outputs.emplace_back("shape", *level);
        if (!outputs.empty()) {
            function = model_.next_id();
            const std::string text = nodes.text(function, fablet.name, outputs);
            if (!nodes.fault().empty()) return user_error(nodes.fault());
            model_.add(text);
        }
        if (mixed) {
            ModelVolume data;
            for (size_t i = 0; i < order.size(); ++i)
                data.shares.push_back({function, fmt::format("share_{}", i), {}});
            data.color.push_back({function, "color", {}});
            volume = model_.add_volume(data, materials);
        }
        if (beams != nullptr) {
            if (has_hulls(*beams)) note_once(fmt::format(messages::kBeamsOfTwoRadii, object.name));
            return model_.add_beams(object.name, *beams, materials);
        }
        if (!level)
            return model_.add_mesh(object.name, mesh.positions, mesh.triangles, materials, volume);
        const bool box_only = shape.fablet != nullptr;
        const int bounds = box_only ? model_.add_box(box)
                                    : model_.add_mesh({}, mesh.positions, mesh.triangles, 0, 0);
        return model_.add_level_set(object.name, {function, "shape", {}}, bounds, box_only,
                                    materials, volume);
    }

    /// Where a reader may ask an object's function: within its box, and some voxels beyond.
    static std::array<ValueBounds, 3> around(const Box3d& box) {
        constexpr double kMargin = 0.25;
        const Vec3d more = box.size() * kMargin;
        std::array<ValueBounds, 3> out;
        for (int a = 0; a < 3 && !box.empty(); ++a)
            out[static_cast<size_t>(a)] = {box.lo[a] - more[a], box.hi[a] + more[a]};
        return out;
    }

    static uint32_t value_of_shape(const FabletIr& fablet) {
        for (const IrOutput& output : fablet.shape.outputs) {
            if (output.kind == "shape_value") return output.value;
        }
        return 0;
    }

    /// Shares whose sum is at most 1, and a colour that is their mean, in linear light.
    void add_shares(const std::vector<size_t>& order, std::map<size_t, NodeValue>& amounts,
                    const NodeValue& total, FunctionNodes* nodes,
                    std::vector<std::pair<std::string, NodeValue>>* outputs) const {
        const NodeValue one{true, 1, {}, false};
        // Shares of a sum below 1 mean the same: what need not be divided keeps its bits.
        const NodeValue divisor = nodes->binary("max", total, one);
        std::array<NodeValue, 3> color;
        for (size_t i = 0; i < order.size(); ++i) {
            const NodeValue share = nodes->binary("division", amounts[order[i]], divisor);
            outputs->emplace_back(fmt::format("share_{}", i), share);
            for (size_t c = 0; c < 3; ++c) {
                const double light = srgb_to_linear(world_.materials[order[i]].preview[c] / 255.0);
                color[c] =
                    nodes->binary("addition", color[c],
                                  nodes->binary("multiplication", share,
                                                {true, static_cast<float>(light), {}, false}));
            }
        }
        outputs->emplace_back("color", nodes->vector(color));
    }

    void note_once(const std::string& text) {
        if (std::find(notes_.begin(), notes_.end(), text) == notes_.end()) notes_.push_back(text);
    }

    double longest_side_mm() const {
        Box3d box;
        for (const world::Placement& placement : world_.build) {
            const world::Object& object = world_.objects[static_cast<size_t>(placement.object)];
            for (const Vec3d& p : world_.meshes[static_cast<size_t>(object.mesh)].positions)
                box.add(placement.transform.apply(p));
        }
        const Vec3d size = box.size();
        return std::max({size.x, size.y, size.z});
    }

    /// Writes all that is printed as one object of stacks of images.
    Result<void> stack(const std::string& why) {
        const std::string voxel = arguments_.voxel.empty()
                                      ? fmt::format("{:.4g}mm", longest_side_mm() / kStackVoxels)
                                      : arguments_.voxel;
        const Result<FractionStack> stack = print_fractions(
            {arguments_.world, voxel, arguments_.programs, arguments_.settings}, folder_);
        if (!stack) return stack.error();
        note(fmt::format(messages::kWrittenAsStacks, why, stack->size[0], stack->size[1],
                         stack->size[2], stack->pitch_mm.x, stack->pitch_mm.y, stack->pitch_mm.z));
        FieldModel model(arguments_.composite);
        std::vector<size_t> order;
        for (size_t m = 0; m < stack->used.size(); ++m) {
            if (stack->used[m]) order.push_back(m);
        }
        if (order.empty()) return user_error(messages::kNothingPrintedNoMaterial);
        FieldPackage package;
        Result<void> done = package.begin(arguments_.output);
        if (!done) return done;
        std::map<int32_t, std::vector<std::string>> sheets;
        done = make_sheets(*stack, [&](int32_t z, int32_t m, const std::vector<uint8_t>& png) {
            if (m >= 0 && order.size() == 1) return Result<void>();
            const std::string name = m < 0 ? fmt::format("3D/volumes/solid_{}.png", z)
                                           : fmt::format("3D/volumes/material_{}_{}.png", m, z);
            sheets[m].push_back(name);
            return package.add_sheet(name, png);
        });
        if (!done) return done;
        Vec3d size;
        size.x = stack->size[0] * stack->pitch_mm.x;
        size.y = stack->size[1] * stack->pitch_mm.y;
        size.z = stack->size[2] * stack->pitch_mm.z;
        const Vec3d& origin = stack->origin_mm;
        Affine3d to_image;
        to_image.m = {1 / size.x, 0, 0, 0, 1 / size.y, 0, 0, 0, 1 / size.z};
        to_image.t = {-origin.x / size.x, -origin.y / size.y, -origin.z / size.z};
        const std::string transform = transform_text(to_image);
        std::vector<ModelMaterial> group;
        for (const size_t m : order) {
            const auto found = std::find_if(
                world_.materials.begin(), world_.materials.end(),
                [&](const world::Material& one) { return one.name == stack->materials[m]; });
            group.push_back(found == world_.materials.end()
                                ? ModelMaterial{stack->materials[m], {128, 128, 128, 255}}
                                : model_material(*found));
        }
        const int materials = model.add_materials(group);
        const auto image = [&](int32_t m, double offset, double scale) {
            const int id = model.add_image(sheets[m], stack->size[0], stack->size[1]);
            return ModelField{model.add_image_function(id, offset, scale), "red", transform};
        };
        const ModelField level = image(-1, 0.5, -1);
        int volume = 0;
        if (order.size() > 1) {
            ModelVolume data;
            for (const size_t m : order)
                data.shares.push_back(image(static_cast<int32_t>(m), 0, 1));
            volume = model.add_volume(data, materials);
        }
        const int box = model.add_box({origin, origin + size});
        model.add_item(model.add_level_set(title(), level, box, true, materials, volume), {});
        return package.end(model.text(title()));
    }

    const FunctionsArguments& arguments_;
    const world::World world_;
    const std::filesystem::path folder_;
    FieldModel model_;
    std::map<std::string, FabletIr> fablets_;
    std::map<std::pair<int32_t, std::array<double, 9>>, int> made_;
    std::vector<std::string> notes_;
};

}  // namespace

Result<void> export_functions(const FunctionsArguments& arguments) {
    if (!arguments.output.ends_with(".3mf")) return usage_error(messages::kExportTo3mf);
    Result<world::World> world = world::load_world(arguments.world, {{}, arguments.memory_bytes});
    if (!world) return world.error();
    if (Result<void> apart = program::check_outputs(
            {{"-o", arguments.output}, {"-o", arguments.output + ".part"}}, world->files);
        !apart)
        return apart;
    if (Result<void> set = set_uniforms(arguments.settings, &*world); !set) return set;
    for (const std::string& text : world->warnings)
        warn(text);
    const Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    return FunctionsExport(arguments, std::move(*world), (*folder)->path()).run();
}

}  // namespace openfab::tools
