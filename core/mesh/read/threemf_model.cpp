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
#include "mesh/read/threemf_element.h"
#include "mesh/read/threemf_extensions.h"
#include "mesh/read/threemf_properties.h"
#include "mesh/read/threemf_text.h"

namespace openfab::mesh {
namespace {

constexpr size_t kMaxTransform = 12;
/// Text of a metadata element that is of interest: a truth value or a number.
constexpr size_t kLongestValue = 64;

class ModelReader : public XmlHandler, ThreemfElementReader {
  public:
    ModelReader(int64_t* memory_bytes, std::string file, ThreemfTold* told)
        : ThreemfElementReader(memory_bytes), file_(std::move(file)), told_(*told) {}

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
        wrong_.clear();
        // Drafts of 3MF had volumetric data inside of meshes.
        if (fields_.takes(name) && (object_ == nullptr || name != "volumedata"))
            return fields_.start(name, a);
        if (name == "vertex") return vertex(a);
        if (name == "triangle") return triangle(a);
        if (ThreemfPropertiesReader::takes(name)) return properties_.start(name, a);
        if (name == "model") return root(a);
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
        properties_.end(name);
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

    /// Whether paint is of a version of PrusaSlicer that has yet to come.
    bool has_newer_paint() const { return newer_paint_; }

  private:
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
            told_.add(messages::kLatticesOfBeams, place(), messages::kLatticesOfBeamsHelp,
                      LeftOutKind::kLattices);
            object_->lattice = std::make_shared<ThreemfLattice>();
        }
        if (object_->lattice == nullptr) return {};
        return ThreemfLatticeReader::read(name, a, object_->lattice.get(), &memory_bytes_);
    }

    /// Which programs that read meshes alone tell of.
    Complaint level_set(const XmlAttributes& a) {
        told_.add(messages::kLevelSets, place(), messages::kImportRemedy, LeftOutKind::kLevelSets);
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
        told_.add(messages::kDisplacements, place(), messages::kImportRemedy,
                  LeftOutKind::kDisplacements);
        object_->displaced = std::make_shared<ThreemfDisplaced>();
    }

    void volume_of_mesh(const XmlAttributes& a) {
        if (object_ == nullptr) return;
        object_->volume = integer(a, "volumeid", -1);
        if (object_->volume >= 0)
            told_.add(messages::kVolumetricData, place(), messages::kImportRemedy,
                      LeftOutKind::kVolumetricData);
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
            if (name == "mmu_segmentation") object_->paint_escapes = painting_version_ == 2;
            newer_paint_ = newer_paint_ || (name == "mmu_segmentation" && painting_version_ > 2);
        } else if (name == "paint_supports" || name == "custom_supports") {
            tell_paint(0, messages::kPaintedSupports);
        } else if (name == "paint_seam" || name == "custom_seam") {
            tell_paint(1, messages::kPaintedSeams);
        } else if (name == "paint_fuzzy_skin" || name == "fuzzy_skin") {
            tell_paint(2, messages::kPaintedFuzzySkin);
        }
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
        if (object_ == nullptr) {
            const char* name = a.find("name");
            if (name != nullptr && std::string_view(name) == kPaintingVersion)
                key_ = kPaintingVersion;
            return;
        }
        if (const char* name = a.find("name"); name != nullptr) {
            const std::string_view text = name;
            if (text.starts_with(kCura)) key_ = text.substr(kCura.size());
        } else if (const char* key = a.find("key"); key != nullptr) {
            key_ = key;
        }
        key_.resize(std::min(key_.size(), kLongestValue));
    }

    void end_value() {
        if (key_ == kPaintingVersion && object_ == nullptr) {
            key_.clear();
            constexpr int64_t kLast = 2;
            if (!scan_integer(trim_threemf(value_), 0, kLast, &painting_version_).empty())
                painting_version_ = kLast + 1;
        }
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

    ThreemfPropertiesReader properties_{&model, &memory_bytes_};
    ThreemfFieldsReader fields_{&model.fields, &memory_bytes_};
    ThreemfDisplacementReader displacements_;
    std::string file_;
    ThreemfTold& told_;
    static constexpr std::string_view kPaintingVersion = "slic3rpe:MmPaintingVersion";
    int64_t painting_version_ = 0;
    bool newer_paint_ = false;
    std::string key_, value_;          ///< of the metadata that is open; no key: not of interest
    int unknown_ = 0;                  ///< depth in an element that nothing reads
    ThreemfObject* object_ = nullptr;  ///< the one that is open
    int64_t object_id_ = 0;
    std::array<bool, 3> told_paint_{};  ///< of this object
};

}  // namespace

Result<ThreemfModel> parse_threemf_model(std::string_view text, const std::string& file,
                                         int64_t* memory_bytes, ThreemfTold* told) {
    ModelReader reader(memory_bytes, file, told);
    if (Result<void> parsed = parse_xml(text, file, &reader); !parsed) return parsed.error();
    if (reader.has_newer_paint())
        return user_error(fmt::format(messages::kPaintOfNewerVersion, file),
                          messages::kPaintOfNewerVersionHelp);
    if (const std::string wrong = reader.check_vertices(); !wrong.empty())
        return user_error(fmt::format("{}: {}", file, wrong));
    return std::move(reader.model);
}

}  // namespace openfab::mesh
