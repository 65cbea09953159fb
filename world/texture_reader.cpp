// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/texture_reader.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "world/messages.h"
#include "world/texture_options.h"
#include "world/unit_reader.h"
#include "world/world_keys.h"

namespace openfab::world {
namespace {

/// Each placement searches them linearly.
constexpr size_t kMostTextures = 4096;

/// Reads one number for all axes, or one for each.
std::array<double, 3> read_spacing(const JsonValue& value, const std::string& what,
                                   JsonReader* json) {
    std::vector<double> sizes;
    if (value.is(JsonValue::Kind::kArray)) {
        sizes = json->numbers(value, what, 3, 1e6);
    } else {
        sizes.assign(3, json->number(value, what, 1e-6, 1e6));
    }
    for (const double size : sizes) {
        if (json->ok() && !(size >= 1e-6)) json->fail(value, what + messages::kMustBeAboveZero);
    }
    return {sizes[0], sizes[1], sizes[2]};
}

/// One mode, or one along u and one along v.
void read_wrap(const JsonValue& value, const std::string& what, JsonReader* json,
               Texture* texture) {
    static const std::vector<std::string> kModes = {"clamp", "repeat", "mirror", "black"};
    if (!value.is(JsonValue::Kind::kArray)) {
        texture->wrap = texture->wrap_v = static_cast<Wrap>(json->choice(value, what, kModes));
        return;
    }
    if (value.items.size() != 2) {
        json->fail(value,
                   value.items.size() == 1
                       ? what + messages::kOneMode
                       : fmt::format(messages::kWrongModes, what, value.items.size()),
                   messages::kWrongModesHelp);
        return;
    }
    texture->wrap = static_cast<Wrap>(json->choice(value.items[0], what, kModes));
    texture->wrap_v = static_cast<Wrap>(json->choice(value.items[1], what, kModes));
}

/// What chooses frames of DICOM: a segment by its label or number, others by numbers.
void read_frames(const JsonValue& value, const std::string& what, JsonReader* json,
                 Texture* texture) {
    if (const JsonMember* p = value.find("segment")) {
        const std::string name = "`segment` of " + what;
        constexpr double kMost = 65535;
        texture->segment = p->value.is(JsonValue::Kind::kNumber)
                               ? fmt::format("{:.0f}", json->number(p->value, name, 0, kMost))
                               : json->string(p->value, name);
    }
    const std::pair<const char*, std::optional<double>*> numbers[] = {
        {"echo", &texture->echo},
        {"detector", &texture->detector},
        {"energy_window", &texture->energy_window},
        {"phase", &texture->phase},
    };
    for (const auto& [key, number] : numbers) {
        if (const JsonMember* p = value.find(key))
            *number = json->number(p->value, fmt::format("`{}` of {}", key, what), 0, 1e9);
    }
}

}  // namespace

void read_texture(const JsonMember& m, JsonReader* json, WorldFiles* files, World* world) {
    const std::string what = fmt::format("texture `{}`", m.key);
    if (!json->object(m.value, world_keys("texture"), what)) return;
    Texture texture;
    texture.name = m.key;
    const auto choice = [&](const char* key, const std::vector<std::string>& choices,
                            size_t otherwise) {
        const JsonMember* p = m.value.find(key);
        return p == nullptr ? otherwise
                            : json->choice(p->value, fmt::format("`{}` of {}", key, what), choices);
    };
    if (const JsonMember* p = m.value.find("wrap"))
        read_wrap(p->value, "`wrap` of " + what, json, &texture);
    texture.filter =
        static_cast<Filter>(choice("filter", {"trilinear", "anisotropic", "nearest"}, 1));
    texture.space = static_cast<Space>(choice("space", {"auto", "srgb", "linear", "data"}, 0));
    const auto channels = choice("channels", {"all", "luminance", "opaque"}, 0);
    texture.luminance = channels == 1;
    texture.opaque = channels == 2;
    if (const JsonMember* p = m.value.find("origin_mm")) {
        const std::vector<double> at = json->numbers(p->value, "`origin_mm` of " + what, 3, 1e6);
        texture.origin_mm = std::array{at[0], at[1], at[2]};
    }
    if (const JsonMember* p = m.value.find("spacing_mm"))
        texture.spacing_mm = read_spacing(p->value, "`spacing_mm` of " + what, json);
    if (const JsonMember* p = m.value.find("field"))
        texture.field = json->string(p->value, "`field` of " + what);
    if (const JsonMember* p = m.value.find("unit"))
        texture.unit = kUnits[json->choice(p->value, "`unit` of " + what, kUnits)];
    if (const JsonMember* p = m.value.find("pitch_mm"))
        texture.pitch_mm = json->number(p->value, "`pitch_mm` of " + what, 1e-4, 1e6);
    if (const JsonMember* p = m.value.find("outside"))
        texture.outside = json->number(p->value, "`outside` of " + what, -1e30, 1e30);
    if (const JsonMember* p = m.value.find("time"))
        texture.time = json->number(p->value, "`time` of " + what, -1e30, 1e30);
    read_frames(m.value, what, json, &texture);
    texture.file =
        files->images(m.value.find("file")->value, "the file of " + what, volume_options(texture));
    for (const char* key : {"origin_mm", "spacing_mm", "field", "unit", "pitch_mm", "outside",
                            "time", "segment", "echo", "detector", "energy_window", "phase"}) {
        if (const JsonMember* p = m.value.find(key))
            texture.of_volume.emplace_back(key, json->location(p->value));
    }
    texture.location = json->location(m.value.find("file")->value);
    if (world->textures.size() == kMostTextures) {
        json->fail(m.value, fmt::format(messages::kTooManyTextures, kMostTextures));
    }
    world->textures.push_back(std::move(texture));
}

}  // namespace openfab::world
