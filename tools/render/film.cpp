// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/film.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <thread>

#include "backends/common/output_file.h"
#include "backends/preview/picture.h"
#include "backends/raster/png_encode.h"
#include "base/clock.h"
#include "base/color.h"
#include "tools/render/messages.h"

namespace openfab::render {

namespace {

constexpr int32_t kTile = 16;
constexpr int32_t kMostInAPass = 16;

/// Leaves values below kBend as they are, and lets those above approach 1.
double shoulder(double value) {
    constexpr double kBend = 0.8;
    if (value <= kBend) return value;
    const double x = (value - kBend) / (1 - kBend);
    return kBend + (1 - kBend) * x / (1 + x);
}

}  // namespace

Film::Film(const FilmOptions& options)
    : options_(options),
      pixels_(static_cast<size_t>(options.width) * static_cast<size_t>(options.height)) {}

int64_t Film::bytes(int32_t width, int32_t height) {
    // With the file that is made of it.
    return int64_t{width} * height * static_cast<int64_t>(sizeof(Pixel) + 16);
}

void Film::trace_tile(const Tracer& tracer, int32_t tile, int32_t samples,
                      const std::atomic<bool>& stop) {
    const int32_t across = (options_.width + kTile - 1) / kTile;
    const int32_t x0 = tile % across * kTile;
    const int32_t y0 = tile / across * kTile;
    const int32_t wide = std::min(kTile, options_.width - x0);
    const int32_t high = std::min(kTile, options_.height - y0);
    const auto index_of = [&](int32_t pixel) {
        return static_cast<size_t>(y0 + pixel / wide) * static_cast<size_t>(options_.width) +
               static_cast<size_t>(x0 + pixel % wide);
    };
    // Paths finish in any order; sums have one.
    std::vector<Rgb> light(static_cast<size_t>(wide * high * samples));
    const auto start = [&](int32_t path) {
        const int32_t pixel = path / samples;
        const size_t index = index_of(pixel);
        const auto sample = static_cast<uint64_t>(pixels_[index].samples + path % samples);
        Random random(options_.seed, index, sample);
        const double px = (x0 + pixel % wide + random.uniform()) / options_.width;
        const double py = (y0 + pixel / wide + random.uniform()) / options_.height;
        return tracer.start_in_picture(px, py, random);
    };
    const auto finish = [&](int32_t path, const Rgb& one, bool) {
        light[static_cast<size_t>(path)] = one;
    };
    if (!tracer.trace(wide * high * samples, stop, start, finish)) return;
    for (int32_t path = 0; path < wide * high * samples; ++path) {
        Pixel& pixel = pixels_[index_of(path / samples)];
        for (size_t c = 0; c < 3; ++c)
            pixel.sum[c] += light[static_cast<size_t>(path)][c];
        ++pixel.samples;
    }
}

void Film::trace(const Tracer& tracer, const std::atomic<bool>& stop,
                 const std::function<bool(int32_t samples)>& after) {
    const double start = seconds_now();
    const int32_t tiles =
        ((options_.width + kTile - 1) / kTile) * ((options_.height + kTile - 1) / kTile);
    int32_t done = 0;
    while (done < options_.samples && !stop) {
        const int32_t samples =
            std::min({std::max(done, 1), kMostInAPass, options_.samples - done});
        std::atomic<int32_t> next{0};
        const auto work = [&] {
            for (int32_t tile = next++; tile < tiles && !stop; tile = next++)
                trace_tile(tracer, tile, samples, stop);
        };
        std::vector<std::thread> others;
        for (int32_t i = 1; i < options_.threads; ++i)
            others.emplace_back(work);
        work();
        for (std::thread& other : others)
            other.join();
        done += samples;
        if (stop || !after(done)) return;
        if (options_.seconds > 0 && seconds_now() - start >= options_.seconds) return;
    }
}

int64_t Film::paths() const {
    int64_t all = 0;
    for (const Pixel& pixel : pixels_)
        all += pixel.samples;
    return all;
}

int32_t Film::fewest() const {
    const auto found =
        std::min_element(pixels_.begin(), pixels_.end(),
                         [](const Pixel& a, const Pixel& b) { return a.samples < b.samples; });
    return found == pixels_.end() ? 0 : found->samples;
}

Rgb Film::mean(int32_t x, int32_t y) const {
    const Pixel& pixel = pixels_[static_cast<size_t>(y) * static_cast<size_t>(options_.width) +
                                 static_cast<size_t>(x)];
    const double scale = pixel.samples > 0 ? 1.0 / pixel.samples : 0;
    return {pixel.sum[0] * scale, pixel.sum[1] * scale, pixel.sum[2] * scale};
}

std::vector<uint8_t> Film::to_png(double exposure_stops) const {
    const double scale = std::exp2(exposure_stops);
    raster::PngImage image;
    image.width = options_.width;
    image.height = options_.height;
    image.color = raster::PngColor::kRgb;
    image.text = "OpenFab";
    return raster::encode_png_rows(image, [&](int32_t y, uint8_t* row) {
        for (int32_t x = 0; x < options_.width; ++x) {
            const Rgb light = mean(x, y);
            for (size_t c = 0; c < 3; ++c)
                row[static_cast<size_t>(x) * 3 + c] = linear_to_srgb8(shoulder(light[c] * scale));
        }
    });
}

std::vector<uint8_t> Film::to_pfm() const {
    static_assert(std::endian::native == std::endian::little, "the scale of -1 says so");
    const std::string head = fmt::format("PF\n{} {}\n-1.0\n", options_.width, options_.height);
    std::vector<uint8_t> out(head.begin(), head.end());
    // Lowest row first.
    for (int32_t y = options_.height - 1; y >= 0; --y) {
        for (int32_t x = 0; x < options_.width; ++x) {
            for (const double channel : mean(x, y)) {
                const auto value = static_cast<float>(channel);
                uint8_t bytes[sizeof value];
                std::memcpy(bytes, &value, sizeof value);
                out.insert(out.end(), bytes, bytes + sizeof value);
            }
        }
    }
    return out;
}

Result<void> write_picture(const Film& film, const std::filesystem::path& file,
                           double exposure_stops) {
    const std::vector<uint8_t> bytes =
        file.extension() == ".pfm" ? film.to_pfm() : film.to_png(exposure_stops);
    if (bytes.empty()) return outside_error(messages::kNoMemoryForPicture);
    return backends::write_whole_file(file, bytes);
}

}  // namespace openfab::render
