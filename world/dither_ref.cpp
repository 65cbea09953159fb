// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/dither_ref.h"

#include "world/world_keys.h"

namespace openfab::world {

DitherRef read_dither(const JsonValue& value, JsonReader* json, WorldFiles* files) {
    DitherRef out;
    if (!json->object(value, world_keys("dither"), "`dither`")) return out;
    out.source = files->existing(value.find("source")->value, "the source of `dither`");
    out.rule = json->string(value.find("rule")->value, "`rule` of `dither`");
    out.location = json->location(value.find("rule")->value);
    return out;
}

Result<std::optional<DitherRef>> load_dither(const std::filesystem::path& file,
                                             const FileRules& rules) {
    const Result<std::string> text = read_text_file(file, kLargestWorld);
    if (!text) return text.error();
    const Result<JsonValue> root = parse_json(*text, file.string(), rules.memory_bytes);
    if (!root) return root.error();
    const JsonMember* member = root->is(JsonValue::Kind::kObject) ? root->find("dither") : nullptr;
    if (member == nullptr) return std::optional<DitherRef>();
    JsonReader json(file.string());
    WorldFiles files(file, rules, &json);
    std::optional<DitherRef> out = read_dither(member->value, &json, &files);
    if (!json.ok()) return json.error();
    return out;
}

}  // namespace openfab::world
