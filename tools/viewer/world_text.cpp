// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/world_text.h"

#include <fmt/format.h>

#include "base/json.h"
#include "base/json_text.h"

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

}  // namespace

Result<std::string> with_uniform(const std::string& text, const std::string& name,
                                 std::string_view object, std::string_view uniform,
                                 std::string_view value) {
    const Result<JsonValue> world = parse_json(text, name);
    if (!world) return world.error();
    const JsonValue* objects = member_of(*world, "objects");
    const JsonValue* of_object = objects == nullptr ? nullptr : member_of(*objects, object);
    if (of_object == nullptr || !of_object->is(JsonValue::Kind::kObject))
        return user_error(fmt::format("{}: there is no object `{}`", name, object));
    const std::string member = fmt::format("{}: {}", quoted(uniform), value);
    const JsonValue* uniforms = member_of(*of_object, "uniforms");
    if (uniforms == nullptr)
        return with_first_member(text, *of_object, "\"uniforms\": {" + member + "}");
    if (!uniforms->is(JsonValue::Kind::kObject))
        return user_error(fmt::format("{}: the uniforms of `{}` are no object", name, object));
    const JsonValue* there = member_of(*uniforms, uniform);
    if (there == nullptr) return with_first_member(text, *uniforms, member);
    const size_t from = offset_of(text, there->line, there->column);
    return text.substr(0, from) + std::string(value) + text.substr(end_of_value(text, from));
}

}  // namespace openfab::viewer
