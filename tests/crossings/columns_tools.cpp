// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Columns of the tools beside the print.

#include <fmt/format.h>

#include <cstring>
#include <filesystem>

#include "tests/crossings/columns.h"
#include "tests/crossings/numbers.h"

namespace openfab::testing {

namespace {

/// Prints a world that a tool wrote; codes as they are.
Made printed(const Bench& bench, const std::string& world, const std::string& voxel = "0.25mm",
             bool options_of_row = true) {
    Made made;
    made.outcome = bench.openfab({"print", world, "-o", "made.npy", "--voxel", voxel, "--printer",
                                  "m.printer.json", "--dither", "majority"},
                                 options_of_row);
    if (made.outcome.exit_code == 0) made.voxels = read_voxels(bench.path("made.npy"));
    return made;
}

Made arrange(const Bench& bench) {
    Made made;
    made.outcome = bench.openfab(
        {"arrange", bench.world(), "-o", bench.path("trays.fab.json"), "--gap", "1mm"});
    return made.outcome.exit_code == 0 ? printed(bench, "trays.fab.json") : made;
}

/// Where cuts are is searched; what is on all trays is the whole solid.
Made split(const Bench& bench) {
    Made made;
    made.outcome = bench.openfab({"split", bench.world(), "--fit", "5.6x5.6x5.6mm", "--peg", "0mm",
                                  "--number", "0mm", "-o", bench.path("pieces.fab.json")});
    if (made.outcome.exit_code != 0) return made;
    double solid = 0;
    std::string tray = "pieces.fab.json";
    for (int n = 2; std::filesystem::exists(bench.path(tray)); ++n) {
        // Fine, as a cut beside centres of voxels has a layer of them more.
        const Made print = printed(bench, tray, "0.0625mm");
        made.outcome = print.outcome;
        if (print.outcome.exit_code != 0) return made;
        solid += static_cast<double>(print.voxels.solid());
        tray = fmt::format("pieces-{}.fab.json", n);
    }
    made.numbers["solid"] = solid;
    return made;
}

/// What is found: the measure of each place, and how many voxels it has. Materials that are mixed touch in a place more
/// or less, so of `--apart` the sums count.
Made check(const Bench& bench) {
    std::vector<std::string> words{"check", bench.world(), "--report", "report.json"};
    words.insert(words.begin() + 2, bench.change().options.begin(), bench.change().options.end());
    Made made;
    made.outcome = bench.openfab(words);
    for (const auto& [name, value] : numbers_of(bench.path("report.json"))) {
        if (!name.ends_with("/measure") && !name.ends_with("/voxels")) continue;
        const bool sums = words[2] == "--apart";
        made.numbers[sums ? name.substr(name.rfind('/')) : name] += value;
    }
    return made;
}

Made estimate(const Bench& bench) {
    Made made;
    std::vector<std::string> words{"print", bench.world(), "--estimate", "--stats", "stats.json"};
    words.insert(words.end(), bench.change().options.begin(), bench.change().options.end());
    made.outcome = bench.openfab(words);
    for (const auto& [name, value] : numbers_of(bench.path("stats.json"))) {
        if (name.find("cost") != std::string::npos || name.find("voxels_by") != std::string::npos)
            made.numbers[name] = value;
    }
    return made;
}

Made statistics(const Bench& bench) {
    Made made;
    made.outcome = bench.print("a.ofr", {"--stats", "stats.json"});
    for (const auto& [name, value] : numbers_of(bench.path("stats.json"))) {
        if (name.find("cost") != std::string::npos || name.find("voxels_by") != std::string::npos ||
            name.find("voxels_solid") != std::string::npos)
            made.numbers[name] = value;
    }
    return made;
}

Made functions(const Bench& bench) {
    Made made;
    made.outcome =
        bench.openfab({"export", bench.world(), "-o", bench.path("f.3mf"), "--voxel", "0.05mm"});
    if (made.outcome.exit_code != 0) return made;
    made.outcome = bench.openfab({"import", "f.3mf", "-o", bench.path("again")}, false);
    if (made.outcome.exit_code != 0) return made;
    return printed(bench, "again/f.fab.json", "0.25mm", false);
}

/// The mean brightness of a small picture.
Made render(const Bench& bench) {
    Made made;
    made.outcome = bench.openfab({"render", bench.world(), "-o", bench.path("r.pfm"), "--size",
                                  "24x18", "--samples", "16", "--threads", "2", "-q"});
    const std::string bytes = read_file(bench.path("r.pfm"));
    constexpr size_t kFloats = size_t{24} * 18 * 3;
    if (bytes.size() < kFloats * 4) return made;
    double sum = 0;
    for (size_t i = 0; i < kFloats; ++i) {
        float value = 0;
        std::memcpy(&value, bytes.data() + bytes.size() - 4 * (kFloats - i), 4);
        sum += static_cast<double>(value);
    }
    made.numbers["mean"] = sum / static_cast<double>(kFloats);
    return made;
}

Made probe(const Bench& bench) {
    Made made;
    made.outcome = bench.openfab({"print", bench.world(), "--probe", "0.4,0.3,1.9"});
    bench.write("probe.json", made.outcome.out);
    made.numbers = numbers_of(bench.path("probe.json"));
    return made;
}

Made info(const Bench& bench) {
    return {.outcome = bench.openfab({"info", bench.world()}, false)};
}

}  // namespace

std::vector<Column> tool_columns() {
    const std::string cost =
        R"({"cost": {"price_ml": {"shell": 0.2, "*": 0.3}, "seconds_pass": 3, "swath_mm": 2, "waste_ml_swath": 0.01}})";
    // Fine enough that few dithered voxels more or less are not a share that counts.
    const std::vector<std::string> cost_options{"--process", "cost.json", "--voxel", "0.125mm"};
    const auto checked = [](const char* id, const char* what, std::vector<std::string> options,
                            const char* items = "") {
        const std::string shown = options[0];
        return Column{id,
                      what,
                      {.items = items, .options = std::move(options), .anchor = false},
                      check,
                      {"check", shown}};
    };
    const char* const beside = R"(, {"object": "block", "translate_mm": [0.2, 2.05, 1.2]})";
    return {
        {"arrange", "`openfab arrange`", {.anchor = false}, arrange, {"arrange"}},
        {"split", "`openfab split`", {.anchor = false}, split, {"split"}},
        checked("check wall", "`check --wall`", {"--wall", "2mm"}),
        checked("check gap", "`check --gap`", {"--gap", "0.8mm"}, beside),
        checked("check hole", "`check --hole`", {"--hole", "1.5mm"}, beside),
        checked("check island", "`check --island`", {"--island", "90mm3"}),
        checked("check trapped", "`check --trapped`", {"--trapped", "0.1mm3"}),
        checked("check apart", "`check --apart`", {"--apart", "left,right"}),
        {"estimate",
         "estimate and cost",
         {.options = cost_options, .files = {{"cost.json", cost}}, .anchor = false},
         estimate,
         {"--estimate"}},
        {"statistics",
         "statistics and cost",
         {.options = cost_options, .files = {{"cost.json", cost}}, .anchor = false},
         statistics,
         {"--stats"}},
        {"probe", "`--probe`", {}, probe, {"--probe"}},
        {"functions",
         "export as functions of 3MF, imported again",
         {.anchor = false},
         functions,
         {"export", "import"}},
        {"render", "`openfab render`", {.anchor = false}, render, {"render"}},
        {"info", "`openfab info`", {}, info, {"info"}},
    };
}

}  // namespace openfab::testing
