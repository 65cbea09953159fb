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

/// A value and how it changes.
struct Moving {
    double value = 0, change = 0;

    Moving() = default;
    Moving(double at, double by = 0) : value(at), change(by) {}
    Moving operator-() const { return {-value, -change}; }
    friend Moving operator+(Moving a, Moving b) { return {a.value + b.value, a.change + b.change}; }
    friend Moving operator-(Moving a, Moving b) { return a + -b; }
    friend Moving operator*(Moving a, Moving b) {
        return {a.value * b.value, a.change * b.value + a.value * b.change};
    }
    friend Moving operator/(Moving a, Moving b) {
        const double value = a.value / b.value;
        return {value, (a.change - value * b.change) / b.value};
    }
    friend auto operator<=>(const Moving& a, const Moving& b) { return a.value <=> b.value; }
};

Moving abs(const Moving& a) {
    return a.value < 0 ? -a : a;
}

/// One channel: positions and values of at least one key.
template <typename Number>
struct Channel {
    std::vector<double> x;
    std::vector<Number> y;

    size_t keys() const { return x.size(); }
    double width(size_t k) const { return x[k + 1] - x[k]; }
    Number rise(size_t k) const { return (y[k + 1] - y[k]) / width(k); }

    /// Of the parabola through three keys, cut so that the curve stays between the first two; `k` and `next` are the
    /// stretches at an end and behind it.
    Number end_slope(size_t k, size_t next) const {
        using std::abs;
        const double h = width(k), more = width(next);
        const Number near = rise(k), far = rise(next);
        const Number slope = ((2 * h + more) * near - h * far) / (h + more);
        if (slope * near <= 0) return 0;
        return near * far <= 0 && abs(slope) > 3 * abs(near) ? 3 * near : slope;
    }

    std::vector<Number> monotone_slopes() const {
        const size_t last = keys() - 1;
        if (last == 0) return {0};
        if (last == 1) return {rise(0), rise(0)};
        std::vector<Number> out = {end_slope(0, 1)};
        for (size_t k = 1; k < last; ++k) {
            const Number before = rise(k - 1), after = rise(k);
            const double a = 2 * width(k) + width(k - 1), b = width(k) + 2 * width(k - 1);
            out.push_back(before * after <= 0 ? Number(0) : (a + b) / (a / before + b / after));
        }
        out.push_back(end_slope(last - 1, last - 2));
        return out;
    }

    /// c0 to c3 of the stretch behind key k.
    std::vector<Number> coefficients(size_t k, Interpolation how,
                                     const std::vector<Number>& slopes) const {
        if (k + 1 == keys() || how == Interpolation::kStep) return {y[k], 0, 0, 0};
        if (how == Interpolation::kLinear) return {y[k], rise(k), 0, 0};
        const double h = width(k);
        const Number a = slopes[k], b = slopes[k + 1];
        return {y[k], a, (3 * rise(k) - 2 * a - b) / h, (a + b - 2 * rise(k)) / (h * h)};
    }
};

float floats(double value) {
    return static_cast<float>(value);
}
float floats(const Moving& of) {
    return static_cast<float>(of.change);
}

/// Writes what of a table belongs to one channel: of moving values, their changes.
template <typename Number>
void write_channel(const Channel<Number>& one, Interpolation how, int32_t channels, int32_t channel,
                   float* table) {
    table[2 + 2 * channel] = floats(*std::min_element(one.y.begin(), one.y.end()));
    table[3 + 2 * channel] = floats(*std::max_element(one.y.begin(), one.y.end()));
    const std::vector<Number> slopes = one.monotone_slopes();
    for (size_t k = 0; k < one.keys(); ++k) {
        const std::vector<Number> c = one.coefficients(k, how, slopes);
        float* to = table + abi::curve_coefficients(channels, static_cast<int32_t>(k), channel);
        for (size_t i = 0; i < c.size(); ++i)
            to[i] = floats(c[i]);
    }
}

Interpolation interpolation_of(const world::Curve& curve, int32_t channels) {
    return curve.interpolation.value_or(channels == 1 ? Interpolation::kCubic
                                                      : Interpolation::kLinear);
}

/// Returns a channel of a curve, with numbers as lookups see them.
template <typename Number>
Channel<Number> channel_of(const world::Curve& curve, int32_t channel) {
    Channel<Number> out;
    for (const std::vector<double>& key : curve.keys) {
        out.x.push_back(static_cast<double>(floats(key[0])));
        out.y.push_back(static_cast<double>(floats(key[1 + static_cast<size_t>(channel)])));
    }
    return out;
}

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
    std::vector<float> out(static_cast<size_t>(abi::curve_size(channels)), 0.0F);
    const auto stride = static_cast<size_t>(abi::curve_stride(channels));
    const auto header = static_cast<size_t>(abi::curve_header(channels));
    out[0] = floats(curve.keys.front()[0]);
    out[1] = floats(curve.keys.back()[0]);
    for (size_t k = 0; k < size_t{abi::kCurveKeys}; ++k)
        out[header + k * stride] = k < curve.keys.size() ? floats(curve.keys[k][0]) : abi::kNoKey;
    const Interpolation how = interpolation_of(curve, channels);
    for (int32_t channel = 0; channel < channels; ++channel)
        write_channel(channel_of<double>(curve, channel), how, channels, channel, out.data());
    return out;
}

std::vector<float> curve_change(const world::Curve& curve, int32_t channels, size_t key,
                                int32_t channel) {
    std::vector<float> out(static_cast<size_t>(abi::curve_size(channels)), 0.0F);
    Channel<Moving> one = channel_of<Moving>(curve, channel);
    one.y[key].change = 1;
    write_channel(one, interpolation_of(curve, channels), channels, channel, out.data());
    return out;
}

}  // namespace openfab::part
