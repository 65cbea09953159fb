// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/model/field_world.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/check.h"
#include "base/json.h"
#include "base/json_text.h"
#include "mechanics/messages.h"

namespace openfab::mechanics {

namespace fs = std::filesystem;

namespace {

constexpr size_t kMostFieldWorldBytes = 256'000'000;  // as a print takes them

/// Writes a value with the paths in it, which count from `folder`, as absolute ones. What a uniform is bound
/// to is a name.
void write_absolute(const JsonValue& value, const fs::path& folder, JsonText* out) {
    static constexpr const char* kPaths[] = {"file",  "source",   "transforms",
                                             "beams", "polygons", "pieces"};
    if (value.is(JsonValue::Kind::kArray)) {
        out->begin_array();
        for (const JsonValue& one : value.items)
            write_absolute(one, folder, out);
        out->end_array();
        return;
    }
    if (!value.is(JsonValue::Kind::kObject)) {
        out->value(value);
        return;
    }
    out->begin_object();
    for (const JsonMember& one : value.members) {
        out->key(one.key);
        const bool text = one.value.is(JsonValue::Kind::kString);
        if (text && std::ranges::find(kPaths, one.key) != std::end(kPaths))
            out->value((folder / one.value.text).string());
        else if (one.key == "uniforms")
            out->value(one.value);
        else
            write_absolute(one.value, folder, out);
    }
    out->end_object();
}

/// Whether a mesh is made by a program, which runs in the world's folder.
bool has_programs(const JsonValue& world) {
    const JsonMember* meshes = world.find("meshes");
    return meshes && std::ranges::any_of(meshes->value.members, [](const JsonMember& one) {
               return one.value.find("program") != nullptr;
           });
}

/// Where the only placement puts the part, or why the field would not fit it.
Result<std::array<double, 3>> placement_of(const JsonValue& world, const std::string& file) {
    const auto refused = [&] {
        return user_error(fmt::format(messages::kFieldForOneObject, file),
                          messages::kFieldForOneObjectHelp);
    };
    const JsonMember* build = world.find("build");
    if (!build || build->value.items.size() != 1 || world.find("arrange")) return refused();
    std::array<double, 3> out{};
    for (const JsonMember& m : build->value.items[0].members) {
        if (m.key == "object" || m.key == "uniforms") continue;
        if (m.key != "translate_mm" || m.value.items.size() != 3) return refused();
        for (size_t a = 0; a < 3; ++a)
            out[a] = m.value.items[a].number;
    }
    return out;
}

}  // namespace

Result<FieldWorld> FieldWorld::open(const fs::path& world, const std::string& texture,
                                    const fs::path& folder) {
    FieldWorld out;
    out.world_ = world;
    out.texture_ = texture;
    Result<std::string> text = read_text_file(world, kMostFieldWorldBytes);
    if (!text) return text.error();
    out.read_ = std::move(*text);
    const Result<JsonValue> json = parse_json(out.read_, world.string());
    if (!json) return json.error();
    const JsonMember* textures = json->find("textures");
    if (!textures || !textures->value.find(texture))
        return user_error(fmt::format(messages::kNoTexture, world.string(), texture),
                          messages::kNoTextureHelp);
    const Result<std::array<double, 3>> moved = placement_of(*json, world.string());
    if (!moved) return moved.error();
    out.moved_mm_ = *moved;
    std::error_code ignored;
    const fs::path own = fs::absolute(world).parent_path();
    if (has_programs(*json) && !fs::equivalent(folder, own, ignored))
        return user_error(fmt::format(messages::kProgramElsewhere, world.string()),
                          fmt::format(messages::kProgramElsewhereHelp, own.string()));
    return out;
}

std::string FieldWorld::text(const fs::path& field, const std::array<double, 3>& origin_mm,
                             const std::array<double, 3>& pitch_mm, const fs::path& folder) const {
    const Result<JsonValue> json = parse_json(read_, world_.string());
    OPENFAB_CHECK(json);  // it was parsed before
    const fs::path own = fs::absolute(world_).parent_path().lexically_normal();
    std::error_code ignored;
    const bool same = fs::equivalent(folder, own, ignored);
    JsonText out;
    const auto write = [&](const JsonValue& value) {
        if (same)
            out.value(value);
        else
            write_absolute(value, own, &out);
    };
    out.begin_object();
    for (const JsonMember& m : json->members) {
        out.key(m.key);
        if (m.key != "textures") {
            // The printer's name, or its file.
            if (m.key == "printer" && !same && m.value.text.ends_with(".json"))
                out.value((own / m.value.text).string());
            else
                write(m.value);
            continue;
        }
        out.begin_object();
        for (const JsonMember& one : m.value.members) {
            out.key(one.key);
            if (one.key != texture_) {
                write(one.value);
                continue;
            }
            out.begin_object();
            out.member("file", same ? field.filename().string() : fs::absolute(field).string());
            for (const auto& [key, values] :
                 {std::pair("origin_mm", &origin_mm), std::pair("spacing_mm", &pitch_mm)}) {
                out.key(key).begin_array();
                for (size_t a = 0; a < 3; ++a)
                    out.value((*values)[a] - (values == &origin_mm ? moved_mm_[a] : 0.0));
                out.end_array();
            }
            out.member("wrap", "clamp").member("filter", "trilinear");
            out.end_object();
        }
        out.end_object();
    }
    out.end_object();
    return out.take() + "\n";
}

}  // namespace openfab::mechanics
