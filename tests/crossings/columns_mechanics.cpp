// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Columns of `openfab mechanics`.

#include <fmt/format.h>

#include <sstream>

#include "tests/crossings/columns.h"
#include "tests/crossings/numbers.h"

namespace openfab::testing {

namespace {

constexpr const char* kPull =
    R"(, "cases": {"one": {"held": [{"side": "-x"}], "loads": [{"side": "+x", "force_N": [1, 0.5, 0]}]}})";
constexpr const char* kWarm =
    R"(, "cases": {"one": {"held": [{"side": "-x", "celsius": 20}], "loads": [{"side": "+x", "watt": 0.1}]}})";
constexpr const char* kGrows =
    R"(, "textures": {"need": {"file": "nothing.nrrd"}}, "cases": {"one": {"held": [{"side": "-x"}], "loads": [{"side": "+x", "force_N": [0, 0, 12]}]}})";
// The faces of both bodies next to the solid are held.
constexpr const char* kMarked =
    R"(, "cases": {"one": {"held": [{"object": "solid"}], "loads": [{"side": "-y", "force_N": [0, 0, -1]}]}})";

Made mechanics(const Bench& bench, const char* command, std::vector<std::string> more,
               const std::vector<std::string>& wanted, const char* voxel = "0.25mm") {
    std::vector<std::string> words{"mechanics", command, bench.world(), "--voxel",
                                   voxel,       "-q",    "-o",          bench.path("r.json")};
    words.insert(words.end(), more.begin(), more.end());
    Made made;
    made.outcome = bench.openfab(words);
    for (const auto& [name, value] : numbers_of(bench.path("r.json"))) {
        for (const std::string& key : wanted) {
            if (name == key) made.numbers[name] = value;
        }
    }
    return made;
}

Made part(const Bench& bench) {
    // Pieces that are apart, and are held by nothing, are left out.
    return mechanics(bench, "part", {"--loose"}, {"moved_mm", "work_Nmm", "solid_elements"},
                     "0.2mm");
}

/// Elements are the printer's voxels, which are the same for all kinds: what is next to a marker is a matter of whole
/// elements.
Made marker(const Bench& bench) {
    return mechanics(bench, "part", {"--loose"}, {"moved_mm", "work_Nmm", "solid_elements"});
}

Made stand(const Bench& bench) {
    return mechanics(bench, "stand", {"--modes", "0", "--loose"}, {"mass_g", "volume_mm3"});
}

Made conduct(const Bench& bench) {
    return mechanics(bench, "conduct", {}, {"most", "least"});
}

Made cell(const Bench& bench) {
    return mechanics(bench, "cell", {"--cell", "2mm", "--object", "solid"},
                     {"young_MPa/0", "young_MPa/1", "young_MPa/2", "share/shell", "share/left"});
}

/// The text with `to` in all places of `from`.
std::string replaced(std::string text, std::string_view from, std::string_view to) {
    for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
        text.replace(at, from.size(), to);
    return text;
}

/// The solid is hollow, and its walls get thicker where the field grows.
Made strengthen(const Bench& bench) {
    const std::string with_field =
        replaced(read_file(bench.path("crossings.fl")), "Material shell, left, right; }",
                 "Material shell, left, right; ImageTexture3D need; }");
    bench.write("crossings.fl", replaced(with_field, "        return paint(",
                                         "        MaterialComposition hollow;\n"
                                         "        if (-distance(attr.voxelCenter) > 0.6 + 2 * "
                                         "need.Sample1(attr.voxelCenter, 0)) return hollow;\n"
                                         "        return paint("));
    bench.write("w.fab.json", replaced(read_file(bench.world()), R"("uniforms": {"shell")",
                                       R"("uniforms": {"need": "need", "shell")"));
    bench.write("nothing.nrrd",
                "NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 1\nspacings: 100 100 100\n"
                "encoding: text\n\n0\n");
    Made made;
    made.outcome = bench.openfab({"mechanics", "strengthen", bench.world(), "--voxel", "0.25mm",
                                  "--field", "need", "--safety", "2", "--rounds", "2", "--loose",
                                  "-q", "-o", bench.path("strong.fab.json")});
    // A line a round: its number, the least safety, weak elements, material. Where the surface lies in an element decides
    // over the weakest; what grows depends on all of them.
    std::istringstream lines(made.outcome.out);
    std::string line;
    for (int round = 0; std::getline(lines, line);) {
        std::istringstream words(line);
        double number = 0, safety = 0, weak = 0, material = 0;
        if (!(words >> number >> safety >> weak >> material)) continue;
        made.numbers[fmt::format("material of round {}", round)] = material;
        made.numbers["rounds"] = ++round;
    }
    return made;
}

Made inp(const Bench& bench) {
    Made made;
    made.outcome = bench.openfab({"mechanics", "export", bench.world(), "--voxel", "0.25mm", "-q",
                                  "-o", bench.path("r.inp")});
    std::istringstream text(read_file(bench.path("r.inp")));
    std::string section;
    for (std::string line; std::getline(text, line);) {
        if (line.starts_with("*")) {
            section = line.substr(0, line.find(','));
        } else if (section == "*NODE" || section == "*ELEMENT") {
            made.numbers[section] += 1;
        }
    }
    return made;
}

}  // namespace

std::vector<Column> mechanics_columns() {
    return {
        {"part",
         "`mechanics part`",
         {.world = kPull, .anchor = false},
         part,
         {"mechanics", "mechanics part"}},
        {"marker",
         "`mechanics part`, held where an object is",
         {.world = kMarked,
          .items = R"(, {"object": "low", "translate_mm": [-0.5, -2, 1.3]})",
          .anchor = false},
         marker},
        {"stand", "`mechanics stand`", {.anchor = false}, stand, {"mechanics stand"}},
        {"conduct",
         "`mechanics conduct`",
         {.world = kWarm, .anchor = false},
         conduct,
         {"mechanics conduct"}},
        {"strengthen",
         "`mechanics strengthen`",
         {.world = kGrows, .build = "{ONE}", .anchor = false},
         strengthen,
         {"mechanics strengthen"}},
        {"cell", "`mechanics cell`", {}, cell, {"mechanics cell"}},
        {"inp",
         "`mechanics export` to INP",
         {.world = kPull, .anchor = false},
         inp,
         {"mechanics export"}},
    };
}

}  // namespace openfab::testing
