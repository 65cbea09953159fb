// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What tests of `openfab view` show: a print that is written without one, and a world of a box in a folder of its own.

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>

#include "base/json_text.h"
#include "tests/programs/viewer/viewer_client.h"
#include "tests/unit/backends/sample_print.h"

namespace openfab::testing {

using Rgba = std::array<uint8_t, 4>;
/// Of void and of three materials; what the page would send is `kColorText`.
constexpr std::array<Rgba, 4> kColors{
    {{0, 0, 0, 0}, {250, 40, 10, 255}, {9, 200, 90, 255}, {60, 70, 255, 255}}};
constexpr const char* kColorText = "00000000fa280aff09c85aff3c46ffff";
/// Larger than a tile along x, odd, and with a last row of tiles of one voxel.
constexpr Vec3i kSize{517, 23, 37};

/// The address of a tile of the first print.
std::string tile_path(const std::string& values);

class PrintFixture : public ::testing::Test {
  protected:
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    /// Returns the path of the .ofr file.
    std::string write(const SamplePrint& print, const std::string& name, bool complete = true);
    /// The answer's PNG; fails the test where it is none.
    ReadPng picture(const HttpAnswer& answer);

    ScratchFolder scratch_;
    SamplePrint print_ = make_sample(kSize);
};

/// A world with one object, `cube`, whose fablet `NAME.fl` is of the material uniforms `a` (white) and `b` (black).
class WorldFixture : public ::testing::Test {
  protected:
    /// `fablet` is what the text calls it; `build` is what the world prints.
    WorldFixture(const std::string& name, const std::string& fablet, std::string text,
                 const std::string& build = R"([{"object": "cube"}])");

    std::string world() const { return (scratch_ / "cube.fab.json").string(); }
    std::string cache() const { return (scratch_ / "cache").string(); }
    std::string source() const { return (scratch_ / source_).string(); }
    const std::string& world_text() const { return world_text_; }

    /// Whether the draft is printed; of a generation, or of any.
    static bool is_done(const JsonValue& state);
    static bool has_done(const JsonValue& state, double generation);
    /// Asks about a text of the fablet; `action` is JSON, none where it is empty.
    static HttpAnswer ask(const Viewer& viewer, const std::string& path, const std::string& text,
                          const std::string& action = {});

    ScratchFolder scratch_;

  private:
    std::string source_, world_text_;
};

}  // namespace openfab::testing
