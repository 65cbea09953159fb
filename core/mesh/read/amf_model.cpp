// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/amf_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <initializer_list>
#include <limits>

#include "base/scan_number.h"
#include "base/text.h"
#include "base/xml.h"
#include "mesh/model/mesh_source.h"
#include "mesh/read/messages.h"
#include "mesh/read/threemf_text.h"

namespace openfab::mesh {
namespace {

/// Of a name, or of the texts in between that nobody needs.
constexpr size_t kLongestText = 4096;
constexpr size_t kDeepest = 64;
constexpr int64_t kNode = 300;  ///< bytes of an object, a material, a constellation

constexpr std::pair<std::string_view, double> kUnits[] = {
    {"millimeter", 1}, {"inch", 25.4},    {"feet", 304.8},      {"foot", 304.8},
    {"meter", 1000},   {"micron", 0.001}, {"micrometer", 0.001}};

/// Volumes of PrusaSlicer that are no part of what is printed.
constexpr std::pair<std::string_view, const char*> kSlicerVolumes[] = {
    {"ParameterModifier", messages::kAmfModifiers},
    {"SupportEnforcer", messages::kAmfSupports},
    {"SupportBlocker", messages::kAmfSupports}};

class AmfHandler final : public XmlHandler {
  public:
    AmfHandler(std::string file, int64_t* memory_bytes)
        : file_(std::move(file)), memory_bytes_(*memory_bytes) {}

    AmfModel model;
    const std::string& wrong() const { return wrong_; }

    bool wants_text() const override { return true; }
    void text(std::string_view piece) override {
        if (text_.size() + piece.size() <= kLongestText) text_ += piece;
    }

    Complaint start(std::string_view name, const XmlAttributes& a) override {
        if (path_.size() >= kDeepest) fail(fmt::format(messages::kAmfTooDeep, kDeepest));
        if (path_.empty() && name != "amf") fail(messages::kNoAmf);
        text_.clear();
        const std::string_view parent = in();
        if (name == "amf") {
            begin_file(a);
        } else if (parent == "amf") {
            begin_resource(name, a);
        } else if (!skips_) {
            begin_part(name, a);
        }
        path_.emplace_back(name);
        if (memory_bytes_ < 0) fail(messages::kAmfTakesTooMuch);
        return {wrong_, {}};
    }

    void end(std::string_view name) override {
        path_.pop_back();
        const std::string_view parent = in();
        if (parent == "amf" || parent.empty()) {
            skips_ = false;
            if (name == "metadata") take_file_metadata();
            if (parent.empty()) in_degrees();
        } else if (!skips_) {
            take(name);
        }
        text_.clear();
    }

    /// What is checked once the file is read.
    Result<void> finish() const {
        if (!wrong_.empty()) return user_error(fmt::format("{}: {}", file_, wrong_));
        return {};
    }

  private:
    std::string_view in() const {
        return path_.empty() ? std::string_view() : std::string_view(path_.back());
    }

    /// Whether the element that holds this one is at such a path below `amf`, so that what begins there is
    /// there.
    bool within(std::initializer_list<std::string_view> path) const {
        return path_.size() == path.size() + 1 &&
               std::equal(path.begin(), path.end(), path_.begin() + 1);
    }

    void fail(std::string what) {
        if (wrong_.empty()) wrong_ = std::move(what);
    }

    void leave_out(const char* what, const char* remedy) { model.told.add(what, place(), remedy); }

    std::string place() const {
        if (model.objects.empty()) return file_;
        return fmt::format("object {}", model.objects.back().id);
    }

    template <typename T>
    T& add(std::vector<T>* list, T value) {
        memory_bytes_ -= static_cast<int64_t>(3 * sizeof(T));
        list->push_back(std::move(value));
        return list->back();
    }

    void begin_file(const XmlAttributes& a) {
        const char* unit = a.find("unit");
        if (unit == nullptr) return;
        const std::string wanted = lower_ascii(unit);
        for (const auto& [name, mm] : kUnits) {
            if (wanted != name) continue;
            model.unit_mm = mm;
            return;
        }
        fail(fmt::format(messages::kAmfUnit, printable(wanted)));
    }

    int64_t id(const XmlAttributes& a, const char* key) {
        const char* text = a.find(key);
        int64_t value = -1;
        if (text == nullptr) return fail(fmt::format(messages::kAmfLacksId, key)), -1;
        return read_id(text, &value) ? value : -1;
    }

    bool read_id(std::string_view text, int64_t* out) {
        text = trim_threemf(text);
        const char* const end = text.data() + text.size();
        const auto [at, failed] = std::from_chars(text.data(), end, *out);
        if (failed == std::errc{} && at == end && *out >= 0 && *out <= INT32_MAX) return true;
        fail(fmt::format(messages::kAmfNoId, printable(text.substr(0, 40))));
        return false;
    }

    void begin_resource(std::string_view name, const XmlAttributes& a) {
        if (name == "object") {
            AmfObject object;
            object.id = id(a, "id");
            memory_bytes_ -= kNode;
            model.objects.push_back(std::move(object));
        } else if (name == "material") {
            memory_bytes_ -= kNode;
            material_ = &model.materials[id(a, "id")];
        } else if (name == "constellation") {
            memory_bytes_ -= kNode;
            constellation_ = &model.constellations[id(a, "id")];
        } else {
            // Its data, a picture's, are long; of the file's own metadata nothing is needed.
            skips_ = name != "metadata";
            set_metadata(a);
            if (name == "texture") leave_out(messages::kAmfPictures, messages::kSaveAs3mfOrObj);
        }
    }

    void begin_part(std::string_view name, const XmlAttributes& a) {
        if (name == "vertex" && within({"object", "mesh", "vertices"})) {
            constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
            add(&object().vertices, Vec3d{kNone, kNone, kNone});
        } else if (name == "volume" && within({"object", "mesh"})) {
            AmfVolume volume;
            if (a.find("materialid") != nullptr) volume.material = id(a, "materialid");
            const char* type = a.find("type");
            if (type != nullptr && std::string_view(type) == "support") {
                volume.role = BodyRole::kNotPrinted;
                volume.use = messages::kAmfSupports;
            }
            add(&object().volumes, std::move(volume));
        } else if (name == "triangle" && within({"object", "mesh", "volume"})) {
            add(&volume().triangles, AmfTriangle());
        } else if (name == "color") {
            color_ = {0, 0, 0, 1};
            color_known_ = true;
            const char* profile = a.find("profile");
            if (profile != nullptr && lower_ascii(profile) != "srgb")
                leave_out(messages::kAmfColourSpaces, messages::kSaveAs3mfOrObj);
        } else if (name == "composite" && within({"material"})) {
            add(&material_->parts, std::pair(id(a, "materialid"), 0.0));
        } else if (name == "instance" && within({"constellation"})) {
            AmfInstance instance;
            instance.id = id(a, "objectid");
            add(constellation_, instance);
        } else if (name == "normal" || name == "edge") {
            leave_out(messages::kAmfCurves, messages::kAmfCurvesHelp);
        } else if (name == "texmap" || name == "map") {
            leave_out(messages::kAmfPictures, messages::kSaveAs3mfOrObj);
        } else if (name == "metadata") {
            set_metadata(a);
        }
    }

    void set_metadata(const XmlAttributes& a) {
        const char* type = a.find("type");
        metadata_ = type == nullptr ? "" : type;
    }

    /// Slic3r and those that came of it write angles in radians, where the format has degrees.
    void take_file_metadata() {
        const std::string program = lower_ascii(text_);
        radians_ = radians_ || metadata_ == "slic3rpe_amf_version" ||
                   (metadata_ == "cad" && (program.find("slic3r") != std::string::npos ||
                                           program.find("slicer") != std::string::npos));
    }

    void in_degrees() {
        constexpr double kDegrees = 57.295779513082321;
        if (!radians_) return;
        for (auto& [id, instances] : model.constellations) {
            for (AmfInstance& instance : instances)
                instance.rotation_deg = instance.rotation_deg * kDegrees;
        }
    }

    AmfObject& object() { return model.objects.back(); }
    /// That of a triangle, which the path says to be there.
    AmfVolume& volume() { return object().volumes.back(); }

    double number() {
        double value = 0;
        const std::string_view text = trim_threemf(text_);
        if (!scan_number(text, &value).empty())
            fail(fmt::format(messages::kAmfNoNumber, printable(text.substr(0, 40))));
        return value;
    }

    void take(std::string_view name) {
        const bool is_axis = name == "x" || name == "y" || name == "z";
        if (is_axis && within({"object", "mesh", "vertices", "vertex", "coordinates"})) {
            object().vertices.back()[name[0] - 'x'] = number();
        } else if (within({"object", "mesh", "volume", "triangle"}) && name.size() == 2 &&
                   name[0] == 'v' && name[1] >= '1' && name[1] <= '3') {
            int64_t index = 0;
            if (read_id(text_, &index))
                volume().triangles.back().vertices[static_cast<size_t>(name[1] - '1')] =
                    static_cast<int32_t>(index);
        } else if (in() == "color" && name.size() == 1) {
            take_channel(name[0]);
        } else if (name == "color") {
            take_color();
        } else if (name == "composite" && within({"material"})) {
            double share = 0;
            if (scan_number(trim_threemf(text_), &share).empty()) {
                material_->parts.back().second = share;
            } else {
                material_->has_formula = true;
            }
        } else if (name == "metadata") {
            take_metadata();
        } else if (within({"constellation", "instance"})) {
            AmfInstance& instance = constellation_->back();
            if (name.starts_with("delta") && name.size() == 6 && name[5] >= 'x' && name[5] <= 'z')
                instance.delta[name[5] - 'x'] = number();
            if (name.size() == 2 && name[0] == 'r' && name[1] >= 'x' && name[1] <= 'z')
                instance.rotation_deg[name[1] - 'x'] = number();
            take_of_slicer(name, &instance);
        } else if (name == "triangle" && within({"object", "mesh", "volume"})) {
            check_triangle();
        }
    }

    void take_of_slicer(std::string_view name, AmfInstance* instance) {
        const bool has_axis = name.back() >= 'x' && name.back() <= 'z';
        const std::string_view what = has_axis ? name.substr(0, name.size() - 1) : name;
        if (what == "scale" && !has_axis) {
            const double all = number();
            instance->scale = {all, all, all};
        } else if (what == "scale") {
            instance->scale[name.back() - 'x'] = number();
        } else if (what == "mirror" && has_axis) {
            instance->mirror[name.back() - 'x'] = number();
        } else if (name == "printable") {
            instance->printable = number() != 0;
        }
    }

    /// Vertices precede volumes, as the format's order of elements is.
    void check_triangle() {
        for (const int32_t v : volume().triangles.back().vertices) {
            if (v < 0 || static_cast<size_t>(v) >= object().vertices.size())
                fail(fmt::format(messages::kAmfNoVertex, v, object().id, object().vertices.size()));
        }
    }

    void take_channel(char channel) {
        const size_t at = std::string_view("rgba").find(channel);
        if (at == std::string_view::npos) return;
        double value = 0;
        if (scan_number(trim_threemf(text_), &value).empty()) {
            color_[at] = std::min(std::max(value, 0.0), 1.0);
        } else {
            color_known_ = false;
        }
    }

    void take_color() {
        if (!color_known_)
            return leave_out(messages::kAmfColourFormulas, messages::kAmfColourFormulasHelp);
        if (model.colors.empty() || model.colors.back() != color_) add(&model.colors, color_);
        const auto index = static_cast<AmfColorIndex>(model.colors.size() - 1);
        if (within({"object", "mesh", "vertices", "vertex"})) {
            std::vector<AmfColorIndex>& colors = object().vertex_colors;
            memory_bytes_ -= static_cast<int64_t>(3 * sizeof(AmfColorIndex));
            colors.resize(object().vertices.size(), -1);
            colors.back() = index;
        } else if (within({"object", "mesh", "volume", "triangle"})) {
            volume().triangles.back().color = index;
        } else if (within({"object", "mesh", "volume"})) {
            volume().color = index;
        } else if (within({"object"})) {
            object().color = index;
        } else if (within({"material"})) {
            material_->color = index;
        }
    }

    void take_metadata() {
        const std::string value(trim_threemf(text_));
        memory_bytes_ -= static_cast<int64_t>(value.size());
        int64_t number = 0;
        const bool of_object = within({"object"});
        if (within({"material"}) && metadata_ == "name") {
            material_->name = value;
        } else if (of_object && metadata_ == "name") {
            object().name = value;
        } else if (of_object && metadata_ == "slic3r.extruder") {
            if (read_id(value, &number)) object().extruder = static_cast<int32_t>(number);
        } else if (!within({"object", "mesh", "volume"})) {
            return;
        } else if (metadata_ == "name") {
            volume().name = value;
        } else if (metadata_ == "slic3r.extruder") {
            if (read_id(value, &number)) volume().extruder = static_cast<int32_t>(number);
        } else if (metadata_ == "slic3r.modifier" && value == "1") {
            not_printed(messages::kAmfModifiers);
        } else if (metadata_ == "slic3r.volume_type") {
            if (value == "NegativeVolume") volume().role = BodyRole::kNegative;
            for (const auto& [type, use] : kSlicerVolumes) {
                if (value == type) not_printed(use);
            }
        }
    }

    void not_printed(const char* use) {
        volume().role = BodyRole::kNotPrinted;
        volume().use = use;
    }

    std::string file_, text_, metadata_, wrong_;
    std::vector<std::string> path_;
    AmfColor color_{};
    bool color_known_ = true, radians_ = false;
    bool skips_ = false;  ///< what is in a resource that is not read
    AmfMaterial* material_ = nullptr;
    std::vector<AmfInstance>* constellation_ = nullptr;
    int64_t& memory_bytes_;
};

}  // namespace

Result<AmfModel> parse_amf_model(std::string_view text, const std::string& file,
                                 int64_t* memory_bytes) {
    AmfHandler handler(file, memory_bytes);
    if (Result<void> parsed = parse_xml(text, file, &handler); !parsed) return parsed.error();
    if (Result<void> fine = handler.finish(); !fine) return fine.error();
    return std::move(handler.model);
}

}  // namespace openfab::mesh
