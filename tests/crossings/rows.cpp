// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/crossings/rows.h"

#include <fmt/format.h>

#include "tests/crossings/solid.h"

namespace openfab::testing {

namespace {

// A box that is larger than the solid, by another length on each side; below by whole voxels, as grids begin there.
constexpr const char* kBox = R"("box_mm": [[-4.08, -2.95, -0.75], [3.6, 2.3, 4.9]])";
constexpr const char* kRadius = R"("radius": 1.15)";

/// A program that answers once.
std::string program_text(const std::string& answer) {
    return "import sys\nfor line in sys.stdin:\n    print('''" + answer +
           "''')\n    print('done', flush=True)\n";
}

std::string beam_line(const char* separator) {
    const Hull h;
    return fmt::format("{0}{7}{1}{7}{2}{7}{3}{7}{4}{7}{5}{7}{6}", h.from.x, h.from.y, h.from.z,
                       h.to.x, h.to.y, h.to.z, fmt::format("{}{}{}", h.radius, separator, h.other),
                       separator);
}

std::string truss_text() {
    const Hull h;
    return fmt::format("node {} {} {} {}\nnode {} {} {} {}\nstrut 0 1\n", h.from.x, h.from.y,
                       h.from.z, h.radius, h.to.x, h.to.y, h.to.z, h.other);
}

Kind shape(const char* id, const char* what) {
    Kind kind{id,
              what,
              SolidKind::kShape,
              "shape",
              fmt::format(R"({{"shape": "declared", {}}})", kBox),
              "declared"};
    return kind;
}

Kind program(const char* id, const char* what, const std::string& answer) {
    Kind kind{id, what, SolidKind::kGrow, "program",
              fmt::format(R"({{"program": ["python3", "answer.py"], {}}})", kBox)};
    kind.options = {"--allow-programs"};
    kind.files["answer.py"] = program_text(answer);
    return kind;
}

std::vector<Kind> make_kinds() {
    std::vector<Kind> all;
    const auto add = [&](Kind kind) -> Kind& { return all.emplace_back(std::move(kind)); };
    const std::string mesh = R"({"file": "hull.obj", "unit": "mm"})";
    add({"file", "mesh of a file", SolidKind::kMesh, "file", mesh}).files["hull.obj"] =
        hull_obj({});
    add({"body", "body of a file", SolidKind::kMesh, "body",
         R"({"file": "two.obj", "unit": "mm", "body": "hull"})"})
        .files["two.obj"] = hull_obj({}, 1, "hull");
    // A capsule: the hull of two balls of 2 mm, upright. It turns before the item does.
    add({"primitive", "primitive", SolidKind::kMesh, "capsule", R"({"capsule": [2.3, 5.1]})"})
        .item = R"(, "rotate_deg": [0, 90, 17])";
    Kind& moved = add({"displaced", "displaced mesh", SolidKind::kMesh, "file", mesh, "moved"});
    moved.files["hull.obj"] = hull_obj({}, 1.0625);
    moved.object_uniforms = R"(, "push": 0.0625)";
    add(shape("shape", "shape, a distance")).object_uniforms = fmt::format(", {}", kRadius);
    Kind& undeclared = add(shape("undeclared", "shape, not declared"));
    undeclared.mesh = fmt::format(R"({{"shape": "undeclared", {}}})", kBox);
    undeclared.fablet = "undeclared";
    undeclared.object_uniforms = fmt::format(", {}", kRadius);
    add(shape("of fablet", "shape, value of its fablet")).fablet_uniforms = kRadius;
    add(shape("of item", "shape, value of its placement")).item_uniforms = kRadius;
    add(shape("of group", "shape, value of its group")).group_uniforms = R"("solid.radius": 1.15)";
    add(shape("of --set", "shape, value of `--set`")).options = {"--set", "solid.radius=1.15"};
    add({"beams", "beams", SolidKind::kBeams, "beams", R"({"beams": "truss.txt"})"})
        .files["truss.txt"] = truss_text();
    Kind grown{"grown",
               "grown by a rule",
               SolidKind::kGrow,
               "grow",
               fmt::format(R"({{"grow": "grown", {}}})", kBox),
               "grown"};
    grown.object_uniforms = fmt::format(", {}", kRadius);
    add(grown);
    grown.id = "grown of group";
    grown.what = "grown, value of its group";
    grown.object_uniforms = "";
    grown.group_uniforms = R"("solid.radius": 1.15)";
    add(grown);
    add(program("program", "program, beams", "beam " + beam_line(" ")));
    add(program("program mesh", "program, a mesh", hull_answer({})));
    return all;
}

/// Three pieces.
std::string cuts(bool peg) {
    return fmt::format(
        R"({{"normal": [1, 0, 0], "at_mm": 0.13, "front": {{"normal": [0, 0.3, 1], "at_mm": 2.54}}{}}})",
        peg ? R"(, "connectors": [{"peg": [0.13, 0.05, 1.78], "diameter_mm": 0.8, "length_mm": 0.6, "material": "right", "skin_mm": 0.02}])"
            : "");
}

std::string braces(const std::string& members, const char* key) {
    return members.empty() ? "" : fmt::format(R"(, "{}": {{{}}})", key, members);
}

}  // namespace

std::string cuts_file() {
    return cuts(true);
}

const char* name_of(Form form) {
    switch (form) {
        case Form::kWhole:
            return "whole";
        case Form::kPieces:
            return "pieces";
        case Form::kPiecesOfFile:
            return "pieces of a file";
        case Form::kTouching:
            return "several that touch";
    }
    return "";
}

std::span<const Kind> kinds() {
    static const std::vector<Kind> all = make_kinds();
    return all;
}

const Kind& twin_of(const Kind& kind) {
    static const Kind capsule = [] {
        Kind made = kinds()[0];
        // Of the primitive, which stands on z = 0.
        made.files["hull.obj"] = hull_obj({{0, 0, 1.15}, {0, 0, 3.95}, 1.15, 1.15});
        made.item = R"(, "rotate_deg": [0, 90, 17])";
        return made;
    }();
    // The first is compared with the second: one mesh in two files.
    if (kind.id == "file") return kinds()[1];
    return kind.id == "primitive" ? capsule : kinds()[0];
}

std::string world_text(const Kind& kind, Form form, const Change& change) {
    const std::string item = fmt::format(
        R"({{"object": "solid"{}{}{})", kind.item, braces(kind.item_uniforms, "uniforms"),
        form == Form::kPieces         ? R"(, "piece": "all", "explode_mm": 0.6)"
        : form == Form::kPiecesOfFile ? R"(, "piece": "all")"
                                      : "");
    std::string items = item + "}";
    if (form == Form::kTouching) {
        items += ", " + item + R"(, "translate_mm": [2.2, 1.3, 0.4]})";
        items += R"(, {"object": "block", "translate_mm": [-2, 1.5, 0.5]})";
    }
    const std::string placement =
        fmt::format(R"({{"group": "all"{}{}}})", braces(kind.group_uniforms, "uniforms"),
                    change.placement.empty() ? "" : ", " + change.placement);
    std::string build = change.build.empty() ? placement : change.build;
    // `ALL` in what a column builds is the placement with what it needs, `ONE` the solid itself unless its group has values.
    const std::string all = placement.substr(1, placement.size() - 2);
    const std::string one = kind.group_uniforms.empty() ? item.substr(1) : all;
    for (const auto& [word, members] : {std::pair("ALL", &all), std::pair("ONE", &one)}) {
        for (size_t at = 0; (at = build.find(word, at)) != std::string::npos;)
            build.replace(at, 3, *members);
    }
    if (change.anchor) build += R"(, {"object": "anchor", "translate_mm": [-9, -8, -5]})";
    const std::string pieces = form == Form::kPieces         ? ", \"pieces\": " + cuts(false)
                               : form == Form::kPiecesOfFile ? R"(, "pieces": "cuts.json")"
                                                             : "";
    std::string fablets;
    for (const char* name : {"Skin", "Moved", "Declared", "Undeclared", "Grown"}) {
        std::string id = name;
        id[0] = static_cast<char>(std::tolower(id[0]));
        fablets += fmt::format(R"({}"{}": {{"source": "crossings.fl", "fablet": "{}"{}}})",
                               fablets.empty() ? "" : ", ", id, name,
                               id == kind.fablet ? braces(kind.fablet_uniforms, "uniforms") : "");
    }
    return fmt::format(
        R"({{"openfab": 1, "printer": "m.printer.json"{world},
"fablets": {{{fablets}}},
"materials": {{"shell": {{"key": "#101010", "density_g_cm3": 1.1}}, "left": {{"key": "#c02020", "density_g_cm3": 1.2}},
    "right": {{"key": "#2020c0", "density_g_cm3": 1.3}}}},
"meshes": {{"solid": {mesh}, "block": {{"box": [2.6, 1.7, 1.4]}}, "anchor": {{"box": [0.25, 0.25, 0.25]}}{more_meshes}}},
"objects": {{"solid": {{"mesh": "solid", "fablet": "{fablet}", "uniforms": {{"shell": "shell", "left": "left", "right": "right"{uniforms}}}{pieces}}},
    "block": {{"mesh": "block", "fablet": "skin", "uniforms": {{"shell": "left", "left": "left", "right": "shell"}}}},
    "low": {{"mesh": "block", "priority": -1, "fablet": "skin", "uniforms": {{"shell": "left", "left": "left", "right": "left"}}}},
    "high": {{"mesh": "block", "priority": 1, "fablet": "skin", "uniforms": {{"shell": "right", "left": "right", "right": "right"}}}},
    "anchor": {{"mesh": "anchor", "fablet": "skin", "uniforms": {{"shell": "left", "left": "left", "right": "left"}}}}{more_objects}}},
"groups": {{"all": [{items}{more_items}]}},
"build": [{build}]}}
)",
        fmt::arg("world", change.world), fmt::arg("fablets", fablets), fmt::arg("mesh", kind.mesh),
        fmt::arg("more_meshes", kind.more_meshes), fmt::arg("fablet", kind.fablet),
        fmt::arg("uniforms", kind.object_uniforms), fmt::arg("pieces", pieces),
        fmt::arg("more_objects", kind.more_objects), fmt::arg("items", items),
        fmt::arg("more_items", change.items), fmt::arg("build", build));
}

}  // namespace openfab::testing
