// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fields/displaced_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/similarity.h"
#include "mesh/read/threemf_displaced.h"
#include "tools/fields/messages.h"
#include "tools/fields/node_text.h"

namespace openfab::tools {

namespace {

/// What a coordinate must be for a tile style that ends.
std::string within(const mesh::ThreemfDisplacementMap& map) {
    std::string text;
    for (size_t axis = 0; axis < map.wrap.size(); ++axis) {
        if (map.wrap[axis] != mesh::PictureWrap::kNone) continue;
        text += fmt::format("{0}uv.{1} >= 0 && uv.{1} <= 1", text.empty() ? "" : " && ",
                            axis == 0 ? "x" : "y");
    }
    return text;
}

}  // namespace

Result<DisplacedText> displaced_text(const mesh::ThreemfPlaced& placed, const Affine3d& to_mm,
                                     const std::string& file) {
    const auto error = [&](const std::string& what, const std::string& help = {}) {
        return user_error(fmt::format("{}: {}: {}", file, placed.place(), what), help);
    };
    DisplacedText out;
    if (placed.model->displacements == nullptr) return out;
    const double scale = even_scale(to_mm);
    if (!(scale > 0)) return error(messages::kDisplacedAndScaled, messages::kApplyTheScale);
    const mesh::ThreemfDisplacements& all = *placed.model->displacements;
    std::string choice;
    int number = 0;
    for (const auto& [id, group] : all.groups) {
        ++number;
        const mesh::ThreemfDisplaced& of = *placed.object->displaced;
        const bool used = std::ranges::any_of(of.triangles, [&](const auto& t) {
            return t.points[0] >= 0 && all.group_of(t.group >= 0 ? t.group : of.group) == id;
        });
        if (!used) continue;
        const auto map = all.maps.find(group.map);
        if (map == all.maps.end()) return error(fmt::format(messages::kNoSuchMap, id, group.map));
        const std::string uniform = fmt::format("map_{}", number);
        out.maps.push_back({uniform, map->second.path, map->second.wrap, map->second.nearest});
        const double height = group.height * scale, offset = group.offset * scale;
        double factor = 0;
        for (const mesh::ThreemfDisplacementPoint& point : group.points)
            factor = std::max(factor, point.factor);
        out.most_mm = std::max(
            {out.most_mm, factor * std::fabs(offset), factor * std::fabs(height + offset)});
        std::string value =
            fmt::format("{}.Sample1(uv, {}, 0) * {} + {}", uniform, map->second.channel,
                        float_text(height), float_text(offset));
        if (const std::string inside = within(map->second); !inside.empty())
            value = fmt::format("{} ? {} : 0.0", inside, value);
        choice += fmt::format("        if (map == {}) far = {};\n", number, value);
    }
    out.stage = fmt::format(
        "\n    // The file's displacement: coordinates in a map, a factor and the map's number.\n"
        "    @Surface(@varying {{ SurfaceAttributes attr, float4 displace = 0, float3 displace_n = "
        "0 "
        "}})\n    {{\n        int map = (int)round(displace.w);\n        if (map < 1) return 0;\n"
        "        float2 uv = displace.xy;\n        float far = 0;\n{}"
        "        return normalize(displace_n) * (far * displace.z);\n    }}\n",
        choice);
    return out;
}

}  // namespace openfab::tools
