// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A world with two materials, whose shares the page can set.

#include <string>
#include <vector>

#include "tests/programs/viewer/view_fixtures.h"

namespace openfab::testing {

inline constexpr const char* kFablet = R"(fablet Halves {
    @uniform {
        float share = 0.5 [[float min = 0, float max = 1]];
        Material a, b;
    }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(a, share);
        mc.Set(b, 1 - share);
        return mc;
    }
}
)";

inline constexpr const char* kTwo =
    R"([{"object": "cube"}, {"object": "cube", "translate_mm": [3, 0, 0]}])";

class ViewWorld : public WorldFixture {
  protected:
    ViewWorld() : WorldFixture("halves", "Halves", kFablet, kTwo) {}

    /// The share of solid voxels that are of the first material.
    static double share(const JsonValue& state) {
        const JsonValue& print = member(state, "prints").items.at(0);
        return member(member(print, "materials").items.at(0), "voxels").number /
               member(print, "solid").number;
    }

    /// What the page knows of a uniform of the only object; fails the test where there is none.
    static JsonValue uniform_of(const JsonValue& details, const std::string& name) {
        const std::vector<JsonValue>& objects = member(details, "objects").items;
        if (!objects.empty()) {
            for (const JsonValue& uniform : member(objects[0], "uniforms").items) {
                if (member(uniform, "name").text == name) return uniform;
            }
        }
        ADD_FAILURE() << "no uniform " << name;
        return {};
    }
};

}  // namespace openfab::testing
