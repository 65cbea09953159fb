// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// `Object` uniforms: bound by the name of an object that is placed somewhere.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/messages.h"
#include "runtime/part/bind.h"
#include "runtime/part/messages.h"
#include "tests/support/meshes/meshes.h"
#include "tests/support/meshes/temp_folder.h"

namespace openfab::part {
namespace {

const openfab_uniform kUniforms[] = {
    {"core", "Object", OPENFAB_UNIFORM_OBJECT, OPENFAB_FLOAT, 1, 1, 0, nullptr},
    {"ribs", "Object", OPENFAB_UNIFORM_OBJECT, OPENFAB_FLOAT, 1, 2, 1, nullptr},
    {"white", "Material", OPENFAB_UNIFORM_MATERIAL, OPENFAB_FLOAT, 1, 1, 0, nullptr},
};

constexpr const char* kWorld = R"({
  "openfab": 1,
  "fablets": {"near": {"source": "n.fl", "fablet": "Near"}},
  "materials": {"white": {"key": "#ffffff"}},
  "meshes": {"box": {"box": [10, 10, 10]}},
  "objects": {
    "body": {"mesh": "box", "fablet": "near",
      "uniforms": {"core": "rod", "ribs": ["rod", "body"], "white": "white"}},
    "rod": {"mesh": "box", "fablet": "near",
      "uniforms": {"core": "body", "ribs": ["rod", "body"], "white": "white"}},
    "idle": {"mesh": "box", "fablet": "near"}
  },
  "build": [
    {"object": "rod"},
    {"object": "body"},
    {"object": "rod", "translate_mm": [30, 0, 0]}
  ]
})";

class BindObjectsTest : public ::testing::Test {
  protected:
    BindObjectsTest() : fablet_(testing::empty_fablet()) {
        fablet_.abi_version = OPENFAB_ABI_VERSION;
        fablet_.name = "Near";
        fablet_.uniform_count = 3;
        fablet_.uniforms = kUniforms;
        fablet_.object_count = 3;
        fablet_.slot_count = 1;
        pointers_[0] = &fablet_;
    }
    Result<std::vector<Part>> bind_with(const std::string& from, const std::string& to) {
        std::string text = kWorld;
        if (!from.empty()) text.replace(text.find(from), from.size(), to);
        Result<world::World> world = world::load_world(folder_.write("w.fab.json", text));
        if (!world) return world.error();
        return bind(*world, {1, pointers_});
    }
    std::string error_with(const std::string& from, const std::string& to) {
        const Result<std::vector<Part>> parts = bind_with(from, to);
        if (parts) return "no error";
        return parts.error().text().substr((folder_.path() / "w.fab.json").string().size() + 1);
    }

    testing::TempFolder folder_;
    openfab_fablet fablet_;
    const openfab_fablet* pointers_[1];
};

TEST_F(BindObjectsTest, FindsEveryPlacementAndMayGoRound) {
    const Result<std::vector<Part>> parts = bind_with("", "");
    ASSERT_TRUE(parts) << parts.error().text();
    using Places = std::vector<std::vector<int32_t>>;
    EXPECT_EQ((*parts)[1].objects, (Places{{0, 2}, {0, 2}, {1}}));
    EXPECT_EQ((*parts)[0].objects, (Places{{1}, {0, 2}, {1}}));
    EXPECT_EQ((*parts)[2].objects, (*parts)[0].objects);
}

TEST_F(BindObjectsTest, NamesWhatWouldBeRight) {
    struct Case {
        const char* from;
        const char* to;
        std::string message;
    };
    const Case cases[] = {
        {"\"core\": \"rod\"", "\"core\": \"rodd\"",
         "8:28: " +
             fmt::format(messages::kForUniform, fmt::format(messages::kNoSuchObject, "rodd"),
                         "Object core", "Near") +
             "; " + fmt::format(openfab::messages::kDidYouMean, "rod")},
        {"\"core\": \"rod\"", "\"core\": \"white\"",
         "8:28: " + fmt::format(messages::kOtherKind, "white", messages::kAMaterial, "Object core",
                                "Near", messages::kNameOfObject)},
        {"\"white\": \"white\"", "\"white\": \"rod\"",
         "8:69: " + fmt::format(messages::kOtherKind, "rod", messages::kAnObject, "Material white",
                                "Near", messages::kNameOfMaterial)},
        {"\"core\": \"rod\"", "\"core\": \"idle\"",
         "8:28: " + fmt::format(messages::kNotPlaced, "idle", "Object core", "Near") + "; " +
             messages::kNotPlacedHelp},
        {"\"core\": \"rod\", ", "",
         "7:39: " + fmt::format(messages::kNotBound, "body", "Object core", "Near") + "; " +
             fmt::format(messages::kGiveIt, messages::kNameOfObject)},
        {"[\"rod\", \"body\"]", "\"rod\"",
         "8:43: " +
             fmt::format(messages::kIsGiven, "Object ribs[2]", "Near",
                         fmt::format(messages::kTheString, "rod")) +
             "; " + fmt::format(messages::kItTakes, fmt::format(messages::kNamesOfObjects, 2))},
    };
    for (const auto& c : cases)
        EXPECT_EQ(error_with(c.from, c.to), c.message) << c.to;
}

}  // namespace
}  // namespace openfab::part
