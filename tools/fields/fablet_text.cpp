// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fields/fablet_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/similarity.h"
#include "base/text.h"
#include "mesh/read/threemf_lattice_beams.h"
#include "tools/fields/bounds.h"
#include "tools/fields/displaced_text.h"
#include "tools/fields/function_text.h"
#include "tools/fields/lattice_text.h"
#include "tools/fields/messages.h"

namespace openfab::tools {

namespace {

using mesh::ThreemfField;
using mesh::ThreemfGroup;
using mesh::ThreemfModel;
using mesh::ThreemfObject;
using mesh::ThreemfType;

constexpr size_t kMostMaterials = 60;

std::array<double, 3> linear(const mesh::ThreemfColor& color) {
    return {static_cast<double>(color[0]), static_cast<double>(color[1]),
            static_cast<double>(color[2])};
}

/// One fablet that is written.
class FabletText {
  public:
    FabletText(const ThreemfModel& model, const Affine3d& to_mm, std::string file,
               const std::string& fablet)
        : model_(model), file_(std::move(file)), to_mm_(to_mm), functions_(model, file_) {
        out_.fablet = fablet;
    }

    Result<FieldFablet> level_set(const mesh::ThreemfPlaced& placed) {
        const mesh::ThreemfLevelSet& set = *placed.object->level_set;
        const std::string whose = messages::kLevelSetOf + placed.place();
        if (Result<void> fine = check_map(whose); !fine) return fine.error();
        const auto domain = model_.objects.find(set.mesh);
        if (domain == model_.objects.end() || domain->second.triangles.empty())
            return error(whose, fmt::format(messages::kMeshIdIsNoMesh, set.mesh));
        const FieldBounds bounds = bounds_of(domain->second, set.box_only);
        const Vec3d size = bounds.box.size();
        if (!(std::min({size.x, size.y, size.z}) > 0))
            return error(whose, fmt::format(messages::kBoundIsFlat, set.mesh));
        const Result<std::string> value =
            functions_.at(set.field, "q", ThreemfType::kScalar, whose);
        if (!value) return value.error();
        if (set.field.least_feature > 0)
            out_.notes.push_back(fmt::format(messages::kSmallestFeature, whose,
                                             set.field.least_feature * scale_of_lengths()));
        if (Result<void> done = volume_stage(set.volume, placed.object, whose); !done)
            return done.error();
        const bool is_shape = !bounds.text.empty();
        shape_ = std::make_pair(*value, set.field.fallback);
        if (is_shape) {
            bounds_ = bounds.text;
            out_.box_mm = box_in_mm(bounds.box);
        } else {
            ThreemfObject box;
            const ThreemfObject* mesh = &domain->second;
            if (set.box_only) mesh = &(box = box_mesh(bounds.box));
            out_.meshes.push_back({"", "bounds", obj_text(*mesh, to_mm_)});
            out_.notes.push_back(fmt::format(messages::kBoundNotConvex, whose));
        }
        return finish(set.field.transform, whose);
    }

    Result<FieldFablet> mesh(const mesh::ThreemfPlaced& placed) {
        const std::string whose = placed.place();
        if (Result<void> fine = check_map(whose); !fine) return fine.error();
        if (Result<void> done = volume_stage(placed.object->volume, placed.object, whose); !done)
            return done.error();
        if (placed.object->displaced != nullptr) {
            Result<DisplacedText> text = displaced_text(placed, to_mm_, file_);
            if (!text) return text.error();
            surface_ = std::move(text->stage);
            out_.maps = std::move(text->maps);
            out_.most_displacement_mm = text->most_mm;
        }
        return finish({}, whose);
    }

  private:
    Error error(const std::string& place, const std::string& what,
                const std::string& help = {}) const {
        return user_error(fmt::format("{}: {}: {}", file_, place, what), help);
    }

    Result<void> check_map(const std::string& whose) const {
        const Affine3d back = inverse(to_mm_);
        for (const double m : back.m) {
            if (!std::isfinite(m)) return error(whose, messages::kTransformIsFlat);
        }
        return {};
    }

    double scale_of_lengths() const { return std::cbrt(std::fabs(determinant(to_mm_))); }

    Box3d box_in_mm(const Box3d& box) const {
        Box3d out;
        for (int c = 0; c < 8; ++c)
            out.add(to_mm_.apply({(c & 1) != 0 ? box.hi.x : box.lo.x,
                                  (c & 2) != 0 ? box.hi.y : box.lo.y,
                                  (c & 4) != 0 ? box.hi.z : box.lo.z}));
        // A shape that reached the border would be open, and numbers are rounded.
        const Vec3d size = out.size();
        const double margin = 0.01 + 1e-3 * std::max({size.x, size.y, size.z});
        out.lo = out.lo - Vec3d{margin, margin, margin};
        out.hi = out.hi + Vec3d{margin, margin, margin};
        return out;
    }

    static ThreemfObject box_mesh(const Box3d& box) {
        ThreemfObject out;
        for (int c = 0; c < 8; ++c)
            out.vertices.push_back({(c & 1) != 0 ? box.hi.x : box.lo.x,
                                    (c & 2) != 0 ? box.hi.y : box.lo.y,
                                    (c & 4) != 0 ? box.hi.z : box.lo.z});
        constexpr int32_t kFaces[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                           {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                           {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
        for (const auto& f : kFaces) {
            mesh::ThreemfTriangle t;
            t.vertices = {f[0], f[1], f[2]};
            out.triangles.push_back(t);
        }
        return out;
    }

    /// A value behind its fallback; `wrong` is what an undefined one is without it.
    static std::string or_fallback(const std::string& value, double fallback) {
        return fmt::format("isnan({0}) ? {1} : {0}", value, float_text(fallback));
    }

    Result<void> volume_stage(int64_t id, const ThreemfObject* object, const std::string& whose) {
        const auto it = model_.fields.volumes.find(id);
        if (id >= 0 && it == model_.fields.volumes.end())
            return error(whose, fmt::format(messages::kNoSuchVolumeData, id));
        const mesh::ThreemfVolumeData none;
        const mesh::ThreemfVolumeData& data = id >= 0 ? it->second : none;
        for (const ThreemfField& one : data.properties) {
            if (Result<void> done = property(one, whose); !done) return done;
        }
        if (data.mixture.empty() && !data.shares.empty() && object != nullptr) {
            mesh::ThreemfVolumeData own = data;
            own.mixture = data.shares;
            own.materials = object->group;
            return mixture(own, whose);
        }
        if (!data.mixture.empty()) {
            if (data.color) out_.notes.push_back(fmt::format(messages::kColourAndMixture, whose));
            return mixture(data, whose);
        }
        if (data.color) return color(*data.color, whose);
        out_.materials.push_back(material_of(object));
        volume_ += "        mc.Set(material, 1);\n";
        return {};
    }

    Result<void> color(const ThreemfField& field, const std::string& whose) {
        const Result<std::string> value =
            functions_.at(field, "q", ThreemfType::kVector, messages::kColourOf + whose);
        if (!value) return value.error();
        out_.inks = uses_point_ = true;
        volume_ += fmt::format(
            "        float3 rgb = {};\n        rgb = saturate(select(rgb == rgb, rgb, {}));\n"
            "        mc = inks(cyan, magenta, yellow, black, white, ink_limit(rgb_to_cmyk(rgb, "
            "density, 0.8), 1));\n",
            *value, float_text(field.fallback));
        return {};
    }

    Result<void> mixture(const mesh::ThreemfVolumeData& data, const std::string& whose) {
        const auto group = model_.groups.find(data.materials);
        if (group == model_.groups.end() || group->second.kind != ThreemfGroup::Kind::kMaterials)
            return error(whose, fmt::format(messages::kNoBaseMaterials, data.materials));
        const ThreemfGroup& of = group->second;
        if (data.mixture.size() > of.names.size())
            return error(whose, fmt::format(messages::kMixesMoreThanThereAre, data.mixture.size(),
                                            of.names.size()));
        if (data.mixture.size() > kMostMaterials)
            return error(whose,
                         fmt::format(messages::kMixesTooMany, data.mixture.size(), kMostMaterials));
        uses_point_ = true;
        for (size_t i = 0; i < data.mixture.size(); ++i) {
            const ThreemfField& one = data.mixture[i];
            const Result<std::string> value =
                functions_.at(one, "q", ThreemfType::kScalar, messages::kMixtureOf + whose);
            if (!value) return value.error();
            const std::string uniform = fmt::format("material_{}", i);
            out_.materials.push_back({uniform, of.names[i], linear(of.values[i])});
            volume_ += fmt::format(
                "        float share_{0} = {1};\n        mc.Set({2}, saturate(isnan(share_{0}) ? "
                "{3} : share_{0}));\n",
                i, *value, uniform, float_text(one.fallback));
        }
        // Of less the specification leaves the mixture to the reader.
        volume_ += "        if (mc.Total() < 1e-5) mc.Set(material_0, 1);\n";
        return {};
    }

    Result<void> property(const ThreemfField& field, const std::string& whose) {
        for (const ThreemfType type : {ThreemfType::kScalar, ThreemfType::kVector}) {
            const Result<std::string> value =
                functions_.at(field, "q", type, fmt::format(messages::kTheProperty, field.name));
            if (!value && type == ThreemfType::kVector) return value.error();
            if (!value) continue;
            const std::string name = "property_" + openfl_name(field.name);
            properties_ += fmt::format(
                "\n    // The property `{}` at a point of the object.\n    {} {}(float3 q)\n    "
                "{{\n"
                "        return {};\n    }}\n",
                printable(field.name), openfl_type(type), name, *value);
            out_.notes.push_back(fmt::format(messages::kPropertyIsFunction, whose, field.name,
                                             field.required ? messages::kRequiredByFile : "",
                                             name));
            break;
        }
        return {};
    }

    FieldMaterial material_of(const ThreemfObject* object) const {
        FieldMaterial out{"material", "", {}};
        if (object == nullptr) return out;
        const auto group = model_.groups.find(object->group);
        if (group == model_.groups.end()) return out;
        const ThreemfGroup& of = group->second;
        const auto at = static_cast<size_t>(object->property);
        if (of.kind == ThreemfGroup::Kind::kMaterials && at < of.names.size()) {
            out.name = of.names[at];
            out.color = linear(of.values[at]);
        } else if (of.kind == ThreemfGroup::Kind::kColors && at < of.values.size()) {
            out.color = linear(of.values[at]);
        }
        return out;
    }

    std::string uniforms() {
        std::string text;
        const auto line = [&](const std::string& one) { text += "        " + one + "\n"; };
        for (const FieldMaterial& one : out_.materials)
            line(fmt::format("Material {};", one.uniform));
        if (out_.inks) {
            line("Material cyan, magenta, yellow, black, white;");
            line(
                "float density = 1.2 [[ float min = 0.1, string help = \"optical density of a "
                "skin of pure ink\" ]];");
        }
        for (const FieldImage& one : out_.images)
            line(fmt::format("ImageTexture3D {};", one.uniform));
        for (const FieldMap& one : out_.maps)
            line(fmt::format("ImageTexture2D {};", one.uniform));
        for (const FieldMesh& one : out_.meshes) {
            if (!one.uniform.empty()) line(fmt::format("Object {};", one.uniform));
        }
        return text;
    }

    void take_images() {
        for (const int64_t id : functions_.images()) {
            const mesh::ThreemfFunction& function = model_.fields.functions.at(id);
            const mesh::ThreemfImage& image = model_.fields.images.at(function.image);
            out_.images.push_back({fmt::format("image_{}", id),
                                   function.image,
                                   image.sheets,
                                   {image.columns, image.rows, image.count},
                                   std::ranges::find(function.wrap, mesh::PictureWrap::kRepeat) !=
                                       function.wrap.end(),
                                   function.nearest});
        }
    }

    bool asks_distances() const {
        return !functions_.meshes().empty() || !functions_.lattices().empty();
    }

    /// Adds the meshes and lattices whose distance is asked for, where the functions' space is theirs.
    Result<std::string> distances(const Affine3d& to_function, const std::string& whose) {
        std::string text;
        if (!asks_distances()) return text;
        const Affine3d to_mm = product(to_mm_, inverse(to_function));
        const double scale = even_scale(to_mm);
        if (!(scale > 0))
            return error(whose, messages::kDistancesAndScaled, messages::kApplyTheScale);
        const auto ask = [&](int64_t id, const std::string& uniform) {
            text += fmt::format(
                "    // The distance of a point from {} {}, in the file's unit.\n"
                "    float {}_distance(float3 q)\n    {{\n        return distance_to({}, {}) / "
                "{};\n    }}\n\n",
                uniform[0] == 'm' ? "object" : "the lattice of object", id, uniform, uniform,
                mapped_text(to_mm, "q"), float_text(scale));
        };
        for (const int64_t id : functions_.meshes()) {
            const std::string uniform = fmt::format("mesh_{}", id);
            out_.meshes.push_back({uniform, uniform, obj_text(model_.objects.at(id), to_mm)});
            ask(id, uniform);
        }
        for (const int64_t id : functions_.lattices()) {
            const std::string uniform = fmt::format("lattice_{}", id);
            const std::string name = fmt::format(messages::kObjectOfFile, id);
            // The model is in memory, and what is made of it no larger.
            int64_t memory = std::numeric_limits<int64_t>::max();
            mesh::ThreemfTold told;
            const Result<mesh::ThreemfBeams> beams =
                mesh::lattice_beams(model_.objects.at(id), to_mm, name, file_, &memory, &told);
            if (!beams) return beams.error();
            if (beams->beams.beams.empty())
                return error(whose, fmt::format(messages::kLatticeWithoutBeams, name));
            for (const mesh::LeftOut& left : told.list())
                out_.notes.push_back(fmt::format("{}: {}", whose, describe(left)));
            out_.meshes.push_back({uniform, uniform, lattice_text(beams->beams), true});
            ask(id, uniform);
        }
        return text;
    }

    Result<FieldFablet> finish(const Affine3d& to_function, const std::string& whose) {
        take_images();
        Result<std::string> meshes = distances(to_function, whose);
        if (!meshes) return meshes.error();
        std::string text = fmt::format(
            "// Made by `openfab import` of {}: each node of a function "
            "is a line.\n",
            printable(file_));
        if (out_.inks) text += "import color;\n";
        text += fmt::format("\nfablet {} {{\n    @uniform {{\n{}    }}\n\n{}", out_.fablet,
                            uniforms(), *meshes);
        for (const std::string& one : functions_.texts())
            text += one + "\n";
        const bool asks = uses_point_ || shape_ || !properties_.empty();
        if (asks)
            text += fmt::format(
                "    // A point of the print, in mm, as the object has it.\n    float3 "
                "of_object(float3 p)\n    {{\n        return {};\n    }}\n",
                mapped_text(inverse(to_mm_), "p"));
        text += properties_;
        if (!bounds_.empty()) {
            text += fmt::format(
                "\n    // Below 0 in what bounds the level set.\n    float "
                "bounds(float3 q)\n    {{\n{}    }}\n",
                bounds_);
            // `max(x, y)` is y where x is undefined: the fallback comes first.
            std::string value = "level";
            if (functions_.may_be_undefined() || shape_->second < 0)
                value = fmt::format("({})", or_fallback("level", shape_->second));
            text += fmt::format(
                "\n    @Shape(@varying {{ ShapeAttributes attr }})\n    {{\n        float3 q = "
                "of_object(attr.p);\n        float level = {};\n        return max({}, "
                "bounds(q));\n    }}\n",
                shape_->first, value);
        }
        text += surface_;
        text +=
            "\n    @Volume(@varying { VolumeAttributes attr })\n    {\n        "
            "MaterialComposition mc;\n";
        const bool cuts = shape_ && bounds_.empty();
        if (cuts || uses_point_) text += "        float3 q = of_object(attr.voxelCenter);\n";
        if (cuts)
            text += fmt::format(
                "        float level = {};\n        if (!({} < 0)) return mc;\n", shape_->first,
                shape_->second < 0 ? or_fallback("level", shape_->second) : "level");
        text += volume_ + "        return mc;\n    }\n}\n";
        out_.source = std::move(text);
        return std::move(out_);
    }

    const ThreemfModel& model_;
    std::string file_;
    Affine3d to_mm_;  ///< from the object
    FunctionTexts functions_;
    FieldFablet out_;
    std::optional<std::pair<std::string, double>> shape_;  ///< the level, and its fallback
    std::string bounds_, surface_, volume_, properties_;
    bool uses_point_ = false;  ///< in the volume stage
};

}  // namespace

Result<FieldFablet> level_set_fablet(const mesh::ThreemfPlaced& placed, const Affine3d& to_mm,
                                     const std::string& file, const std::string& fablet) {
    return FabletText(*placed.model, product(to_mm, placed.map), file, fablet).level_set(placed);
}

Result<FieldFablet> mesh_fablet(const mesh::ThreemfPlaced& placed, const Affine3d& to_mm,
                                const std::string& file, const std::string& fablet) {
    return FabletText(*placed.model, product(to_mm, placed.map), file, fablet).mesh(placed);
}

}  // namespace openfab::tools
