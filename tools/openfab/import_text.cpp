// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import_text.h"

#include <fmt/format.h>

#include "base/json_text.h"

namespace openfab::tools {

namespace {

std::string lines(const std::vector<std::string>& all, const char* indent) {
    std::string out;
    for (const std::string& line : all)
        out += (out.empty() ? "" : ",\n") + (indent + line);
    return out;
}

/// `"NAME": {` its lines `},`; nothing where there are none.
std::string section(const char* name, const std::vector<std::string>& all) {
    if (all.empty()) return {};
    return fmt::format("    \"{}\": {{\n{}\n    }},\n", name, lines(all, "        "));
}

std::string text_of(const ObjectText& object) {
    std::vector<std::string> all;
    all.push_back(fmt::format("\"mesh\": {}", json_text(object.name)));
    all.push_back(fmt::format("\"fablet\": \"{}\"", object.fablet));
    if (object.priority != 0) all.push_back(fmt::format("\"priority\": {}", object.priority));
    if (!object.support) all.emplace_back("\"support\": false");
    if (object.repair) all.emplace_back("\"repair\": \"winding\"");
    std::vector<std::string> uniforms;
    for (const auto& [name, value] : object.uniforms)
        uniforms.push_back(fmt::format("{}: {}", json_text(name), value));
    if (uniforms.size() == 1) {
        all.push_back(fmt::format("\"uniforms\": {{{}}}", uniforms[0]));
    } else if (!uniforms.empty()) {
        all.push_back(fmt::format("\"uniforms\": {{\n{}\n            }}",
                                  lines(uniforms, "                ")));
    }
    return fmt::format("{}: {{\n{}\n        }}", json_text(object.name),
                       lines(all, "            "));
}

}  // namespace

std::string json_text(std::string_view text) {
    return JsonText().value(text).take();
}

std::string number(double value) {
    std::string text = fmt::format("{:.5f}", value);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) text.pop_back();
    return text == "-0" ? "0" : text;
}

std::string Names::unique(const std::string& wanted) {
    const std::string base = wanted.empty() ? "unnamed" : wanted;
    std::string name = base;
    // The search for a name continues where the last one ended.
    for (int& i = next_.try_emplace(base, 2).first->second; !taken_.insert(name).second; ++i)
        name = fmt::format("{}_{}", base, i);
    return name;
}

std::string plain_name(const std::string& name) {
    std::string out;
    for (const char c : name) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                           (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
        out += plain ? c : '_';
    }
    return out.empty() || out[0] == '.' ? "picture" + out : out;
}

std::string WorldText::str() const {
    std::vector<std::string> sources, meshes, texts, placed;
    for (const std::string& name : fablets) {
        std::string fablet = name;
        fablet[0] = static_cast<char>(fablet[0] - 32);
        sources.push_back(fmt::format(
            "\"{0}\": {{\"source\": \"stock_{0}.fl\", \"fablet\": \"{1}\"}}", name, fablet));
    }
    for (const ObjectText& object : objects) {
        meshes.push_back(fmt::format("{}: {}", json_text(object.name), object.mesh));
        texts.push_back(text_of(object));
        placed.push_back(fmt::format("{{\"object\": {}}}", json_text(object.name)));
    }
    const bool alone = objects.size() == 1;
    std::string groups;
    if (!alone) {
        groups = fmt::format("    \"groups\": {{\n        {}: [\n{}\n        ]\n    }},\n",
                             json_text(group), lines(placed, "            "));
    }
    const std::string what = alone ? fmt::format("\"object\": {}", json_text(objects[0].name))
                                   : fmt::format("\"group\": {}", json_text(group));
    return fmt::format(
        "{{\n    \"$schema\": \"fab_world.schema.json\",\n    \"openfab\": 1,\n    \"printer\": "
        "{},\n{}{}{}{}{}{}    \"build\": [{{{}{}, \"translate_mm\": {}}}]\n}}\n",
        json_text(printer), section("fablets", sources), section("materials", materials),
        section("textures", textures), section("meshes", meshes), section("objects", texts), groups,
        what, scale == 1 ? "" : fmt::format(", \"scale\": {:.9g}", scale), translate);
}

}  // namespace openfab::tools
