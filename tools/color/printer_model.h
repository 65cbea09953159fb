// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A model of a printer's colours, fitted to a measured chart: amounts of ink to Lab. Two parts:
//
//   mixing    in each band v (cone responses by Bradford's matrix) the inks' own colours P_i are
//             averaged after a power, (v^q - 1) / q, with weights a_i s_i that tell how strong an
//             ink is there. One exponent q covers what inks do: 1 is Neugebauer, 1 / n is Yule and
//             Nielsen, 0 is Beer and Lambert, below 0 pigments in white, as in Kubelka and Munk.
//   residual  what is left in Lab, interpolated by a Gaussian process (Matérn 3/2 of the roots of
//             amounts); its noise and length are those that predict left-out patches best.

#include <array>
#include <string>
#include <vector>

#include "base/result.h"
#include "tools/color/samples.h"

namespace openfab::color {

/// A patch against the prediction from all others.
struct LeftOut {
    std::string id;
    Inks inks{};
    Lab measured, predicted;
    double difference = 0;  ///< CIEDE2000
    /// Same as `difference` of what mixing alone says, which no single patch turns.
    double of_mixing = 0;
    /// How far off the prediction may be expected to be, in a unit of the model's: more where the others are far.
    double spread = 1;
};

class PrinterModel {
  public:
    /// Fails where white or a pure ink is missing, or where there are too few patches.
    static Result<PrinterModel> fit(const SampleTable& table);

    /// Returns the colour of amounts that add up to 1 at most.
    Lab predict(const Inks& inks) const;
    /// Returns the measured white.
    const Lab& white() const { return white_; }
    double exponent() const { return exponent_; }
    /// Return differences (CIEDE2000) between each patch and what the others predict for it.
    double left_out_mean() const { return left_out_mean_; }
    double left_out_worst() const { return left_out_worst_; }
    size_t patches() const { return points_.size(); }
    /// In the order of the table, those of the same amounts once.
    const std::vector<LeftOut>& left_out() const { return left_out_; }

  private:
    static constexpr size_t kInks = 4;
    using Bands = std::array<double, 3>;
    struct Point {
        Inks roots{};
        std::array<double, 3> weight{};
    };

    PrinterModel() = default;
    Lab mix(const Inks& inks) const;
    double fit_band(const std::vector<Sample>& samples, const std::vector<Bands>& measured,
                    size_t band);
    void fit_mixing(const std::vector<Sample>& samples);
    void fit_residual(const std::vector<Sample>& samples);

    Lab white_;
    double exponent_ = 1;
    std::array<Bands, kInks + 1> primaries_{};  ///< white is the last
    std::array<Bands, kInks> strengths_{};
    double length_ = 1;
    std::vector<Point> points_;
    std::vector<LeftOut> left_out_;
    double left_out_mean_ = 0, left_out_worst_ = 0;
};

}  // namespace openfab::color
