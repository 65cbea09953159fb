// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/printer_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "tools/color/least_squares.h"
#include "tools/color/messages.h"

namespace openfab::color {

namespace {

constexpr size_t kFewestPatches = 16;
constexpr size_t kMostPatches = 1500;  // the fit takes the third power of it
constexpr double kDarkest = 1e-4;      // of a band

// Bradford's cone responses of XYZ, and their inverse.
constexpr double kCones[3][3] = {
    {0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}};
constexpr double kOfCones[3][3] = {{0.9869929, -0.1470543, 0.1599627},
                                   {0.4323053, 0.5183603, 0.0492912},
                                   {-0.0085287, 0.0400428, 0.9684867}};

std::array<double, 3> bands_of(const Lab& lab) {
    const Xyz xyz = to_xyz(lab);
    std::array<double, 3> out{};
    for (size_t i = 0; i < 3; ++i) {
        out[i] =
            std::max(kCones[i][0] * xyz.x + kCones[i][1] * xyz.y + kCones[i][2] * xyz.z, kDarkest);
    }
    return out;
}

Lab lab_of(const std::array<double, 3>& v) {
    std::array<double, 3> xyz{};
    for (size_t i = 0; i < 3; ++i)
        xyz[i] = kOfCones[i][0] * v[0] + kOfCones[i][1] * v[1] + kOfCones[i][2] * v[2];
    return to_lab({std::max(xyz[0], 0.0), std::max(xyz[1], 0.0), std::max(xyz[2], 0.0)});
}

double power(double v, double q) {
    return q == 0 ? std::log(v) : (std::pow(v, q) - 1) / q;
}

double unpower(double h, double q) {
    if (q == 0) return std::exp(h);
    return std::pow(std::max(1 + q * h, 1e-9), 1 / q);
}

double white_share(const Inks& inks) {
    return std::max(1 - (inks[0] + inks[1] + inks[2] + inks[3]), 0.0);
}

Inks roots_of(const Inks& inks) {
    Inks out;
    for (size_t i = 0; i < inks.size(); ++i)
        out[i] = std::sqrt(std::max(inks[i], 0.0));
    return out;
}

double matern(const Inks& a, const Inks& b, double length) {
    double square = 0;
    for (size_t i = 0; i < a.size(); ++i)
        square += (a[i] - b[i]) * (a[i] - b[i]);
    const double r = std::sqrt(3 * square) / length;
    return (1 + r) * std::exp(-r);
}

/// Means of patches of the same amounts, in the order of the first of each.
std::vector<Sample> distinct(const SampleTable& table) {
    std::map<Inks, std::pair<size_t, int>> known;
    std::vector<Sample> out;
    for (const Sample& sample : table.samples) {
        const auto [at, is_new] = known.try_emplace(sample.inks, out.size(), 1);
        if (is_new) {
            out.push_back(sample);
            continue;
        }
        Lab& mean = out[at->second.first].lab;
        const double n = ++at->second.second;
        mean.l += (sample.lab.l - mean.l) / n;
        mean.a += (sample.lab.a - mean.a) / n;
        mean.b += (sample.lab.b - mean.b) / n;
    }
    return out;
}

}  // namespace

Result<PrinterModel> PrinterModel::fit(const SampleTable& table) {
    if (table.is_chart)
        return user_error(messages::kChartNotMeasured, messages::kChartNotMeasuredHelp);
    if (!table.has_inks || !table.has_lab) {
        return user_error(messages::kNoMeasuredPatches, messages::kNoMeasuredPatchesHelp);
    }
    const std::vector<Sample> samples = distinct(table);
    if (samples.size() < kFewestPatches || samples.size() > kMostPatches) {
        return user_error(
            fmt::format(messages::kPatchCount, samples.size(), kFewestPatches, kMostPatches),
            messages::kPatchCountHelp);
    }
    PrinterModel model;
    constexpr std::array<const char*, kInks + 1> kNames = {
        messages::kPureCyan, messages::kPureMagenta, messages::kPureYellow, messages::kPureBlack,
        messages::kNoInk};
    for (size_t i = 0; i <= kInks; ++i) {
        Inks pure{};
        if (i < kInks) pure[i] = 1;
        const auto is_pure = [&](const Sample& s) {
            constexpr double kSlack = 1e-3;
            for (size_t k = 0; k < kInks; ++k) {
                if (std::abs(s.inks[k] - pure[k]) > kSlack) return false;
            }
            return true;
        };
        const auto found = std::find_if(samples.begin(), samples.end(), is_pure);
        if (found == samples.end()) {
            return user_error(fmt::format(messages::kNoPatchOf, kNames[i]),
                              messages::kNoPatchOfHelp);
        }
        model.primaries_[i] = bands_of(found->lab);
        if (i == kInks) model.white_ = found->lab;
    }
    constexpr double kDarkestWhite = 20;
    if (model.white_.l < kDarkestWhite) {
        return user_error(fmt::format(messages::kWhitePatch, model.white_.l),
                          messages::kWhitePatchHelp);
    }
    model.fit_mixing(samples);
    model.fit_residual(samples);
    return model;
}

double PrinterModel::fit_band(const std::vector<Sample>& samples,
                              const std::vector<Bands>& measured, size_t band) {
    const double q = exponent_;
    std::array<double, kInks + 1> pure{};
    for (size_t i = 0; i <= kInks; ++i)
        pure[i] = power(primaries_[i][band], q);
    // Differences of cube roots, since those of the bands themselves see dark patches too little.
    const auto residuals = [&](const std::vector<double>& logs, std::vector<double>* out) {
        std::array<double, kInks> s{};
        for (size_t i = 0; i < kInks; ++i)
            s[i] = std::exp(std::clamp(logs[i], -6.0, 6.0));
        for (size_t j = 0; j < samples.size(); ++j) {
            const Inks& inks = samples[j].inks;
            double weights = white_share(inks), sum = weights * pure[kInks];
            for (size_t i = 0; i < kInks; ++i) {
                weights += inks[i] * s[i];
                sum += inks[i] * s[i] * pure[i];
            }
            (*out)[j] = std::cbrt(unpower(sum / weights, q)) - std::cbrt(measured[j][band]);
        }
    };
    std::vector<double> logs(kInks, 0.0);
    const double error = minimise_squares(residuals, samples.size(), &logs);
    for (size_t i = 0; i < kInks; ++i)
        strengths_[i][band] = std::exp(std::clamp(logs[i], -6.0, 6.0));
    return error;
}

void PrinterModel::fit_mixing(const std::vector<Sample>& samples) {
    std::vector<Bands> measured;
    measured.reserve(samples.size());
    for (const Sample& sample : samples)
        measured.push_back(bands_of(sample.lab));
    std::optional<PrinterModel> best;
    double least = std::numeric_limits<double>::infinity();
    constexpr int kSteps = 10, kLowest = -20;
    for (int step = kLowest; step <= kSteps; ++step) {
        exponent_ = static_cast<double>(step) / kSteps;
        double error = 0;
        for (size_t band = 0; band < 3; ++band)
            error += fit_band(samples, measured, band);
        if (error >= least) continue;
        least = error;
        best = *this;
    }
    if (best) *this = *best;
}

Lab PrinterModel::mix(const Inks& inks) const {
    Bands v{};
    const double white = white_share(inks);
    for (size_t band = 0; band < 3; ++band) {
        double weights = white, sum = white * power(primaries_[kInks][band], exponent_);
        for (size_t i = 0; i < kInks; ++i) {
            const double weight = inks[i] * strengths_[i][band];
            weights += weight;
            sum += weight * power(primaries_[i][band], exponent_);
        }
        v[band] = unpower(sum / weights, exponent_);
    }
    return lab_of(v);
}

void PrinterModel::fit_residual(const std::vector<Sample>& samples) {
    const size_t n = samples.size();
    std::vector<Lab> mixed(n);
    std::vector<std::array<double, 3>> rest(n);
    for (size_t j = 0; j < n; ++j) {
        mixed[j] = mix(samples[j].inks);
        rest[j] = {samples[j].lab.l - mixed[j].l, samples[j].lab.a - mixed[j].a,
                   samples[j].lab.b - mixed[j].b};
        points_.push_back({roots_of(samples[j].inks), {}});
        left_out_.push_back({samples[j].id,
                             samples[j].inks,
                             samples[j].lab,
                             {},
                             0,
                             ciede2000(samples[j].lab, mixed[j])});
    }
    double least = std::numeric_limits<double>::infinity();
    for (const double length : {0.35, 0.7, 1.4}) {
        for (const double noise : {1e-5, 1e-4, 1e-3, 1e-2}) {
            Square kernel(n);
            for (size_t i = 0; i < n; ++i) {
                for (size_t j = 0; j < n; ++j)
                    kernel.at(i, j) = matern(points_[i].roots, points_[j].roots, length);
                kernel.at(i, i) += noise;
            }
            if (!invert_positive(&kernel)) continue;
            std::vector<std::array<double, 3>> weights(n);
            std::vector<LeftOut> left_out = left_out_;
            double sum = 0, worst = 0;
            for (size_t i = 0; i < n; ++i) {
                for (size_t j = 0; j < n; ++j) {
                    for (size_t c = 0; c < 3; ++c)
                        weights[i][c] += kernel.at(i, j) * rest[j][c];
                }
                // What the other patches leave of this one, without fitting them anew (Rasmussen
                // and Williams, "Gaussian Processes for Machine Learning", 2006, 5.12).
                const double own = kernel.at(i, i);
                const Lab& is = samples[i].lab;
                const Lab predicted{is.l - weights[i][0] / own, is.a - weights[i][1] / own,
                                    is.b - weights[i][2] / own};
                const double difference = ciede2000(is, predicted);
                left_out[i].predicted = predicted;
                left_out[i].difference = difference;
                left_out[i].spread = std::sqrt(1 / own);
                sum += difference;
                worst = std::max(worst, difference);
            }
            if (sum >= least) continue;
            least = sum;
            length_ = length;
            left_out_mean_ = sum / static_cast<double>(n);
            left_out_worst_ = worst;
            left_out_ = std::move(left_out);
            for (size_t i = 0; i < n; ++i)
                points_[i].weight = weights[i];
        }
    }
}

Lab PrinterModel::predict(const Inks& inks) const {
    Lab out = mix(inks);
    const Inks roots = roots_of(inks);
    for (const Point& point : points_) {
        const double near = matern(roots, point.roots, length_);
        out.l += near * point.weight[0];
        out.a += near * point.weight[1];
        out.b += near * point.weight[2];
    }
    return out;
}

}  // namespace openfab::color
