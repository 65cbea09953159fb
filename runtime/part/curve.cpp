// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/part/curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abi/curve_table.h"
#include "runtime/part/messages.h"

namespace openfab::part {

namespace {

using Interpolation = world::Curve::Interpolation;

/// One channel: positions and values of at least one key.
struct Channel {
    std::vector<double> x, y;

    size_t keys() const { return x.size(); }
    double width(size_t k) const { return x[k + 1] - x[k]; }
    double rise(size_t k) const { return (y[k + 1] - y[k]) / width(k); }

    /// Of the parabola through three keys, cut so that the curve stays between the first two; `k` and `next` are the
    /// stretches at an end and behind it.
    double end_slope(size_t k, size_t next) const {
        const double h = width(k), more = width(next), near = rise(k), far = rise(next);
        const double slope = ((2 * h + more) * near - h * far) / (h + more);
        if (slope * near <= 0) return 0;
        return near * far <= 0 && std::abs(slope) > 3 * std::abs(near) ? 3 * near : slope;
    }

    std::vector<double> monotone_slopes() const {
        const size_t last = keys() - 1;
        if (last == 0) return {0};
        if (last == 1) return {rise(0), rise(0)};
        std::vector<double> out = {end_slope(0, 1)};
        for (size_t k = 1; k < last; ++k) {
            const double before = rise(k - 1), after = rise(k);
            const double a = 2 * width(k) + width(k - 1), b = width(k) + 2 * width(k - 1);
            out.push_back(before * after <= 0 ? 0 : (a + b) / (a / before + b / after));
        }
        out.push_back(end_slope(last - 1, last - 2));
        return out;
    }

    /// c0 to c3 of the stretch behind key k.
    std::vector<double> coefficients(size_t k, Interpolation how,
                                     const std::vector<double>& slopes) const {
        if (k + 1 == keys() || how == Interpolation::kStep) return {y[k], 0, 0, 0};
        if (how == Interpolation::kLinear) return {y[k], rise(k), 0, 0};
        const double h = width(k), a = slopes[k], b = slopes[k + 1];
        return {y[k], a, (3 * rise(k) - 2 * a - b) / h, (a + b - 2 * rise(k)) / (h * h)};
    }
};

}  // namespace

std::string curve_fault(const world::Curve& curve, int32_t channels) {
    const size_t numbers = 1 + static_cast<size_t>(channels);
    if (curve.keys.empty() || curve.keys.size() > size_t{abi::kCurveKeys})
        return fmt::format(messages::kCurveKeys, curve.keys.size(), abi::kCurveKeys);
    for (size_t k = 0; k < curve.keys.size(); ++k) {
        const std::vector<double>& key = curve.keys[k];
        if (key.size() != numbers) {
            return fmt::format(messages::kCurveNumbers, key.size(), k, numbers,
                               channels == 1 ? messages::kCurveKeyValue : messages::kCurveKeyColor);
        }
        for (const double number : key) {
            // Their differences and the cubics' coefficients are floats, too.
            if (!(std::abs(number) <= 1e9)) return fmt::format(messages::kCurveBeyond, number, k);
        }
        const bool rises =
            k == 0 || static_cast<float>(key[0]) > static_cast<float>(curve.keys[k - 1][0]);
        if (!rises) {
            return fmt::format(messages::kCurveOrder, k, key[0], curve.keys[k - 1][0]);
        }
    }
    return "";
}

std::vector<float> curve_table(const world::Curve& curve, int32_t channels) {
    const auto floats = [](double value) { return static_cast<float>(value); };
    std::vector<float> out(static_cast<size_t>(abi::curve_size(channels)), 0.0F);
    const auto stride = static_cast<size_t>(abi::curve_stride(channels));
    const auto header = static_cast<size_t>(abi::curve_header(channels));
    out[0] = floats(curve.keys.front()[0]);
    out[1] = floats(curve.keys.back()[0]);
    for (size_t k = 0; k < size_t{abi::kCurveKeys}; ++k)
        out[header + k * stride] = k < curve.keys.size() ? floats(curve.keys[k][0]) : abi::kNoKey;
    const Interpolation how = curve.interpolation.value_or(channels == 1 ? Interpolation::kCubic
                                                                         : Interpolation::kLinear);
    for (size_t channel = 0; channel < static_cast<size_t>(channels); ++channel) {
        Channel one;
        // As lookups see them.
        for (const std::vector<double>& key : curve.keys) {
            one.x.push_back(static_cast<double>(floats(key[0])));
            one.y.push_back(static_cast<double>(floats(key[1 + channel])));
        }
        out[2 + 2 * channel] = floats(*std::min_element(one.y.begin(), one.y.end()));
        out[3 + 2 * channel] = floats(*std::max_element(one.y.begin(), one.y.end()));
        const std::vector<double> slopes = one.monotone_slopes();
        for (size_t k = 0; k < one.keys(); ++k) {
            const std::vector<double> c = one.coefficients(k, how, slopes);
            for (size_t i = 0; i < c.size(); ++i)
                out[header + k * stride + 1 + 4 * channel + i] = floats(c[i]);
        }
    }
    return out;
}

}  // namespace openfab::part
