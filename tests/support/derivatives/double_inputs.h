// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Central differences of a volume's fractions in double, the oracle of derivatives.

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "compiler/interp/evaluate_double.h"
#include "compiler/ir/arithmetic.h"

namespace openfab::testing {

/// Inputs of a volume stage at one voxel.
class DoubleInputs : public interp::DoubleEnvironment {
  public:
    using Key = std::tuple<int32_t, int32_t, int32_t>;
    std::map<Key, double> numbers;       ///< by kind, a and b; 0 where there is none
    std::map<int32_t, uint32_t> others;  ///< bits of uniforms that are no floats
    /// Answers queries: the result's kind, its component, and the point.
    std::function<double(int32_t kind, int32_t b, std::span<const double, 3> point)> surface;

    /// Sets all uniforms to their defaults.
    void set_defaults(const ir::Fablet& fablet) {
        for (const ir::Uniform& u : fablet.uniforms) {
            for (size_t k = 0; k < u.default_bits.size(); ++k) {
                const auto at = u.first_index + static_cast<int32_t>(k);
                if (u.type == ir::Type::kFloat) {
                    numbers[{OPENFAB_ARG_UNIFORM, at, 0}] = ir::as_float(u.default_bits[k]);
                } else {
                    others[at] = u.default_bits[k];
                }
            }
        }
    }
    double& uniform(int32_t index) { return numbers[{OPENFAB_ARG_UNIFORM, index, 0}]; }

    double number(int32_t kind, int32_t a, int32_t b) const override {
        const auto found = numbers.find({kind, a, b});
        return found == numbers.end() ? 0 : found->second;
    }
    uint32_t bits(int32_t kind, int32_t a, int32_t b) const override {
        if (kind != OPENFAB_ARG_UNIFORM)
            return static_cast<uint32_t>(static_cast<int64_t>(number(kind, a, b)));
        const auto found = others.find(a);
        return found == others.end() ? 0 : found->second;
    }
    interp::TextureView texture(int32_t /*index*/) const override { return {}; }
    double query(const ir::Instr& /*query*/, const ir::Instr& result,
                 std::span<const double, 3> point) const override {
        return surface ? surface(result.kind, result.b, point) : 0;
    }
};

/// The fractions of a volume's slots.
inline std::vector<double> fractions_of(const ir::Stage& volume, const DoubleInputs& inputs) {
    std::vector<double> out = interp::evaluate_double(volume, inputs);
    double sum = 0;
    for (double& amount : out) {
        if (!(amount > 0)) amount = 0;
        sum += amount;
    }
    for (double& amount : out)
        amount = sum > 0 ? amount / sum : 0;
    return out;
}

/// Central differences by a uniform, extrapolated from two steps; nothing where they, or those of either side, disagree:
/// there the fractions jump or bend.
inline std::optional<std::vector<double>> differences(const ir::Stage& volume, DoubleInputs inputs,
                                                      int32_t uniform) {
    const double at = inputs.uniform(uniform);
    const double step = 1e-5 * std::max(1.0, std::fabs(at));
    const auto moved = [&](double by) {
        inputs.uniform(uniform) = at + by;
        return fractions_of(volume, inputs);
    };
    const std::vector<double> middle = moved(0), wide_up = moved(step), wide_down = moved(-step),
                              up = moved(step / 2), down = moved(-step / 2);
    std::vector<double> out;
    for (size_t k = 0; k < middle.size(); ++k) {
        const double wide = (wide_up[k] - wide_down[k]) / (2 * step);
        const double near = (up[k] - down[k]) / step;
        const double left = (middle[k] - down[k]) / (step / 2),
                     right = (up[k] - middle[k]) / (step / 2);
        const double size = std::max(std::fabs(near), 1e-3 / std::max(1.0, std::fabs(at)));
        const bool smooth =
            std::fabs(wide - near) < 1e-5 * size && std::fabs(left - right) < 1e-2 * size;
        if (!smooth || !std::isfinite(near)) return std::nullopt;
        out.push_back(near + (near - wide) / 3);
    }
    return out;
}

}  // namespace openfab::testing
