// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/scan_number.h"
#include "base/xml.h"
#include "mesh/read/messages.h"
#include "mesh/read/threemf_displaced.h"
#include "mesh/read/threemf_extensions.h"
#include "mesh/read/threemf_text.h"

namespace openfab::mesh {
namespace {

constexpr int64_t kMaxId = INT32_MAX;
constexpr size_t kMaxTransform = 12;
/// Text of a metadata element that is of interest: a truth value or a number.
constexpr size_t kLongestValue = 64;

class ModelReader : public XmlHandler {
  public:
    ModelReader(int64_t* memory_bytes, std::string file, ThreemfTold* told)
        : memory_bytes_(*memory_bytes), file_(std::move(file)), told_(*told) {}

    ThreemfModel model;

    Complaint start(std::string_view name, const XmlAttributes& a) override {
        if (unknown_ > 0) {
            ++unknown_;
            return {};
        }
        Complaint wrong = read(name, a);
        if (wrong.empty() && memory_bytes_ < 0)
            return {messages::kModelTakesTooMuch, messages::kAllowMoreMemory};
        return wrong;
    }

    Complaint read(std::string_view name, const XmlAttributes& a) {
        using Kind = ThreemfGroup::Kind;
        wrong_.clear();
        // Drafts of 3MF had volumetric data inside of meshes.
        if (fields_.takes(name) && (object_ == nullptr || name != "volumedata"))
            return fields_.start(name, a);
        if (name == "vertex") return vertex(a);
        if (name == "triangle") return triangle(a);
        if (name == "tex2coord") return coordinate(a);
        if (name == "model") return root(a);
        if (name == "basematerials") return begin_group(a, Kind::kMaterials);
        if (name == "colorgroup") return begin_group(a, Kind::kColors);
        if (name == "texture2d") return texture(a);
        if (name == "texture2dgroup") return begin_coordinates(a);
        if (name == "compositematerials") return begin_composites(a);
        if (name == "multiproperties") return begin_multi(a);
        if (name == "base") return base(a);
        if (name == "color") return color(a);
        if (name == "composite") return composite(a);
        if (name == "multi") return multi(a);
        if (name == "object") return begin_object(a);
        if (name == "component" || name == "boolean") return component(a);
        if (name == "booleanshape") return boolean_shape(a);
        if (name == "item") return placement(a, &model.build);
        if (name == "metadata" || name == "setting") begin_value(a);
        if (name == "mesh") volume_of_mesh(a);
        if (ThreemfDisplacementReader::takes(name)) return displacement(name, a);
        if (object_ != nullptr && name == "displacementmesh") begin_displaced();
        if (name == "displacementmesh") return {};
        if (name == "triangles" && is_displaced())
            object_->displaced->group = integer(a, "did", -1);
        if (object_ != nullptr && name == "levelset") return level_set(a);
        if (object_ != nullptr && ThreemfLatticeReader::takes(name)) return lattice(name, a);
        if (is_left_out_of_threemf(name, place(), &told_)) unknown_ = 1;
        return {};
    }

    void end(std::string_view name) override {
        if (unknown_ > 0) {
            --unknown_;
            return;
        }
        if (fields_.end()) return;
        if (name == "object") object_ = nullptr;
        if (name == "basematerials" || name == "colorgroup" || name == "texture2dgroup" ||
            name == "compositematerials" || name == "multiproperties")
            group_ = nullptr;
        if (name == "metadata" || name == "setting") end_value();
    }

    bool wants_text() const override { return !key_.empty(); }
    void text(std::string_view piece) override {
        value_ += piece.substr(0, kLongestValue - std::min(kLongestValue, value_.size()));
    }

    /// Checks that triangles refer to existing vertices; returns an error text, empty if none.
    std::string check_vertices() const {
        for (const auto& [id, object] : model.objects) {
            const auto count = static_cast<int32_t>(object.vertices.size());
            for (const ThreemfTriangle& t : object.triangles) {
                const int32_t most = std::max({t.vertices[0], t.vertices[1], t.vertices[2]});
                if (most >= count)
                    return fmt::format(messages::kTriangleOfNoVertex, id, most, count);
            }
        }
        return {};
    }

  private:
    /// Appends to a list and accounts for its memory: lists double, and are copied then.
    template <typename T>
    T& add(std::vector<T>* list, T value, size_t more = 0) {
        memory_bytes_ -= static_cast<int64_t>(3 * sizeof(T) + more);
        list->push_back(std::move(value));
        return list->back();
    }

    /// Accounts for the memory of a resource's map entry and name.
    template <typename T>
    void take(const std::string& name) {
        constexpr size_t kNode = 64;
        memory_bytes_ -= static_cast<int64_t>(sizeof(T) + kNode + name.size());
    }

    static Complaint too_long(const std::string& name) {
        constexpr size_t kLongest = 1000;
        if (name.size() <= kLongest) return {};
        return {fmt::format(messages::kLongName, name.size()),
                fmt::format(messages::kAtMost, kLongest)};
    }

    double number(const XmlAttributes& a, const char* key) {
        const char* text = a.find(key);
        double value = 0;
        if (text == nullptr) {
            wrong_ = fmt::format(messages::kAttributeMissing, key);
        } else if (const std::string wrong = scan_number(trim_threemf(text), &value);
                   !wrong.empty()) {
            wrong_ = wrong;
        }
        return value;
    }

    int64_t integer(const XmlAttributes& a, const char* key, int64_t otherwise) {
        const char* text = a.find(key);
        if (text == nullptr) return otherwise;
        int64_t value = otherwise;
        if (const std::string wrong = scan_integer(trim_threemf(text), 0, kMaxId, &value);
            !wrong.empty())
            wrong_ = fmt::format("`{}`: {}", key, wrong);
        return value;
    }

    int64_t needed_integer(const XmlAttributes& a, const char* key) {
        const int64_t value = integer(a, key, -1);
        if (value < 0 && wrong_.empty()) wrong_ = fmt::format(messages::kAttributeMissing, key);
        return value;
    }

    static std::string attribute(const XmlAttributes& a, const char* key) {
        const char* value = a.find(key);
        return value != nullptr ? value : "";
    }

    Complaint root(const XmlAttributes& a) {
        static constexpr std::pair<std::string_view, double> kUnits[] = {
            {"micron", 0.001}, {"millimeter", 1}, {"centimeter", 10},
            {"inch", 25.4},    {"foot", 304.8},   {"meter", 1000}};
        const std::string unit = attribute(a, "unit");
        bool found = unit.empty();
        for (const auto& [name, size] : kUnits) {
            if (name != unit) continue;
            model.unit_mm = size;
            found = true;
        }
        if (!found) return fmt::format(messages::kUnknownUnit, unit.substr(0, 40));
        return check_threemf_extensions(a);
    }

    Complaint begin_group(const XmlAttributes& a, ThreemfGroup::Kind kind) {
        const int64_t id = needed_integer(a, "id");
        if (!wrong_.empty()) return wrong_;
        const auto [it, fresh] = model.groups.try_emplace(id);
        if (!fresh) return fmt::format(messages::kSecondResource, id);
        take<ThreemfGroup>({});
        group_ = &it->second;
        group_->kind = kind;
        return {};
    }

    Complaint begin_coordinates(const XmlAttributes& a) {
        Complaint wrong = begin_group(a, ThreemfGroup::Kind::kCoordinates);
        if (wrong.empty()) group_->source = integer(a, "texid", -1);
        return wrong.empty() ? Complaint(wrong_) : wrong;
    }

    Complaint begin_composites(const XmlAttributes& a) {
        Complaint wrong = begin_group(a, ThreemfGroup::Kind::kComposites);
        if (wrong.empty()) wrong = integers(attribute(a, "matindices"), &group_->layers);
        if (wrong.empty()) group_->source = integer(a, "matid", -1);
        // Each composite searches all of them.
        constexpr size_t kMaxMaterials = 256;
        if (wrong.empty() && group_->layers.size() > kMaxMaterials)
            return {fmt::format(messages::kTooManyComposites, group_->layers.size()),
                    fmt::format(messages::kAtMost, kMaxMaterials)};
        return wrong.empty() ? Complaint(wrong_) : wrong;
    }

    Complaint begin_multi(const XmlAttributes& a) {
        Complaint wrong = begin_group(a, ThreemfGroup::Kind::kMulti);
        if (wrong.empty()) wrong = integers(attribute(a, "pids"), &group_->layers);
        // Each triangle searches all of them.
        constexpr size_t kMaxLayers = 16;
        if (wrong.empty() && group_->layers.size() > kMaxLayers)
            return {fmt::format(messages::kTooManyMultiproperties, group_->layers.size()),
                    fmt::format(messages::kAtMost, kMaxLayers)};
        if (!wrong.empty()) return wrong;
        const std::string methods = attribute(a, "blendmethods");
        for (const std::string_view method : threemf_words(methods)) {
            if (group_->multiplied.size() == kMaxLayers) break;
            if (method != "mix" && method != "multiply")
                return {fmt::format(messages::kUnknownBlendMethod, method.substr(0, 40)),
                        messages::kUnknownBlendMethodHelp};
            group_->multiplied.push_back(method == "multiply");
        }
        return {};
    }

    std::string integers(std::string_view list, std::vector<int64_t>* out) {
        for (std::string_view word : threemf_words(list)) {
            int64_t value = 0;
            if (std::string wrong = scan_integer(word, 0, kMaxId, &value); !wrong.empty())
                return wrong;
            add(out, value);
        }
        return {};
    }

    bool in(ThreemfGroup::Kind kind) const { return group_ != nullptr && group_->kind == kind; }

    Complaint base(const XmlAttributes& a) {
        if (!in(ThreemfGroup::Kind::kMaterials)) return {};
        std::string name = attribute(a, "name");
        if (name.empty()) name = fmt::format("material {}", group_->names.size());
        const std::optional<ThreemfColor> color = parse_threemf_color(attribute(a, "displaycolor"));
        const size_t length = name.size();
        add(&group_->values, color.value_or(ThreemfColor{}), 1);
        group_->colored.push_back(color.has_value());
        return too_long(add(&group_->names, std::move(name), length));
    }

    Complaint color(const XmlAttributes& a) {
        if (!in(ThreemfGroup::Kind::kColors)) return {};
        const std::string written = attribute(a, "color");
        const std::optional<ThreemfColor> value = parse_threemf_color(written);
        if (!value)
            return {fmt::format(messages::kNotAColour, written.substr(0, 40)),
                    messages::kNotAColourHelp};
        add(&group_->values, *value);
        return {};
    }

    Complaint texture(const XmlAttributes& a) {
        const int64_t id = needed_integer(a, "id");
        if (!wrong_.empty()) return wrong_;
        const auto [it, fresh] = model.textures.try_emplace(id);
        if (!fresh) return fmt::format(messages::kSecondTexture, id);
        ThreemfTexture& texture = it->second;
        texture.path = attribute(a, "path");
        take<ThreemfTexture>(texture.path);
        texture.nearest = attribute(a, "filter") == "nearest";
        const char* const keys[] = {"tilestyleu", "tilestylev"};
        for (size_t axis = 0; axis < texture.wrap.size(); ++axis) {
            const std::string style = attribute(a, keys[axis]);
            if (style.empty() || style == "wrap") continue;
            if (style == "mirror") {
                texture.wrap[axis] = PictureWrap::kMirror;
            } else if (style == "clamp") {
                texture.wrap[axis] = PictureWrap::kClamp;
            } else if (style == "none") {
                texture.wrap[axis] = PictureWrap::kNone;
            } else {
                return {fmt::format(messages::kUnknownTileStyle, style.substr(0, 40)),
                        messages::kTileStyles};
            }
        }
        return {};
    }

    Complaint coordinate(const XmlAttributes& a) {
        if (!in(ThreemfGroup::Kind::kCoordinates)) return {};
        const double u = number(a, "u");
        const double v = number(a, "v");
        add(&group_->values, {static_cast<float>(u), static_cast<float>(v), 0, 0});
        return wrong_;
    }

    Complaint composite(const XmlAttributes& a) {
        if (!in(ThreemfGroup::Kind::kComposites)) return {};
        std::vector<double>& shares = add(&group_->shares, {});
        const std::string values = attribute(a, "values");
        double sum = 0;
        for (const std::string_view word : threemf_words(values)) {
            if (shares.size() == group_->layers.size()) break;
            double value = 0;
            if (std::string wrong = scan_number(word, &value); !wrong.empty()) return wrong;
            if (value < 0) return fmt::format(messages::kNotAShare, word.substr(0, 40));
            sum += add(&shares, value);
        }
        while (shares.size() < group_->layers.size())
            add(&shares, 0.0);
        for (double& share : shares)
            share = sum > 0 ? share / sum : 1 / static_cast<double>(shares.size());
        return {};
    }

    Complaint multi(const XmlAttributes& a) {
        if (!in(ThreemfGroup::Kind::kMulti)) return {};
        return integers(attribute(a, "pindices"), &add(&group_->picks, {}));
    }

    Complaint begin_object(const XmlAttributes& a) {
        const int64_t id = needed_integer(a, "id");
        const int64_t group = integer(a, "pid", -1);
        const int64_t property = integer(a, "pindex", 0);
        if (!wrong_.empty()) return wrong_;
        const auto [it, fresh] = model.objects.try_emplace(id);
        if (!fresh) return fmt::format(messages::kSecondObject, id);
        object_ = &it->second;
        object_id_ = id;
        told_paint_ = {};
        object_->name = attribute(a, "name");
        take<ThreemfObject>(object_->name);
        if (Complaint wrong = too_long(object_->name); !wrong.empty()) return wrong;
        if (const char* type = a.find("type")) object_->type = type;
        if (Complaint wrong = too_long(object_->type); !wrong.empty()) return wrong;
        object_->group = group;
        object_->property = property;
        if (a.find("slicestackid") != nullptr) {
            object_->stand_in = attribute(a, "meshresolution") == "lowres";
            if (!object_->stand_in)
                told_.add(messages::kSlicesOfObjects, place(), messages::kSlicesOfObjectsHelp);
        }
        return {};
    }

    Complaint lattice(std::string_view name, const XmlAttributes& a) {
        if (name == "beamlattice") {
            told_.add(messages::kLatticesOfBeams, place(), messages::kLatticesOfBeamsHelp);
            object_->lattice = std::make_shared<ThreemfLattice>();
        }
        if (object_->lattice == nullptr) return {};
        return ThreemfLatticeReader::read(name, a, object_->lattice.get(), &memory_bytes_);
    }

    /// Which programs that read meshes alone tell of.
    Complaint level_set(const XmlAttributes& a) {
        told_.add(messages::kLevelSets, place(), messages::kImportRemedy);
        object_->level_set = std::make_shared<ThreemfLevelSet>();
        memory_bytes_ -= static_cast<int64_t>(sizeof(ThreemfLevelSet));
        return ThreemfFieldsReader::read_level_set(a, object_->level_set.get());
    }

    Complaint displacement(std::string_view name, const XmlAttributes& a) {
        if (model.displacements == nullptr)
            model.displacements = std::make_shared<ThreemfDisplacements>();
        return displacements_.read(name, a, model.displacements.get(), &memory_bytes_);
    }

    bool is_displaced() const { return object_ != nullptr && object_->displaced != nullptr; }

    void begin_displaced() {
        told_.add(messages::kDisplacements, place(), messages::kImportRemedy);
        object_->displaced = std::make_shared<ThreemfDisplaced>();
    }

    void volume_of_mesh(const XmlAttributes& a) {
        if (object_ == nullptr) return;
        object_->volume = integer(a, "volumeid", -1);
        if (object_->volume >= 0)
            told_.add(messages::kVolumetricData, place(), messages::kImportRemedy);
    }

    /// Names where something is, for people.
    std::string place() const {
        if (object_ == nullptr) return file_;
        return object_->name.empty() ? fmt::format("object {}", object_id_)
                                     : fmt::format("object `{}`", object_->name);
    }

    Complaint vertex(const XmlAttributes& a) {
        if (object_ == nullptr) return {};
        add(&object_->vertices, {number(a, "x"), number(a, "y"), number(a, "z")});
        return wrong_;
    }

    Complaint triangle(const XmlAttributes& a) {
        if (object_ == nullptr) return {};
        ThreemfTriangle t;
        t.vertices = {-1, -1, -1};
        a.each([&](std::string_view name, const char* value) { attribute_of(name, value, &t); });
        for (size_t c = 0; c < 3; ++c) {
            if (t.vertices[c] < 0 && wrong_.empty())
                wrong_ = fmt::format(messages::kCornerMissing, c + 1);
            // One for all corners unless the others have their own.
            if (t.properties[c] < 0) t.properties[c] = t.properties[0];
        }
        add(&object_->triangles, t);
        if (is_displaced() && wrong_.empty()) {
            memory_bytes_ -= static_cast<int64_t>(3 * sizeof(ThreemfDisplaced::Triangle));
            return ThreemfDisplacementReader::read_triangle(a, object_->displaced.get());
        }
        return wrong_;
    }

    void attribute_of(std::string_view name, const char* value, ThreemfTriangle* t) {
        if (name.size() == 2 && name[1] >= '1' && name[1] <= '3') {
            const auto corner = static_cast<size_t>(name[1] - '1');
            if (name[0] == 'v') t->vertices[corner] = static_cast<int32_t>(index(name, value));
            if (name[0] == 'p') t->properties[corner] = index(name, value);
        } else if (name == "pid") {
            t->group = index(name, value);
        } else if (*value == 0) {
            // Slicers write empty ones, too.
        } else if (name == "paint_color" || name == "mmu_segmentation") {
            paint(value);
        } else if (name == "paint_supports" || name == "custom_supports") {
            tell_paint(0, messages::kPaintedSupports);
        } else if (name == "paint_seam" || name == "custom_seam") {
            tell_paint(1, messages::kPaintedSeams);
        } else if (name == "paint_fuzzy_skin" || name == "fuzzy_skin") {
            tell_paint(2, messages::kPaintedFuzzySkin);
        }
    }

    int64_t index(std::string_view name, const char* text) {
        int64_t value = -1;
        if (const std::string wrong = scan_integer(trim_threemf(text), 0, kMaxId, &value);
            !wrong.empty())
            wrong_ = fmt::format("`{}`: {}", name, wrong);
        return value;
    }

    void paint(const char* text) {
        const auto number = static_cast<int32_t>(object_->triangles.size());
        if (!object_->paints.empty() && object_->paints.back().first == number) return;
        std::string code = text;
        const size_t length = code.size();
        add(&object_->paints, {number, std::move(code)}, length);
    }

    /// Once for each object.
    void tell_paint(size_t kind, const char* what) {
        if (told_paint_[kind]) return;
        told_paint_[kind] = true;
        told_.add(what, place(), messages::kPaintForFilaments);
    }

    Complaint component(const XmlAttributes& a) {
        if (object_ == nullptr) return {};
        return placement(a, &object_->components);
    }

    Complaint boolean_shape(const XmlAttributes& a) {
        if (object_ == nullptr) return {};
        using Shape = ThreemfObject::Shape;
        const std::string operation = attribute(a, "operation");
        object_->shape = operation == "difference"                   ? Shape::kDifference
                         : operation.empty() || operation == "union" ? Shape::kUnion
                                                                     : Shape::kOther;
        return component(a);
    }

    /// Cura says in text what an object is for.
    void begin_value(const XmlAttributes& a) {
        constexpr std::string_view kCura = "cura:";
        key_.clear();
        value_.clear();
        if (object_ == nullptr) return;
        if (const char* name = a.find("name"); name != nullptr) {
            const std::string_view text = name;
            if (text.starts_with(kCura)) key_ = text.substr(kCura.size());
        } else if (const char* key = a.find("key"); key != nullptr) {
            key_ = key;
        }
        key_.resize(std::min(key_.size(), kLongestValue));
    }

    void end_value() {
        if (key_.empty() || object_ == nullptr) return;
        static constexpr std::pair<std::string_view, const char*> kHelpers[] = {
            {"support_mesh", messages::kSupportMeshesOfCura},
            {"anti_overhang_mesh", messages::kSupportBlockersOfCura},
            {"infill_mesh", messages::kInfillMeshesOfCura},
            {"cutting_mesh", messages::kSettingsMeshesOfCura}};
        const std::string_view value = trim_threemf(value_);
        for (const auto& [key, what] : kHelpers) {
            if (key == key_ && (value == "True" || value == "true" || value == "1"))
                object_->helper = what;
        }
        int64_t extruder = 0;
        constexpr int64_t kMostExtruders = 1000;
        if (key_ == "extruder_nr" && scan_integer(value, 0, kMostExtruders, &extruder).empty())
            object_->extruder = static_cast<int32_t>(extruder) + 1;
        key_.clear();
    }

    Complaint placement(const XmlAttributes& a, std::vector<ThreemfPlacement>* out) {
        ThreemfPlacement p;
        p.object = needed_integer(a, "objectid");
        p.path = attribute(a, "path");
        const std::string printable = attribute(a, "printable");
        p.printable = printable != "0" && printable != "false";
        if (const char* written = a.find("transform")) {
            std::array<double, kMaxTransform> m{};
            const std::vector<std::string_view> words = threemf_words(written);
            if (words.size() != m.size()) return messages::kTransformNumbers;
            for (size_t i = 0; i < m.size(); ++i) {
                if (std::string wrong = scan_number(words[i], &m[i]); !wrong.empty()) return wrong;
            }
            // Written for row vectors: the columns of our matrix, one after another.
            p.transform = {{m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]},
                           {m[9], m[10], m[11]}};
        }
        const size_t length = p.path.size();
        add(out, std::move(p), length);
        return wrong_;
    }

    int64_t& memory_bytes_;
    ThreemfFieldsReader fields_{&model.fields, &memory_bytes_};
    ThreemfDisplacementReader displacements_;
    std::string file_;
    ThreemfTold& told_;
    std::string wrong_;
    std::string key_, value_;          ///< of the metadata that is open; no key: not of interest
    int unknown_ = 0;                  ///< depth in an element that nothing reads
    ThreemfGroup* group_ = nullptr;    ///< the one that is open
    ThreemfObject* object_ = nullptr;  ///< the one that is open
    int64_t object_id_ = 0;
    std::array<bool, 3> told_paint_{};  ///< of this object
};

}  // namespace

Result<ThreemfModel> parse_threemf_model(std::string_view text, const std::string& file,
                                         int64_t* memory_bytes, ThreemfTold* told) {
    ModelReader reader(memory_bytes, file, told);
    if (Result<void> parsed = parse_xml(text, file, &reader); !parsed) return parsed.error();
    if (const std::string wrong = reader.check_vertices(); !wrong.empty())
        return user_error(fmt::format("{}: {}", file, wrong));
    return std::move(reader.model);
}

}  // namespace openfab::mesh
