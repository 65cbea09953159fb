// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import_text.h"

#include <fmt/format.h>

#include <algorithm>

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

std::string join(const std::vector<std::string>& all) {
    return fmt::format("{}", fmt::join(all, ", "));
}

std::vector<std::string> texts_of(const UniformTexts& uniforms) {
    std::vector<std::string> all;
    for (const auto& [name, value] : uniforms)
        all.push_back(fmt::format("{}: {}", json_string(name), value));
    return all;
}

/// Takes the uniforms that all objects of a fablet share out of these.
UniformTexts take_shared(const std::string& fablet, std::vector<ObjectText>* objects) {
    std::vector<UniformTexts*> all;
    for (ObjectText& object : *objects) {
        if (object.fablet == fablet) all.push_back(&object.uniforms);
    }
    UniformTexts shared;
    if (all.size() < 2) return shared;
    for (const auto& one : *all[0]) {
        const auto has_it = [&](const UniformTexts* uniforms) {
            return std::find(uniforms->begin(), uniforms->end(), one) != uniforms->end();
        };
        if (std::all_of(all.begin(), all.end(), has_it)) shared.push_back(one);
    }
    for (UniformTexts* uniforms : all) {
        std::erase_if(*uniforms, [&](const auto& one) {
            return std::find(shared.begin(), shared.end(), one) != shared.end();
        });
    }
    return shared;
}

constexpr size_t kLineLength = 100;

/// A member of objects and fablets.
std::string text_of_uniforms(const UniformTexts& uniforms) {
    const std::vector<std::string> all = texts_of(uniforms);
    const std::string line = fmt::format("\"uniforms\": {{{}}}", join(all));
    if (uniforms.size() == 1 || line.size() + 12 <= kLineLength) return line;
    return fmt::format("\"uniforms\": {{\n{}\n            }}", lines(all, "                "));
}

/// On one line where that is short.
std::string text_of_thing(const std::string& name, const std::vector<std::string>& members) {
    std::string line = fmt::format("{}: {{{}}}", json_string(name), join(members));
    if (line.size() + 9 <= kLineLength && line.find('\n') == std::string::npos) return line;
    return fmt::format("{}: {{\n{}\n        }}", json_string(name), lines(members, "            "));
}

std::string text_of_fablet(const std::string& name, const UniformTexts& uniforms) {
    std::string fablet = name;
    fablet[0] = static_cast<char>(fablet[0] - 32);
    std::vector<std::string> all = {fmt::format("\"source\": \"stock_{}.fl\"", name),
                                    fmt::format("\"fablet\": \"{}\"", fablet)};
    if (!uniforms.empty()) all.push_back(text_of_uniforms(uniforms));
    return text_of_thing(name, all);
}

std::string text_of(const ObjectText& object) {
    std::vector<std::string> all;
    all.push_back(fmt::format("\"mesh\": {}", json_string(object.name)));
    all.push_back(fmt::format("\"fablet\": \"{}\"", object.fablet));
    if (object.priority != 0) all.push_back(fmt::format("\"priority\": {}", object.priority));
    if (!object.support) all.emplace_back("\"support\": false");
    if (object.most_displacement_mm > 0)
        all.push_back(fmt::format("\"max_displacement_mm\": {:.6g}", object.most_displacement_mm));
    if (object.repair) all.emplace_back("\"repair\": \"winding\"");
    if (!object.uniforms.empty()) all.push_back(text_of_uniforms(object.uniforms));
    return text_of_thing(object.name, all);
}

}  // namespace

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
    std::vector<ObjectText> short_ones = objects;
    for (const std::string& name : fablets)
        sources.push_back(text_of_fablet(name, take_shared(name, &short_ones)));
    for (const std::string& name : own_fablets)
        sources.push_back(text_of_thing(name, {fmt::format("\"source\": \"{}.fl\"", name),
                                               fmt::format("\"fablet\": \"{}\"", name)}));
    for (const ObjectText& object : short_ones) {
        meshes.push_back(fmt::format("{}: {}", json_string(object.name), object.mesh));
        texts.push_back(text_of(object));
        placed.push_back(fmt::format("{{\"object\": {}}}", json_string(object.name)));
    }
    const bool alone = objects.size() == 1;
    std::string groups;
    if (!alone) {
        groups = fmt::format("    \"groups\": {{\n        {}: [\n{}\n        ]\n    }},\n",
                             json_string(group), lines(placed, "            "));
    }
    const std::string what = alone ? fmt::format("\"object\": {}", json_string(objects[0].name))
                                   : fmt::format("\"group\": {}", json_string(group));
    return fmt::format(
        "{{\n    \"$schema\": \"fab_world.schema.json\",\n    \"openfab\": 1,\n    \"printer\": "
        "{},\n{}{}{}{}{}{}    \"build\": [{{{}{}, \"translate_mm\": {}}}]\n}}\n",
        json_string(printer), section("fablets", sources), section("materials", materials),
        section("textures", textures), section("meshes", meshes), section("objects", texts), groups,
        what, scale == 1 ? "" : fmt::format(", \"scale\": {:.9g}", scale), translate);
}

}  // namespace openfab::tools
