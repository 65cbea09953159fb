// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/figures/paint.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace openfab::figures {

namespace {

using Color = std::array<double, 3>;

double mix(double a, double b, double t) {
    return a + (b - a) * t;
}
Color mix(const Color& a, const Color& b, double t) {
    return {mix(a[0], b[0], t), mix(a[1], b[1], t), mix(a[2], b[2], t)};
}
double ramp(double low, double high, double x) {
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

double hash(int32_t x, int32_t y) {
    uint32_t h = static_cast<uint32_t>(x) * 0x9E3779B1U + static_cast<uint32_t>(y) * 0x85EBCA77U;
    h = (h ^ (h >> 15)) * 0x2C1B3C6DU;
    h = (h ^ (h >> 12)) * 0x297A2D39U;
    return static_cast<double>(h ^ (h >> 15)) / 4294967296.0;
}

/// Value noise in -1 … 1.
double noise(double x, double y) {
    const double fx = std::floor(x);
    const double fy = std::floor(y);
    const auto ix = static_cast<int32_t>(fx);
    const auto iy = static_cast<int32_t>(fy);
    const double tx = ramp(0, 1, x - fx);
    const double ty = ramp(0, 1, y - fy);
    const double low = mix(hash(ix, iy), hash(ix + 1, iy), tx);
    const double high = mix(hash(ix, iy + 1), hash(ix + 1, iy + 1), tx);
    return 2 * mix(low, high, ty) - 1;
}

/// Returns the distance of x from the nearest integer: 0 … 0.5.
double wave(double x) {
    return std::abs(x - std::floor(x + 0.5));
}

/// Stripes across the body, along the legs bands; they tilt at the shoulder and the haunch, and
/// fork where the domain warp pulls them apart. u 0 … 1 over 77 mm, v over 36 mm.
double zebra(double u, double v) {
    const double x = u * 77;
    const double z = v * 36;
    const double warp = 1.7 * noise(x / 9, z / 7) + 0.7 * noise(x / 3.5 + 40, z / 3.5);
    const double body = (x + warp + 0.012 * (z - 22) * (x - 30)) / 5.2;
    const double bands = (z + 0.6 * warp + 0.12 * x) / 3.1;
    const double leg = 1 - ramp(9, 16, z);
    const double phase = mix(body, bands, leg);
    const double width = 0.25 + 0.07 * noise(x / 8 + 9, z / 8 + 5);
    const double belly =
        ramp(9, 12, z) * (1 - ramp(12.5, 15, z)) * ramp(22, 28, x) * (1 - ramp(40, 46, x));
    return std::max(ramp(width - 0.03, width + 0.03, wave(phase)), belly);
}

/// A reef fish: a warm body with blue stripes that wind, spots towards the tail, a dark mask.
Color reef(double u, double v) {
    const double x = u * 61;
    const double z = v * 31;
    const Color flank = mix({1.0, 0.45, 0.05}, {0.98, 0.85, 0.10}, ramp(6, 24, z));
    Color color = mix({0.10, 0.62, 0.55}, flank, ramp(8, 26, x));
    color = mix(color, {0.85, 0.12, 0.35}, ramp(24, 28, z));
    const double warp = 2.4 * noise(x / 7, z / 5) + noise(x / 3 + 7, z / 3);
    const double lines = 1 - ramp(0.10, 0.16, wave((z + warp) / 4.6));
    const Color blue =
        mix({0.05, 0.10, 0.65}, {0.10, 0.65, 0.95}, lines * ramp(0, 0.05, wave((z + warp) / 4.6)));
    color = mix(color, blue, lines * ramp(12, 20, x) * (1 - ramp(50, 54, x)));
    const double cx = std::floor(x / 2.6);
    const double cz = std::floor(z / 2.6);
    const auto ix = static_cast<int32_t>(cx);
    const auto iz = static_cast<int32_t>(cz);
    const double dx = x / 2.6 - cx - 0.3 - 0.4 * hash(ix, iz);
    const double dz = z / 2.6 - cz - 0.3 - 0.4 * hash(iz + 50, ix);
    const double spot = 1 - ramp(0.20, 0.28, std::sqrt(dx * dx + dz * dz));
    color = mix(color, {0.98, 0.95, 0.75}, spot * (1 - ramp(14, 22, x)));
    const double gill = 1 - ramp(0.6, 1.0, std::abs(x - 44.5 + 0.05 * (z - 14) * (z - 14)));
    color = mix(color, {0.03, 0.08, 0.45}, gill * ramp(6, 9, z) * (1 - ramp(19, 21, z)));
    const double ex = x - 52.4;
    const double ez = z - 16.9;
    const double eye = std::sqrt(ex * ex + ez * ez);
    color = mix(color, {0.98, 0.92, 0.20}, 1 - ramp(2.2, 2.5, eye));
    color = mix(color, {0.02, 0.02, 0.05}, 1 - ramp(1.1, 1.3, eye));
    return color;
}

uint8_t byte(double value) {
    return static_cast<uint8_t>(std::clamp(value, 0.0, 1.0) * 255 + 0.5);
}

template <typename Paint>
Painting paint(const char* name, int32_t width, int32_t height, int32_t channels, Paint&& color) {
    Painting painting{name, width, height, channels, {}};
    painting.pixels.reserve(static_cast<size_t>(width) * static_cast<size_t>(height) *
                            static_cast<size_t>(channels));
    for (int32_t y = 0; y < height; ++y) {
        for (int32_t x = 0; x < width; ++x) {
            color((x + 0.5) / width, 1 - (y + 0.5) / height, &painting.pixels);
        }
    }
    return painting;
}

}  // namespace

std::vector<Painting> all_paintings() {
    std::vector<Painting> paintings;
    paintings.push_back(paint(
        "zebra", 1024, 480, 1,
        [](double u, double v, std::vector<uint8_t>* out) { out->push_back(byte(zebra(u, v))); }));
    paintings.push_back(
        paint("reef", 1024, 520, 3, [](double u, double v, std::vector<uint8_t>* out) {
            for (double c : reef(u, v))
                out->push_back(byte(c));
        }));
    return paintings;
}

}  // namespace openfab::figures
