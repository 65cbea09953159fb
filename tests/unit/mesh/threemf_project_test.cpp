// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Projects of slicers, and what else a 3MF has beside its models: roles of bodies, paint, extruders.

#include <fmt/format.h>

#include <cmath>

#include "base/messages.h"
#include "mesh/read/messages.h"
#include "tests/support/says/says.h"
#include "tests/unit/mesh/threemf_package.h"

namespace openfab::mesh {
namespace {

using Color = std::optional<std::array<double, 3>>;

constexpr const char* kBuildItem = R"(<item objectid="9"/>)";

double volume_of(const MeshSource& source, int32_t body) {
    double six = 0;
    for (size_t t = 0; t < source.mesh.triangles.size(); ++t) {
        if (source.groups[source.face_groups[t]].body != body) continue;
        const auto& c = source.mesh.triangles[t];
        six += dot(source.mesh.positions[c[0]],
                   cross(source.mesh.positions[c[1]], source.mesh.positions[c[2]]));
    }
    return six / 6;
}

double area_of(const MeshSource& source, const std::string& look) {
    double area = 0;
    for (size_t t = 0; t < source.mesh.triangles.size(); ++t) {
        if (look_of(source, t).name != look) continue;
        const auto& c = source.mesh.triangles[t];
        const Vec3d a = source.mesh.positions[c[0]];
        area += length(cross(source.mesh.positions[c[1]] - a, source.mesh.positions[c[2]] - a)) / 2;
    }
    return area;
}

/// `NAME role volume look`, a body a line.
std::string bodies(const MeshSource& source) {
    std::string text;
    for (size_t b = 0; b < source.bodies.size(); ++b) {
        std::string look;
        for (size_t t = source.mesh.triangles.size(); t-- > 0;) {
            if (&body_of(source, t) == &source.bodies[b]) look = look_of(source, t).name;
        }
        const char* const role = source.bodies[b].role == BodyRole::kNegative ? "negative" : "part";
        text += fmt::format("{}: {} of {:.0f} mm3, {}, in {}\n", source.bodies[b].name, role,
                            volume_of(source, static_cast<int32_t>(b)), look,
                            source.bodies[b].assembly);
    }
    return text;
}

/// Several cubes in one mesh, as PrusaSlicer writes its volumes.
std::string cubes(const std::vector<std::pair<double, double>>& ranges) {
    std::string vertices, triangles;
    int first = 0;
    for (const auto& [low, high] : ranges) {
        std::string text = threemf_cube(low, high);
        const size_t middle = text.find("</vertices>");
        vertices += text.substr(16, middle - 16);
        for (size_t at = text.find("<triangle "); at != std::string::npos;
             at = text.find("<triangle ", at + 1)) {
            int v[3];
            std::sscanf(text.c_str() + at, R"(<triangle v1="%d" v2="%d" v3="%d")", v, v + 1, v + 2);
            triangles += fmt::format(R"(<triangle v1="{}" v2="{}" v3="{}"/>)", v[0] + first,
                                     v[1] + first, v[2] + first);
        }
        first += 8;
    }
    return "<mesh><vertices>" + vertices + "</vertices><triangles>" + triangles +
           "</triangles></mesh>";
}

constexpr const char* kPrusaSettings =
    "; filament_colour = #111111;#222222;#333333\n; extruder_colour = #FF0000;\"\";#0000FF\n"
    "; filament_settings_id = \"Prusament PLA\";\"Prusament PLA\"\n; filament_type = PLA;PLA;PVB\n";

TEST(ThreemfProject, ReadsVolumesOfPrusaSlicer) {
    const std::string config = R"(<?xml version="1.0" encoding="UTF-8"?><config>
<object id="9" instances_count="2"><metadata type="object" key="name" value="case"/><metadata type="object" key="extruder" value="1"/>
<volume firstid="0" lastid="11"><metadata type="volume" key="name" value="shell"/><metadata type="volume" key="volume_type" value="ModelPart"/></volume>
<volume firstid="12" lastid="23"><metadata type="volume" key="name" value="hole"/><metadata type="volume" key="modifier" value="1"/><metadata type="volume" key="volume_type" value="NegativeVolume"/></volume>
<volume firstid="24" lastid="35"><metadata type="volume" key="volume_type" value="ModelPart"/><metadata type="volume" key="extruder" value="3"/></volume>
<volume firstid="36" lastid="47"><metadata type="volume" key="name" value="dense"/><metadata type="volume" key="volume_type" value="ParameterModifier"/></volume>
<volume firstid="48" lastid="59"><metadata type="volume" key="volume_type" value="SupportEnforcer"/></volume>
<volume firstid="60" lastid="71"><metadata type="volume" key="volume_type" value="SupportBlocker"/></volume>
<volume firstid="72" lastid="83"><metadata type="volume" key="name" value="old"/><metadata type="volume" key="modifier" value="1"/><metadata type="volume" key="extruder" value="2"/></volume>
</object></config>)";
    const std::string model = threemf_model(
        R"(<object id="9" type="model">)" +
            cubes({{0, 10}, {4, 6}, {12, 15}, {0, 3}, {1, 2}, {2, 3}, {3, 5}}) + "</object>",
        std::string(kBuildItem) +
            R"(<item objectid="9" transform="1 0 0 0 1 0 0 0 1 50 0 0" printable="1"/>
<item objectid="9" transform="1 0 0 0 1 0 0 0 1 90 0 0" printable="0"/>)");
    const MeshSource source =
        read_source(threemf_package(model, {{"Metadata/Slic3r_PE_model.config", config},
                                            {"Metadata/Slic3r_PE.config", kPrusaSettings}}));
    EXPECT_EQ(bodies(source),
              "shell: part of 1000 mm3, Prusament PLA, in 0\n"
              "hole: negative of 8 mm3, Prusament PLA, in 0\n"
              "case: part of 27 mm3, PVB, in 0\n"
              "shell: part of 1000 mm3, Prusament PLA, in 1\n"
              "hole: negative of 8 mm3, Prusament PLA, in 1\n"
              "case: part of 27 mm3, PVB, in 1\n");
    EXPECT_EQ(look_of(source, 0).color, (Color{{1, 0, 0}}));
    EXPECT_EQ(look_of(source, 24).color, (Color{{0, 0, 1}}));
    EXPECT_TRUE(look_of(source, 0).is_material);
    EXPECT_EQ(source.groups[source.face_groups[0]].names, (std::vector<std::string>{"case"}));
    const std::string why = messages::kSlicerVolumeHelp;
    EXPECT_EQ(told(source),
              told_line(messages::kSlicerSettings, "1, Metadata/Slic3r_PE.config",
                        messages::kSlicerSettingsHelp) +
                  told_line(messages::kModifierVolumes, "2, volume `dense`", why) +
                  told_line(messages::kSupportEnforcers, "2, case", why) +
                  told_line(messages::kSupportBlockers, "2, case", why) +
                  told_line(std::string(messages::kModifierVolumes) + messages::kThatNameAnExtruder,
                            "2, volume `old`", why) +
                  told_line(messages::kItemsSwitchedOff, "1, object 9", messages::kSwitchThemOn));
}

TEST(ThreemfProject, ReadsPartsOfBambuStudio) {
    const auto part = [](const char* resources) { return threemf_model(resources, ""); };
    std::string objects, components;
    int id = 1;
    for (const auto& [low, high] :
         std::vector<std::pair<double, double>>{{0, 10}, {4, 6}, {12, 15}, {0, 3}, {1, 2}}) {
        objects += fmt::format(R"(<object id="{}" type="{}">{}</object>)", id,
                               id == 1 || id == 3 ? "model" : "other", threemf_cube(low, high));
        components +=
            fmt::format(R"(<component p:path="/3D/Objects/object_1.model" objectid="{}"/>)", id++);
    }
    const std::string root = threemf_model(
        R"(<object id="9" type="model"><components>)" + components + "</components></object>",
        R"(<item objectid="9" printable="1"/>)", R"(requiredextensions="p")");
    const std::string config = R"(<?xml version="1.0" encoding="UTF-8"?><config><object id="9">
<metadata key="name" value="gear"/><metadata key="extruder" value="2"/>
<part id="1" subtype="normal_part"><metadata key="name" value="wheel"/><metadata key="extruder" value="0"/></part>
<part id="2" subtype="negative_part"><metadata key="name" value="bore"/></part>
<part id="3" subtype="normal_part"><metadata key="name" value="pin"/><metadata key="extruder" value="1"/></part>
<part id="4" subtype="modifier_part"><metadata key="name" value="soft"/></part>
<part id="5" subtype="support_blocker"/></object>
<plate><metadata key="plater_id" value="1"/><model_instance><metadata key="object_id" value="9"/></model_instance></plate>
<plate><metadata key="plater_id" value="2"/></plate></config>)";
    const MeshSource source = read_source(threemf_package(
        root,
        {{"3D/Objects/object_1.model", part(objects.c_str())},
         {"Metadata/model_settings.config", config},
         {"Metadata/project_settings.config",
          R"({"filament_colour": ["#00FF00", "#FFFFFF00"], "filament_settings_id": ["Bambu PLA Basic", ""], "filament_type": ["PLA", "PETG"]})"},
         {"Metadata/custom_gcode_per_layer.xml",
          R"(<custom_gcodes_per_layer><plate><layer top_z="3" type="2" extruder="2"/><layer top_z="4" type="1"/></plate></custom_gcodes_per_layer>)"}}));
    EXPECT_EQ(bodies(source),
              "wheel: part of 1000 mm3, PETG, in 0\n"
              "bore: negative of 8 mm3, PETG, in 0\n"
              "pin: part of 27 mm3, Bambu PLA Basic, in 0\n");
    EXPECT_EQ(look_of(source, 24).color, (Color{{0, 1, 0}}));
    EXPECT_EQ(look_of(source, 0).alpha, 0);
    EXPECT_EQ(source.groups[source.face_groups[0]].names,
              (std::vector<std::string>{"gear", "wheel"}));
    EXPECT_EQ(
        told(source),
        told_line(fmt::format(messages::kDivisionIntoPlates, 2),
                  "1, Metadata/model_settings.config", messages::kDivisionIntoPlatesHelp) +
            told_line(messages::kSlicerSettings, "1, Metadata/project_settings.config",
                      messages::kSlicerSettingsHelp) +
            told_line(messages::kFilamentChanges, "1, Metadata/custom_gcode_per_layer.xml",
                      messages::kFilamentChangesHelp) +
            told_line(messages::kModifierVolumes, "1, volume `soft`", messages::kSlicerVolumeHelp) +
            told_line(messages::kSupportBlockers, "1, object 5", messages::kSlicerVolumeHelp));
}

/// Paint of a triangle whose three sides are halved.
std::string in_four(const std::string& a, const std::string& b, const std::string& c,
                    const std::string& middle) {
    return a + b + c + middle + "3";
}

std::string finely(int depth) {
    if (depth == 0) return "8";
    return in_four("0", finely(depth - 1), "0C", finely(depth - 1));
}

/// A cube of 10 mm whose first triangles, those of the bottom, are painted.
MeshSource painted(const std::vector<std::string>& codes, const char* attribute = "paint_color") {
    std::vector<std::string> faces;
    for (const std::string& code : codes)
        faces.push_back(fmt::format(R"({}="{}")", attribute, code));
    faces.emplace_back();
    const std::string package = threemf_package(threemf_model(
        R"(<object id="9" name="cube">)" + threemf_cube(0, 10, faces) + "</object>", kBuildItem));
    // Whatever is divided, the surface stays closed.
    const Result<LoadedMesh> loaded = parse_bytes(package, "a.3mf");
    EXPECT_TRUE(loaded) << loaded.error().text();
    MeshSource source = read_source(package);
    EXPECT_NEAR(volume_of(source, 0), 1000, 1e-9);
    return source;
}

/// The filament at the corner of the cube that only one triangle of the bottom has.
std::string look_at(const MeshSource& source, const Vec3d& point) {
    std::string found = "none";
    for (size_t t = 0; t < source.mesh.triangles.size(); ++t) {
        const auto& c = source.mesh.triangles[t];
        Vec3d sum{};
        for (const int32_t v : c)
            sum = sum + source.mesh.positions[v];
        const bool bottom = sum.z == 0;
        for (const int32_t v : c) {
            if (bottom && source.mesh.positions[v] == point) found = look_of(source, t).name;
        }
    }
    return found;
}

TEST(ThreemfProject, GivesPaintedTrianglesTheirFilaments) {
    for (const char* attribute : {"paint_color", "slic3rpe:mmu_segmentation"}) {
        std::string name = attribute;
        const std::string model = threemf_model(
            R"(<object id="9">)" +
                threemf_cube(
                    0, 10,
                    {name + "=\"8\"", name + "=\"0C\"", name + "=\"3FC\"", name + "=\"0\"", ""}) +
                "</object>",
            kBuildItem, R"(xmlns:slic3rpe="http://schemas.slic3r.org/3mf/2017/06")");
        const MeshSource source = read_source(threemf_package(model));
        EXPECT_EQ(source.mesh.triangles.size(), 12u);
        EXPECT_EQ(look_of(source, 0).name, "extruder 2");
        EXPECT_EQ(look_of(source, 1).name, "extruder 3");
        EXPECT_EQ(look_of(source, 2).name, "extruder 21");  // 3 + 15 + 3
        EXPECT_EQ(look_of(source, 3).name, "extruder 1");   // the volume's own
        EXPECT_EQ(look_of(source, 4).name, "extruder 1");
    }
}

TEST(ThreemfProject, ReadsPaintOfPrusaSlicersSecondVersion) {
    const auto model = [](const char* version) {
        std::string text = threemf_model(
            R"(<object id="9">)" +
                threemf_cube(
                    0, 10,
                    {R"(slic3rpe:mmu_segmentation="00EC")", R"(slic3rpe:mmu_segmentation="01EC")",
                     R"(slic3rpe:mmu_segmentation="EEEC")", R"(slic3rpe:mmu_segmentation="0C")",
                     R"(paint_color="0FC")", ""}) +
                "</object>",
            kBuildItem, R"(xmlns:slic3rpe="http://schemas.slic3r.org/3mf/2017/06")");
        text.insert(
            text.find("<resources>"),
            fmt::format(R"(<metadata name="slic3rpe:MmPaintingVersion">{}</metadata>)", version));
        return text;
    };
    const MeshSource source = read_source(threemf_package(model("2")));
    EXPECT_EQ(look_of(source, 0).name, "extruder 17");
    EXPECT_EQ(look_of(source, 1).name, "extruder 18");
    EXPECT_EQ(look_of(source, 2).name, "extruder 255");  // 17 + 14 + 16 * 14
    EXPECT_EQ(look_of(source, 3).name, "extruder 3");
    const Result<MeshSource> newer = parse_threemf(threemf_package(model("3")), "part.3mf");
    ASSERT_FALSE(newer);
    EXPECT_TRUE(testing::says(newer.error().text(), messages::kPaintOfNewerVersion));
    // A leaf within a divided triangle: half is 18, half is 2.
    std::string divided = model("2");
    divided.replace(divided.find("00EC"), 4, "01EC81");
    const MeshSource parts = read_source(threemf_package(divided));
    EXPECT_DOUBLE_EQ(area_of(parts, "extruder 2"), 25);
    // The second triangle is 18, too, and the fifth, of another program.
    EXPECT_DOUBLE_EQ(area_of(parts, "extruder 18"), 125);
}

TEST(ThreemfProject, DividesPaintedTriangles) {
    // The first triangle of the bottom: (0, 0), (0, 10), (10, 10).
    const Vec3d b{0, 10, 0}, c{10, 10, 0};
    MeshSource source = painted({"481"});
    EXPECT_NEAR(area_of(source, "extruder 1"), 575, 1e-9);
    EXPECT_NEAR(area_of(source, "extruder 2"), 25, 1e-9);
    // The side opposite of corner a is halved; the first child has b, and comes last.
    EXPECT_EQ(look_at(source, b), "extruder 1");
    // Side 1 is special: the corners are c, a, b in its place.
    source = painted({"0C85"});
    EXPECT_NEAR(area_of(source, "extruder 3"), 25, 1e-9);
    EXPECT_NEAR(area_of(source, "extruder 2"), 25, 1e-9);
    const auto at = [&](size_t corner) {
        return source.mesh.positions[source.mesh.triangles[0][corner]];
    };
    EXPECT_EQ(look_of(source, 0).name, "extruder 2");
    EXPECT_EQ(at(0), (Vec3d{5, 5, 0}));
    EXPECT_EQ(at(1), (Vec3d{0, 0, 0}));
    EXPECT_EQ(at(2), b);
    // Two halved sides: a quarter, a quarter, a half.
    source = painted({"0C802"});
    EXPECT_NEAR(area_of(source, "extruder 3"), 12.5, 1e-9);
    EXPECT_NEAR(area_of(source, "extruder 2"), 12.5, 1e-9);
    EXPECT_NEAR(area_of(source, "extruder 1"), 575, 1e-9);
    // Three: one at each corner, and the last in the middle.
    source = painted({"0C8003"});
    EXPECT_EQ(look_at(source, b), "extruder 2");
    EXPECT_EQ(look_at(source, c), "extruder 1");
    EXPECT_NEAR(area_of(source, "extruder 3"), 12.5, 1e-9);
    // A part of a part of one triangle beside a part of a part of a part of its neighbour.
    const std::string part = in_four("8", "0", "0", "0");
    source = painted(
        {in_four(part, "0", "0", "0"), in_four("0", "0", "0", in_four("0", "0", "0", part))});
    EXPECT_NEAR(area_of(source, "extruder 2"), 50.0 / 16 + 50.0 / 64, 1e-9);
    EXPECT_EQ(told(source), "");
}

TEST(ThreemfProject, KeepsSurfacesClosedWhereVerticesAreNotShared) {
    // Each triangle has vertices of its own; one is painted finely.
    std::string vertices, triangles;
    const std::string shared = threemf_cube(0, 10);
    const std::string paint = fmt::format(R"( paint_color="{}")", finely(4));
    int count = 0;
    for (size_t at = shared.find("<triangle "); at != std::string::npos;
         at = shared.find("<triangle ", at + 1)) {
        int v[3];
        std::sscanf(shared.c_str() + at, R"(<triangle v1="%d" v2="%d" v3="%d")", v, v + 1, v + 2);
        for (const int one : v)
            vertices += fmt::format(R"(<vertex x="{}" y="{}" z="{}"/>)", one & 1 ? 10 : 0,
                                    one & 2 ? 10 : 0, one & 4 ? 10 : 0);
        triangles += fmt::format(R"(<triangle v1="{}" v2="{}" v3="{}"{}/>)", count, count + 1,
                                 count + 2, count == 6 ? paint : "");
        count += 3;
    }
    const Result<LoadedMesh> loaded =
        parse_bytes(threemf_package(threemf_model("<object id=\"9\"><mesh><vertices>" + vertices +
                                                      "</vertices><triangles>" + triangles +
                                                      "</triangles></mesh></object>",
                                                  kBuildItem)),
                    "a.3mf");
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_GT(loaded->mesh.triangles.size(), 20u);
    EXPECT_NEAR(testing::signed_volume(loaded->mesh), 1000, 1e-9);
}

TEST(ThreemfProject, KeepsRangesOfVolumesWhereTrianglesAreDivided) {
    std::string mesh = cubes({{0, 10}, {4, 6}});
    const size_t first = mesh.find("<triangle ");
    mesh.insert(mesh.find("/>", first), R"( slic3rpe:mmu_segmentation="841")");
    const MeshSource source = read_source(threemf_package(
        threemf_model("<object id=\"9\">" + mesh + "</object>", kBuildItem,
                      R"(xmlns:slic3rpe="s")"),
        {{"Metadata/Slic3r_PE_model.config",
          R"(<config><object id="9"><volume firstid="0" lastid="11"/><volume firstid="12" lastid="23"><metadata key="volume_type" value="NegativeVolume"/><metadata key="extruder" value="2"/></volume></object></config>)"}}));
    EXPECT_EQ(bodies(source),
              ": part of 1000 mm3, extruder 1, in 0\n: negative of 8 mm3, extruder 2, in 0\n");
}

TEST(ThreemfProject, RefusesDamagedProjects) {
    const auto error = [](const std::string& config) {
        return parse_error(
            threemf_package(
                threemf_model("<object id=\"9\">" + threemf_cube(0, 10) + "</object>", kBuildItem),
                {{"Metadata/Slic3r_PE_model.config", config}}),
            "a.3mf");
    };
    const std::string begin = "a.3mf: Metadata/Slic3r_PE_model.config:1:";
    EXPECT_EQ(error(R"(<config><object id="9"><volume firstid="x" lastid="1"/></object></config>)"),
              begin + "24: `firstid`: " +
                  fmt::format(openfab::messages::kNotWholeNumber, "x", 0, 2147483647));
    EXPECT_EQ(error("<config><object"), begin + "9: unclosed token");
    std::string many = R"(<config><object id="9">)";
    for (int i = 0; i < 5000; ++i)
        many += R"(<volume firstid="0" lastid="1"/>)";
    EXPECT_THAT(error(many + "</object></config>"), testing::Says(messages::kTooManyVolumes, 4096));
}

TEST(ThreemfProject, RefusesDamagedPaint) {
    const auto error = [](const std::string& code) {
        return parse_error(
            threemf_package(threemf_model(
                R"(<object id="9" name="cube">)" +
                    threemf_cube(0, 10, {fmt::format(R"(paint_color="{}")", code), ""}) +
                    "</object>",
                kBuildItem)),
            "a.3mf");
    };
    const std::string begin =
        "a.3mf: " + fmt::format(messages::kPaintWrong, "object `cube`", 0, "");
    EXPECT_EQ(error("81"), begin + messages::kPaintEndsTooEarly);
    EXPECT_EQ(error("C"), begin + messages::kPaintEndsTooEarly);
    EXPECT_EQ(error("8xC"), begin + messages::kPaintNotHexadecimal);
    EXPECT_EQ(error("00D"), begin + messages::kPaintOfNoSide);
    EXPECT_EQ(error("0" + std::string(80, 'F') + "C"), begin + messages::kPaintOfNoFilament);
    EXPECT_EQ(error(std::string(200, '1')), begin + messages::kPaintTooFine);
}

TEST(ThreemfProject, LetsPropertiesOfTheFileWinOverPaint) {
    const std::string resources =
        R"(<basematerials id="1"><base name="red" displaycolor="#FF0000"/></basematerials>
<m:colorgroup id="2"><m:color color="#FF0000"/><m:color color="#00FF00"/></m:colorgroup>)";
    const MeshSource source = read_source(threemf_package(threemf_model(
        resources + R"(<object id="9" name="cube" pid="1" pindex="0">)" +
            threemf_cube(0, 10,
                         {R"(p1="0" paint_color="8")", R"(paint_color="8")",
                          R"(pid="2" p1="0" p2="1" p3="0")", R"(paint_color="481")", ""}) +
            "</object>",
        kBuildItem)));
    EXPECT_EQ(look_of(source, 0).name, "red");
    EXPECT_EQ(look_of(source, 1).name, "extruder 2");
    EXPECT_EQ(look_of(source, 4).name, "red");
    EXPECT_EQ(told(source), told_line(messages::kPaintAndColours, "1, a.3mf: object `cube`",
                                      messages::kPaintAndColoursHelp));
}

TEST(ThreemfProject, TellsOfPaintForTheSlicer) {
    const MeshSource source = read_source(threemf_package(threemf_model(
        R"(<object id="9" name="cube">)" +
            threemf_cube(
                0, 10,
                {R"(paint_supports="4")", R"(paint_seam="8")", R"(paint_fuzzy_skin="4")", ""}) +
            "</object>",
        kBuildItem)));
    const std::string why = told_line("", "1, object `cube`", messages::kPaintForFilaments);
    EXPECT_EQ(told(source), messages::kPaintedSupports + why + messages::kPaintedSeams + why +
                                messages::kPaintedFuzzySkin + why);
}

TEST(ThreemfProject, ReadsWhatObjectsAreForInCura) {
    const auto object = [](int id, const std::string& metadata) {
        return fmt::format(
            R"(<object id="{}" name="o{}" type="model"><metadatagroup>{}</metadatagroup>{}</object>)",
            id, id, metadata, threemf_cube(0, 10));
    };
    const auto flag = [](const char* name, const char* value) {
        return fmt::format(
            R"(<metadata name="cura:{}" preserve="true" type="xs:string">{}</metadata>)", name,
            value);
    };
    const MeshSource source = read_source(threemf_package(
        threemf_model(
            object(1, flag("extruder_nr", "1") + flag("cutting_mesh", "False")) +
                object(2, flag("cutting_mesh", "True")) + object(3, flag("infill_mesh", "True")) +
                object(4, flag("anti_overhang_mesh", "True")) +
                object(5, flag("support_mesh", "True")) +
                R"(<object id="6"><settings xmlns="cura"><setting key="support_mesh">True</setting></settings>)" +
                threemf_cube(0, 1) + "</object>",
            R"(<item objectid="1"/><item objectid="2"/><item objectid="3"/><item objectid="4"/><item objectid="5"/><item objectid="6"/>)"),
        {{"Cura/preferences.cfg", "[general]"}}));
    EXPECT_EQ(bodies(source), "o1: part of 1000 mm3, extruder 2, in 0\n");
    const std::string why = messages::kOnlyForTheSlicer;
    EXPECT_EQ(told(source), told_line(messages::kSlicerSettings, "1, Cura/preferences.cfg",
                                      messages::kFilamentColours) +
                                told_line(messages::kSettingsMeshesOfCura, "1, object `o2`", why) +
                                told_line(messages::kInfillMeshesOfCura, "1, object `o3`", why) +
                                told_line(messages::kSupportBlockersOfCura, "1, object `o4`", why) +
                                told_line(messages::kSupportMeshesOfCura, "2, object `o5`", why));
}

}  // namespace
}  // namespace openfab::mesh
