// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What slicers of 2026 write beside the model: paint, and filaments that are mixed of others.

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "mesh/read/messages.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/threemf_package.h"

namespace openfab::mesh {
namespace {

constexpr const char* kOneItem = R"(<item objectid="9"/>)";

TEST(ThreemfMixed, ReadsPaintBesideTheModel) {
    const auto package = [](const std::string& json) {
        return threemf_package(
            threemf_model(R"(<object id="9">)" + threemf_cube(0, 10) + "</object>", kOneItem),
            {{"Metadata/Slic3r_facets_annotation.json", json}});
    };
    const MeshSource source = read_source(package(
        R"([{"id": 9, "mmSegmentationFacetsVersion": 1, "mmSegmentationFacets": [{"triangle": 2, "dividing": "8"},
            {"triangle": 0, "dividing": "0C"}]}, {"id": 3, "mmSegmentationFacets": [{"triangle": 99, "dividing": "8"}]}])"));
    EXPECT_EQ(look_of(source, 0).name, "extruder 3");
    EXPECT_EQ(look_of(source, 1).name, "extruder 1");
    EXPECT_EQ(look_of(source, 2).name, "extruder 2");
    EXPECT_TRUE(testing::says(told(source), messages::kPaintBeside));  // of object 3
    // What is made of others has no triangles.
    const MeshSource made_of_others = read_source(threemf_package(
        threemf_model(
            R"(<object id="3">)" + threemf_cube(0, 10) +
                R"(</object><object id="9"><components><component objectid="3"/></components></object>)",
            kOneItem),
        {{"Metadata/Slic3r_facets_annotation.json",
          R"([{"id": 9, "mmSegmentationFacets": [{"triangle": 2, "dividing": "8"}]}])"}}));
    EXPECT_TRUE(testing::says(told(made_of_others), messages::kPaintBeside));
    for (const char* json :
         {R"({"objects": [{"id": 9, "mmSegmentationFacets": [{"triangle": 2, "dividing": "8"}]}]})",
          R"([{"id": 9.5, "mmSegmentationFacets": [{"triangle": 2, "dividing": "8"}]}])",
          R"([{"mmSegmentationFacets": [{"triangle": 2, "dividing": "8"}]}])"})
        EXPECT_TRUE(testing::says(told(read_source(package(json))), messages::kPaintBeside))
            << json;
    const MeshSource as_text = read_source(
        package(R"([{"id": "9", "mmSegmentationFacets": [{"triangle": 2, "dividing": "8"}]}])"));
    EXPECT_EQ(look_of(as_text, 2).name, "extruder 2");
    EXPECT_EQ(told(as_text), "");
    const std::pair<const char*, const char*> wrong[] = {
        {R"([{"id": 9, "mmSegmentationFacets": [{"triangle": 12, "dividing": "8"}]}])",
         messages::kPaintOfNoTriangle},
        {R"([{"id": 9, "mmSegmentationFacets": [{"triangle": -1, "dividing": "8"}]}])",
         messages::kPaintOfNoTriangle},
        {R"([{"id": 9, "mmSegmentationFacetsVersion": 3, "mmSegmentationFacets": []}])",
         messages::kPaintOfNewerVersion}};
    for (const auto& [json, row] : wrong) {
        const Result<MeshSource> read = parse_threemf(package(json), "part.3mf");
        ASSERT_FALSE(read) << json;
        EXPECT_TRUE(testing::says(read.error().text(), row)) << read.error().text();
    }
}

/// "0.25 of red, 0.75 of blue", as the looks are listed.
std::string mixture_of(const MeshSource& source, size_t triangle) {
    std::string text;
    for (const auto& [look, share] : look_of(source, triangle).mixture)
        text += fmt::format("{}{:.4g} of {}", text.empty() ? "" : ", ", share,
                            source.looks[static_cast<size_t>(look)].name);
    return text;
}

TEST(ThreemfMixed, MixesFilamentsAsThreeSlicersSay) {
    const std::string model = threemf_model(
        R"(<object id="9">)" +
            threemf_cube(0, 10, {R"(paint_color="0C")", R"(paint_color="1C")", ""}) + "</object>",
        kOneItem);
    const std::string colors =
        R"("filament_settings_id": ["red", "blue", "white"], "filament_colour": ["#FF0000", "#0000FF", "#FFFFFF")";
    // Painted with filaments 3 and 4.
    const std::tuple<const char*, std::string, const char*, const char*> cases[] = {
        {"Metadata/project_settings.config",
         R"({"filament_settings_id": ["red", "blue", "mix", "even"], "filament_colour": ["#FF0000", "#0000FF", "#800080", "#800080"],
             "filament_is_mixed": ["0", "0", "1", "1"], "filament_mixed_components": ["", "", "1,2", "2,1"],
             "filament_mixed_sublayer_ratios": ["", "", "0.25,0.75", ""]})",
         "0.25 of red, 0.75 of blue", "0.5 of red, 0.5 of blue"},
        // Of a mixture, which stands behind it: 0.5 + 0.5 * 0.25 of red. Truths and numbers are those of scripts.
        {"Metadata/project_settings.config",
         R"({"filament_settings_id": ["red", "blue", "of mix", "mix"], "filament_colour": ["#FF0000", "#0000FF", "#800080", "#800080"],
             "filament_is_mixed": [false, 0, true, 1], "filament_mixed_components": ["", "", "1,4", "1,2"],
             "filament_mixed_sublayer_ratios": ["", "", "0.5,0.5", "0.25,0.75"]})",
         "0.625 of red, 0.375 of blue", "0.25 of red, 0.75 of blue"},
        {"Metadata/project_settings.config",
         "{" + colors +
             R"(], "mixed_filament_definitions": "1,2,0,0,50,0,g,w,m2,d1,o1,u1;1,2,1,1,40,0,g,w,m2,z0,xa0,xb0,d0,o0,u2"})",
         "", "0.6 of red, 0.4 of blue"},
        {"Metadata/project_settings.config",
         "{" + colors +
             R"(], "mixed_filament_definitions": "1,2,1,1,50,0,g1/2/3,w2/1/1,m0,z0,xa0,xb0,d0,o0,u2,cm0"})",
         "", "0.25 of white, 0.5 of red, 0.25 of blue"},
        {"Metadata/Prusa_Slicer_full_spectrum.json",
         R"({"version": 1, "physical_extruders": [{"id": 1, "color": "#FF0000"}, {"id": 2, "color": "#0000FF"}], "virtual_extruders":
             [{"id": 3, "kind": "fullspectrum", "color": "#800080", "components": [{"extruder": 1, "ratio": 1}, {"extruder": 2, "ratio": 3}]},
              {"id": 4, "kind": "fullspectrum", "color": "#800080", "components": [{"extruder": 2, "ratio": 1}, {"extruder": 1, "ratio": 1}]}]})",
         "0.25 of extruder 1, 0.75 of extruder 2", "0.5 of extruder 1, 0.5 of extruder 2"}};
    for (const auto& [file, text, third, fourth] : cases) {
        const MeshSource source = read_source(threemf_package(model, {{file, text}}));
        EXPECT_EQ(mixture_of(source, 0), third) << text;
        EXPECT_EQ(mixture_of(source, 1), fourth) << text;
        EXPECT_EQ(mixture_of(source, 2), "") << text;
    }
}

int64_t looks_named(const MeshSource& source, const std::string& name) {
    return std::ranges::count(source.looks, name, &Look::name);
}

/// Base materials that other programs read, and filaments of a slicer: as OpenFab and others write them.
TEST(ThreemfMixed, FilamentsAreTheMaterialsOfTheirNameAndColour) {
    const std::string materials =
        R"(<basematerials id="5"><base name="red" displaycolor="#FF0000FF"/><base name="blue" displaycolor="#0000FF"/><base name="1 red + 3 blue" displaycolor="#800080"/></basematerials>)";
    for (const bool first : {false, true}) {  // the mixture before its materials
        const std::vector<std::string> triangles{
            first ? R"(pid="5" p1="2" paint_color="0C")" : R"(pid="5" p1="0" paint_color="4")",
            R"(pid="5" p1="1" paint_color="8")", R"(pid="5" p1="2" paint_color="0C")",
            R"(pid="5" p1="0" paint_color="4")"};
        const MeshSource source = read_source(threemf_package(
            threemf_model(materials + R"(<object id="9" pid="5" pindex="0">)" +
                              threemf_cube(0, 10, triangles) + "</object>",
                          kOneItem),
            {{"Metadata/Prusa_Slicer_full_spectrum.json",
              R"({"version": 1, "physical_extruders": [{"id": 1, "color": "#FF0000", "name": "red"}, {"id": 2, "color": "#0000FF", "name": "blue"}],
                  "virtual_extruders": [{"id": 3, "kind": "fullspectrum", "color": "#800080", "components": [{"extruder": 1, "ratio": 1}, {"extruder": 2, "ratio": 3}]}]})"}}));
        EXPECT_EQ(mixture_of(source, 2), "0.25 of red, 0.75 of blue");
        EXPECT_EQ(looks_named(source, "red"), 1);
        EXPECT_EQ(looks_named(source, "blue"), 1);
        // Those alike of one slicer are of two spools.
        const MeshSource alike = read_source(threemf_package(
            threemf_model(R"(<object id="9">)" +
                              threemf_cube(0, 10, {R"(paint_color="4")", R"(paint_color="8")"}) +
                              "</object>",
                          kOneItem),
            {{"Metadata/project_settings.config",
              R"({"filament_settings_id": ["PLA", "PLA"], "filament_colour": ["#FF0000", "#FF0000"]})"}}));
        EXPECT_EQ(looks_named(alike, "PLA"), 2);
    }
}

TEST(ThreemfMixed, TellsOfMixturesThatItCannotMix) {
    const std::string model =
        threemf_model(R"(<object id="9">)" + threemf_cube(0, 10) + "</object>", kOneItem);
    const auto settings = [&](const char* more) {
        return told(read_source(threemf_package(
            model, {{"Metadata/project_settings.config",
                     std::string(R"({"filament_colour": ["#FF0000", "#0000FF", "#800080"],)") +
                         more + "}"}})));
    };
    EXPECT_TRUE(testing::says(
        settings(
            R"("filament_is_mixed": ["0", "0", "1"], "filament_mixed_components": ["", "", "1,7"])"),
        messages::kMixtureOfNoFilaments));
    // Of each other, and more weights than filaments.
    EXPECT_TRUE(testing::says(
        settings(
            R"("filament_is_mixed": ["0", "1", "1"], "filament_mixed_components": ["", "1,3", "1,2"])"),
        messages::kMixtureOfNoFilaments));
    EXPECT_TRUE(testing::says(
        settings(
            R"("filament_is_mixed": ["0", "0", "1"], "filament_mixed_components": ["", "", "1,2"], "filament_mixed_sublayer_ratios": ["", "", "0.2,0.3,0.5"])"),
        messages::kMixtureOfNoFilaments));
    EXPECT_TRUE(testing::says(
        settings(
            R"("filament_is_mixed": ["0", "0", "1"], "filament_mixed_components": ["", "", "1,2"], "filament_mixed_gradient": ["0", "0", "1"])"),
        messages::kMixedGradients));
    EXPECT_TRUE(testing::says(
        settings(R"("mixed_filament_definitions": "1,2,1,1,50,0,g,w,m2,r1/0.1/0.9,d0")"),
        messages::kMixedGradients));
}

}  // namespace
}  // namespace openfab::mesh
