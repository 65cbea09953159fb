// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Extensions of 3MF, types of objects, and packages: what is read, what is told, what is refused.

#include <fmt/format.h>

#include "mesh/read/messages.h"
#include "tests/unit/mesh/threemf_package.h"

namespace openfab::mesh {
namespace {

constexpr const char* kPlaced = R"(<item objectid="9"/>)";

std::string object(int id, const std::string& attributes = "", double low = 0, double high = 10) {
    return fmt::format(R"(<object id="{}" {}>{}</object>)", id, attributes,
                       threemf_cube(low, high));
}

/// What is told of a model with a cube beside `resources`.
std::string told_of(const std::string& resources, const std::string& build = kPlaced) {
    const MeshSource source =
        read_source(threemf_package(threemf_model(resources + object(9, R"(name="cube")"), build)));
    EXPECT_EQ(source.mesh.triangles.size(), 12u);
    return told(source);
}

TEST(ThreemfExtensions, LeavesOutObjectsThatAreNoModels) {
    std::string resources, build = kPlaced, expected;
    int id = 20;
    for (const char* type : {"solidsupport", "support", "surface", "other"}) {
        for (int i = 0; i < 2; ++i) {
            resources += object(id, fmt::format(R"(name="{}{}" type="{}")", type, i, type));
            build += fmt::format(R"(<item objectid="{}"/>)", id++);
        }
        expected += told_line(fmt::format(messages::kObjectsOfType, type),
                              fmt::format("2, object `{}0`", type), messages::kObjectTypeHelp);
    }
    EXPECT_EQ(told_of(resources, build), expected);
}

TEST(ThreemfExtensions, RefusesMeshesThatStandInForSlices) {
    const std::string stack =
        R"(<s:slicestack id="2" zbottom="0"><s:slice ztop="10"><s:vertices><s:vertex x="4" y="4"/></s:vertices><s:polygon startv="0"><s:segment v2="0"/></s:polygon></s:slice></s:slicestack>)";
    const auto package = [&](const char* resolution) {
        return threemf_package(threemf_model(
            stack + object(9, fmt::format(R"(name="part" s:slicestackid="2" {})", resolution)),
            kPlaced, R"(requiredextensions="s")"));
    };
    EXPECT_EQ(parse_error(package(R"(s:meshresolution="lowres")"), "a.3mf"),
              "a.3mf: " + fmt::format(messages::kMeshIsAStandIn, "object `part`") + "; " +
                  messages::kMeshIsAStandInHelp);
    EXPECT_EQ(
        told(read_source(package(R"(s:meshresolution="fullres")"))),
        told_line(messages::kSlicesOfObjects, "1, object `part`", messages::kSlicesOfObjectsHelp));
}

TEST(ThreemfExtensions, TellsOfElementsThatItDoesNotRead) {
    const std::string mesh = threemf_cube(0, 10);
    const auto told_in_mesh = [&](const std::string& more) {
        std::string inside = mesh;
        inside.insert(inside.find("</mesh>"), more);
        return told(read_source(
            threemf_package(threemf_model("<object id=\"9\">" + inside + "</object>", kPlaced))));
    };
    EXPECT_EQ(
        told_in_mesh(
            R"(<x:beamlattice minlength="1" radius="1"><x:beams><x:beam v1="0" v2="1"/></x:beams></x:beamlattice>)"),
        told_line(messages::kLatticesOfBeams, "1, object 9", messages::kLatticesOfBeamsHelp));
    EXPECT_EQ(told_in_mesh(R"(<x:volumedata><x:color transform="1"/></x:volumedata>)"),
              told_line(messages::kVolumetricDataInsideMeshes, "1, object 9",
                        messages::kVolumetricDataInsideMeshesHelp));
    EXPECT_EQ(
        told_in_mesh(
            R"(<x:trianglesets><x:triangleset name="a"><x:ref index="1"/></x:triangleset></x:trianglesets>)"),
        "");
    EXPECT_EQ(
        told_of(
            R"(<x:implicitfunction id="2"><x:constant value="7"/><x:color/></x:implicitfunction>)"),
        "");
    std::string displaced = mesh;
    displaced.replace(0, 6, "<x:displacementmesh>");
    displaced.replace(displaced.size() - 7, 7, "</x:displacementmesh>");
    const MeshSource source = read_source(
        threemf_package(threemf_model("<object id=\"9\">" + displaced + "</object>", kPlaced)));
    EXPECT_EQ(source.mesh.triangles.size(), 12u);
    EXPECT_EQ(told(source),
              told_line(messages::kDisplacements, "1, object 9", messages::kImportRemedy));
}

TEST(ThreemfExtensions, SaysWhatIsMissingWhereNothingIsLeft) {
    EXPECT_EQ(
        parse_error(
            threemf_package(threemf_model(
                R"(<object id="9" name="ball"><x:levelset functionid="2" meshid="1"/></object>)",
                kPlaced)),
            "a.3mf"),
        fmt::format(messages::kNothingLeftToPrint, "a.3mf", messages::kLevelSets, "object `ball`") +
            "; " + messages::kImportRemedy);
    // Settings beside the model are no reason.
    const PackageFiles settings = {{"Metadata/Slic3r_PE.config", "; layer_height = 0.2"}};
    EXPECT_EQ(parse_error(
                  threemf_package(threemf_model(object(9, R"(type="support")"), kPlaced), settings),
                  "a.3mf"),
              fmt::format(messages::kNothingLeftToPrint, "a.3mf",
                          fmt::format(messages::kObjectsOfType, "support"), "object 9") +
                  "; " + messages::kObjectTypeHelp);
}

TEST(ThreemfExtensions, RefusesExtensionsThatMustBeKnown) {
    EXPECT_EQ(
        parse_error(
            threemf_package(threemf_model(object(9), kPlaced, R"(requiredextensions="m x")")),
            "a.3mf"),
        "a.3mf: /3D/3dmodel.model:2:1: " +
            fmt::format(messages::kRequiresThreemfExtension, "http://example.org/extension/2026") +
            "; " + messages::kRequiresThreemfExtensionHelp);
    EXPECT_EQ(parse_error(threemf_package(threemf_model(object(9), kPlaced,
                                                        R"(requiredextensions="m p s bo")")),
                          "a.3mf"),
              "no error");
}

TEST(ThreemfExtensions, CutsAndUnitesBooleanShapes) {
    const std::string meshes = object(1) + object(2, R"(name="hole")", 4, 6) + object(3, "", 8, 12);
    const auto shape = [&](const char* operation) {
        return threemf_package(threemf_model(
            meshes +
                fmt::format(
                    R"(<object id="9" name="shape"><bo:booleanshape objectid="1" {}><bo:boolean objectid="2"/><bo:boolean objectid="3" transform="1 0 0 0 1 0 0 0 1 1 0 0"/></bo:booleanshape></object>)",
                    operation),
            std::string(kPlaced) + R"(<item objectid="1" transform="1 0 0 0 1 0 0 0 1 20 0 0"/>)"));
    };
    MeshSource source = read_source(shape(R"(operation="difference")"));
    ASSERT_EQ(source.bodies.size(), 4u);
    EXPECT_EQ(source.bodies[0].role, BodyRole::kPart);
    EXPECT_EQ(source.bodies[0].name, "shape");
    EXPECT_EQ(source.bodies[1].role, BodyRole::kNegative);
    EXPECT_EQ(source.bodies[1].name, "hole");
    EXPECT_EQ(source.bodies[2].role, BodyRole::kNegative);
    EXPECT_EQ(source.bodies[1].assembly, source.bodies[0].assembly);
    EXPECT_EQ(source.bodies[3].role, BodyRole::kPart);
    EXPECT_NE(source.bodies[3].assembly, source.bodies[0].assembly);
    source = read_source(shape(""));
    ASSERT_EQ(source.bodies.size(), 4u);
    for (const Body& body : source.bodies)
        EXPECT_EQ(body.role, BodyRole::kPart);
    EXPECT_EQ(parse_error(shape(R"(operation="intersection")"), "a.3mf"),
              "a.3mf: " + fmt::format(messages::kIntersectionOfOthers, "object `shape`") + "; " +
                  messages::kIntersectionOfOthersHelp);
}

TEST(ThreemfExtensions, RefusesEncryptedParts) {
    const std::string relationships =
        R"(<Relationships><Relationship Target="/3D/3dmodel.model" Id="r0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
<Relationship Target="/Secure/keystore.xml" Id="r1" Type="http://schemas.microsoft.com/3dmanufacturing/2019/04/keystore"/></Relationships>)";
    const std::string store =
        R"(<keystore xmlns="http://schemas.microsoft.com/3dmanufacturing/securecontent/2019/04"><consumer consumerid="x"/><resourcedatagroup><resourcedata path="/3D/Secret.model"/></resourcedatagroup></keystore>)";
    const std::string root = threemf_model(
        R"(<object id="9"><components><component objectid="1" p:path="/3D/secret.model"/></components></object>)",
        kPlaced);
    EXPECT_EQ(parse_error(testing::zip_archive({{"_rels/.rels", relationships},
                                                {"3D/3dmodel.model", root},
                                                {"3D/secret.model", "\x01\x02\x03"},
                                                {"Secure/keystore.xml", store}}),
                          "a.3mf"),
              fmt::format(messages::kEncryptedArchive, "a.3mf", "3D/secret.model") + "; " +
                  messages::kEncryptedArchiveHelp);
}

/// The text in UTF-16, which starts with the mark of the order of its bytes.
std::string utf16(const std::string& text, bool big) {
    std::string out = big ? "\xfe\xff" : "\xff\xfe";
    for (const char c : text) {
        if (big) out += '\0';
        out += c;
        if (!big) out += '\0';
    }
    return out;
}

TEST(ThreemfExtensions, ReadsXmlInAnyEncoding) {
    const std::string model = threemf_model(object(9, R"(name="box")"), kPlaced);
    std::string plain = model;
    const size_t at = plain.find(R"( encoding="UTF-8")");
    plain.erase(at, 17);
    for (const std::string& text :
         {"\xef\xbb\xbf" + model, utf16(plain, false), utf16(plain, true)}) {
        const MeshSource source = read_source(threemf_package(text));
        ASSERT_EQ(source.bodies.size(), 1u);
        EXPECT_EQ(source.bodies[0].name, "box");
    }
}

TEST(ThreemfExtensions, FindsTheModelByAnyPath) {
    const std::string model = threemf_model(object(9), kPlaced);
    const auto relationships = [](const char* target) {
        return fmt::format(
            R"(<Relationships><Relationship Target="{}" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/><Relationship Target="/other.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)",
            target);
    };
    const std::pair<const char*, const char*> paths[] = {
        {"/3D/a.model", "3D/a.model"},      {"3D/a.model", "3D/a.model"},
        {"./3D/a.model", "3D/a.model"},     {"/3d/A.MODEL", "3D/a.model"},
        {"/x/../3D/a.model", "3D/a.model"}, {"/3D/a%20b.model", "3D/a b.model"},
        {"/3D/a b.model", "3D/a%20b.model"}};
    for (const auto& [target, entry] : paths) {
        const std::string package =
            testing::zip_archive({{"_rels/.rels", relationships(target)}, {entry, model}});
        EXPECT_EQ(parse_error(package, "a.3mf"), "no error") << target;
    }
}

}  // namespace
}  // namespace openfab::mesh
