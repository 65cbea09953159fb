// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/part/bind.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <bit>
#include <set>

#include "base/messages.h"
#include "mesh/model/messages.h"
#include "runtime/part/messages.h"
#include "runtime/part/settings.h"
#include "tests/support/meshes/meshes.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "texture/cache.h"
#include "texture/messages.h"
#include "texture/pyramid_file.h"

namespace openfab::part {
namespace {

const uint32_t kHalf[] = {0x3f000000u};

// Lays out uniforms like openflc: values, textures and slots are numbered separately.
const openfab_uniform kUniforms[] = {
    {"border", "float2", OPENFAB_UNIFORM_VALUE, OPENFAB_FLOAT, 2, 1, 0, nullptr},
    {"gain", "float", OPENFAB_UNIFORM_VALUE, OPENFAB_FLOAT, 1, 1, 2, kHalf},
    {"steps", "int", OPENFAB_UNIFORM_VALUE, OPENFAB_INT, 1, 1, 3, nullptr},
    {"seed", "uint", OPENFAB_UNIFORM_VALUE, OPENFAB_UINT, 1, 1, 4, nullptr},
    {"inverted", "bool", OPENFAB_UNIFORM_VALUE, OPENFAB_BOOL, 1, 1, 5, nullptr},
    {"ramp", "float2", OPENFAB_UNIFORM_VALUE, OPENFAB_FLOAT, 2, 2, 6, nullptr},
    {"photo", "ImageTexture2D", OPENFAB_UNIFORM_TEXTURE2D, OPENFAB_FLOAT, 1, 1, 0, nullptr},
    {"skin", "Material", OPENFAB_UNIFORM_MATERIAL, OPENFAB_FLOAT, 1, 1, 0, nullptr},
    {"palette", "Material", OPENFAB_UNIFORM_MATERIAL, OPENFAB_FLOAT, 1, 2, 1, nullptr},
};
const openfab_varying kInputs[] = {{"face", "int", OPENFAB_INT, 1, -1, nullptr}};

openfab_fablet make_fablet() {
    openfab_fablet f = testing::empty_fablet();
    f.abi_version = OPENFAB_ABI_VERSION;
    f.name = "Coat";
    f.uniform_count = 9;
    f.uniforms = kUniforms;
    f.uniform_value_count = 10;
    f.texture_count = 1;
    f.slot_count = 4;
    f.void_slot = 3;
    f.surface_input_count = 1;
    f.surface_inputs = kInputs;
    return f;
}

constexpr const char* kWorld = R"({
  "openfab": 1,
  "fablets": {"coat": {"source": "coat.fl", "fablet": "Coat"}},
  "materials": {"red": {"key": "#ff0000"}, "blue": {"key": "#0000ff"}},
  "textures": {"photo": {"file": "photo.png", "wrap": ["mirror", "clamp"]}},
  "meshes": {"box": {"box": [10, 20, 30]}},
  "objects": {
    "thing": {"mesh": "box", "fablet": "coat", "priority": 2, "max_displacement_mm": 0.5,
      "uniforms": {"border": [0.25, 2], "steps": -7, "seed": 4294967295, "inverted": true,
        "ramp": [[1, 2], [3, 4]], "photo": "photo", "skin": "blue", "palette": ["VOID", "red"]}}
  },
  "build": [
    {"object": "thing"},
    {"object": "thing", "rotate_deg": [10, 20, 30], "translate_mm": [50, 0, 0], "uniforms": {"gain": 4}},
    {"object": "thing", "scale": 2}
  ]
})";

class BindTest : public ::testing::Test {
  protected:
    BindTest() {
        fablet_ = make_fablet();
        pointers_[0] = &fablet_;
        list_ = {1, pointers_};
        // The pyramid is written to the cache directly: no helper runs here.
        ::setenv("OPENFAB_CACHE", (folder_.path() / "cache").c_str(), 1);
        std::filesystem::create_directories(folder_.path() / "cache");
        const std::filesystem::path photo = folder_.write("photo.png", "stands for a picture");
        const uint64_t key = *texture::content_key(photo, {"auto", false});
        auto writer =
            texture::PyramidWriter::create(*texture::cache_folder() / texture::cache_name(key),
                                           *texture::pyramid_layout(2, 2, 1), key);
        for (int i = 0; i < 4; ++i)
            (*writer)->level0()[i] = 0.25f * static_cast<float>(i);
        EXPECT_TRUE((*writer)->finish());
    }

    Result<std::vector<Part>> bind_text(const std::string& text, const BindOptions& options = {}) {
        Result<world::World> world = world::load_world(folder_.write("w.fab.json", text));
        if (!world) return world.error();
        return bind(*world, list_, options);
    }
    std::string error_with(const std::string& from, const std::string& to,
                           const BindOptions& options = {}) {
        std::string text = kWorld;
        const size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        const Result<std::vector<Part>> parts =
            bind_text(text.replace(at, from.size(), to), options);
        if (parts) return "no error";
        const std::string file = (folder_.path() / "w.fab.json").string();
        return parts.error().text().starts_with(file) ? parts.error().text().substr(file.size() + 1)
                                                      : parts.error().text();
    }
    static float as_float(uint32_t bits) { return std::bit_cast<float>(bits); }

    testing::TempFolder folder_;
    openfab_fablet fablet_{};
    const openfab_fablet* pointers_[1]{};
    openfab_fablet_list list_{};
};

TEST_F(BindTest, LaysEverythingOut) {
    const Result<std::vector<Part>> parts = bind_text(kWorld);
    ASSERT_TRUE(parts) << parts.error().text();
    ASSERT_EQ(parts->size(), 3u);
    const Part& part = (*parts)[0];
    EXPECT_EQ(part.name, "thing");
    EXPECT_EQ(part.fablet, &fablet_);
    EXPECT_EQ(part.priority, 2);
    EXPECT_EQ(part.max_displacement_mm, 0.5f);
    ASSERT_EQ(part.uniform_values.size(), 10u);
    EXPECT_EQ(as_float(part.uniform_values[0]), 0.25f);
    EXPECT_EQ(as_float(part.uniform_values[1]), 2.0f);
    EXPECT_EQ(as_float(part.uniform_values[2]), 0.5f);  // the default
    EXPECT_EQ(static_cast<int32_t>(part.uniform_values[3]), -7);
    EXPECT_EQ(part.uniform_values[4], 4294967295u);
    EXPECT_EQ(part.uniform_values[5], 1u);
    EXPECT_EQ(as_float(part.uniform_values[9]), 4.0f);
    EXPECT_EQ(part.slot_material, (std::vector<uint8_t>{2, 0, 1, 0}));
    ASSERT_EQ(part.textures.size(), 1u);
    EXPECT_EQ(part.textures[0]->info()[2], static_cast<int32_t>(world::Wrap::kMirror));
    EXPECT_EQ(part.textures[0]->info()[texture::kInfoWrapV],
              static_cast<int32_t>(world::Wrap::kClamp));
    EXPECT_EQ(part.textures[0]->texels()[3], 0.75f);
    EXPECT_EQ(part.mesh->center_part_mm, (Vec3d{0, 0, 15}));
    EXPECT_EQ(part.local_to_build.t, (Vec3d{0, 0, 15}));

    EXPECT_EQ(as_float((*parts)[1].uniform_values[2]), 4.0f);
    EXPECT_EQ((*parts)[1].instance, 1);
    // A rotation shares the mesh, a scale does not; the texture is one for all.
    EXPECT_EQ((*parts)[1].mesh, part.mesh);
    EXPECT_NE((*parts)[2].mesh, part.mesh);
    EXPECT_EQ((*parts)[2].mesh->center_part_mm, (Vec3d{0, 0, 30}));
    EXPECT_EQ((*parts)[2].textures[0], part.textures[0]);
}

/// What is said of a value that does not fit.
std::string given(const char* declaration, const std::string& value, const std::string& needed) {
    return fmt::format(messages::kIsGiven, declaration, "Coat", value) + "; " +
           fmt::format(messages::kItTakes, needed);
}

TEST_F(BindTest, SetsWinOverTheWorld) {
    const BindOptions options{{"thing.gain=8", "thing.border=[3, 4]", "thing.inverted=false",
                               "thing.skin=red", "thing.palette=[\"red\", \"blue\"]"}};
    const Result<std::vector<Part>> parts = bind_text(kWorld, options);
    ASSERT_TRUE(parts) << parts.error().text();
    for (const Part& part : *parts) {
        EXPECT_EQ(as_float(part.uniform_values[2]), 8.0f);
        EXPECT_EQ(as_float(part.uniform_values[1]), 4.0f);
        EXPECT_EQ(part.uniform_values[5], 0u);
        EXPECT_EQ(part.slot_material, (std::vector<uint8_t>{1, 1, 2, 0}));
    }
    const auto error_of = [&](const char* set) {
        const Result<std::vector<Part>> failed = bind_text(kWorld, {{set}});
        if (failed) return std::string("no error");
        EXPECT_EQ(setting_of(failed.error()), set);
        return failed.error().text();
    };
    EXPECT_EQ(error_of("gain=8"), std::string("--set gain=8: ") + messages::kSetForm);
    EXPECT_EQ(error_of("thing.gain="), std::string("--set thing.gain=: ") + messages::kSetForm);
    EXPECT_EQ(error_of("thin.gain=8"),
              "--set thin.gain=8: " + fmt::format(messages::kNoSuchObject, "thin") + "; " +
                  fmt::format(openfab::messages::kDidYouMean, "thing"));
    EXPECT_EQ(error_of("thing.gian=8"),
              "--set thing.gian=8: " + fmt::format(messages::kNoSuchUniform, "Coat", "gian") +
                  "; " + fmt::format(openfab::messages::kDidYouMean, "gain"));
    EXPECT_EQ(error_of("thing.gain=[1"),
              std::string("--set thing.gain=[1: ") + messages::kSetNeitherJsonNorName);
    EXPECT_EQ(error_of("thing.gain=[null]"),
              std::string("--set thing.gain=[null]: ") + messages::kSetNotAValue);
    EXPECT_EQ(
        error_of("thing.gain=lots"),
        "--set thing.gain=lots: " +
            given("float gain", fmt::format(messages::kTheString, "lots"), messages::kANumber));
    EXPECT_EQ(setting_of(error_at({"thing.fab.json", 0, 0}, "no --set thing.gain=8: ")), "");
}

/// Marks of cases and bodies of shapes are objects that the build does not place: a wrong name is an error there, too.
TEST_F(BindTest, SetsOfUnplacedObjectsAreChecked) {
    std::string world = kWorld;
    const size_t at = world.find(R"("thing": {)");
    const std::string thing = world.substr(at, world.find("}}", at) + 2 - at);
    world.insert(at, "\"mark\"" + thing.substr(7) + ",\n    ");
    ASSERT_TRUE(bind_text(world, {{"mark.gain=8"}}));
    for (const char* set : {"mark.gian=8", "mark.gain=lots"}) {
        const Result<std::vector<Part>> failed = bind_text(world, {{set}});
        ASSERT_FALSE(failed) << set;
        EXPECT_EQ(setting_of(failed.error()), set);
    }
}

/// Values that have names are bound by these, by what people read, or by the value.
TEST_F(BindTest, TakesTheNamesOfValues) {
    const char* pattern = "Pattern\nSTRIPES\t0\tStripes\nDOTS\t4\tpolka dots\nNONE\t-1\tNONE";
    const char* hollow = "bool\nfalse\t0\tsolid\ntrue\t1\thollow";
    const openfab_uniform uniforms[] = {
        {"pattern", pattern, OPENFAB_UNIFORM_VALUE, OPENFAB_INT, 1, 1, 0, nullptr},
        {"pair", pattern, OPENFAB_UNIFORM_VALUE, OPENFAB_INT, 1, 2, 1, nullptr},
        {"hollow", hollow, OPENFAB_UNIFORM_VALUE, OPENFAB_BOOL, 1, 1, 3, nullptr},
        kUniforms[7]};
    fablet_.uniform_count = 4;
    fablet_.uniforms = uniforms;
    fablet_.uniform_value_count = 4;
    fablet_.texture_count = 0;
    fablet_.surface_input_count = 0;
    const auto world = [](const std::string& pattern, const std::string& pair,
                          const std::string& hollow) {
        return R"({"openfab": 1, "fablets": {"coat": {"source": "coat.fl", "fablet": "Coat"}},
"materials": {"red": {"key": "#ff0000"}}, "meshes": {"box": {"box": [10, 20, 30]}}, "objects": {"thing": {"mesh": "box",
"fablet": "coat", "uniforms": {"skin": "red", "pattern": )" +
               pattern + ", \"pair\": " + pair + ", \"hollow\": " + hollow +
               R"(}}}, "build": [{"object": "thing"}]})";
    };
    const auto values = [&](const std::string& text) {
        const Result<std::vector<Part>> parts = bind_text(text);
        EXPECT_TRUE(parts) << parts.error().text();
        return parts ? (*parts)[0].uniform_values : std::vector<uint32_t>();
    };
    EXPECT_EQ(values(world(R"("DOTS")", R"(["polka dots", "NONE"])", R"("hollow")")),
              (std::vector<uint32_t>{4, 4, 0xffffffffu, 1}));
    EXPECT_EQ(values(world("0", "[4, -1]", "false")),
              (std::vector<uint32_t>{0, 4, 0xffffffffu, 0}));
    const auto error_of = [&](const std::string& text) {
        const Result<std::vector<Part>> parts = bind_text(text);
        const std::string all = parts ? "no error" : parts.error().text();
        return all.substr(std::min(all.find('`'), all.size()));
    };
    const auto string = [](const char* value) { return fmt::format(messages::kTheString, value); };
    EXPECT_EQ(error_of(world(R"("DOTTS")", "[0, 0]", "true")),
              fmt::format(messages::kIsGiven, "Pattern pattern", "Coat", string("DOTTS")) + "; " +
                  fmt::format(openfab::messages::kDidYouMean, "DOTS"));
    const std::string patterns = "`Stripes`, `polka dots` or `NONE`";
    EXPECT_EQ(error_of(world(R"("checks")", "[0, 0]", "true")),
              given("Pattern pattern", string("checks"), patterns));
    EXPECT_EQ(error_of(world("3", "[0, 0]", "true")),
              given("Pattern pattern", fmt::format(messages::kTheNumber, 3.0), patterns));
    EXPECT_EQ(
        error_of(world("0", R"("DOTS")", "true")),
        given("Pattern pair[2]", string("DOTS"), fmt::format(messages::kAnArrayEach, 2, patterns)));
    EXPECT_EQ(error_of(world("0", "[0, 0]", R"("open")")),
              given("bool hollow", string("open"), "`solid` or `hollow`"));
}

TEST_F(BindTest, NamesTheDeclarationAndThePlace) {
    const auto number = [](double value) { return fmt::format(messages::kTheNumber, value); };
    const std::string two = fmt::format(messages::kAnArray, fmt::format(messages::kNumbers, 2));
    const struct {
        const char* from;
        const char* to;
        std::string message;
    } cases[] = {
        {"\"steps\": -7, ", "",
         "8:40: " + fmt::format(messages::kNotBound, "thing", "int steps", "Coat") + "; " +
             fmt::format(messages::kGiveIt, messages::kAnInt)},
        {"\"photo\": \"photo\"", "\"gain\": 1",
         "8:40: " + fmt::format(messages::kNotBound, "thing", "ImageTexture2D photo", "Coat") +
             "; " + fmt::format(messages::kGiveIt, messages::kNameOfTexture)},
        {"\"border\"", "\"boarder\"",
         "9:31: " + fmt::format(messages::kNoSuchUniform, "Coat", "boarder") + "; " +
             fmt::format(openfab::messages::kDidYouMean, "border")},
        {"[0.25, 2]", "0.25", "9:30: " + given("float2 border", number(0.25), two)},
        {"[0.25, 2]", "[true, false]",
         "9:30: " + given("float2 border", fmt::format(messages::kBooleans, 2), two)},
        {"[0.25, 2]", "[0.25, 1e39]",
         "9:30: " + fmt::format(messages::kIsGivenAsValue, "float2 border", "Coat", 1e39, 1) +
             "; " + fmt::format(messages::kEachMustBe, messages::kANumber)},
        {"-7", "1.5", "9:50: " + given("int steps", number(1.5), messages::kAnInt)},
        {"-7", "true", "9:50: " + given("int steps", "true", messages::kAnInt)},
        {"4294967295", "-1", "9:62: " + given("uint seed", number(-1), messages::kAUint)},
        {"true", "1", "9:86: " + given("bool inverted", number(1), messages::kTrueOrFalse)},
        {"[0.25, 2]", "{\"keys\": [[0, 1]]}",
         "9:30: " + given("float2 border", messages::kACurve, two)},
        {"\"photo\": \"photo\"", "\"photo\": \"red\"",
         "10:44: " + fmt::format(messages::kOtherKind, "red", messages::kAMaterial,
                                 "ImageTexture2D photo", "Coat", messages::kNameOfTexture)},
        {"\"photo\": \"photo\"", "\"photo\": \"photos\"",
         "10:44: " +
             fmt::format(messages::kForUniform, fmt::format(messages::kNoSuchTexture, "photos"),
                         "ImageTexture2D photo", "Coat") +
             "; " + fmt::format(openfab::messages::kDidYouMean, "photo")},
        {"\"skin\": \"blue\"", "\"skin\": \"bleu\"",
         "10:61: " +
             fmt::format(messages::kForUniform, fmt::format(messages::kNoSuchMaterial, "bleu"),
                         "Material skin", "Coat") +
             "; " + fmt::format(openfab::messages::kDidYouMean, "blue")},
        {"\"skin\": \"blue\"", "\"skin\": 3",
         "10:61: " + given("Material skin", number(3), messages::kNameOfMaterial)},
        {"[\"VOID\", \"red\"]", "\"red\"",
         "10:80: " + given("Material palette[2]", fmt::format(messages::kTheString, "red"),
                           fmt::format(messages::kNamesOfMaterials, 2))},
        {"\"fablet\": \"Coat\"", "\"fablet\": \"Coad\"",
         "3:55: " + fmt::format(messages::kFabletNotInPrint, "Coad", "coat.fl") + "; " +
             fmt::format(openfab::messages::kDidYouMean, "Coat")},
    };
    for (const auto& c : cases)
        EXPECT_EQ(error_with(c.from, c.to), c.message) << c.to;
}

TEST_F(BindTest, NamesTheMeshThatLacksAnAttribute) {
    folder_.write("tetra.obj",
                  "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    EXPECT_EQ(
        error_with("{\"box\": [10, 20, 30]}", "{\"file\": \"tetra.obj\"}"),
        "8:23: " + fmt::format(messages::kNoSuchAttribute, "box", "face", "Coat", "int", "face") +
            "; " + messages::kNoAttributes);
}

TEST_F(BindTest, SaysWhenTheHelperIsMissing) {
    ::setenv("PATH", "/nonexistent", 1);
    ::unsetenv("OPENFAB_HELPER");
    folder_.write("other.png", "another picture");
    EXPECT_THAT(error_with("photo.png", "other.png"),
                ::testing::HasSubstr("5:34: " + fmt::format(messages::kTextureBefore, "photo") +
                                     fmt::format(texture::messages::kNoConverter,
                                                 (folder_.path() / "other.png").string())));
}

TEST_F(BindTest, MakesAQuickWorldOfAMesh) {
    const openfab_uniform uniforms[] = {kUniforms[1], kUniforms[7], kUniforms[8]};
    fablet_.uniform_count = 3;
    fablet_.uniforms = uniforms;
    fablet_.texture_count = 0;
    fablet_.surface_input_count = 0;
    const std::filesystem::path file = folder_.write(
        "tetra.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    const Result<world::World> world = make_quick_world(file, list_);
    ASSERT_TRUE(world) << world.error().text();
    EXPECT_EQ(world->printer, "generic");
    EXPECT_EQ(world->notes,
              std::vector<std::string>{fmt::format(messages::kMeshSize, "tetra.obj", 9.0, 9.0, 9.0,
                                                   1.0, mesh::messages::kUnitAssumed)});
    ASSERT_EQ(world->materials.size(), 3u);
    EXPECT_EQ(world->materials[0].name, "skin");
    EXPECT_EQ(world->materials[2].name, "palette[1]");
    std::set<world::Rgba8> keys;
    for (const world::Material& m : world->materials)
        keys.insert(m.key);
    EXPECT_EQ(keys.size(), 3u);
    const Result<std::vector<Part>> parts = bind(*world, list_, {{"tetra.gain=2"}});
    ASSERT_TRUE(parts) << parts.error().text();
    EXPECT_EQ((*parts)[0].slot_material, (std::vector<uint8_t>{1, 2, 3, 0}));
    EXPECT_EQ(as_float((*parts)[0].uniform_values[2]), 2.0f);
    EXPECT_FALSE(make_quick_world(folder_.path() / "none.obj", list_));
    const Result<world::World> step = make_quick_world(folder_.write("x.step", "solid"), list_);
    ASSERT_FALSE(step);
    EXPECT_THAT(step.error().text(), testing::Says(mesh::messages::kNoMeshExtension));
    EXPECT_FALSE(make_quick_world(file, list_, "Other"));
}

}  // namespace
}  // namespace openfab::part
