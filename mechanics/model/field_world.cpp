// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/model/field_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "base/json_text.h"
#include "mechanics/messages.h"

namespace openfab::mechanics {

namespace fs = std::filesystem;

namespace {

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
    Result<world::WorldEdit> edit = world::WorldEdit::of_file(world);
    if (!edit) return edit.error();
    const JsonMember* const textures = edit->tree().find("textures");
    if (!textures || !textures->value.find(texture))
        return user_error(fmt::format(messages::kNoTexture, world.string(), texture),
                          messages::kNoTextureHelp);
    const Result<std::array<double, 3>> moved = placement_of(edit->tree(), world.string());
    if (!moved) return moved.error();
    if (Result<void> done = edit->relocate(fs::absolute(world).parent_path(), folder); !done)
        return done.error();
    return FieldWorld(std::move(*edit), texture, *moved);
}

bool FieldWorld::names_others() const {
    const std::vector<fs::path> paths = world_.paths();
    return std::any_of(paths.begin(), paths.end(),
                       [](const fs::path& path) { return *path.begin() == ".."; });
}

Result<std::string> FieldWorld::text(const fs::path& field, const std::array<double, 3>& origin_mm,
                                     const std::array<double, 3>& pitch_mm) const {
    JsonText entry;
    entry.begin_object().member("file", field.filename().string());
    for (const auto& [key, values] :
         {std::pair("origin_mm", &origin_mm), std::pair("spacing_mm", &pitch_mm)}) {
        entry.key(key).begin_array();
        for (size_t a = 0; a < 3; ++a)
            entry.value((*values)[a] - (values == &origin_mm ? moved_mm_[a] : 0.0));
        entry.end_array();
    }
    entry.member("wrap", "clamp").member("filter", "trilinear").end_object();
    world::WorldEdit edit = world_;
    if (Result<void> done = edit.set_entry("textures", texture_, entry.take()); !done)
        return done.error();
    return edit.text();
}

}  // namespace openfab::mechanics
