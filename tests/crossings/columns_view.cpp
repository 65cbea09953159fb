// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab view`: what the page shows is the print, and what is under a pointer has the name of its object.

#include <fmt/format.h>

#include <algorithm>

#include "tests/crossings/columns.h"
#include "tests/programs/viewer/viewer_client.h"

namespace openfab::testing {

namespace {

std::string hash_of_print(const Bench& bench) {
    const Result<JsonValue> read = parse_json(read_file(bench.path("stats.json")), "statistics");
    return read ? member(*read, "hash").text : "no statistics";
}

/// Asks what is at a voxel of the material that only the solid has.
HttpAnswer pick(const Viewer& viewer, const JsonValue& state, const Voxels& voxels) {
    constexpr uint8_t kRight = 3;
    const auto at = std::find(voxels.codes.begin(), voxels.codes.end(), kRight);
    const auto index = at == voxels.codes.end() ? 0 : at - voxels.codes.begin();
    const auto [nx, ny, nz] = voxels.size;
    return viewer.get(fmt::format("/api/pick?generation={}&print=0&x={}&y={}&z={}",
                                  member(state, "generation").number, index % nx, index / nx % ny,
                                  index / nx / ny));
}

Made view(const Bench& bench) {
    Made made;
    made.outcome = bench.print("a.npy", {"--stats", bench.path("stats.json")});
    if (made.outcome.exit_code != 0) return made;
    std::vector<std::string> words{bench.world(), "--draft", "1"};
    words.insert(words.end(), bench.options().begin(), bench.options().end());
    const Viewer viewer(words, bench.cache());
    const JsonValue state = viewer.wait_for([](const JsonValue& s) {
        const std::string& phase = member(member(s, "live"), "phase").text;
        return phase == "done" || phase == "failed";
    });
    if (member(state, "prints").items.empty()) {
        made.wrong = "the page shows no print: " + viewer.get("/api/state").body;
        return made;
    }
    if (const std::string hash = member(member(state, "prints").items[0], "hash").text;
        hash != hash_of_print(bench))
        made.wrong = fmt::format("the page shows {}, the print is {}", hash, hash_of_print(bench));
    const HttpAnswer answer = pick(viewer, state, read_voxels(bench.path("a.npy")));
    if (answer.status != 200 || answer.body.find(R"("part":"solid)") == std::string::npos)
        made.wrong = "under the pointer is: " + answer.body;
    return made;
}

}  // namespace

std::vector<Column> view_columns() {
    return {{"view", "`openfab view`", {}, view, {"view"}}};
}

}  // namespace openfab::testing
