// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/world_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/json.h"
#include "base/json_text.h"
#include "tools/viewer/messages.h"

namespace openfab::viewer {

namespace {

/// The byte at a place of JSON's: one-based, columns in code points.
size_t offset_of(std::string_view text, int32_t line, int32_t column) {
    size_t at = 0;
    for (int32_t l = 1; l < line; ++l)
        at = text.find('\n', at) + 1;
    for (int32_t c = 1; c < column; ++c) {
        ++at;
        while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xc0) == 0x80)
            ++at;
    }
    return at;
}

/// The end of a value, in text that was parsed.
size_t end_of_value(std::string_view text, size_t at) {
    int depth = 0;
    bool quoted = false;
    for (; at < text.size(); ++at) {
        const char c = text[at];
        if (quoted) {
            if (c == '\\') ++at;
            if (c == '"') quoted = false;
        } else if (c == '"') {
            quoted = true;
        } else if (c == '{' || c == '[') {
            ++depth;
        } else if (c == '}' || c == ']') {
            if (depth == 0) return at;
            --depth;
        } else if (depth == 0 && (c == ',' || c == ' ' || c == '\n' || c == '\r' || c == '\t')) {
            return at;
        } else {
            continue;
        }
        if (depth == 0 && !quoted) return at + 1;
    }
    return at;
}

std::string quoted(std::string_view text) {
    JsonText out;
    out.value(text);
    return out.take();
}

/// Puts a member before the others of an object, spaced as they are.
std::string with_first_member(const std::string& text, const JsonValue& object,
                              const std::string& member) {
    const size_t brace = offset_of(text, object.line, object.column);
    if (object.members.empty()) {
        const size_t end = end_of_value(text, brace);
        return text.substr(0, brace) + "{" + member + "}" + text.substr(end);
    }
    const JsonMember& first = object.members.front();
    const size_t key = offset_of(text, first.line, first.column);
    const std::string space = text.substr(brace + 1, key - brace - 1);
    return text.substr(0, key) + member + "," + (space.empty() ? " " : space) + text.substr(key);
}

/// Gives a member of an object that value; an object has no two of one key.
std::string with_member(const std::string& text, const JsonValue& object, std::string_view key,
                        std::string_view value) {
    const JsonValue* there = member_of(object, key);
    if (there == nullptr)
        return with_first_member(text, object, fmt::format("{}: {}", quoted(key), value));
    const size_t from = offset_of(text, there->line, there->column);
    return text.substr(0, from) + std::string(value) + text.substr(end_of_value(text, from));
}

}  // namespace

Result<std::string> with_entry(const std::string& text, const std::string& name,
                               std::string_view section, std::string_view key,
                               std::string_view value) {
    const Result<JsonValue> world = parse_json(text, name);
    if (!world) return world.error();
    if (!world->is(JsonValue::Kind::kObject))
        return user_error(fmt::format(messages::kNoWorld, name));
    const JsonValue* of_section = member_of(*world, section);
    if (of_section == nullptr)
        return with_first_member(
            text, *world, fmt::format("{}: {{{}: {}}}", quoted(section), quoted(key), value));
    if (!of_section->is(JsonValue::Kind::kObject))
        return user_error(fmt::format(messages::kNoObject, name, section));
    return with_member(text, *of_section, key, value);
}

Result<std::string> with_renamed_uniform(const std::string& text, const std::string& name,
                                         std::string_view section, std::string_view entry,
                                         std::string_view from, std::string_view to) {
    const Result<JsonValue> world = parse_json(text, name);
    if (!world) return world.error();
    const JsonValue* at = member_of(*world, section);
    for (const std::string_view key : {entry, std::string_view("uniforms")})
        at = at == nullptr ? nullptr : member_of(*at, key);
    if (at == nullptr) return text;
    for (const JsonMember& member : at->members) {
        if (member.key != from) continue;
        const size_t begin = offset_of(text, member.line, member.column);
        size_t end = begin + 1;
        while (end < text.size() && text[end] != '"')
            end += text[end] == '\\' ? 2 : 1;
        return text.substr(0, begin) + quoted(to) + text.substr(std::min(end + 1, text.size()));
    }
    return text;
}

Result<std::string> with_mesh(const std::string& text, const std::string& name,
                              std::string_view object, std::string_view mesh) {
    const Result<JsonValue> world = parse_json(text, name);
    if (!world) return world.error();
    const JsonValue* objects = member_of(*world, "objects");
    const JsonValue* of_object = objects == nullptr ? nullptr : member_of(*objects, object);
    if (of_object == nullptr || !of_object->is(JsonValue::Kind::kObject))
        return user_error(fmt::format(messages::kNoObjectOfName, name, object));
    return with_member(text, *of_object, "mesh", quoted(mesh));
}

Result<std::string> with_uniform(const std::string& text, const std::string& name,
                                 std::string_view object, std::string_view uniform,
                                 std::string_view value) {
    const Result<JsonValue> world = parse_json(text, name);
    if (!world) return world.error();
    const JsonValue* objects = member_of(*world, "objects");
    const JsonValue* of_object = objects == nullptr ? nullptr : member_of(*objects, object);
    if (of_object == nullptr || !of_object->is(JsonValue::Kind::kObject))
        return user_error(fmt::format(messages::kNoObjectOfName, name, object));
    const std::string member = fmt::format("{}: {}", quoted(uniform), value);
    const JsonValue* uniforms = member_of(*of_object, "uniforms");
    if (uniforms == nullptr)
        return with_first_member(text, *of_object, "\"uniforms\": {" + member + "}");
    if (!uniforms->is(JsonValue::Kind::kObject))
        return user_error(fmt::format(messages::kUniformsNoObject, name, object));
    return with_member(text, *uniforms, uniform, value);
}

}  // namespace openfab::viewer
