// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/patch_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tools/color/messages.h"

namespace openfab::color {

namespace {

// In a chart that is right, mixtures at the border are off by up to 10.
constexpr double kSurely = 13;
// Of repeated patches and pure inks, which all others are mixed of.
constexpr double kOfRepeated = 8, kOfPure = 10;

/// Differences, and what is usual of them in a table.
class Differences {
  public:
    explicit Differences(const std::vector<LeftOut>& patches) {
        // Noise of measurements raises both.
        constexpr double kLeast = 6, kTimes = 5;
        above_ = std::max(kLeast, kTimes * upper_quarter(patches, unexplained));
        unit_ = upper_quarter(patches, relative);
    }

    /// Whether a patch is looked at.
    bool is_strange(const LeftOut& patch) const {
        return unexplained(patch) > above_ || is_unexpected(patch);
    }
    bool is_surely(const LeftOut& patch) const {
        return unexplained(patch) > std::max(kSurely, 2 * above_) || is_unexpected(patch);
    }
    /// Whether a patch is off by far more than how far its neighbours are explains.
    bool is_unexpected(const LeftOut& patch) const {
        constexpr double kTimes = 9, kLeast = 10;  // right charts have 8 at most
        return patch.difference > std::max(kLeast, above_) && relative(patch) > kTimes * unit_;
    }

  private:
    /// What neither the other patches nor the mixing of inks explains. Where inks change colours fastest the other patches alone
    /// are off by 10, as they are few there, and mixing alone is where dots grow.
    static double unexplained(const LeftOut& patch) {
        return std::min(patch.difference, patch.of_mixing);
    }
    static double relative(const LeftOut& patch) { return patch.difference / patch.spread; }

    static double upper_quarter(const std::vector<LeftOut>& patches,
                                double (*value)(const LeftOut&)) {
        std::vector<double> all;
        for (const LeftOut& patch : patches)
            all.push_back(value(patch));
        const auto at = all.begin() + static_cast<std::ptrdiff_t>(all.size() * 3 / 4);
        std::nth_element(all.begin(), at, all.end());
        return *at;
    }

    double above_ = 0, unit_ = 0;
};

bool is_pure(const Inks& inks) {
    constexpr double kSlack = 1e-3;
    const double most = *std::max_element(inks.begin(), inks.end());
    double sum = 0;
    for (const double ink : inks)
        sum += ink;
    return sum < kSlack || most > 1 - kSlack;
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Takes patches out of a table whose repetitions say something else.
std::vector<LeftOut> take_strays(const PrinterModel& model, SampleTable* table) {
    std::map<Inks, std::vector<const Sample*>> groups;
    for (const Sample& sample : table->samples)
        groups[sample.inks].push_back(&sample);
    std::vector<LeftOut> out;
    std::set<const Sample*> strays;
    for (const LeftOut& patch : model.left_out()) {
        const std::vector<const Sample*>& group = groups[patch.inks];
        if (group.size() < 2) continue;
        Lab is = patch.predicted;  // of two, the other patches say which is right
        if (group.size() > 2) {
            const auto middle = [&](double Lab::*of) {
                std::vector<double> values;
                for (const Sample* sample : group)
                    values.push_back(sample->lab.*of);
                return median(std::move(values));
            };
            is = {middle(&Lab::l), middle(&Lab::a), middle(&Lab::b)};
        } else if (ciede2000(group[0]->lab, group[1]->lab) < kOfRepeated) {
            continue;
        }
        const auto off = [&](const Sample* sample) { return ciede2000(sample->lab, is); };
        const auto worst =
            std::max_element(group.begin(), group.end(),
                             [&](const Sample* a, const Sample* b) { return off(a) < off(b); });
        for (const Sample* sample : group) {
            const bool stray = group.size() > 2 ? off(sample) > kOfRepeated : sample == *worst;
            if (!stray) continue;
            strays.insert(sample);
            LeftOut& one = out.emplace_back(patch);
            one.id = sample->id, one.measured = sample->lab, one.predicted = is;
            one.difference = one.of_mixing = off(sample);
        }
    }
    std::vector<Sample> kept;
    for (const Sample& sample : table->samples)
        if (strays.count(&sample) == 0) kept.push_back(sample);
    table->samples = std::move(kept);
    return out;
}

/// Puts what others predict of pure inks that are out of line in their place, since all others are mixed of them.
std::vector<LeftOut> replace_pure(SampleTable* table, PrinterModel* model) {
    std::vector<LeftOut> out;
    const auto replace = [&](const LeftOut& patch) {
        for (Sample& sample : table->samples)
            if (sample.inks == patch.inks) sample.lab = patch.predicted;
        if (Result<PrinterModel> again = PrinterModel::fit(*table); again) *model = *again;
    };
    // Returns how well the others go together once a patch is what they predict.
    const auto mean_with = [&](const LeftOut& patch) {
        SampleTable other = *table;
        for (Sample& sample : other.samples)
            if (sample.inks == patch.inks) sample.lab = patch.predicted;
        const Result<PrinterModel> again = PrinterModel::fit(other);
        return again ? again->left_out_mean() : model->left_out_mean();
    };
    constexpr size_t kMost = 5;
    while (out.size() < kMost) {
        const Differences usual(model->left_out());
        std::optional<LeftOut> worst, mixture;
        for (const LeftOut& patch : model->left_out()) {
            if (!usual.is_unexpected(patch)) continue;
            std::optional<LeftOut>& of = is_pure(patch.inks) ? worst : mixture;
            if (!of || patch.difference > of->difference) of = patch;
        }
        if (!worst || worst->difference <= kOfPure) break;
        // A wedge's step beside a pure ink throws suspicion on it.
        if (mixture && mean_with(*mixture) < mean_with(*worst)) worst = mixture;
        replace(*worst);
        // What others predict is better without what was wrong.
        for (const LeftOut& patch : model->left_out()) {
            if (patch.inks != worst->inks) continue;
            worst->predicted = patch.predicted;
            worst->difference = worst->of_mixing = ciede2000(worst->measured, worst->predicted);
        }
        replace(*worst);
        out.push_back(*worst);
    }
    return out;
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

PatchCheck check_patches(const SampleTable& table, const PrinterModel& whole) {
    PatchCheck out;
    SampleTable rest = table;
    PrinterModel model = whole;
    const auto strange_of = [&] {
        const Differences usual(model.left_out());
        std::vector<LeftOut> strange;
        for (const LeftOut& patch : model.left_out())
            if (usual.is_strange(patch)) strange.push_back(patch);
        return strange;
    };
    // So many are no single mistakes, and what is predicted is as wrong.
    constexpr double kMostMean = 6;
    constexpr size_t kMostShare = 4;
    if (model.left_out_mean() > kMostMean || strange_of().size() * kMostShare > model.patches()) {
        out.disordered = true;
        out.out_of_line = strange_of();
        return out;
    }
    constexpr double kMostOfWhite = 13;
    if (std::hypot(model.white().a, model.white().b) > kMostOfWhite)
        out.tinted_white = model.white();
    const std::vector<LeftOut> strays = take_strays(model, &rest);
    if (!strays.empty())
        if (Result<PrinterModel> again = PrinterModel::fit(rest); again) model = *again;
    const std::vector<LeftOut> pure = replace_pure(&rest, &model);
    std::vector<LeftOut> strange = strange_of();
    if (!strange.empty()) predict_anew(rest, &strange);
    const Differences usual(model.left_out());
    const size_t judged = strange.size();
    strange.insert(strange.end(), pure.begin(), pure.end());
    strange.insert(strange.end(), strays.begin(), strays.end());
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
    for (size_t k = 0; k < strange.size(); ++k)
        if (k >= judged || usual.is_surely(strange[k])) out.out_of_line.push_back(strange[k]);
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
    if (check.tinted_white)
        out.push_back(fmt::format(messages::kWhiteIsTinted, check.tinted_white->l,
                                  check.tinted_white->a, check.tinted_white->b));
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
