// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/part/settings.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/json.h"
#include "base/near_miss.h"
#include "runtime/part/messages.h"
#include "world/uniform_values.h"

namespace openfab::part {

namespace {

/// Of the location of an error that is about a setting.
constexpr std::string_view kSetPlace = "--set ";

/// Makes an error of a `--set` that says nothing.
Error malformed(const std::string& text, std::string message, std::string help = {}) {
    return {ErrorCode::kUsage, std::move(message), std::move(help), place_of_setting(text)};
}

}  // namespace

SourceLocation place_of_setting(const std::string& text) {
    return {std::string(kSetPlace) + text, 0, 0};
}

Result<Setting> parse_setting(const std::string& text) {
    const size_t equals = text.find('=');
    const size_t dot = equals == std::string::npos ? equals : text.rfind('.', equals);
    if (dot == std::string::npos || dot == 0 || dot + 1 == equals || equals + 1 == text.size()) {
        return malformed(text, messages::kSetForm);
    }
    Setting out;
    out.object = text.substr(0, dot);
    out.uniform = text.substr(dot + 1, equals - dot - 1);
    const std::string value = text.substr(equals + 1);
    JsonValue json;
    if (Result<JsonValue> parsed = parse_json(value, "--set");
        parsed && !parsed->is(JsonValue::Kind::kNull)) {
        json = std::move(*parsed);
    } else {
        // A bare word is a name; anything that starts like other JSON is an error.
        if (std::string_view("[{\"-+.0123456789").find(value[0]) != std::string_view::npos) {
            return malformed(text, messages::kSetNeitherJsonNorName);
        }
        json.kind = JsonValue::Kind::kString;
        json.text = value;
    }
    const SourceLocation location = place_of_setting(text);
    Result<world::UniformBinding> binding =
        world::uniform_binding(json, location, fmt::format(messages::kUniform, out.uniform));
    if (!binding && json.is(JsonValue::Kind::kObject)) {
        return malformed(text, binding.error().message, binding.error().help);
    }
    if (!binding) return malformed(text, messages::kSetNotAValue);
    out.binding = std::move(*binding);
    out.binding.location = location;
    return out;
}

Result<Settings> read_settings(const world::World& world, const std::vector<std::string>& texts) {
    Settings out;
    std::vector<std::string> objects;
    for (const world::Object& object : world.objects)
        objects.push_back(object.name);
    for (const std::string& text : texts) {
        Result<Setting> set = parse_setting(text);
        if (!set) return set.error();
        if (std::find(objects.begin(), objects.end(), set->object) == objects.end()) {
            return error_at(place_of_setting(text),
                            fmt::format(messages::kNoSuchObject, set->object),
                            suggest(set->object, objects));
        }
        out[set->object].insert_or_assign(set->uniform, std::move(set->binding));
    }
    return out;
}

Result<void> apply_settings(const std::vector<std::string>& texts, world::World* world) {
    const Result<Settings> settings = read_settings(*world, texts);
    if (!settings) return settings.error();
    for (size_t i = 0; i < world->objects.size(); ++i) {
        const auto found = settings->find(world->objects[i].name);
        if (found == settings->end()) continue;
        for (const auto& [name, binding] : found->second) {
            world->objects[i].uniforms.insert_or_assign(name, binding);
            for (world::Placement& placement : world->build) {
                if (static_cast<size_t>(placement.object) == i) placement.overrides.erase(name);
            }
        }
    }
    return {};
}

std::string_view setting_of(const Error& error) {
    const std::string_view place = error.location.file;
    if (error.location.line > 0 || !place.starts_with(kSetPlace)) return {};
    return place.substr(kSetPlace.size());
}

}  // namespace openfab::part
