// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A printer that is known: nominal inks whose dots grow, as a table of measurements.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include "tools/color/chart.h"
#include "tools/color/nominal_inks.h"
#include "tools/color/printer_model.h"

namespace openfab::testing {

class SyntheticPrinter {
  public:
    /// Inks spread: an amount a becomes a + 4 gain a (1 - a), which is 50 % + gain for half, before
    /// all are scaled to 1 again.
    explicit SyntheticPrinter(double gain) : gain_(gain) {}

    color::Lab print(color::Inks inks) const {
        double sum = 0;
        for (double& ink : inks) {
            ink += 4 * gain_ * ink * (1 - ink);
            sum += ink;
        }
        for (double& ink : inks)
            ink /= std::max(sum, 1.0);
        return inks_.predict(inks, 0.5);
    }

    /// The chart as an instrument with this much noise, in Lab, reads it.
    color::SampleTable measured(double noise, uint32_t seed = 1) const {
        color::SampleTable table = color::ink_chart();
        table.has_lab = true;
        std::mt19937 random(seed);
        std::normal_distribution<double> error(0, noise);
        for (color::Sample& s : table.samples) {
            s.lab = print(s.inks);
            if (noise > 0)
                s.lab = {s.lab.l + error(random), s.lab.a + error(random), s.lab.b + error(random)};
        }
        return table;
    }

  private:
    static color::NominalInks inks();

    double gain_;
    color::NominalInks inks_ = inks();
};

/// Random amounts that add up to 1 at most, many of them small.
inline color::Inks random_inks(std::mt19937* random) {
    std::uniform_real_distribution<double> unit(0, 1);
    color::Inks inks;
    double sum = 0;
    for (double& ink : inks) {
        ink = std::pow(unit(*random), 2);
        sum += ink;
    }
    for (double& ink : inks)
        ink /= std::max(sum, 1.0);
    return inks;
}

}  // namespace openfab::testing
