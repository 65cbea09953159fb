// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The picture that is being made: sums of samples for each pixel, traced pass by pass on all threads,
// and its file. The same seed and number of samples give the same sums on any number of threads.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "base/result.h"
#include "tools/render/tracer.h"

namespace openfab::render {

struct FilmOptions {
    int32_t width = 0, height = 0;
    int32_t samples = 64;  ///< a pixel
    double seconds = 0;    ///< ends after a pass that took it beyond; 0: none
    int32_t threads = 1;
    uint64_t seed = 0;
};

class Film {
  public:
    explicit Film(const FilmOptions& options);

    /// Calls `after` when every pixel has one more pass; ends early where it returns false, where the
    /// time is over or soon after `stop` is set.
    void trace(const Tracer& tracer, const std::atomic<bool>& stop,
               const std::function<bool(int32_t samples)>& after);

    int64_t paths() const;
    /// Return the fewest and most samples that a pixel has.
    int32_t fewest() const;
    /// Returns the mean over a pixel's samples; 0 where it has none.
    Rgb mean(int32_t x, int32_t y) const;
    /// Return pictures: sRGB of `exposure` stops more, as a PNG file, and linear light as a PFM file.
    std::vector<uint8_t> to_png(double exposure_stops) const;
    std::vector<uint8_t> to_pfm() const;

    static int64_t bytes(int32_t width, int32_t height);

  private:
    struct Pixel {
        Rgb sum{};
        int32_t samples = 0;
    };
    void trace_tile(const Tracer& tracer, int32_t tile, int32_t samples,
                    const std::atomic<bool>& stop);

    FilmOptions options_;
    std::vector<Pixel> pixels_;  ///< top row first
};

/// Writes the file, as a PNG or, for a name that ends in .pfm, as linear light.
Result<void> write_picture(const Film& film, const std::filesystem::path& file,
                           double exposure_stops);

}  // namespace openfab::render
