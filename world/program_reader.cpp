// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/program_reader.h"

#include <algorithm>
#include <cmath>

#include "world/messages.h"

namespace openfab::world {

namespace {

using Attribute = ProgramRef::Attribute;

std::vector<std::string> words(const JsonValue& value, const std::string& what, JsonReader* json) {
    if (value.kind != JsonValue::Kind::kArray || value.items.empty()) {
        json->fail(value, what + messages::kNotWords, messages::kNotWordsHelp);
        return {};
    }
    std::vector<std::string> out;
    for (const JsonValue& item : value.items) {
        out.push_back(json->string(item, "a word of " + what));
        if (json->ok() && out.back().find('\0') != std::string::npos)
            json->fail(item, fmt::format(messages::kWordWithZero, what));
    }
    if (json->ok() && out[0].empty()) json->fail(value.items[0], what + messages::kNoFirstWord);
    return out;
}

bool is_name(const std::string& text) {
    const auto letter = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    };
    return !text.empty() && letter(text[0]) &&
           std::ranges::all_of(text, [&](char c) { return letter(c) || (c >= '0' && c <= '9'); });
}

std::vector<Attribute> attributes(const JsonValue& value, const std::string& what,
                                  JsonReader* json) {
    static const std::vector<std::string> kTypes = {"float", "float2", "float3", "float4", "int"};
    std::vector<Attribute> out;
    if (!json->named_things(value, "attributes")) return out;
    for (const JsonMember& member : value.members) {
        if (!is_name(member.key)) {
            json->fail_at(member.line, member.column,
                          fmt::format(messages::kAttributeName, what, member.key),
                          messages::kAttributeNameHelp);
        }
        Attribute& attribute = out.emplace_back();
        const size_t type = json->choice(
            member.value, fmt::format("attribute `{}` of {}", member.key, what), kTypes);
        attribute.name = member.key;
        attribute.type = kTypes[type];
        attribute.is_int = type == 4;
        attribute.components = attribute.is_int ? 1 : static_cast<int32_t>(type) + 1;
    }
    return out;
}

}  // namespace

std::shared_ptr<const ProgramRef> read_program(const JsonValue& mesh, const JsonValue& command,
                                               const std::string& what, JsonReader* json,
                                               WorldFiles* files) {
    constexpr double kMostSeconds = 86'400, kMostMegabytes = 4096;
    auto out = std::make_shared<ProgramRef>();
    out->location = out->places_location = json->location(command);
    out->folder = files->folder().empty() ? "." : files->folder();
    out->command = words(command, "`program` of " + what, json);
    if (!json->ok()) return out;
    files->words(command, out->command);
    if (const JsonMember* p = mesh.find("attributes"))
        out->attributes = attributes(p->value, what, json);
    if (const JsonMember* p = mesh.find("places")) {
        out->places_location = json->location(p->value);
        if (p->value.kind != JsonValue::Kind::kArray)
            json->fail(p->value, fmt::format(messages::kPlacesNoList, what),
                       messages::kPlacesNoListHelp);
        for (const JsonValue& item : p->value.items)
            out->places.push_back(json->string(item, "a name in `places` of " + what));
    }
    if (const JsonMember* p = mesh.find("version"))
        out->version = json->string(p->value, "`version` of " + what);
    if (const JsonMember* p = mesh.find("answer_s"))
        out->answer_ms = static_cast<int32_t>(std::lround(
            1000 * json->number(p->value, "`answer_s` of " + what, 0.001, kMostSeconds)));
    if (const JsonMember* p = mesh.find("answer_mb"))
        out->most_bytes = static_cast<size_t>(std::llround(
            1048576 * json->number(p->value, "`answer_mb` of " + what, 0.001, kMostMegabytes)));
    return out;
}

}  // namespace openfab::world
