// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What tests of `openfab print` share: a world of one block, and a cache of their own.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/places/places.h"
#include "tests/support/process/process.h"

namespace openfab::testing {

inline constexpr const char* kFablet = R"(fablet Plain {
    @uniform { Material body; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(body, 1);
        return mc;
    }
}
)";

inline constexpr const char* kWorld = R"({
  "openfab": 1,
  "printer": "generic",
  "fablets": {"plain": {"source": "plain.fl", "fablet": "Plain"}},
  "materials": {"resin": {"key": "#ffffff", "preview": "#f0f0f0ff", "density_g_cm3": 1.18}},
  "meshes": {"block": {"box": [4, 3, 2]}},
  "objects": {"thing": {"mesh": "block", "fablet": "plain", "uniforms": {"body": "resin"}}},
  "build": [{"object": "thing"}]
}
)";

class OpenfabPrint : public ::testing::Test {
  protected:
    OpenfabPrint() {
        scratch_.write("plain.fl", kFablet);
        scratch_.write("world.fab.json", kWorld);
        scratch_.write("block.obj",
                       "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 2\nv 4 0 2\nv 4 3 2\nv 0 3 2\n"
                       "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome print(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), {program("openfab"), "print"});
        return run(arguments, {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    }

    ScratchFolder scratch_;
};

}  // namespace openfab::testing
