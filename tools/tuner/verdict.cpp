// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/tuner/verdict.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace openfab::tuner {

namespace {

/// Quantiles of Student's distribution: 99 % lie below, for 1, 2, … degrees of freedom.
constexpr std::array kQuantiles{31.821, 6.965, 4.541, 3.747, 3.365, 3.143, 2.998, 2.896,
                                2.821,  2.764, 2.718, 2.681, 2.650, 2.624, 2.602, 2.583,
                                2.567,  2.552, 2.539, 2.528, 2.518, 2.508, 2.500, 2.492};

/// To the geometric mean of the first schedule's two: noise alone then is as often above 1 as below.
double ratio_of(const Triple& triple) {
    return triple.contender / std::sqrt(triple.before * triple.after);
}

struct Moments {
    double mean = 0, deviation = 0;
};

Moments moments_of(const std::vector<double>& values) {
    const auto count = static_cast<double>(values.size());
    Moments out;
    for (const double value : values)
        out.mean += value / count;
    for (const double value : values)
        out.deviation += (value - out.mean) * (value - out.mean);
    out.deviation = std::sqrt(out.deviation / std::max(1.0, count - 1));
    return out;
}

}  // namespace

Verdict judge(const std::vector<std::vector<Triple>>& runs) {
    Verdict verdict;
    verdict.runs = static_cast<int32_t>(runs.size());
    if (runs.empty()) return verdict;
    verdict.places = static_cast<int32_t>(runs.front().size());
    std::vector<double> ratios, noise;
    std::vector<Triple> by_place(runs.front().size());
    for (const std::vector<Triple>& run : runs) {
        Triple all;
        for (size_t p = 0; p < run.size(); ++p) {
            for (Triple* sum : {&all, &by_place[p]}) {
                sum->before += run[p].before;
                sum->contender += run[p].contender;
                sum->after += run[p].after;
            }
        }
        ratios.push_back(std::log(ratio_of(all)));
        noise.push_back(std::log(all.after / all.before));
    }
    const Moments seen = moments_of(ratios);
    verdict.ratio = std::exp(seen.mean);
    verdict.bound = std::numeric_limits<double>::infinity();
    if (runs.size() > 1) {
        const double deviation = std::max(seen.deviation, moments_of(noise).deviation);
        const double quantile = kQuantiles[std::min(runs.size() - 2, kQuantiles.size() - 1)];
        verdict.bound = std::exp(seen.mean + quantile * deviation /
                                                 std::sqrt(static_cast<double>(runs.size())));
    }
    std::vector<double> places;
    for (const Triple& sum : by_place)
        places.push_back(ratio_of(sum));
    const auto [least, most] = std::minmax_element(places.begin(), places.end());
    verdict.of_places = {*least, *most};
    const auto less =
        std::count_if(places.begin(), places.end(), [](double ratio) { return ratio < 1; });
    verdict.faster = verdict.ratio <= 1 - kLeastGain && verdict.bound < 1 &&
                     5 * static_cast<size_t>(less) >= 4 * places.size();
    return verdict;
}

}  // namespace openfab::tuner
