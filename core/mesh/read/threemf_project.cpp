// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_project.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/json.h"
#include "base/scan_number.h"
#include "base/text.h"
#include "base/xml.h"
#include "mesh/read/messages.h"
#include "mesh/read/threemf_mixed.h"

namespace openfab::mesh {
namespace {

constexpr int64_t kMostExtruders = 1000;
constexpr size_t kLongestName = 1000;

/// The same in all slicers, under two names.
struct VolumeKind {
    std::string_view prusa, bambu;
    BodyRole role;
    const char* name;
};

constexpr VolumeKind kVolumeKinds[] = {
    {"ModelPart", "normal_part", BodyRole::kPart, ""},
    {"NegativeVolume", "negative_part", BodyRole::kNegative, ""},
    {"ParameterModifier", "modifier_part", BodyRole::kNotPrinted, messages::kModifierVolumes},
    {"SupportEnforcer", "support_enforcer", BodyRole::kNotPrinted, messages::kSupportEnforcers},
    {"SupportBlocker", "support_blocker", BodyRole::kNotPrinted, messages::kSupportBlockers},
};

/// The file that says what objects consist of.
class ObjectsReader : public XmlHandler {
  public:
    ObjectsReader(int64_t* memory_bytes, std::string file, ThreemfTold* told)
        : memory_bytes_(*memory_bytes), file_(std::move(file)), told_(*told) {}

    std::map<int64_t, ThreemfProjectObject> objects;
    int64_t plates = 0;

    Complaint start(std::string_view name, const XmlAttributes& a) override {
        if (name == "plate") ++plates;
        if (name == "object") return begin_object(a);
        if (object_ == nullptr) return {};
        if (name == "volume") return begin_volume(a, "firstid", "lastid");
        if (name == "part") return begin_volume(a, "id", nullptr);
        if (name == "metadata") return metadata(a);
        return {};
    }

    void end(std::string_view name) override {
        if (name == "object") object_ = nullptr;
        if (name == "volume" || name == "part") volume_ = nullptr;
    }

  private:
    static std::string attribute(const XmlAttributes& a, const char* key) {
        const char* value = a.find(key);
        return std::string(value != nullptr ? value : "").substr(0, kLongestName);
    }

    Complaint number(const XmlAttributes& a, const char* key, int64_t* out) {
        if (std::string wrong = scan_integer(attribute(a, key), 0, INT32_MAX, out); !wrong.empty())
            return fmt::format("`{}`: {}", key, wrong);
        return {};
    }

    Complaint take(size_t bytes) {
        memory_bytes_ -= static_cast<int64_t>(3 * bytes);
        if (memory_bytes_ >= 0) return {};
        return {messages::kProjectTakesTooMuch, messages::kAllowMoreMemory};
    }

    Complaint begin_object(const XmlAttributes& a) {
        int64_t id = 0;
        if (Complaint wrong = number(a, "id", &id); !wrong.empty()) return wrong;
        object_ = &objects[id];
        return take(sizeof *object_ + sizeof id);
    }

    Complaint begin_volume(const XmlAttributes& a, const char* first, const char* last) {
        ThreemfVolume volume;
        Complaint wrong = number(a, first, last != nullptr ? &volume.first : &volume.part);
        if (wrong.empty() && last != nullptr) wrong = number(a, last, &volume.last);
        if (!wrong.empty()) return wrong;
        // Each placement of the object goes through all of them.
        constexpr size_t kMostVolumes = 4096;
        if (object_->volumes.size() == kMostVolumes)
            return {fmt::format(messages::kTooManyVolumes, kMostVolumes),
                    messages::kTooManyVolumesHelp};
        object_->volumes.push_back(std::move(volume));
        volume_ = &object_->volumes.back();
        if (const std::string kind = attribute(a, "subtype"); !kind.empty()) set_kind(kind);
        return take(sizeof *volume_);
    }

    void set_kind(const std::string& kind) {
        for (const VolumeKind& one : kVolumeKinds) {
            if (kind != one.prusa && kind != one.bambu) continue;
            volume_->role = one.role;
            volume_->kind = one.name;
            return;
        }
        told_.add(fmt::format(messages::kVolumesOfType, kind), file_, messages::kVolumesOfTypeHelp);
    }

    Complaint metadata(const XmlAttributes& a) {
        const std::string key = attribute(a, "key");
        const std::string value = attribute(a, "value");
        if (key == "name") {
            (volume_ != nullptr ? volume_->name : object_->name) = value;
            return take(value.size());
        }
        if (key == "extruder") {
            int64_t extruder = 0;
            if (!scan_integer(value, 0, kMostExtruders, &extruder).empty()) return {};
            (volume_ != nullptr ? volume_->extruder : object_->extruder) =
                static_cast<int32_t>(extruder);
        }
        if (volume_ == nullptr) return {};
        if (key == "volume_type") set_kind(value);
        // As older versions say it.
        if (key == "modifier" && value == "1" && volume_->role == BodyRole::kPart)
            set_kind("ParameterModifier");
        return {};
    }

    int64_t& memory_bytes_;
    std::string file_;
    ThreemfTold& told_;
    ThreemfProjectObject* object_ = nullptr;  ///< the one that is open
    ThreemfVolume* volume_ = nullptr;         ///< the one that is open
};

/// Heights at which the filament changes.
class HeightsReader : public XmlHandler {
  public:
    int64_t changes = 0;

    Complaint start(std::string_view name, const XmlAttributes& a) override {
        const char* type = a.find("type");
        const char* code = a.find("gcode");
        const std::string_view kind = type != nullptr ? type : "";
        const std::string_view old = code != nullptr ? code : "";
        const bool changes_filament =
            kind == "0" || kind == "2" || (kind.empty() && (old == "M600" || old == "tool_change"));
        if ((name == "code" || name == "layer") && changes_filament) ++changes;
        return {};
    }
    void end(std::string_view) override {}
};

/// Settings by extruder: names and colours of the filaments.
struct Settings {
    std::vector<std::string> extruder_colors, filament_colors, names, types;

    std::vector<std::string>* find(std::string_view key) {
        if (key == "extruder_colour") return &extruder_colors;
        if (key == "filament_colour") return &filament_colors;
        if (key == "filament_settings_id") return &names;
        if (key == "filament_type") return &types;
        return nullptr;
    }

    std::vector<ThreemfFilament> filaments() const {
        const size_t count = std::max(extruder_colors.size(), filament_colors.size());
        std::vector<ThreemfFilament> out(std::min<size_t>(count, kMostExtruders));
        const auto of = [](const std::vector<std::string>& list, size_t i) {
            return i < list.size() ? list[i] : std::string();
        };
        for (size_t i = 0; i < out.size(); ++i) {
            out[i].color = parse_threemf_color(of(extruder_colors, i));
            if (!out[i].color) out[i].color = parse_threemf_color(of(filament_colors, i));
            out[i].name = of(names, i).empty() ? of(types, i) : of(names, i);
        }
        return out;
    }
};

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r\n\"";
    const size_t start = text.find_first_not_of(kBlanks);
    if (start == std::string_view::npos) return {};
    return text.substr(start, text.find_last_not_of(kBlanks) - start + 1);
}

/// Lines `; key = value;value;…` of PrusaSlicer.
Settings parse_lines(std::string_view text) {
    Settings out;
    while (!text.empty()) {
        std::string_view line = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(line.size() + 1, text.size()));
        if (line.starts_with(';')) line.remove_prefix(1);
        const size_t equal = line.find('=');
        if (equal == std::string_view::npos) continue;
        std::vector<std::string>* list = out.find(trimmed(line.substr(0, equal)));
        if (list == nullptr) continue;
        line.remove_prefix(equal + 1);
        while (list->size() < kMostExtruders) {
            const size_t end = std::min(line.find(';'), line.size());
            list->emplace_back(trimmed(line.substr(0, end)).substr(0, kLongestName));
            if (end == line.size()) break;
            line.remove_prefix(end + 1);
        }
    }
    return out;
}

/// The JSON of Bambu Studio and OrcaSlicer.
Settings parse_settings(const JsonValue& json) {
    Settings out;
    for (const char* key :
         {"extruder_colour", "filament_colour", "filament_settings_id", "filament_type"}) {
        const JsonMember* member = json.find(key);
        if (member == nullptr) continue;
        for (const JsonValue& item : member->value.items) {
            if (out.find(key)->size() < kMostExtruders)
                out.find(key)->push_back(item.text.substr(0, kLongestName));
        }
    }
    return out;
}

constexpr const char* kAnnotations = "Metadata/Slic3r_facets_annotation.json";

/// The number of an object, which scripts write as text, too.
std::optional<int64_t> object_id(const JsonValue& object) {
    const JsonMember* id = object.find("id");
    int64_t number = 0;
    if (id == nullptr) return {};
    if (id->value.is(JsonValue::Kind::kNumber)) return id->value.whole();
    if (!scan_integer(id->value.text, 0, INT32_MAX, &number).empty()) return {};
    return number;
}

class ProjectReader {
  public:
    ProjectReader(const ZipFile& zip, const std::string& file, int64_t* memory_bytes,
                  ThreemfTold* told)
        : zip_(zip), file_(file), memory_bytes_(*memory_bytes), told_(*told) {}

    Result<ThreemfProject> read() {
        Result<void> done = read_objects();
        if (done) done = read_settings();
        if (done) done = read_mixtures();
        if (done) done = read_paint();
        if (done) done = read_heights();
        if (!done) return done.error();
        tell_of_cura();
        tell_of_resin();
        return std::move(project_);
    }

  private:
    std::string path(const char* part) const { return fmt::format("{}: {}", file_, part); }

    /// Some programs write their own and PrusaSlicer's: the first counts.
    template <typename Names, typename Read>
    Result<void> first_of(const Names& names, const Read& read) {
        for (const char* name : names) {
            if (!zip_.has(name)) continue;
            const Result<std::string> text = zip_.read(name, memory_bytes_);
            if (!text) return text.error();
            const auto length = static_cast<int64_t>(text->size());
            memory_bytes_ -= length;
            Result<void> done = read(*text, name);
            memory_bytes_ += length;
            return done;
        }
        return Ok{};
    }

    Result<void> read_objects() {
        constexpr const char* kNames[] = {
            "Metadata/model_settings.config", "Metadata/Slic3r_PE_model.config",
            "Metadata/SuperSlicer_model.config", "Metadata/Slic3r_model.config"};
        return first_of(kNames, [&](std::string_view text, const char* name) -> Result<void> {
            ObjectsReader reader(&memory_bytes_, path(name), &told_);
            const Result<void> parsed = parse_xml(text, path(name), &reader);
            if (!parsed) return parsed.error();
            project_.objects = std::move(reader.objects);
            if (reader.plates > 1)
                told_.add(fmt::format(messages::kDivisionIntoPlates, reader.plates), name,
                          messages::kDivisionIntoPlatesHelp);
            return Ok{};
        });
    }

    Result<void> read_settings() {
        constexpr const char* kNames[] = {"Metadata/project_settings.config",
                                          "Metadata/Slic3r_PE.config",
                                          "Metadata/SuperSlicer.config", "Metadata/Slic3r.config"};
        return first_of(kNames, [&](std::string_view text, const char* name) -> Result<void> {
            told_.add(messages::kSlicerSettings, name, messages::kSlicerSettingsHelp);
            if (!trimmed(text).starts_with('{')) {
                project_.filaments = parse_lines(text).filaments();
                return Ok{};
            }
            const Result<JsonValue> json = parse_json(text, path(name), memory_bytes_);
            if (!json) return json.error();
            project_.filaments = parse_settings(*json).filaments();
            mix_filaments(*json, name, &project_.filaments, &told_);
            return Ok{};
        });
    }

    Result<void> read_mixtures() {
        constexpr const char* kNames[] = {"Metadata/Prusa_Slicer_full_spectrum.json"};
        return first_of(kNames, [&](std::string_view text, const char* name) -> Result<void> {
            const Result<JsonValue> json = parse_json(text, path(name), memory_bytes_);
            if (!json) return json.error();
            mix_extruders(*json, name, &project_.filaments, &told_);
            return Ok{};
        });
    }

    /// What PrusaSlicer 3 paints; supports and seams are the slicer's.
    Result<void> read_paint() {
        constexpr const char* kNames[] = {kAnnotations};
        return first_of(kNames, [&](std::string_view text, const char* name) -> Result<void> {
            const Result<JsonValue> json = parse_json(text, path(name), memory_bytes_);
            if (!json) return json.error();
            if (!json->is(JsonValue::Kind::kArray))
                told_.add(messages::kPaintBeside, name, messages::kPaintBesideHelp);
            for (const JsonValue& object : json->items) {
                const JsonMember* facets = object.find("mmSegmentationFacets");
                if (facets == nullptr) continue;
                const JsonMember* version = object.find("mmSegmentationFacetsVersion");
                const double number = version != nullptr ? version->value.number : 1;
                if (number > 2)
                    return user_error(fmt::format(messages::kPaintOfNewerVersion, path(name)),
                                      messages::kPaintOfNewerVersionHelp);
                if (facets->value.items.empty()) continue;
                const std::optional<int64_t> id = object_id(object);
                if (!id) {
                    told_.add(messages::kPaintBeside, name, messages::kPaintBesideHelp);
                    continue;
                }
                ThreemfAnnotation& out = project_.annotations[*id];
                out.escapes = number == 2;
                if (Result<void> done = read_facets(facets->value, path(name), &out.paints); !done)
                    return done;
            }
            return Ok{};
        });
    }

    Result<void> read_facets(const JsonValue& facets, const std::string& place,
                             std::vector<std::pair<int32_t, std::string>>* out) {
        for (const JsonValue& facet : facets.items) {
            const JsonMember* triangle = facet.find("triangle");
            const JsonMember* code = facet.find("dividing");
            if (triangle == nullptr || code == nullptr || code->value.text.empty()) continue;
            const double number = triangle->value.number;
            if (!(number >= 0 && number < INT32_MAX))
                return user_error(fmt::format(messages::kPaintOfNoTriangle, place, number));
            memory_bytes_ -= static_cast<int64_t>(3 * (sizeof(*out)[0] + code->value.text.size()));
            if (memory_bytes_ < 0)
                return user_error(fmt::format("{}: {}", place, messages::kProjectTakesTooMuch),
                                  messages::kAllowMoreMemory);
            out->emplace_back(static_cast<int32_t>(number), code->value.text);
        }
        std::stable_sort(out->begin(), out->end(),
                         [](const auto& a, const auto& b) { return a.first < b.first; });
        out->erase(std::unique(out->begin(), out->end(),
                               [](const auto& a, const auto& b) { return a.first == b.first; }),
                   out->end());
        return Ok{};
    }

    Result<void> read_heights() {
        constexpr const char* kNames[] = {"Metadata/custom_gcode_per_layer.xml",
                                          "Metadata/Prusa_Slicer_custom_gcode_per_print_z.xml"};
        return first_of(kNames, [&](std::string_view text, const char* name) -> Result<void> {
            HeightsReader reader;
            const Result<void> parsed = parse_xml(text, path(name), &reader);
            if (!parsed) return parsed.error();
            for (int64_t i = 0; i < reader.changes; ++i)
                told_.add(messages::kFilamentChanges, name, messages::kFilamentChangesHelp);
            return Ok{};
        });
    }

    /// Of what Cura writes, the models alone are read.
    void tell_of_cura() {
        const char* const preferences = "Cura/preferences.cfg";
        if (zip_.has(preferences))
            told_.add(messages::kSlicerSettings, preferences, messages::kFilamentColours);
    }

    void tell_of_resin() {
        const char* const holes = "Metadata/Slic3r_PE_sla_drain_holes.txt";
        if (zip_.has(holes)) told_.add(messages::kDrainHoles, holes, messages::kDrainHolesHelp);
        const char* const points = "Metadata/Slic3r_PE_sla_support_points.txt";
        if (zip_.has(points))
            told_.add(messages::kSupportPoints, points, messages::kSupportPointsHelp);
    }

    const ZipFile& zip_;
    const std::string& file_;
    int64_t& memory_bytes_;
    ThreemfTold& told_;
    ThreemfProject project_;
};

}  // namespace

std::string ThreemfProject::paint(int64_t id, const std::string& name, ThreemfObject* object) {
    const auto it = annotations.find(id);
    if (it == annotations.end() || object->triangles.empty()) return {};
    ThreemfAnnotation& beside = it->second;
    beside.used = true;
    if (beside.paints.empty() || !object->paints.empty()) return {};
    object->paints = beside.paints;
    object->paint_escapes = beside.escapes;
    const auto last = static_cast<size_t>(object->paints.back().first);
    if (last < object->triangles.size()) return {};
    return fmt::format(messages::kPaintOfNoTriangle, name, last);
}

void ThreemfProject::tell_of_unused_paint(ThreemfTold* told) const {
    for (const auto& [object, paint] : annotations) {
        if (!paint.used && !paint.paints.empty())
            told->add(messages::kPaintBeside, kAnnotations, messages::kPaintBesideHelp);
    }
}

bool ThreemfProjectObject::has_ranges() const {
    return std::any_of(volumes.begin(), volumes.end(),
                       [](const ThreemfVolume& volume) { return volume.part < 0; });
}

const ThreemfVolume* ThreemfProjectObject::component(int64_t object) const {
    const auto it = std::find_if(volumes.begin(), volumes.end(), [&](const ThreemfVolume& volume) {
        return volume.part == object;
    });
    return it != volumes.end() ? &*it : nullptr;
}

std::vector<ThreemfPiece> ThreemfProjectObject::split(const ThreemfObject& object,
                                                      int64_t* passed) const {
    std::vector<ThreemfPiece> pieces(volumes.size() + 1);  // the last one is of no volume
    std::vector<std::pair<int64_t, size_t>> starts;
    for (size_t i = 0; i < volumes.size(); ++i) {
        pieces[i].volume = &volumes[i];
        starts.emplace_back(volumes[i].first, i);
    }
    std::sort(starts.begin(), starts.end());
    int64_t count = 0;
    for (size_t t = 0; t < object.triangles.size(); ++t) {
        const int64_t source = object.sources.empty() ? static_cast<int64_t>(t) : object.sources[t];
        count = std::max(count, source + 1);
        const int64_t number = *passed + source;
        auto after =
            std::upper_bound(starts.begin(), starts.end(), std::pair(number, volumes.size()));
        size_t piece = volumes.size();
        if (after != starts.begin() && number <= volumes[std::prev(after)->second].last)
            piece = std::prev(after)->second;
        pieces[piece].triangles.push_back(static_cast<int32_t>(t));
    }
    *passed += count;
    return pieces;
}

Result<ThreemfProject> read_threemf_project(const ZipFile& zip, const std::string& file,
                                            int64_t* memory_bytes, ThreemfTold* told) {
    return ProjectReader(zip, file, memory_bytes, told).read();
}

}  // namespace openfab::mesh
