// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fablets that call one function of the standard library, as the table of costs (stdlib/costs.json)
// writes its calls. In scope are `p`, the voxel's centre, mm, meant to be within 16 of the origin;
// `unit`, that as 0 ... 1; t and d, the first components of both; Materials m0, m1, …; and `voxel` in
// a dither rule.

#include <fmt/format.h>

#include <map>
#include <string>
#include <vector>

namespace openfab::testing {

struct LibraryCall {
    std::string module;
    std::string type;  ///< what it returns, as OpenFL writes it; "rule": a number of a fraction
    std::string call;
};

/// The components of what a function returns: each is an amount of one material.
inline const std::vector<std::string>& components_of(const std::string& type) {
    static const std::map<std::string, std::vector<std::string>> all = {
        {"int", {""}},
        {"int3", {".x", ".y", ".z"}},
        {"float", {""}},
        {"float2", {".x", ".y"}},
        {"float3", {".x", ".y", ".z"}},
        {"float4", {".x", ".y", ".z", ".w"}},
        {"Cells", {".at.x", ".at.y", ".at.z", ".size.x", ".size.y", ".size.z"}},
        {"Joint", {".fillet", ".least", ".square"}},
        {"Path", {".off.x", ".way.x", ".square", ".at", ".pieces"}},
        {"Polygon", {".p.x", ".p.y", ".square", ".inside ? 1 : 0"}},
        {"Voronoi", {".site.x", ".site.y", ".site.z", ".face", ".edge"}},
    };
    return all.at(type);
}

inline std::string fablet_of(const LibraryCall& call) {
    std::string text = fmt::format("import {};\n", call.module);
    if (call.module == "property") {
        text +=
            "const PropertyTable ROWS_OF_THREE = {4,\n"
            "{0, 2, 5, 9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},\n"
            "{{1, 0, 0, 0}, {0.25, 0.75, 0, 0}, {0, 0.5, 0.5, 0}, {0, 0, 1, 0},\n"
            "0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}};\n";
    }
    if (call.module == "solids") {
        text +=
            "const float2 STAR[32] = {float2(0, 12), float2(2.9, 4), float2(11.4, 3.7),\n"
            "float2(4.8, -1.5), float2(7, -9.7), float2(0, -5), float2(-7, -9.7),\n"
            "float2(-4.8, -1.5), float2(-11.4, 3.7), float2(-2.9, 4),\n"
            "0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};\n";
    }
    if (call.module == "sweeps") {
        text +=
            "const float3 HOOK[32] = {float3(-9, -6, 0), float3(0, -7, 2), float3(8, -2, 0),\n"
            "float3(5, 7, -3), float3(-4, 8, 0), float3(-6, 2, 4),\n"
            "0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};\n";
    }
    const bool rule = call.type == "rule", mixture = call.type == "MaterialComposition";
    const std::string type = rule ? "float3" : call.type;
    size_t materials = mixture ? 0 : components_of(type).size();
    while (mixture && call.call.find(fmt::format("m{}", materials)) != std::string::npos)
        ++materials;
    text += "fablet F { @uniform {";
    for (size_t k = 0; k < materials; ++k)
        text += fmt::format(" Material m{};", k);
    text +=
        " }\nMaterialComposition pure(Material m) { MaterialComposition mc; mc.Set(m, 1); return "
        "mc; }\n"
        "@Volume(@varying { VolumeAttributes attr }) { float3 p = attr.voxelCenter;\n"
        "float3 unit = p / 32 + 0.5; float t = unit.x, d = p.x;\n";
    if (mixture) return text + "return " + call.call + "; } }\n";
    text += "MaterialComposition mc;\n";
    text += fmt::format("{} v = {};\n", type, rule ? "unit" : call.call);
    for (size_t k = 0; k < materials; ++k)
        text += fmt::format("mc.Set(m{}, v{});\n", k, components_of(type)[k]);
    text += "return mc; }\n";
    if (rule)
        text += "@Dither(@varying { DitherAttributes voxel }) { return " + call.call + "; }\n";
    return text + "}\n";
}

}  // namespace openfab::testing
