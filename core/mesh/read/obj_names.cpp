// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/obj_names.h"

#include <fmt/format.h>

#include "base/text.h"
#include "mesh/read/messages.h"
#include "mesh/read/obj_lines.h"

namespace openfab::mesh {
namespace {

constexpr int64_t kNodeBytes = 96;

int64_t bytes_of(const std::string& name) {
    return static_cast<int64_t>(sizeof name + name.size());
}
int64_t bytes_of(const std::vector<std::string>& names) {
    int64_t bytes = sizeof names;
    for (const std::string& name : names)
        bytes += bytes_of(name);
    return bytes;
}

std::vector<std::string> words_of(std::string_view line) {
    std::vector<std::string> words;
    for (line = without_blanks(line); !line.empty(); line = without_blanks(line)) {
        const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
        words.push_back(utf8_or_latin1(word));
        line.remove_prefix(word.size());
    }
    return words;
}

}  // namespace

template <typename Names>
int32_t ObjNames::number_of(const Names& names, std::map<Names, int32_t>* numbers) {
    const auto [known, fresh] =
        numbers->try_emplace(names, static_cast<int32_t>(numbers->size()) + 1);
    if (fresh) bytes_ += kNodeBytes + bytes_of(names);
    return known->second;
}

Result<void> ObjNames::take(std::string_view word, std::string_view rest,
                            const std::vector<std::string_view>& words, int32_t line) {
    if (word == "mtllib") return libraries_.add(rest, SourceLocation{file_, line, 1}.str());
    group_.reset();
    if (word == "o") {
        object_ = utf8_or_latin1(without_comment(rest));
        ++object_number_;
    } else if (word == "usemtl") {
        const std::string name = utf8_or_latin1(without_comment(rest));
        material_number_ =
            name.empty() ? 0 : static_cast<size_t>(number_of(name, &material_numbers_));
        if (material_number_ == materials_.size()) {
            materials_.push_back({name, line, -1});
            bytes_ += static_cast<int64_t>(3 * sizeof(Material) + name.size());
        }
    } else {
        // Names such as `#1` are names; a comment has a blank behind its sign.
        const std::string_view names = without_comment(rest);
        if (names.find('#') != std::string_view::npos) {
            groups_ = words_of(names);
        } else {
            groups_.clear();
            for (size_t i = 1; i < words.size(); ++i)
                groups_.push_back(utf8_or_latin1(words[i]));
        }
        if (groups_.size() >= kMaxObjCorners) {
            return error_at({file_, line, 1},
                            fmt::format(messages::kFaceInTooManyGroups, kMaxObjCorners));
        }
        groups_number_ = number_of(groups_, &groups_numbers_);
    }
    return Ok{};
}

int32_t ObjNames::group() {
    if (group_) return *group_;
    // A cache: statements that alternate between a few groups do not process all of their names
    // again.
    const Key key{object_number_, groups_number_, static_cast<int32_t>(material_number_)};
    const auto [known, fresh] = group_of_.try_emplace(key, 0);
    if (fresh) {
        bytes_ += kNodeBytes;
        known->second = out_.group_index(
            {groups_, materials_[material_number_].name, look_of_material(), body_of_names()});
    }
    return *(group_ = known->second);
}

int32_t ObjNames::look_of_material() {
    Material& material = materials_[material_number_];
    if (material.look < 0) {
        material.look = static_cast<int32_t>(material_of_look_number_.size());
        material_of_look_number_.push_back(material_number_);
        bytes_ += static_cast<int64_t>(3 * sizeof(Look) + material.name.size());
    }
    return material.look;
}

int32_t ObjNames::body_of_names() {
    const auto [known, fresh] = body_of_.try_emplace({object_number_, groups_number_},
                                                     static_cast<int32_t>(body_names_.size()));
    if (fresh) {
        std::string names;
        for (const std::string& name : groups_)
            names += (names.empty() ? "" : " ") + name;
        bytes_ += kNodeBytes + static_cast<int64_t>(3 * (sizeof(BodyNames) + sizeof(Body)) +
                                                    2 * (object_.size() + names.size()));
        body_names_.push_back({object_number_, object_, std::move(names)});
    }
    return known->second;
}

/// An object of one group has its own name, since programs repeat it in the group's.
void ObjNames::name_bodies() {
    std::map<int32_t, int32_t> bodies_of_object;
    bool named = false;
    for (const BodyNames& names : body_names_) {
        ++bodies_of_object[names.object];
        named = named || !names.object_name.empty() || !names.group_names.empty();
    }
    if (!named && body_names_.size() < 2) return;
    for (BodyNames& names : body_names_) {
        std::string& name = names.object_name;
        if (name.empty()) {
            name = std::move(names.group_names);
        } else if (bodies_of_object[names.object] > 1 && !names.group_names.empty()) {
            name += " " + names.group_names;
        }
        out_.bodies.push_back({std::move(name), BodyRole::kPart, 0});
    }
}

void ObjNames::finish() {
    name_bodies();
    for (const size_t number : material_of_look_number_) {
        const MtlMaterial* found = libraries_.find(materials_[number].name);
        // Without `usemtl` anywhere, the only material of the libraries is meant.
        if (materials_.size() == 1 && libraries_.materials().size() == 1)
            found = &libraries_.materials()[0];
        Look look;
        if (found != nullptr) look = found->look;
        look.name = number == 0 ? look.name : materials_[number].name;
        look.is_material = number != 0 || found != nullptr;
        out_.looks.push_back(std::move(look));
        material_of_look_.push_back(found);
        if (found == nullptr) continue;
        for (const LeftOut& left : found->left_out)
            out_.leave_out(left.what, left.place, left.remedy);
    }
    tell_unknown();
}

void ObjNames::tell_unknown() {
    // Without libraries, materials are names; one that is missing is told.
    if (!libraries_.complete()) return;
    std::vector<int64_t> faces(out_.looks.size());
    for (const int32_t group : out_.face_groups)
        ++faces[out_.groups[group].look];
    int named = 0;
    for (size_t look = 0; look < material_of_look_.size(); ++look) {
        const Material& material = materials_[material_of_look_number_[look]];
        if (material_of_look_[look] != nullptr || material.name.empty()) continue;
        constexpr int kMostNamed = 100;
        if (named++ >= kMostNamed) {
            out_.leave_out(messages::kFurtherMaterialsWithoutLook,
                           SourceLocation{file_, material.line, 1}.str(),
                           messages::kFurtherMaterialsWithoutLookHelp);
            continue;
        }
        out_.left_out.push_back(
            {fmt::format(messages::kMaterialWithoutLook, printable(material.name)),
             SourceLocation{file_, material.line, 1}.str(), messages::kMaterialWithoutLookHelp,
             faces[look]});
    }
}

}  // namespace openfab::mesh
