// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/postcard/check.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace openfab::postcard {

namespace {

/// IEC 61966-2-1.
double srgb_to_linear(double s) {
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

struct Columns {
    const Voxels& print;
    const Card& card;

    double x_mm(int32_t i) const { return print.origin_mm.x + (i + 0.5) * print.pitch_mm.x; }
    double y_mm(int32_t j) const { return print.origin_mm.y + (j + 0.5) * print.pitch_mm.y; }
    double z_mm(int32_t k) const { return print.origin_mm.z + (k + 0.5) * print.pitch_mm.z; }
    double u(int32_t i) const { return x_mm(i) / card.width_mm + 0.5; }
    double v(int32_t j) const { return y_mm(j) / card.height_mm + 0.5; }
    bool inside(int32_t i, int32_t j, double margin_mm) const {
        return std::abs(x_mm(i)) < card.width_mm / 2 - margin_mm &&
               std::abs(y_mm(j)) < card.height_mm / 2 - margin_mm;
    }
};

/// Returns the thickness of the back at (u, v), in mm below z = 0.
double relief_mm(const Card& card, const Picture& hidden, double u, double v) {
    if (u < card.border_u || u > 1 - card.border_u || v < card.border_v || v > 1 - card.border_v) {
        return card.max_thickness_mm;
    }
    return std::sqrt(1 - std::min(1.0, hidden.sample(u, v))) * card.max_thickness_mm;
}

void fault(Findings& found, std::string text) {
    if (found.first_fault.empty()) found.first_fault = std::move(text);
}

void compare_texture(const Columns& at, const Picture& front, Findings& found) {
    constexpr int32_t kWindow = 32;
    // Tolerance for one window in one slice: an ordered dither is not exact per window. The worst
    // of 26,000 is off by 0.020.
    constexpr double kAllowedWindow = 0.025;
    const Voxels& print = at.print;
    double sum = 0;
    for (int32_t k = 0; k < print.size.z; ++k) {
        const double depth = at.card.base_mm - at.z_mm(k);
        if (depth < 0 || depth > at.card.texture_depth_mm - 1e-3) continue;
        for (int32_t j0 = 0; j0 + kWindow <= print.size.y; j0 += kWindow) {
            for (int32_t i0 = 0; i0 + kWindow <= print.size.x; i0 += kWindow) {
                const double margin = at.card.texture_depth_mm;
                if (!at.inside(i0, j0, margin) ||
                    !at.inside(i0 + kWindow - 1, j0 + kWindow - 1, margin))
                    continue;
                double asked = 0;
                int64_t white = 0;
                for (int32_t j = j0; j < j0 + kWindow; ++j) {
                    for (int32_t i = i0; i < i0 + kWindow; ++i) {
                        asked += front.sample(at.u(i), at.v(j));
                        white += print.code(i, j, k) == print.white ? 1 : 0;
                    }
                }
                const double error = (static_cast<double>(white) - asked) / (kWindow * kWindow);
                sum += error;
                ++found.windows;
                if (std::abs(error) > found.worst_window) {
                    found.worst_window = std::abs(error);
                    if (found.worst_window > kAllowedWindow) {
                        fault(found,
                              fmt::format("slice {}: window at column {}, row {} is off by {:.4f}",
                                          k, i0, j0, error));
                    }
                }
            }
        }
    }
    found.signed_mean = found.windows > 0 ? sum / static_cast<double>(found.windows) : 0;
}

void compare_column(const Columns& at, int32_t i, int32_t j, const std::vector<double>& relief,
                    Findings& found) {
    const Voxels& print = at.print;
    int32_t lowest = -1, highest = -1;
    int32_t solid = 0;
    for (int32_t k = 0; k < print.size.z; ++k) {
        const uint8_t code = print.code(i, j, k);
        if (code == 0) continue;
        if (lowest < 0) lowest = k;
        highest = k;
        ++solid;
        if (at.card.base_mm - at.z_mm(k) > at.card.texture_depth_mm + 1e-3 && code != print.white) {
            ++found.not_white;
            fault(found, fmt::format("voxel ({}, {}, {}) below the texture is not white", i, j, k));
        }
    }
    ++found.columns;
    if (lowest < 0) {
        ++found.missing_columns;
        fault(found, fmt::format("column ({}, {}) is empty", i, j));
        return;
    }
    if (solid != highest - lowest + 1) {
        ++found.holes;
        fault(found, fmt::format("column ({}, {}) has a hole", i, j));
    }
    double least = 1e9, greatest = -1e9;
    for (int32_t dj = -1; dj <= 1; ++dj) {
        for (int32_t di = -1; di <= 1; ++di) {
            const int32_t ii = std::clamp(i + di, 0, print.size.x - 1),
                          jj = std::clamp(j + dj, 0, print.size.y - 1);
            const double r = relief[static_cast<size_t>(jj) * static_cast<size_t>(print.size.x) +
                                    static_cast<size_t>(ii)];
            least = std::min(least, r);
            greatest = std::max(greatest, r);
        }
    }
    const double depth = -(print.origin_mm.z + lowest * print.pitch_mm.z);
    if (depth < least - 1.5 * print.pitch_mm.z || depth > greatest + 1.5 * print.pitch_mm.z) {
        ++found.relief_misses;
        fault(found, fmt::format("column ({}, {}): relief of {:.4f} mm, asked {:.4f} to {:.4f}", i,
                                 j, depth, least, greatest));
    }
}

}  // namespace

double Picture::sample(double u, double v) const {
    const double x = u * width - 0.5, y = v * height - 0.5;
    const double fx = std::floor(x), fy = std::floor(y);
    const auto texel = [&](double tx, double ty) {
        const auto ix = static_cast<int32_t>(std::clamp(tx, 0.0, width - 1.0));
        const auto iy = static_cast<int32_t>(std::clamp(ty, 0.0, height - 1.0));
        return luminance[static_cast<size_t>(iy) * static_cast<size_t>(width) +
                         static_cast<size_t>(ix)];
    };
    const double ax = x - fx, ay = y - fy;
    const double low = texel(fx, fy) * (1 - ax) + texel(fx + 1, fy) * ax;
    const double high = texel(fx, fy + 1) * (1 - ax) + texel(fx + 1, fy + 1) * ax;
    return low * (1 - ay) + high * ay;
}

Picture read_picture(const std::string& file) {
    Picture picture;
    auto input = OIIO::ImageInput::open(file);
    if (!input) return picture;
    const OIIO::ImageSpec spec = input->spec();
    std::vector<uint8_t> bytes(static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height) *
                               static_cast<size_t>(spec.nchannels));
    if (spec.nchannels < 3 ||
        !input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, bytes.data()))
        return picture;
    picture.width = spec.width;
    picture.height = spec.height;
    picture.luminance.resize(static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height));
    for (int32_t y = 0; y < spec.height; ++y) {
        for (int32_t x = 0; x < spec.width; ++x) {
            const uint8_t* p =
                &bytes[(static_cast<size_t>(spec.height - 1 - y) * static_cast<size_t>(spec.width) +
                        static_cast<size_t>(x)) *
                       static_cast<size_t>(spec.nchannels)];
            picture.luminance[static_cast<size_t>(y) * static_cast<size_t>(spec.width) +
                              static_cast<size_t>(x)] = 0.2126 * srgb_to_linear(p[0] / 255.0) +
                                                        0.7152 * srgb_to_linear(p[1] / 255.0) +
                                                        0.0722 * srgb_to_linear(p[2] / 255.0);
        }
    }
    return picture;
}

Findings compare(const Voxels& print, const Card& card, const Picture& front,
                 const Picture& hidden) {
    Findings found;
    const Columns at{print, card};
    compare_texture(at, front, found);
    std::vector<double> relief(static_cast<size_t>(print.size.x) *
                               static_cast<size_t>(print.size.y));
    for (int32_t j = 0; j < print.size.y; ++j) {
        for (int32_t i = 0; i < print.size.x; ++i) {
            relief[static_cast<size_t>(j) * static_cast<size_t>(print.size.x) +
                   static_cast<size_t>(i)] = relief_mm(card, hidden, at.u(i), at.v(j));
        }
    }
    for (int32_t j = 0; j < print.size.y; ++j) {
        for (int32_t i = 0; i < print.size.x; ++i) {
            if (at.inside(i, j, 0)) compare_column(at, i, j, relief, found);
        }
    }
    return found;
}

}  // namespace openfab::postcard
