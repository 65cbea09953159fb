// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What 3MF files hold, by the specifications of its core and extensions: each is carried over, or told.
// How it is carried over is in the tests of looks, extensions and projects.

#include <fmt/format.h>

#include "mesh/read/messages.h"
#include "tests/unit/mesh/features.h"
#include "tests/unit/mesh/threemf_package.h"

namespace openfab::mesh {
namespace {

using Carried = std::function<bool(const MeshSource&)>;

const std::string kPlacedCube = R"(<item objectid="9"/>)";
const std::string kMaterials =
    R"(<basematerials id="1"><base name="red" displaycolor="#FF0000"/><base name="blue" displaycolor="#0000FF80"/><base name="bare"/></basematerials>)";
const std::string kColors =
    R"(<m:colorgroup id="2"><m:color color="#00FF00"/><m:color color="#0000FF"/></m:colorgroup>)";

std::string picture(const std::string& attributes = "") {
    return R"(<m:texture2d id="3" path="/3D/a.png" contenttype="image/png" )" + attributes +
           R"(/><m:texture2dgroup id="4" texid="3"><m:tex2coord u="0.25" v="0.75"/><m:tex2coord u="1" v="0"/><m:tex2coord u="0" v="1"/></m:texture2dgroup>)";
}

std::string cube(const std::string& resources, const std::string& faces = "",
                 const std::string& object = "", const std::string& build = kPlacedCube,
                 const std::string& model = "", const PackageFiles& more = {}) {
    return threemf_package(threemf_model(resources + R"(<object id="9" name="cube" )" + object +
                                             ">" + threemf_cube(0, 10, {faces}) + "</object>",
                                         build, model),
                           more);
}
/// With more in the element of the mesh.
std::string with_mesh(const std::string& more) {
    std::string mesh = threemf_cube(0, 10);
    mesh.insert(mesh.find("</mesh>"), more);
    return threemf_package(threemf_model("<object id=\"9\">" + mesh + "</object>", kPlacedCube));
}

double largest_x(const MeshSource& m) {
    double most = -1e9;
    for (const Vec3d& p : m.mesh.positions)
        most = std::max(most, p.x);
    return most;
}

Carried named(const std::string& look, bool is_material = true) {
    return [=](const MeshSource& m) {
        return look_of(m, 0).name == look && look_of(m, 0).is_material == is_material;
    };
}
Carried shows(const std::function<bool(const PictureUse&)>& as) {
    return [=](const MeshSource& m) {
        const Look look = look_of(m, 0);
        return look.picture && look.picture->name == "a.png" && as(*look.picture) &&
               near(value_at(m, "uv", 0, 0, 0), 0.25) && near(value_at(m, "uv", 0, 0, 1), 0.75);
    };
}
Carried colored(double r, double g, double b) {
    return [=](const MeshSource& m) {
        return look_of(m, 0).vertex_colors && near(value_at(m, "color", 0, 0, 0), r) &&
               near(value_at(m, "color", 0, 0, 1), g) && near(value_at(m, "color", 0, 0, 2), b);
    };
}
Carried has(const char* bodies, double x) {
    return [=](const MeshSource& m) { return bodies_of(m) == bodies && near(largest_x(m), x); };
}

std::vector<Feature> of_the_core() {
    std::string inches = cube("");
    const std::string in = R"(unit="inch")", mm = R"(unit="millimeter")";
    std::string model = threemf_model(
        R"(<object id="9" name="cube">)" + threemf_cube(0, 10) + "</object>", kPlacedCube);
    model.replace(model.find(mm), mm.size(), in);
    return {
        {"nothing", cube(""), {}, "", 0, has("cube", 10)},
        {"a unit",
         threemf_package(model),
         {},
         "",
         0,
         [](const MeshSource& m) { return m.unit_mm == 25.4 && near(largest_x(m), 10); }},
        {"metadata and part numbers",
         cube("", "", R"(partnumber="7" p:UUID="x" thumbnail="/Metadata/a.png")",
              R"(<item objectid="9" partnumber="8" p:UUID="y"/>)"),
         {},
         "",
         0,
         has("cube", 10)},
        {"a transform",
         cube("", "", "", R"(<item objectid="9" transform="1 0 0 0 1 0 0 0 1 5 0 0"/>)"),
         {},
         "",
         0,
         has("cube", 15)},
        {"two items",
         cube("", "", "",
              kPlacedCube + R"(<item objectid="9" transform="1 0 0 0 1 0 0 0 1 20 0 0"/>)"),
         {},
         "",
         0,
         has("cube, cube", 30)},
        {"components",
         cube(
             R"(<object id="8" name="pair"><components><component objectid="9"/><component objectid="9" transform="2 0 0 0 2 0 0 0 2 10 0 0"/></components></object>)",
             "", "", R"(<item objectid="8"/>)"),
         {},
         "",
         0,
         has("cube, cube", 30)},
        {"an item that is switched off",
         cube("", "", "", kPlacedCube + R"(<item objectid="9" printable="0"/>)"),
         {},
         messages::kItemsSwitchedOff,
         1,
         has("cube", 10)},
        {"an object that is no model",
         cube(R"(<object id="8" type="support">)" + threemf_cube(0, 20) + "</object>", "", "",
              kPlacedCube + R"(<item objectid="8"/>)"),
         {},
         fmt::format(messages::kObjectsOfType, "support"),
         1,
         has("cube", 10)},
        {"an object that no item places",
         cube(R"(<object id="8" name="spare">)" + threemf_cube(0, 20) + "</object>"),
         {},
         messages::kObjectsNotPlaced,
         1,
         has("cube", 10)},
        {"a material", cube(kMaterials, R"(pid="1" p1="0")"), {}, "", 0, named("red")},
        {"a material of the object",
         cube(kMaterials, "", R"(pid="1" pindex="1")"),
         {},
         "",
         0,
         [](const MeshSource& m) {
             return named("blue")(m) && near(look_of(m, 0).alpha, 128 / 255.0);
         }},
        {"a material without a colour",
         cube(kMaterials, R"(pid="1" p1="2")"),
         {},
         "",
         0,
         [](const MeshSource& m) { return named("bare")(m) && !look_of(m, 0).color; }},
        // Of which the specification takes the first.
        {"several materials of a triangle",
         cube(kMaterials, R"(pid="1" p1="0" p2="1" p3="1")"),
         {},
         "",
         0,
         named("red")},
        {"a property that is not there",
         cube(kMaterials, R"(pid="1" p1="7")"),
         {},
         messages::kPropertiesNotDefined,
         1,
         has("cube", 10)},
    };
}

std::vector<Feature> of_materials() {
    const auto gloss = [](const char* kind) {
        return cube(std::string("<m:") + kind + "displayproperties id=\"7\"/>" + kMaterials,
                    R"(pid="1" p1="0")");
    };
    const std::string composite =
        kMaterials +
        R"(<m:compositematerials id="5" matid="1" matindices="0 1"><m:composite values="1 3"/></m:compositematerials>)";
    const auto multi = [](const std::string& pids, const std::string& more = "") {
        return cube(kMaterials + kColors + picture() + R"(<m:multiproperties id="8" pids=")" +
                        pids + "\" " + more + R"(><m:multi pindices="0 0"/></m:multiproperties>)",
                    R"(pid="8" p1="0")");
    };
    using Alpha = PictureUse::Alpha;
    return {
        {"a colour", cube(kColors, R"(pid="2" p1="0")"), {}, "", 0, colored(0, 1, 0)},
        {"colours by corner",
         cube(kColors, R"(pid="2" p1="0" p2="1" p3="1")"),
         {},
         "",
         0,
         [](const MeshSource& m) {
             return colored(0, 1, 0)(m) && near(value_at(m, "color", 0, 1, 2), 1);
         }},
        {"a picture",
         cube(picture(), R"(pid="4" p1="0" p2="1" p3="2")"),
         {},
         "",
         0,
         shows([](const PictureUse& p) {
             return p.wrap == std::array{PictureWrap::kRepeat, PictureWrap::kRepeat} &&
                    p.alpha == Alpha::kOpaque && !p.nearest;
         })},
        {"tile styles",
         cube(picture(R"(tilestyleu="mirror" tilestylev="none")"),
              R"(pid="4" p1="0" p2="1" p3="2")"),
         {},
         "",
         0,
         shows([](const PictureUse& p) {
             return p.wrap == std::array{PictureWrap::kMirror, PictureWrap::kNone};
         })},
        {"a filter",
         cube(picture(R"(filter="nearest")"), R"(pid="4" p1="0" p2="1" p3="2")"),
         {},
         "",
         0,
         shows([](const PictureUse& p) { return p.nearest; })},
        {"a filter of one's choice",
         cube(picture(R"(filter="auto")"), R"(pid="4" p1="0")"),
         {},
         "",
         0,
         shows([](const PictureUse& p) { return !p.nearest; })},
        {"a picture that is not there",
         cube(R"(<m:texture2dgroup id="4" texid="3"><m:tex2coord u="0" v="0"/></m:texture2dgroup>)",
              R"(pid="4" p1="0")"),
         {},
         messages::kPicturesNotDefined,
         1,
         {}},
        {"a composite",
         cube(composite, R"(pid="5" p1="0")"),
         {},
         "",
         0,
         [](const MeshSource& m) {
             const auto& mixture = look_of(m, 0).mixture;
             return mixture.size() == 2 && near(mixture[0].second, 0.25) &&
                    near(mixture[1].second, 0.75);
         }},
        {"a colour on a material",
         multi("1 2"),
         {},
         "",
         0,
         [](const MeshSource& m) { return named("red")(m) && colored(0, 1, 0)(m); }},
        {"a picture on a material",
         multi("1 4"),
         {},
         "",
         0,
         [](const MeshSource& m) {
             return named("red")(m) && look_of(m, 0).picture->alpha == Alpha::kBlend;
         }},
        {"a picture times a colour",
         multi("2 4", R"(blendmethods="multiply")"),
         {},
         "",
         0,
         [](const MeshSource& m) { return look_of(m, 0).picture && look_of(m, 0).tinted; }},
        {"a picture on a picture", multi("4 4"), {}, messages::kTooManyLayers, 0, {}},
        {"gloss", gloss("pbspecular"), {}, messages::kGlossOfMaterials, 1, named("red")},
        {"metal", gloss("pbmetallic"), {}, messages::kGlossOfMaterials, 1, named("red")},
        {"translucency", gloss("translucent"), {}, messages::kGlossOfMaterials, 1, named("red")},
    };
}

std::vector<Feature> of_other_extensions() {
    const std::string part =
        threemf_model(kMaterials + R"(<object id="2" name="far">)" +
                          threemf_cube(0, 10, {R"(pid="1" p1="0")"}) + "</object>",
                      "");
    const auto booleans = [](const char* operation) {
        return cube(R"(<object id="8" name="shape"><bo:booleanshape objectid="9" operation=")" +
                        std::string(operation) +
                        R"("><bo:boolean objectid="9"/></bo:booleanshape></object>)",
                    "", "", R"(<item objectid="8"/>)");
    };
    return {
        {"objects of other parts",
         threemf_package(
             threemf_model(
                 R"(<object id="9"><components><component objectid="2" p:path="/3D/b.model"/></components></object>)",
                 kPlacedCube),
             {{"3D/b.model", part}}),
         {},
         "",
         0,
         [](const MeshSource& m) { return named("red")(m) && has("far", 10)(m); }},
        {"slices beside a mesh",
         cube(R"(<s:slicestack id="2"/>)", "", R"(s:slicestackid="2" s:meshresolution="fullres")"),
         {},
         messages::kSlicesOfObjects,
         1,
         has("cube", 10)},
        {"beams",
         with_mesh(R"(<x:beamlattice minlength="1"/>)"),
         {},
         messages::kLatticesOfBeams,
         1,
         {}},
        {"volumetric data",
         with_mesh("<x:volumedata/>"),
         {},
         messages::kVolumetricDataInsideMeshes,
         1,
         {}},
        {"functions", cube(R"(<x:implicitfunction id="2"/>)"), {}, "", 0, {}},
        // Names of some triangles, for programs that edit them.
        {"sets of triangles", with_mesh("<x:trianglesets/>"), {}, "", 0, {}},
        {"cuts",
         booleans("difference"),
         {},
         "",
         0,
         [](const MeshSource& m) {
             return m.bodies.size() == 2 && m.bodies[1].role == BodyRole::kNegative;
         }},
        {"unions",
         booleans("union"),
         {},
         "",
         0,
         [](const MeshSource& m) {
             return m.bodies.size() == 2 && m.bodies[1].role == BodyRole::kPart;
         }},
        {"settings",
         cube("", "", "", kPlacedCube, "", {{"Metadata/Slic3r_PE.config", "; layer_height = 0.2"}}),
         {},
         messages::kSlicerSettings,
         1,
         has("cube", 10)},
        {"painted supports",
         cube("", R"(slic3rpe:custom_supports="4")", "", kPlacedCube,
              R"(xmlns:slic3rpe="http://schemas.slic3r.org/3mf/2017/06")"),
         {},
         messages::kPaintedSupports,
         1,
         has("cube", 10)},
    };
}

TEST(ThreemfFeatures, AreCarriedOverOrTold) {
    const Read read = [](std::string_view bytes, const std::string& file, int64_t memory_bytes) {
        return parse_threemf(bytes, file, memory_bytes);
    };
    for (const auto& features : {of_the_core(), of_materials(), of_other_extensions()})
        check_features(read, "m.3mf", features);
}

}  // namespace
}  // namespace openfab::mesh
