// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "backends/ofr/ofr_reader.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"

namespace openfab::testing {

/// A ball of black in a skin that turns to white; a third material that it does not have.
class ProcessOption : public ::testing::Test {
  protected:
    ProcessOption() {
        scratch_.write("f.fl", "fablet Skin {}\n");
        write_world("w.fab.json", "");
        scratch_.write("p.printer.json", R"({"name": "p", "pitch_mm": [0.1, 0.1, 0.1],
            "build_volume_mm": [100, 100, 50], "native_format": "ofr"})");
    }
    void write_world(const std::string& name, const std::string& placement,
                     const std::string& keys = "", int diameter_mm = 6) {
        scratch_.write(name, fmt::format(R"({{
  "openfab": 1, "printer": "p.printer.json", {}
  "fablets": {{"f": {{"source": "f.fl", "fablet": "Skin"}}}},
  "materials": {{
    "white": {{"key": "#ffffff", "density_g_cm3": 1}},
    "black": {{"key": "#000000", "channel": "K"}},
    "grey": {{"key": "#808080"}}
  }},
  "meshes": {{"ball": {{"sphere": {}}}}},
  "objects": {{"a": {{"mesh": "ball", "fablet": "f", "uniforms": {{"a": "white", "b": "black"}}}}}},
  "build": [{{"object": "a"{}}}]
}})",
                                         keys, diameter_mm, placement));
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome print(const std::vector<std::string>& more, const std::string& world = "w.fab.json",
                  const RunOptions& options = {}) {
        std::vector<std::string> argv{test_program("openfab_test_print_4"), path(world)};
        argv.insert(argv.end(), more.begin(), more.end());
        return run(argv, options);
    }

    struct Voxels {
        pipeline::PrintInfo info;
        std::vector<uint8_t> codes;
        uint8_t at(int32_t x, int32_t y, int32_t z) const {
            return codes[static_cast<size_t>((int64_t{z} * info.size.y + y) * info.size.x + x)];
        }
    };
    Voxels read(const std::string& name) const {
        auto reader = ofr::OfrReader::open(path(name));
        EXPECT_TRUE(reader);
        Voxels out;
        out.info = (*reader)->info();
        while (true) {
            const Result<bool> more = (*reader)->next();
            EXPECT_TRUE(more);
            if (!more || !*more) return out;
            for (int32_t y = 0; y < out.info.size.y; ++y) {
                for (int32_t x = 0; x < out.info.size.x; ++x)
                    out.codes.push_back((*reader)->slice().code(x, y, out.info.bits));
            }
        }
    }
    Voxels print_voxels(std::vector<std::string> more, const std::string& world = "w.fab.json") {
        more.insert(more.end(), {"-o", path("out.ofr")});
        const Outcome outcome = print(more, world);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return read("out.ofr");
    }

    ScratchFolder scratch_;
};

}  // namespace openfab::testing
