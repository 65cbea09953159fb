// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/check_print.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/color.h"

namespace openfab::color {

void Differences::add(double difference, const std::string& id) {
    ++count;
    mean += (difference - mean) / static_cast<double>(count);
    if (difference <= worst) return;
    worst = difference;
    worst_id = id;
}

Result<PrintCheck> check_print(const SampleTable& chart, const PrintedChart& printed,
                               const PrinterProfile& profile) {
    PrintCheck out;
    out.of_colours = !chart.has_inks;
    out.voxels = printed.voxels;
    std::vector<Inks> asked;
    if (out.of_colours) {
        std::vector<Rgb> colours;
        for (const Sample& sample : chart.samples)
            colours.push_back(sample.rgb);
        Result<std::vector<Inks>> inks = profile.to_inks(colours, Intent::kRelative, false);
        if (!inks) return inks.error();
        for (const Inks& one : *inks)
            asked.push_back(limited(one, 1));
    } else {
        for (const Sample& sample : chart.samples)
            asked.push_back(sample.inks);
    }
    const Result<std::vector<Lab>> ideal = profile.to_lab(asked, false);
    if (!ideal) return ideal.error();
    const Result<std::vector<Lab>> is = profile.to_lab(printed.patches, false);
    if (!is) return is.error();
    out.report = chart;
    out.report.has_inks = out.report.has_lab = true;
    for (size_t k = 0; k < chart.samples.size(); ++k) {
        const Sample& sample = chart.samples[k];
        out.report.samples[k].inks = printed.patches[k];
        out.report.samples[k].lab = (*is)[k];
        out.amounts.add(ciede2000((*ideal)[k], (*is)[k]), sample.id);
        if (out.of_colours) {
            Rgb linear;
            for (size_t c = 0; c < 3; ++c)
                linear[c] = srgb_to_linear(sample.rgb[c]);
            const Lab wanted = to_lab(xyz_of_linear(linear));
            constexpr double kReached = 2;
            const double difference = ciede2000(wanted, (*is)[k]);
            out.all.add(difference, sample.id);
            if (ciede2000(wanted, (*ideal)[k]) <= kReached) out.reached.add(difference, sample.id);
        } else {
            for (size_t i = 0; i < asked[k].size(); ++i)
                out.most_off =
                    std::max(out.most_off, std::abs(asked[k][i] - printed.patches[k][i]));
        }
    }
    return out;
}

std::string format_check(const PrintCheck& check) {
    const auto line = [](const std::string& what, const Differences& d) {
        return fmt::format("{}: {:.2f} in the mean of {}, {:.2f} at worst (patch {})\n", what,
                           d.mean, d.count, d.worst, d.worst_id);
    };
    std::string out = fmt::format(
        "{} patches of {} voxels or more; differences are CIEDE2000, relative to the print's "
        "white\n",
        check.report.samples.size(), check.voxels);
    if (check.of_colours) {
        out += line("colours asked, colours of the print", check.all);
        out += line("  of those that the inks reach", check.reached);
        out += line("inks of the profile, inks of the print", check.amounts);
    } else {
        out += line("inks asked, inks of the print", check.amounts);
        out += fmt::format("an amount is off by {:.2f} % of the voxels at most\n",
                           check.most_off * 100);
    }
    return out;
}

}  // namespace openfab::color
