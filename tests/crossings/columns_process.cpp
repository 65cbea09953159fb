// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Columns of machines: what a printer's profile and its process do to a print.

#include <fmt/format.h>

#include <cmath>

#include "tests/crossings/columns.h"

namespace openfab::testing {

namespace {

/// A field over the print that moves nowhere as elsewhere, by at most 0.3 mm.
std::string field_nrrd() {
    std::string text =
        "NRRD0004\ntype: float\ndimension: 4\nspace dimension: 3\nsizes: 3 9 9 9\nkinds: vector "
        "domain domain domain\nspace directions: none (1.5,0,0) (0,1.5,0) (0,0,1.5)\nspace "
        "origin: (-6,-6,-2)\nencoding: ascii\n\n";
    for (int z = 0; z < 9; ++z) {
        for (int y = 0; y < 9; ++y) {
            for (int x = 0; x < 9; ++x) {
                text += fmt::format("{:.4f} {:.4f} {:.4f}\n", 0.3 * std::sin(0.5 * x + 0.3 * z),
                                    0.2 * std::cos(0.4 * y - 0.2 * x), 0.25 * std::sin(0.35 * z));
            }
        }
    }
    return text;
}

}  // namespace

std::vector<Column> process_columns() {
    std::vector<Column> all;
    const auto add = [&](const char* id, const char* what, const std::string& process,
                         std::vector<std::string> shows = {"--process"}) -> Change& {
        all.push_back({id, what, {}, nullptr, std::move(shows)});
        Change& change = all.back().change;
        if (!process.empty()) {
            change.options = {"--process", "machine.json"};
            change.files["machine.json"] = process;
        }
        return change;
    };
    add("machine scale", "the machine's scale", R"({"scale": 1.12})");
    add("machine stretch", "the machine's scale, of each axis", R"({"scale": [1.2, 1.0, 0.9]})");
    add("field", "the machine's displacement field", R"({"field": "field.nrrd"})")
        .files["field.nrrd"] = field_nrrd();
    add("bleed", "bleed, undone", R"({"bleed": {"sigma_um": [150, 150, 80], "steps": 1}})");
    add("bleed shown", "bleed, shown", R"({"bleed": {"sigma_um": [150, 150, 80], "steps": 1}})",
        {"--bleed"})
        .options = {"--process", "machine.json", "--bleed", "both"};
    add("dead", "dead nozzles",
        R"({"dead": [{"material": "left", "nozzles": [1, [4, 5]], "head": 8, "substitute": "right"}]})");
    Change& nozzles = add("nozzles", "dead nozzles of a file", "", {"--nozzles"});
    nozzles.options = {"--nozzles", "nozzles.json"};
    nozzles.files["nozzles.json"] =
        R"([{"material": "shell", "nozzles": [2, 3], "head": 8, "substitute": "left"}])";
    Change& printer = add("printer", "another printer, with oblong voxels", "", {"--printer"});
    printer.options = {"--printer", "oblong.printer.json"};
    printer.files["oblong.printer.json"] =
        R"({"name": "oblong", "pitch_mm": [0.3, 0.2, 0.15], "build_volume_mm": [40, 40, 40], "native_format": "ofr"})";
    add("voxel", "other voxels", "", {"--voxel"}).options = {"--voxel", "0.31mm"};
    add("dpi", "voxels by dots per inch", "", {"--dpi", "--layer"}).options = {"--dpi", "100x120",
                                                                               "--layer", "0.2mm"};
    add("dither", "another dither", "", {"--dither", "--seed"}).options = {
        "--dither", "floyd_steinberg", "--seed", "7"};
    // Of a printer so fine that all drafts of it have the voxels of other columns.
    for (const int draft : {2, 3, 4, 5, 6, 8, 12, 16}) {
        const std::string n = std::to_string(draft);
        add(("draft " + n).c_str(), ("`--draft " + n + "`").c_str(), "", {"--draft"});
        all.back().change.options = {"--printer", "fine.printer.json", "--draft", n};
        all.back().change.files["fine.printer.json"] = fmt::format(
            R"({{"name": "fine", "pitch_mm": [{0}, {0}, {0}], "build_volume_mm": [40, 40, 40], "native_format": "ofr"}})",
            0.25 / draft);
    }
    return all;
}

}  // namespace openfab::testing
