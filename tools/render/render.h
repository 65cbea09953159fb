// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `openfab render`: a picture of how a print will look.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "tools/render/film.h"
#include "tools/render/scene.h"

namespace openfab::render {

struct RenderOptions {
    std::string input;     ///< an .ofr file, a folder of slices or a world
    std::string output;    ///< .png or .pfm
    std::string describe;  ///< a .json file for the scene; empty: none
    std::string optics;    ///< a file; empty: the built-in one
    std::optional<double> roughness;
    SceneOptions scene;  ///< its aspect follows from the film
    FilmOptions film;
    double exposure_stops = 0;
    int64_t memory_bytes = 0;
    bool quiet = false;
    // Of a world, which is printed first.
    int32_t draft = 1;
    std::vector<std::string> settings, allow;
    std::filesystem::path programs;  ///< folder of `openfab`
};

Result<void> render(const RenderOptions& options);

}  // namespace openfab::render
