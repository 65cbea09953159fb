// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Worlds of a bar and what lies beside it, and what `openfab mechanics` says of them.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/json.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"

namespace openfab::testing {

inline constexpr const char* kFablets = R"(fablet One {
    @uniform { Material m; }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; }
}
fablet Ball {
    @uniform { Material m; float r = 8; float x = 0; }
    @Shape(@varying { ShapeAttributes attr }) { return length(attr.p - float3(x, 0, 0)) - r; }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; }
}
fablet Mark {
    @uniform { float x = -4; }
    @Shape(@varying { ShapeAttributes attr }) { return length(attr.p - float3(x, 0, 2)) - 3; }
}
fablet Skin {
    @uniform { Material m; Object core; }
    @Shape(@varying { ShapeAttributes attr }) { return distance_to(core, attr.p) - 1; }
    @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(m, 1); return mc; }
}
fablet Mix {
    @uniform { Material soft, stiff; float share = 0.3; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(soft, 1 - share);
        mc.Set(stiff, share);
        return mc;
    }
}
fablet Halves {
    @uniform { Material soft, stiff; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(attr.voxelCenter.z < 1 ? soft : stiff, 1);
        return mc;
    }
}
)";
inline constexpr const char* kBar =
    R"("bar": {"mesh": "bar", "fablet": "one", "uniforms": {"m": "stiff"}})";
inline constexpr const char* kBuild = R"({"object": "bar", "translate_mm": [0, 0, 0]})";
/// Held at -x, pushed at +x: by sides, or at an object.
inline constexpr const char* kBySide =
    R"("by_side": {"held": [{"side": "-x"}], "loads": [{"side": "+x", "force_N": [0, 0, -1]}]})";

class MechanicsModel : public ::testing::Test {
  protected:
    MechanicsModel() {
        scratch_.write("f.fl", kFablets);
        scratch_.write("mechanics.json", R"({"materials": {
    "soft": {"E_MPa": 0.6, "nu": 0.48, "strength_MPa": 1, "density_g_cm3": 1.1},
    "stiff": {"E_MPa": 2000, "nu": 0.35, "strength_MPa": 50, "density_g_cm3": 1.2}}})");
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    /// A world with a bar of 10 x 4 x 4 mm beside what is given.
    std::string world(const std::string& name, const std::string& meshes,
                      const std::string& objects, const std::string& build,
                      const std::string& cases, const std::string& printer = "generic",
                      const std::string& more = "") const {
        scratch_.write(name, R"({"openfab": 1, "printer": ")" + printer + R"(", "fablets": {
    "one": {"source": "f.fl", "fablet": "One"}, "ball": {"source": "f.fl", "fablet": "Ball"},
    "mark": {"source": "f.fl", "fablet": "Mark"}, "skin": {"source": "f.fl", "fablet": "Skin"},
    "mix": {"source": "f.fl", "fablet": "Mix"}, "halves": {"source": "f.fl", "fablet": "Halves"}},
"materials": {"soft": {"key": "#e0e0d0"}, "stiff": {"key": "#23415e"}, "label": {"key": "#ff0000"}},
"meshes": {"bar": {"box": [10, 4, 4]})" +
                                 (meshes.empty() ? "" : ", " + meshes) + R"(},
"objects": {)" + objects + "},\n\"build\": [" +
                                 build + "]" + more + R"(, "cases": {)" + cases + "}}\n");
        return path(name);
    }
    Outcome mechanics(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), {program("openfab").string(), "mechanics"});
        return run(arguments, {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    }
    /// What `part` says of a case, without its name.
    std::string part(const std::string& file, const std::string& one_case,
                     std::vector<std::string> more = {"--voxel", "0.5mm"}) const {
        more.insert(more.begin(), {"part", file, "--case", one_case, "--allow-programs"});
        const Outcome out = mechanics(more);
        EXPECT_EQ(out.exit_code, 0) << one_case << ": " << out.err;
        const std::string name = "case " + one_case;
        const size_t at = out.out.find(name + ":");
        return at == std::string::npos ? out.out : out.out.substr(at + name.size());
    }
    JsonValue numbers(std::vector<std::string> arguments) const {
        arguments.insert(arguments.end(), {"-o", path("numbers.json")});
        const Outcome out = mechanics(arguments);
        EXPECT_EQ(out.exit_code, 0) << out.err;
        const Result<JsonValue> json = parse_json(read_file(path("numbers.json")), "numbers");
        return json ? *json : JsonValue{};
    }
    static double number(const JsonValue& json, const char* key) {
        const JsonMember* m = json.find(key);
        return m == nullptr ? NAN : m->value.number;
    }

    ScratchFolder scratch_;
};

}  // namespace openfab::testing
