// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/spectra.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "base/scan_number.h"
#include "base/text.h"
#include "tools/color/cie_tables.h"
#include "tools/color/messages.h"

namespace openfab::color {

namespace {

using Tristimulus = std::array<double, 3>;

/// Interpolates by the cubic through four neighbours, Lagrange's.
double reflected_at(const Wavelengths& at, const std::vector<double>& reflected, double nm) {
    const double place = (nm - at.first) / at.step;
    const auto last = static_cast<double>(at.count - 1);
    if (place <= 0) return reflected.front();
    if (place >= last) return reflected.back();
    const double begin = std::clamp(std::floor(place) - 1, 0.0, last - 3);
    double sum = 0;
    for (size_t i = 0; i < 4; ++i) {
        double weight = 1;
        for (size_t k = 0; k < 4; ++k) {
            if (k == i) continue;
            weight *= (place - begin - static_cast<double>(k)) /
                      (static_cast<double>(i) - static_cast<double>(k));
        }
        sum += weight * reflected[static_cast<size_t>(begin) + i];
    }
    return sum;
}

/// Returns the wavelength that a column's name says, and its unit where it says one; 0 for other columns.
std::pair<double, double> wavelength_of(std::string_view column) {
    const std::string name = lower_ascii(std::string(column));
    std::string_view rest = name;
    const size_t digits = std::min(rest.find_first_of("0123456789"), rest.size());
    std::string_view word = rest.substr(0, digits);
    rest.remove_prefix(digits);
    while (word.ends_with('_') || word.ends_with(' ') || word.ends_with('-'))
        word.remove_suffix(1);
    const bool by_suffix = rest.ends_with("nm");
    if (by_suffix) rest.remove_suffix(2);
    while (rest.ends_with('_') || rest.ends_with(' '))
        rest.remove_suffix(1);
    constexpr std::array<std::string_view, 13> kWords = {
        "",         "spec",         "spectral",     "nm", "spectral_nm", "spectralnm",  "spec_nm",
        "spectrum", "spectral_pct", "spectral_dec", "r",  "refl",        "reflectance",
    };
    if (std::find(kWords.begin(), kWords.end(), word) == kWords.end()) return {};
    double nm = 0;
    constexpr double kShortest = 300, kLongest = 1100;
    if (!scan_number(rest, &nm).empty() || !(nm >= kShortest && nm <= kLongest)) return {};
    return {nm, word == "spectral_pct" ? 100 : word == "spectral_dec" ? 1 : 0};
}

}  // namespace

Result<void> Wavelengths::check() const {
    constexpr double kSlack = 1e-6, kCoarsest = 20, kBegin = 400, kEnd = 700;
    const double last = first + step * (static_cast<double>(count) - 1);
    if (count >= 4 && step > 0 && step <= kCoarsest + kSlack && first <= kBegin + kSlack &&
        last >= kEnd - kSlack)
        return {};
    return user_error(fmt::format(messages::kSpectrumTooShort, count, first, last),
                      messages::kSpectrumTooShortHelp);
}

double unit_of_reflectances(double largest) {
    constexpr double kMostOfLight = 3;  // what fluoresces gives more than it takes there
    return largest > kMostOfLight ? 100 : 1;
}

Lab lab_of_spectrum(const Wavelengths& at, const std::vector<double>& reflected, Light light) {
    Tristimulus sum{}, white{};
    double nm = kCieFirst;
    for (const CieRow& row : kCieRows) {
        const double power = light == Light::kD50 ? row.d50 : row.d65;
        const double share = std::max(reflected_at(at, reflected, nm), 0.0);
        const Tristimulus observer = {row.x, row.y, row.z};
        for (size_t c = 0; c < 3; ++c) {
            white[c] += power * observer[c];
            sum[c] += power * observer[c] * share;
        }
        nm += kCieStep;
    }
    const double whole = white[1];
    return to_lab({sum[0] / whole, sum[1] / whole, sum[2] / whole},
                  {white[0] / whole, 1, white[2] / whole});
}

Result<SpectralColumns> SpectralColumns::find(const std::vector<std::string>& columns) {
    std::vector<std::pair<double, int>> found;
    SpectralColumns out;
    for (size_t k = 0; k < columns.size(); ++k) {
        const auto [nm, unit] = wavelength_of(columns[k]);
        if (nm == 0) continue;
        found.emplace_back(nm, static_cast<int>(k));
        if (unit > 0) out.unit_ = unit;
    }
    // A few numbers are names of other things.
    constexpr size_t kFewest = 8;
    if (found.size() < kFewest) return out;
    std::sort(found.begin(), found.end());
    const double first = found.front().first;
    const double step = (found.back().first - first) / static_cast<double>(found.size() - 1);
    for (size_t k = 0; k < found.size(); ++k) {
        // Names are rounded to whole nanometres.
        constexpr double kRounded = 0.51;
        const double wanted = first + step * static_cast<double>(k);
        if (std::abs(found[k].first - wanted) <= kRounded && step > kRounded) {
            out.columns_.push_back(found[k].second);
            continue;
        }
        const auto name = [&](size_t at) { return columns[static_cast<size_t>(found[at].second)]; };
        for (size_t i = 1; i < found.size(); ++i) {
            if (found[i].first == found[i - 1].first)
                return user_error(fmt::format(messages::kWavelengthTwice, name(i - 1), name(i)),
                                  messages::kWavelengthTwiceHelp);
        }
        return user_error(fmt::format(messages::kWavelengthsUneven, name(k), wanted));
    }
    out.wavelengths_ = {first, step, found.size()};
    if (Result<void> fine = out.wavelengths_.check(); !fine) return fine.error();
    return out;
}

}  // namespace openfab::color
