// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/world_keys.h"

#include <algorithm>

#include "base/check.h"
#include "world/primitive_reader.h"

namespace openfab::world {

namespace {

std::vector<std::string_view> with_primitives(std::vector<std::string_view> keys) {
    keys.insert(keys.end(), primitive_keys().begin(), primitive_keys().end());
    return keys;
}

}  // namespace

const std::vector<KeySet>& world_key_sets() {
    static const std::vector<KeySet> sets = {
        {"world",
         {"$schema", "openfab", "printer", "tray", "support", "fablets", "dither", "materials",
          "textures", "meshes", "objects", "groups", "arrange", "build", "cases"},
         {"openfab", "fablets", "meshes", "objects", "build"}},
        {"fablet", {"source", "fablet", "uniforms"}, {"source", "fablet"}},
        {"dither", {"source", "rule"}, {"source", "rule"}},
        {"material", {"key", "preview", "density_g_cm3", "channel"}, {"key"}},
        {"texture",
         {"file", "wrap", "filter", "space", "channels", "origin_mm", "spacing_mm", "field", "unit",
          "pitch_mm", "outside", "time", "segment", "echo", "detector", "energy_window", "phase"},
         {"file"}},
        {"mesh",
         with_primitives({"file", "body", "unit", "up", "origin_mm", "groups", "groups_attribute",
                          "beams", "shape", "grow", "box_mm", "program", "attributes", "places",
                          "answer_s", "answer_mb", "version"}),
         {}},
        {"extrusion", {"polygons", "height"}, {"polygons", "height"}},
        {"object",
         {"mesh", "fablet", "priority", "max_displacement_mm", "uniforms", "support", "repair",
          "pieces"},
         {"mesh", "fablet"}},
        {"placement",
         {"object", "group", "scale", "rotate_deg", "translate_mm", "matrix", "on_bed", "grid",
          "transforms", "uniforms", "piece", "explode_mm"},
         {}},
        {"cut", {"normal", "at_mm", "front", "back", "connectors", "numbers"}, {"normal", "at_mm"}},
        {"connector",
         {"peg", "dowel", "dovetail", "magnet", "diameter_mm", "width_mm", "length_mm",
          "clearance_mm", "skin_mm", "material", "from", "along", "run_mm", "angle_deg"},
         {"length_mm"}},
        {"number", {"at_mm", "height_mm", "depth_mm", "up", "side"}, {"at_mm"}},
        {"arrange", {"columns", "spacing_mm"}, {"columns", "spacing_mm"}},
        {"grid", {"count", "spacing_mm", "step_mm"}, {"count"}},
    };
    return sets;
}

const std::vector<WorldPath>& world_paths() {
    static const std::vector<WorldPath> paths = {
        {{"printer"}, ".json"},
        {{"fablets", "*", "source"}, ""},
        {{"dither", "source"}, ""},
        {{"textures", "*", "file"}, ""},
        {{"meshes", "*", "file"}, ""},
        {{"meshes", "*", "beams"}, ""},
        {{"objects", "*", "pieces"}, ""},
        {{"groups", "*", "[]", "transforms"}, ""},
        {{"build", "[]", "transforms"}, ""},
    };
    return paths;
}

const KeySet& world_keys(std::string_view kind) {
    const std::vector<KeySet>& sets = world_key_sets();
    const auto found = std::ranges::find(sets, kind, &KeySet::kind);
    OPENFAB_CHECK(found != sets.end());  // the table above has all kinds
    return *found;
}

}  // namespace openfab::world
