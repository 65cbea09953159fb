// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// How triangles of a 3MF look: materials, composites, colours, pictures, and layers of these.

#include "base/color.h"
#include "mesh/read/messages.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/unit/mesh/threemf_package.h"

namespace openfab::mesh {
namespace {

using Rgb = std::vector<float>;
using Color = std::optional<std::array<double, 3>>;

constexpr const char* kItem = R"(<item objectid="9"/>)";

constexpr const char* kMaterials =
    R"(<basematerials id="1"><base name="PLA" displaycolor="#FF0000"/><base name="PLA" displaycolor="#0000FF80"/><base name="bare"/></basematerials>)";
constexpr const char* kColors =
    R"(<m:colorgroup id="2"><m:color color="#FF0000"/><m:color color="#00FF00"/><m:color color="#0000FF80"/><m:color color="#FFFFFF00"/></m:colorgroup>)";
constexpr const char* kPicture =
    R"(<m:texture2d id="3" path="/3D/a.png" contenttype="image/png" tilestyleu="mirror" tilestylev="clamp"/>
<m:texture2dgroup id="4" texid="3"><m:tex2coord u="0.25" v="0.75"/><m:tex2coord u="1" v="0"/><m:tex2coord u="0" v="2"/></m:texture2dgroup>)";

std::string cube_package(const std::string& resources, const std::vector<std::string>& faces,
                         const std::string& object = "", const PackageFiles& more = {}) {
    return threemf_package(threemf_model(resources + R"(<object id="9" name="cube" )" + object +
                                             ">" + threemf_cube(0, 10, faces) + "</object>",
                                         kItem),
                           more);
}

TEST(ThreemfLooks, TellsMaterialsApartByTheirIndex) {
    const MeshSource source = read_source(cube_package(
        kMaterials, {R"(pid="1" p1="1")", R"(pid="1" p1="2")", ""}, R"(pid="1" pindex="0")"));
    ASSERT_EQ(source.looks.size(), 3u);
    EXPECT_EQ(look_of(source, 0).name, "PLA");
    EXPECT_EQ(look_of(source, 0).color, (Color{{0, 0, 1}}));
    EXPECT_NEAR(look_of(source, 0).alpha, 128 / 255.0, 1e-6);
    EXPECT_EQ(look_of(source, 1).name, "bare");
    EXPECT_EQ(look_of(source, 1).color, std::nullopt);
    EXPECT_EQ(look_of(source, 2).name, "PLA");
    EXPECT_EQ(look_of(source, 2).color, (Color{{1, 0, 0}}));
    EXPECT_TRUE(look_of(source, 2).is_material);
    EXPECT_EQ(told(source), "");
}

TEST(ThreemfLooks, HasColoursByCorner) {
    const MeshSource source = read_source(cube_package(
        kColors, {R"(pid="2" p1="0" p2="1" p3="2")", R"(p1="1")", ""}, R"(pid="2" pindex="3")"));
    EXPECT_TRUE(look_of(source, 0).vertex_colors);
    EXPECT_FALSE(look_of(source, 0).is_material);
    EXPECT_EQ(value_of(source, "color", 0, 0), (Rgb{1, 0, 0}));
    EXPECT_EQ(value_of(source, "color", 0, 1), (Rgb{0, 1, 0}));
    // Colours that are no layer are opaque.
    EXPECT_EQ(value_of(source, "color", 0, 2), (Rgb{0, 0, 1}));
    EXPECT_EQ(value_of(source, "color", 1, 2), (Rgb{0, 1, 0}));  // the object's group
    EXPECT_EQ(value_of(source, "color", 2, 0), (Rgb{1, 1, 1}));
}

TEST(ThreemfLooks, PutsPicturesBesidePlainFaces) {
    const MeshSource source =
        read_source(cube_package(std::string(kMaterials) + kPicture,
                                 {R"(pid="4" p1="0" p2="1" p3="2")", ""}, R"(pid="1" pindex="0")"));
    const Look look = look_of(source, 0);
    ASSERT_TRUE(look.picture);
    EXPECT_EQ(look.picture->source, "3D/a.png");
    EXPECT_EQ(look.picture->name, "a.png");
    EXPECT_EQ(look.picture->wrap[0], PictureWrap::kMirror);
    EXPECT_EQ(look.picture->wrap[1], PictureWrap::kClamp);
    EXPECT_EQ(look.picture->alpha, PictureUse::Alpha::kOpaque);
    EXPECT_FALSE(look.tinted);
    EXPECT_FALSE(look.is_material);
    EXPECT_EQ(value_of(source, "uv", 0, 0), (Rgb{0.25f, 0.75f}));
    EXPECT_EQ(value_of(source, "uv", 0, 2), (Rgb{0, 2}));
    EXPECT_EQ(look_of(source, 1).name, "PLA");
    EXPECT_EQ(value_of(source, "uv", 1, 0), Rgb{});
}

TEST(ThreemfLooks, ReadsTileStyles) {
    const auto wrap = [](const std::string& styles) {
        const MeshSource source = read_source(cube_package(
            std::string(kMaterials) +
                R"(<m:texture2d id="3" path="/a.png" contenttype="image/png" )" + styles +
                R"(/><m:texture2dgroup id="4" texid="3"><m:tex2coord u="0" v="0"/></m:texture2dgroup>)",
            {R"(pid="4" p1="0")"}, R"(pid="1" pindex="0")"));
        const Look look = look_of(source, 0);
        EXPECT_TRUE(look.picture);
        // Where a picture ends, the object's colour is seen.
        const bool ends = styles.find("none") != std::string::npos;
        EXPECT_EQ(look.color, ends ? (Color{{1, 0, 0}}) : std::nullopt);
        return look.picture->wrap;
    };
    using Wraps = std::array<PictureWrap, 2>;
    EXPECT_EQ(wrap(""), (Wraps{PictureWrap::kRepeat, PictureWrap::kRepeat}));
    EXPECT_EQ(wrap(R"(tilestyleu="wrap" tilestylev="mirror")"),
              (Wraps{PictureWrap::kRepeat, PictureWrap::kMirror}));
    EXPECT_EQ(wrap(R"(tilestyleu="clamp")"), (Wraps{PictureWrap::kClamp, PictureWrap::kRepeat}));
    EXPECT_EQ(wrap(R"(tilestylev="none")"), (Wraps{PictureWrap::kRepeat, PictureWrap::kNone}));
}

TEST(ThreemfLooks, MixesComposites) {
    const std::string resources =
        std::string(kMaterials) +
        R"(<m:compositematerials id="5" matid="1" matindices="0 1"><m:composite values="0.6 1.4"/><m:composite values="0 0"/><m:composite values="2"/></m:compositematerials>)";
    const MeshSource source = read_source(
        cube_package(resources, {R"(pid="5" p1="0")", R"(pid="5" p1="1")", R"(pid="5" p1="2")",
                                 R"(pid="5" p1="0" p2="2" p3="2")"}));
    const Look third = look_of(source, 0);
    ASSERT_EQ(third.mixture.size(), 2u);
    EXPECT_NEAR(third.mixture[0].second, 0.3, 1e-12);
    EXPECT_NEAR(third.mixture[1].second, 0.7, 1e-12);
    EXPECT_EQ(source.looks[third.mixture[0].first].color, (Color{{1, 0, 0}}));
    EXPECT_EQ(source.looks[third.mixture[1].first].color, (Color{{0, 0, 1}}));
    EXPECT_NEAR((*third.color)[0], 0.3, 1e-12);
    EXPECT_EQ(third.name, "30 % PLA, 70 % PLA");
    EXPECT_TRUE(third.is_material);
    // Shares that are all 0 are alike; one that is missing is 0, and one alone is no mixture.
    EXPECT_NEAR(look_of(source, 1).mixture.at(0).second, 0.5, 1e-12);
    EXPECT_TRUE(look_of(source, 2).mixture.empty());
    EXPECT_EQ(look_of(source, 2).color, (Color{{1, 0, 0}}));
    // Between corners there is the mean: (0.3 + 1 + 1) / 3, in steps of 0.05.
    EXPECT_NEAR(look_of(source, 3).mixture.at(0).second, 0.75, 1e-12);
    EXPECT_EQ(told(source), told_line(messages::kCompositeGradients, "1, 3D/3dmodel.model, group 5",
                                      messages::kCompositeGradientsHelp));
}

/// A cube of multi-properties: its layers, how they are blended, and picks of three corners.
MeshSource multi(const std::string& layers, const std::string& methods,
                 const std::vector<std::string>& picks) {
    std::string resources =
        std::string(kMaterials) + kColors + kPicture +
        R"(<m:texture2dgroup id="6" texid="3"><m:tex2coord u="0" v="0"/></m:texture2dgroup>
<m:compositematerials id="5" matid="1" matindices="0 1"><m:composite values="1 3"/></m:compositematerials>)";
    resources += R"(<m:multiproperties id="8" pids=")" + layers + "\"" +
                 (methods.empty() ? "" : " blendmethods=\"" + methods + "\"") + ">";
    for (const std::string& pick : picks)
        resources += R"(<m:multi pindices=")" + pick + R"("/>)";
    const std::string corners =
        picks.size() == 3 ? R"(pid="8" p1="0" p2="1" p3="2")" : R"(pid="8" p1="0")";
    return read_source(cube_package(resources + "</m:multiproperties>", {corners}));
}

TEST(ThreemfLooks, LaysColoursOnMaterials) {
    // Opaque, half, and not at all.
    const MeshSource source = multi("1 2", "", {"0 1", "0 2", "0 3"});
    const Look look = look_of(source, 0);
    EXPECT_EQ(look.name, "PLA");
    EXPECT_TRUE(look.is_material);
    EXPECT_TRUE(look.vertex_colors);
    EXPECT_EQ(look.color, std::nullopt);
    EXPECT_EQ(value_of(source, "color", 0, 0), (Rgb{0, 1, 0}));
    EXPECT_NEAR(value_of(source, "color", 0, 1)[0], 127 / 255.0, 1e-6);
    EXPECT_NEAR(value_of(source, "color", 0, 1)[2], 128 / 255.0, 1e-6);
    EXPECT_EQ(value_of(source, "color", 0, 2), (Rgb{1, 0, 0}));
    // One that is multiplied is opaque on a material.
    EXPECT_EQ(value_of(multi("1 2", "multiply", {"0 2"}), "color", 0, 0), (Rgb{0, 0, 1}));
    // Nowhere anything: the material itself.
    const Look bare = look_of(multi("1 2", "", {"1 3"}), 0);
    EXPECT_FALSE(bare.vertex_colors);
    EXPECT_EQ(bare.color, (Color{{0, 0, 1}}));
    // Missing picks are 0.
    EXPECT_EQ(value_of(multi("1 2", "", {"0"}), "color", 0, 0), (Rgb{1, 0, 0}));
}

TEST(ThreemfLooks, LaysPicturesOnMaterials) {
    MeshSource source = multi("1 4", "", {"0 0", "0 1", "0 2"});
    Look look = look_of(source, 0);
    ASSERT_TRUE(look.picture);
    EXPECT_EQ(look.name, "PLA");
    EXPECT_TRUE(look.is_material);
    EXPECT_EQ(look.color, (Color{{1, 0, 0}}));
    EXPECT_EQ(look.picture->alpha, PictureUse::Alpha::kBlend);
    EXPECT_FALSE(look.tinted);
    EXPECT_EQ(value_of(source, "uv", 0, 1), (Rgb{1, 0}));
    // The first colour on a material is not multiplied by what cannot be known.
    look = look_of(multi("1 4", "multiply", {"0 0"}), 0);
    EXPECT_EQ(look.picture->alpha, PictureUse::Alpha::kOpaque);
    EXPECT_FALSE(look.tinted);
    look = look_of(multi("5 4", "", {"0 0"}), 0);
    EXPECT_EQ(look.mixture.size(), 2u);
    EXPECT_TRUE(look.picture);
    EXPECT_EQ(told(source), "");
}

TEST(ThreemfLooks, LaysPicturesAndColoursOnEachOther) {
    // A picture over a colour, by its alpha.
    MeshSource source = multi("2 4", "", {"1 0"});
    Look look = look_of(source, 0);
    EXPECT_TRUE(look.vertex_colors);
    EXPECT_FALSE(look.is_material);
    EXPECT_EQ(look.picture->alpha, PictureUse::Alpha::kBlend);
    EXPECT_FALSE(look.tinted);
    EXPECT_EQ(value_of(source, "color", 0, 0), (Rgb{0, 1, 0}));
    // Times a colour, in either order.
    for (const char* layers : {"2 4", "4 2"}) {
        source = multi(layers, "multiply", {"1 1"});
        look = look_of(source, 0);
        EXPECT_TRUE(look.tinted);
        EXPECT_TRUE(look.vertex_colors);
        EXPECT_EQ(look.picture->alpha, PictureUse::Alpha::kOpaque);
        EXPECT_EQ(value_of(source, "color", 0, 0), (Rgb{0, 1, 0}));
    }
    // A colour that hides the picture, and one that is not seen.
    source = multi("4 2", "", {"0 1"});
    EXPECT_FALSE(look_of(source, 0).picture);
    EXPECT_EQ(value_of(source, "color", 0, 0), (Rgb{0, 1, 0}));
    source = multi("4 2", "", {"0 3"});
    EXPECT_TRUE(look_of(source, 0).picture);
    EXPECT_FALSE(look_of(source, 0).vertex_colors);
    // A picture over a colour that is half over a material.
    source = multi("1 2 4", "", {"0 2 0"});
    EXPECT_TRUE(look_of(source, 0).picture);
    EXPECT_NEAR(value_of(source, "color", 0, 0)[0], 127 / 255.0, 1e-6);
    EXPECT_EQ(told(source), "");
}

TEST(ThreemfLooks, TellsOfLayersThatDoNotFit) {
    const std::string expected = told_line(messages::kTooManyLayers, "1, 3D/3dmodel.model, group 8",
                                           messages::kTooManyLayersHelp);
    EXPECT_EQ(told(multi("4 6", "", {"0 0"})), expected);  // two pictures
    EXPECT_EQ(told(multi("4 2", "", {"0 2"})), expected);  // half a colour over a picture
    EXPECT_EQ(told(multi("2 1", "", {"0 0"})), expected);  // a material that is not the lowest
}

TEST(ThreemfLooks, TellsOfALowestLayerThatIsClear) {
    const std::string expected =
        told_line(messages::kTransparentColours, "1, 3D/3dmodel.model, group 2",
                  messages::kTransparentColoursHelp);
    EXPECT_EQ(told(multi("2", "", {"2"})), expected);
    EXPECT_EQ(told(multi("2 2", "multiply", {"2 1"})), expected);
    EXPECT_EQ(told(multi("2 2", "mix", {"1 2"})), "");  // upon an opaque one
}

TEST(ThreemfLooks, KeepsResourcesOfPartsApart) {
    const auto part = [](const char* color, const char* picture) {
        return threemf_model(
            fmt::format(
                R"(<basematerials id="1"><base name="PLA" displaycolor="{}"/><base name="shared" displaycolor="#112233"/></basematerials>
<m:texture2d id="3" path="{}" contenttype="image/png"/><m:texture2dgroup id="4" texid="3"><m:tex2coord u="0" v="0"/></m:texture2dgroup>
<object id="2" pid="1" pindex="0">)",
                color, picture) +
                threemf_cube(0, 1, {R"(pid="4" p1="0")", R"(pid="1" p1="1")", ""}) + "</object>",
            "");
    };
    const std::string root = threemf_model(
        R"(<object id="9" p:UUID="x"><components><component objectid="2" p:path="/3D/b.model"/><component objectid="2" p:path="/3D/Objects/C.model"/></components></object>)",
        kItem);
    const MeshSource source = read_source(
        threemf_package(root, {{"3D/b.model", part("#FF0000", "/3D/red.png")},
                               {"3D/objects/c.model", part("#0000FF", "../blue.png")}}));
    EXPECT_EQ(look_of(source, 2).color, (Color{{1, 0, 0}}));
    EXPECT_EQ(look_of(source, 14).color, (Color{{0, 0, 1}}));
    EXPECT_EQ(look_of(source, 0).picture->source, "3D/red.png");
    EXPECT_EQ(look_of(source, 12).picture->source, "3D/blue.png");
    // What parts repeat is one.
    EXPECT_EQ(source.groups[source.face_groups[1]].look,
              source.groups[source.face_groups[13]].look);
    EXPECT_EQ(told(source), "");
}

TEST(ThreemfLooks, TellsOfPropertiesThatAreNotThere) {
    const auto says = [](const std::string& face) {
        const MeshSource source = read_source(cube_package(
            std::string(kMaterials) + kColors + kPicture +
                R"(<m:texture2dgroup id="6" texid="77"><m:tex2coord u="1" v="0"/></m:texture2dgroup>)",
            {face, ""}));
        EXPECT_EQ(source.mesh.triangles.size(), 12u);
        return look_of(source, 0).name + ": " + told(source);
    };
    const auto none = [](const std::string& group) {
        return "none: " + told_line(messages::kPropertiesNotDefined,
                                    "1, 3D/3dmodel.model, group " + group,
                                    messages::kPropertiesNotDefinedHelp);
    };
    EXPECT_EQ(says(R"(pid="1" p1="3")"), none("1"));
    EXPECT_EQ(says(R"(pid="2" p1="0" p2="4" p3="0")"), none("2"));
    EXPECT_EQ(says(R"(pid="4" p1="9")"), none("4"));
    EXPECT_EQ(says(R"(pid="70" p1="0")"), none("70"));
    EXPECT_EQ(says(R"(pid="6" p1="0")"),
              "none: " + told_line(messages::kPicturesNotDefined, "1, 3D/3dmodel.model, group 6",
                                   messages::kPicturesNotDefinedHelp));
}

TEST(ThreemfLooks, CarriesFiltersAndTellsOfDisplayProperties) {
    const MeshSource source = read_source(cube_package(
        R"(<m:texture2d id="3" path="/a.png" contenttype="image/png" filter="nearest"/><m:texture2dgroup id="4" texid="3"><m:tex2coord u="0" v="0"/></m:texture2dgroup>
<m:pbmetallicdisplayproperties id="7"><m:pbmetallic name="gold" metallicness="1" roughness="0.2"/></m:pbmetallicdisplayproperties>)",
        {R"(pid="4" p1="0")"}));
    EXPECT_EQ(told(source), told_line(messages::kGlossOfMaterials, "1, a.3mf: /3D/3dmodel.model",
                                      messages::kGlossOfMaterialsHelp));
    EXPECT_TRUE(source.looks.at(0).picture->nearest);
}

TEST(ThreemfLooks, FindsPicturesByAnySpelling) {
    const testing::TempFolder folder;
    std::vector<std::string> names;
    const auto read = [&](const char* path, const char* entry) {
        const std::string package =
            cube_package(fmt::format(R"(<m:texture2d id="3" path="{}" contenttype="image/png"/>
<m:texture2dgroup id="4" texid="3"><m:tex2coord u="0" v="0"/></m:texture2dgroup>)",
                                     path),
                         {R"(pid="4" p1="0")"}, "", {{entry, "bytes of it"}});
        const std::filesystem::path file = folder.write("a.3mf", package);
        const Result<MeshSource> source = parse_threemf(package, "a.3mf");
        EXPECT_TRUE(source);
        names.push_back(look_of(*source, 0).picture->name);
        const std::vector<std::string> sources = {look_of(*source, 0).picture->source,
                                                  "not/there.png"};
        std::vector<std::string> found;
        EXPECT_TRUE(read_threemf_pictures(
            file, sources, 1'000'000, [&](size_t i, Result<std::string> bytes) {
                EXPECT_EQ(i, found.size());
                found.push_back(bytes ? *bytes : bytes.error().text());
            }));
        EXPECT_EQ(found.size(), 2u);
        EXPECT_THAT(found[1], testing::Says(messages::kEntryWrong, "*", "not/there.png",
                                            messages::kEntryMissing));
        return found[0];
    };
    EXPECT_EQ(read("/3D/Textures/t.png", "3D/Textures/t.png"), "bytes of it");
    EXPECT_EQ(read("3D/Textures/t.png", "3d/textures/T.png"), "bytes of it");
    EXPECT_EQ(read("Textures/t.png", "3D/Textures/t.png"), "bytes of it");
    EXPECT_EQ(read("../Textures/./t.png", "Textures/t.png"), "bytes of it");
    EXPECT_EQ(read("/3D/my%20t%C3%A9.png", "3D/my t\xc3\xa9.png"), "bytes of it");
    EXPECT_EQ(read("/3D/my%20t%c3%a9.png", "3D/my%20t%C3%A9.png"), "bytes of it");
    EXPECT_EQ(read("/3D/my t\xc3\xa9.png", "3D/my%20t%C3%A9.png"), "bytes of it");
    EXPECT_EQ(read("/3D/50%.png", "3D/50%.png"), "bytes of it");
    EXPECT_EQ(read("\\3D\\t.png", "3D/t.png"), "bytes of it");
    EXPECT_EQ(names, (std::vector<std::string>{"t.png", "t.png", "t.png", "t.png",
                                               "my t\xc3\xa9.png", "my t\xc3\xa9.png",
                                               "my t\xc3\xa9.png", "50%.png", "t.png"}));
}

}  // namespace
}  // namespace openfab::mesh
