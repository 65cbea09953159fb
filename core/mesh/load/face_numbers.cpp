// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/load/face_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "mesh/model/messages.h"

namespace openfab::mesh {
namespace {

class Numberer {
  public:
    Numberer(MeshSource* source, const MeshOptions& options)
        : source_(*source), options_(options), name_(options.groups_attribute.value_or("face")) {}

    Result<FaceNumbers> number() {
        if (options_.groups) {
            if (Result<void> mapped = by_map(); !mapped) return mapped.error();
        } else {
            by_order();
        }
        return std::move(out_);
    }

  private:
    static std::vector<std::string> names_of(const FaceGroup& group) {
        std::vector<std::string> names = group.names;
        if (!group.material.empty()) names.push_back(group.material);
        if (names.empty()) names.emplace_back("default");
        return names;
    }

    /// Returns a triangle of each group.
    std::vector<int32_t> first_triangles() const {
        std::vector<int32_t> first(source_.groups.size(), -1);
        for (size_t t = source_.face_groups.size(); t-- > 0;)
            first[source_.face_groups[t]] = static_cast<int32_t>(t);
        return first;
    }

    Result<void> by_map() {
        // A file without groups has one group named "default".
        if (source_.groups.empty()) {
            source_.groups.push_back({});
            source_.face_groups.assign(source_.mesh.triangles.size(), 0);
        }
        const std::vector<int32_t> first = first_triangles();
        std::vector<int32_t> values(source_.groups.size());
        for (size_t g = 0; g < values.size(); ++g) {
            if (first[g] < 0) continue;
            const Result<int32_t> value = mapped(source_.groups[g], first[g]);
            if (!value) return value.error();
            values[g] = *value;
        }
        std::set<std::string> known;
        for (size_t g = 0; g < values.size(); ++g) {
            if (first[g] < 0) continue;
            const std::vector<std::string> names = names_of(source_.groups[g]);
            known.insert(names.begin(), names.end());
        }
        for (const auto& [name, value] : *options_.groups) {
            out_.groups.emplace_back(name, value);
            if (options_.body.empty() && !known.contains(name))
                source_.warnings.push_back(fmt::format(messages::kGroupNotInFile, options_.name,
                                                       name, source_.origin.file, all_names()));
        }
        add_attribute(values);
        return Ok{};
    }

    Result<int32_t> mapped(const FaceGroup& group, int32_t triangle) const {
        const std::vector<std::string> names = names_of(group);
        const std::string* found = nullptr;
        int32_t value = 0;
        for (const std::string& name : names) {
            const auto it = options_.groups->find(name);
            if (it == options_.groups->end()) continue;
            if (found != nullptr && value != it->second) {
                return error_at(
                    source_.origin.location(triangle),
                    fmt::format(messages::kFaceInTwoGroups, *found, value, name, it->second),
                    messages::kFaceInTwoGroupsHelp);
            }
            value = it->second;
            found = &name;
        }
        if (found != nullptr) return value;
        std::string list;
        for (const std::string& name : names)
            list += fmt::format("{}`{}`", list.empty() ? "" : ", ", name);
        return error_at(source_.origin.location(triangle),
                        fmt::format(messages::kGroupNotMapped, list, options_.name), all_names());
    }

    std::string all_names() const {
        std::set<std::string> names;
        for (const FaceGroup& group : source_.groups) {
            names.insert(group.names.begin(), group.names.end());
            if (!group.material.empty()) names.insert(group.material);
        }
        if (names.empty()) return messages::kFileNamesNoGroups;
        constexpr size_t kMost = 12;
        std::string text = messages::kFileHas;
        size_t shown = 0;
        for (const std::string& name : names) {
            if (shown == kMost) return text + fmt::format(messages::kAndMore, names.size() - kMost);
            text += fmt::format("{}`{}`", shown++ == 0 ? "" : ", ", name);
        }
        return text;
    }

    void by_order() {
        const std::vector<FaceGroup>& groups = source_.groups;
        const bool materials = std::any_of(groups.begin(), groups.end(),
                                           [](const FaceGroup& g) { return !g.material.empty(); });
        const bool looks = std::any_of(groups.begin(), groups.end(), [&](const FaceGroup& g) {
            return g.look != groups[0].look;
        });
        const auto name_of = [&](const FaceGroup& group) {
            if (materials || looks) return group.material;
            std::string name;
            for (const std::string& part : group.names)
                name += (name.empty() ? "" : " ") + part;
            return name;
        };
        std::map<std::pair<std::string, int32_t>, int32_t> numbers;
        std::vector<int32_t> values(groups.size(), -1);
        bool told_apart = false;
        for (int32_t g : source_.face_groups) {
            int32_t& value = values[g];
            if (value >= 0) continue;
            const std::string name = name_of(groups[g]);
            const auto [it, fresh] = numbers.emplace(std::pair(name, groups[g].look),
                                                     static_cast<int32_t>(numbers.size()));
            value = it->second;
            told_apart = told_apart || !name.empty() || numbers.size() > 1;
            if (!fresh) continue;
            out_.groups.emplace_back(name.empty() ? "default" : name, value);
            out_.look_of.push_back(groups[g].look);
        }
        if (told_apart && source_.mesh.find(name_) == nullptr) {
            add_attribute(values);
        } else {
            out_.groups.clear();
            out_.look_of.resize(std::min<size_t>(out_.look_of.size(), 1));
            if (options_.groups_attribute)
                source_.warnings.push_back(fmt::format(messages::kNoGroupsToNumber, options_.name,
                                                       source_.origin.file, name_));
        }
    }

    void add_attribute(const std::vector<int32_t>& values) {
        std::erase_if(source_.mesh.attributes,
                      [&](const MeshAttribute& a) { return a.name == name_; });
        MeshAttribute a;
        a.name = name_;
        a.is_int = true;
        a.faces.reserve(source_.face_groups.size());
        for (int32_t g : source_.face_groups)
            a.faces.push_back(values[g]);
        source_.mesh.attributes.push_back(std::move(a));
    }

    MeshSource& source_;
    const MeshOptions& options_;
    const std::string name_;  ///< of the attribute
    FaceNumbers out_;
};

bool has_all(const std::array<int32_t, 3>& corners) {
    return corners[0] >= 0 && corners[1] >= 0 && corners[2] >= 0;
}

/// Returns whether some group has a look of which `uses` is true.
template <typename Uses>
bool any_look(const std::vector<Look>& looks, const MeshSource& source, const Uses& uses) {
    return std::any_of(source.groups.begin(), source.groups.end(), [&](const FaceGroup& group) {
        return group.look >= 0 && uses(looks[group.look]);
    });
}

/// Gives faces without a value, and those of which `unused` is true, one of `value` in each
/// component.
template <typename Unused>
void fill(float value, const Unused& unused, MeshAttribute* a) {
    const auto added = static_cast<int32_t>(a->values.size() / static_cast<size_t>(a->components));
    a->values.insert(a->values.end(), static_cast<size_t>(a->components), value);
    for (size_t t = 0; t < a->corners.size(); ++t) {
        if (!has_all(a->corners[t]) || unused(t)) a->corners[t] = {added, added, added};
    }
}

}  // namespace

Result<FaceNumbers> number_faces(MeshSource* source, const MeshOptions& options) {
    return Numberer(source, options).number();
}

void part_bare_faces(MeshSource* source) {
    const auto textured = [](const Look& look) { return look.picture.has_value(); };
    const MeshAttribute* uv = source->mesh.find("uv");
    if (uv == nullptr || uv->is_int || !any_look(source->looks, *source, textured)) return;
    // Where no face has any, import has a word on the whole.
    if (std::none_of(uv->corners.begin(), uv->corners.end(), has_all)) return;
    std::map<int32_t, int32_t> bare_group;  // by group
    std::map<int32_t, int32_t> bare_look;
    int64_t count = 0;
    size_t first = 0;
    for (size_t t = 0; t < source->face_groups.size(); ++t) {
        if (has_all(uv->corners[t])) continue;
        int32_t& g = source->face_groups[t];
        const int32_t look = source->groups[g].look;
        if (look < 0 || !source->looks[look].picture) continue;
        if (count++ == 0) first = t;
        const auto [known, fresh] = bare_group.try_emplace(g, 0);
        if (fresh) {
            const auto [plain, added] =
                bare_look.try_emplace(look, static_cast<int32_t>(source->looks.size()));
            if (added) {
                source->looks.push_back(source->looks[look]);
                source->looks.back().picture.reset();
            }
            FaceGroup group = source->groups[g];
            group.look = plain->second;
            known->second = source->group_index(group);
        }
        g = known->second;
    }
    if (count == 0) return;
    source->leave_out(messages::kPicturesWithoutCoordinates,
                      source->origin.str(static_cast<int32_t>(first)),
                      messages::kPicturesWithoutCoordinatesHelp);
}

void complete_attributes(const std::vector<Look>& looks, MeshSource* source) {
    const bool pictures =
        any_look(looks, *source, [](const Look& look) { return look.picture.has_value(); });
    const auto colored = [](const Look& look) { return look.vertex_colors; };
    const bool colors = any_look(looks, *source, colored);
    // Fablets multiply by the colour of a face, whatever its look.
    const auto not_colored = [&](size_t t) {
        const int32_t look = source->groups[source->face_groups[t]].look;
        return look < 0 || !looks[look].vertex_colors;
    };
    const bool all_colored =
        !colors || std::all_of(source->groups.begin(), source->groups.end(), [&](const auto& g) {
            return g.look >= 0 && colored(looks[g.look]);
        });
    std::erase_if(source->mesh.attributes, [&](MeshAttribute& a) {
        if (a.is_int) return false;
        size_t with = 0;
        size_t lacking = a.corners.size();
        for (size_t t = a.corners.size(); t-- > 0;) {
            const bool has = has_all(a.corners[t]);
            with += has;
            lacking = has ? lacking : t;
        }
        if (with == 0) return true;
        if (a.name == "color" && colors && (!all_colored || lacking < a.corners.size())) {
            fill(1, not_colored, &a);
            return false;
        }
        if (lacking == a.corners.size()) return false;
        if (a.name == "uv" && pictures) {
            fill(
                0, [](size_t) { return false; }, &a);
            return false;
        }
        source->warnings.push_back(fmt::format(messages::kAttributeOfSomeFaces,
                                               source->origin.str(static_cast<int32_t>(lacking)),
                                               source->mesh.name, a.name));
        return true;
    });
}

}  // namespace openfab::mesh
