// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/patch_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tools/color/messages.h"

namespace openfab::color {

namespace {

/// What neither the other patches nor the mixing of inks explains. Where inks change colours fastest the
/// other patches alone are off by 10, as they are few there, and mixing alone is where dots grow.
double unexplained(const LeftOut& patch) {
    return std::min(patch.difference, patch.of_mixing);
}

/// Above it a patch is looked at; noise of measurements raises it.
double strange_above(const std::vector<LeftOut>& patches) {
    std::vector<double> all;
    for (const LeftOut& patch : patches)
        all.push_back(unexplained(patch));
    const auto at = all.begin() + static_cast<std::ptrdiff_t>(all.size() * 3 / 4);
    std::nth_element(all.begin(), at, all.end());
    constexpr double kLeast = 6, kTimes = 5;
    return std::max(kLeast, kTimes * *at);
}

/// Predicts patches by all others than these.
void predict_anew(const SampleTable& table, std::vector<LeftOut>* patches) {
    std::set<Inks> strange;
    for (const LeftOut& patch : *patches)
        strange.insert(patch.inks);
    SampleTable rest = table;
    std::erase_if(rest.samples,
                  [&](const Sample& sample) { return strange.count(sample.inks) > 0; });
    // Without white or a pure ink there is no model; then what is known stays.
    const Result<PrinterModel> model = PrinterModel::fit(rest);
    if (!model) return;
    for (LeftOut& patch : *patches) {
        patch.predicted = model->predict(patch.inks);
        patch.difference = ciede2000(patch.measured, patch.predicted);
    }
}

}  // namespace

PatchCheck check_patches(const SampleTable& table, const PrinterModel& model) {
    PatchCheck out;
    const std::vector<LeftOut>& patches = model.left_out();
    const double above = strange_above(patches);
    std::vector<LeftOut> strange;
    for (const LeftOut& patch : patches)
        if (unexplained(patch) > above) strange.push_back(patch);
    // So many are no single mistakes, and what is predicted is as wrong.
    constexpr double kMostMean = 6;
    constexpr size_t kMostShare = 4;
    out.disordered =
        model.left_out_mean() > kMostMean || strange.size() * kMostShare > patches.size();
    if (out.disordered) out.out_of_line = strange;
    if (out.disordered || strange.empty()) return out;
    predict_anew(table, &strange);
    std::vector<bool> paired(strange.size());
    for (size_t i = 0; i < strange.size(); ++i) {
        for (size_t k = i + 1; k < strange.size() && !paired[i]; ++k) {
            const LeftOut &a = strange[i], &b = strange[k];
            const double as_is = a.difference + b.difference;
            const double other =
                ciede2000(a.measured, b.predicted) + ciede2000(b.measured, a.predicted);
            constexpr double kBetter = 3;
            if (paired[k] || other * kBetter > as_is) continue;
            paired[i] = paired[k] = true;
            out.exchanged.emplace_back(a, b);
        }
    }
    // In a chart that is right, mixtures at the border are off by up to 10.
    constexpr double kSurely = 13;
    for (const LeftOut& patch : strange)
        if (unexplained(patch) > std::max(kSurely, 2 * above)) out.out_of_line.push_back(patch);
    std::stable_sort(
        out.out_of_line.begin(), out.out_of_line.end(),
        [](const LeftOut& a, const LeftOut& b) { return a.difference > b.difference; });
    return out;
}

std::vector<std::string> format_patches(const PatchCheck& check, size_t patches) {
    std::vector<std::string> out;
    if (check.disordered) {
        out.push_back(fmt::format(messages::kPatchesDisordered,
                                  std::max<size_t>(check.out_of_line.size(), 1), patches));
        return out;
    }
    constexpr size_t kMost = 5;
    for (size_t k = 0; k < std::min(kMost, check.out_of_line.size()); ++k) {
        const LeftOut& p = check.out_of_line[k];
        out.push_back(fmt::format(messages::kPatchOutOfLine, p.id, p.measured.l, p.measured.a,
                                  p.measured.b, p.predicted.l, p.predicted.a, p.predicted.b,
                                  p.difference));
    }
    if (check.out_of_line.size() > kMost)
        out.push_back(fmt::format(messages::kPatchesOutOfLine, check.out_of_line.size() - kMost));
    if (check.exchanged.empty()) return out;
    std::string pairs;
    for (size_t k = 0; k < std::min(kMost, check.exchanged.size()); ++k) {
        const auto& [a, b] = check.exchanged[k];
        pairs += fmt::format("{}`{}` and `{}`", k > 0 ? ", " : "", a.id, b.id);
    }
    if (check.exchanged.size() > kMost) {
        const auto& [a, b] = check.exchanged.back();
        pairs += fmt::format(", … `{}` and `{}`", a.id, b.id);
    }
    out.push_back(fmt::format(messages::kPatchesExchanged, pairs));
    return out;
}

}  // namespace openfab::color
