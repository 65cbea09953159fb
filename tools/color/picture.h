// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A picture as textures have it: by its own profile, else sRGB, in linear light; and upright, as viewers
// show it.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "tools/color/lab.h"

namespace openfab::color {

class Picture {
  public:
    /// Reads a picture of up to 64 million pixels; errors name the file.
    static Result<Picture> read(const std::filesystem::path& file);

    /// The file, for people.
    const std::string& name() const { return name_; }
    int width() const { return width_; }
    int height() const { return height_; }
    /// Returns the linear light of a pixel, from the top left; clamped to the picture.
    const Rgb& at(int x, int y) const;

    /// What white is, where the picture's profile is of a scanner or a camera: that of the target that it
    /// was made from, under D50.
    const std::optional<Xyz>& input_white() const { return input_white_; }
    /// Whether the file says how long it was exposed: then how bright white is, is arbitrary.
    bool by_camera() const { return by_camera_; }

    /// What is not known of its colours; empty where all is.
    const std::string& note() const { return note_; }

  private:
    Picture() = default;

    std::string name_, note_;
    int width_ = 0, height_ = 0;
    std::vector<Rgb> pixels_;
    std::optional<Xyz> input_white_;
    bool by_camera_ = false;
};

/// Encodes a PNG of 8 bits in sRGB of linear light, rows from the top.
Result<std::vector<uint8_t>> png_of(int width, int height, const std::vector<Rgb>& pixels);

}  // namespace openfab::color
