// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/model/field_world.h"

#include <fmt/format.h>

#include "base/check.h"
#include "base/json.h"
#include "mechanics/messages.h"
#include "mechanics/model/absolute_paths.h"

namespace openfab::mechanics {

namespace fs = std::filesystem;

namespace {

constexpr size_t kMostFieldWorldBytes = 16 << 20;

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

Result<FieldWorld> FieldWorld::open(const fs::path& world, const std::string& texture) {
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
            // An object again, so that a path in it is seen with its key.
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
