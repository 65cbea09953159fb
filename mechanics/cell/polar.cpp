// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/cell/polar.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "mechanics/model/picture.h"

namespace openfab::mechanics {

std::vector<uint8_t> polar_picture(const Stiffness& compliance, double young_most) {
    constexpr int32_t kPanel = 380, kTop = 44;
    constexpr double kRadius = 150;
    constexpr Colour kGrey{190, 190, 190}, kBlack{30, 30, 30}, kCurve{20, 90, 170};
    Picture picture(3 * kPanel, kPanel + kTop);
    // The outer circle has a round number.
    const double decade = std::pow(10, std::floor(std::log10(young_most)));
    double outer = 10 * decade;
    for (const double round : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0})
        if (round * decade >= young_most) {
            outer = round * decade;
            break;
        }
    static constexpr const char* kNames[3][2] = {{"X", "Y"}, {"Y", "Z"}, {"X", "Z"}};
    static constexpr size_t kAxes[3][2] = {{0, 1}, {1, 2}, {0, 2}};
    for (int32_t p = 0; p < 3; ++p) {
        const double cx = kPanel * (p + 0.5), cy = kTop + kPanel * 0.5;
        picture.circle(cx, cy, kRadius, kGrey);
        picture.circle(cx, cy, kRadius / 2, kGrey);
        picture.line(cx - kRadius, cy, cx + kRadius, cy, kGrey);
        picture.line(cx, cy - kRadius, cx, cy + kRadius, kGrey);
        picture.text(static_cast<int32_t>(cx + kRadius) + 6, static_cast<int32_t>(cy) - 7,
                     kNames[p][0], kBlack);
        picture.text(static_cast<int32_t>(cx) - 5, static_cast<int32_t>(cy - kRadius) - 20,
                     kNames[p][1], kBlack);
        picture.text(static_cast<int32_t>(cx + 0.72 * kRadius),
                     static_cast<int32_t>(cy + 0.74 * kRadius), fmt::format("{:.3g}", outer),
                     kBlack, 1);
        picture.text(static_cast<int32_t>(cx + 0.37 * kRadius),
                     static_cast<int32_t>(cy + 0.38 * kRadius), fmt::format("{:.3g}", outer / 2),
                     kBlack, 1);
        double last_x = 0, last_y = 0;
        constexpr int kSteps = 360;
        for (int i = 0; i <= kSteps; ++i) {
            const double a = 2 * std::numbers::pi * i / kSteps;
            std::array<double, 3> n{};
            n[kAxes[p][0]] = std::cos(a);
            n[kAxes[p][1]] = std::sin(a);
            const double r = kRadius * young_along(compliance, n) / outer;
            const double x = cx + r * std::cos(a), y = cy - r * std::sin(a);
            if (i > 0) picture.line(last_x, last_y, x, y, kCurve, 3);
            last_x = x;
            last_y = y;
        }
    }
    picture.text(12, 12,
                 fmt::format("Young's modulus by direction  outer circle {:.3g} MPa", outer),
                 kBlack);
    return picture.png();
}

}  // namespace openfab::mechanics
