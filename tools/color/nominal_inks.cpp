// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/nominal_inks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/scan_number.h"
#include "tools/color/messages.h"
#include "tools/color/read_named.h"

namespace openfab::color {

namespace {

constexpr int64_t kLargestFile = 1 << 20;
constexpr std::array<std::string_view, 5> kNames = {"cyan", "magenta", "yellow", "black", "white"};

// Of a resin of refractive index 1.5: what the surface throws back of light from outside that falls
// straight in, and of diffuse light from inside (Saunderson, "Calculation of the color of pigmented
// plastics", JOSA 32, 1942).
constexpr double kMirrored = 0.04;
constexpr double kKeptInside = 0.6;

/// Reflectance of a layer as thick as light goes.
double reflectance_of_thick(double k, double s) {
    const double a = 1 + k / s;
    return a - std::sqrt(a * a - 1);
}

/// Reflectance of a layer over a ground (Kubelka, JOSA 38, 1948).
double reflectance_of_layer(double k, double s, double thickness, double ground) {
    const double a = 1 + k / s, b = std::sqrt(a * a - 1);
    const double x = b * s * thickness;
    if (b < 1e-9) {  // nothing is absorbed: the limit of the formula below
        const double t = s * thickness;
        return (ground + (1 - ground) * t) / (1 + (1 - ground) * t);
    }
    const double coth = 1 / std::tanh(x);
    return (1 - ground * (a - b * coth)) / (a - ground + b * coth);
}

std::string_view trim(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r";
    const size_t begin = std::min(text.find_first_not_of(kBlanks), text.size());
    const size_t end = text.find_last_not_of(kBlanks);
    return end == std::string_view::npos ? std::string_view() : text.substr(begin, end - begin + 1);
}

}  // namespace

Result<NominalInks> NominalInks::parse(std::string_view text) {
    NominalInks out;
    std::array<bool, kNames.size()> found{};
    int number = 0;
    for (size_t at = 0; at < text.size();) {
        const size_t end = std::min(text.find('\n', at), text.size());
        std::string_view line = text.substr(at, end - at);
        at = end + 1;
        ++number;
        line = trim(line.substr(0, line.find('#')));
        if (line.empty() || line.starts_with("material,")) continue;
        const auto bad = [&](const std::string& what) {
            return user_error(fmt::format(messages::kLineOf, number, what),
                              messages::kNominalLineHelp);
        };
        std::vector<std::string_view> words;
        for (size_t from = 0; from <= line.size();) {
            const size_t to = std::min(line.find(',', from), line.size());
            words.push_back(trim(line.substr(from, to - from)));
            from = to + 1;
        }
        const auto name = std::find(kNames.begin(), kNames.end(), words[0]);
        if (name == kNames.end()) return bad(fmt::format(messages::kUnknownMaterial, words[0]));
        if (words.size() != 7) return bad(fmt::format(messages::kNotSevenValues, words.size()));
        const auto m = static_cast<size_t>(name - kNames.begin());
        found[m] = true;
        for (size_t i = 0; i < 6; ++i) {
            double value = 0;
            const bool scatters = i >= 3;
            if (!scan_number(words[i + 1], &value).empty() || value < 0 || value > 1e4 ||
                (scatters && value < 1e-3))
                return bad(fmt::format(messages::kNotACoefficient, words[i + 1]));
            Band& band = out.bands_[m][i % 3];
            (scatters ? band.scattering : band.absorption) = value;
        }
    }
    for (size_t m = 0; m < kNames.size(); ++m) {
        if (!found[m]) return user_error(fmt::format(messages::kNominalMissing, kNames[m]));
    }
    return out;
}

Result<NominalInks> NominalInks::read(const std::filesystem::path& file) {
    return read_named(file, kLargestFile, [](const std::string& text) { return parse(text); });
}

Lab NominalInks::predict(const Inks& inks, double skin_mm) const {
    double white = 1;
    for (const double ink : inks)
        white -= ink;
    // From radiative transfer of isotropic scattering to two diffuse fluxes: K = 2 sigma_a, S = 3/4
    // sigma_s. Coefficients of a mixture add up by volume.
    constexpr double kOfAbsorption = 2, kOfScattering = 0.75;
    Rgb linear;
    for (size_t c = 0; c < 3; ++c) {
        const Band& core = bands_[kMaterials - 1][c];
        double absorption = std::max(white, 0.0) * core.absorption;
        double scattering = std::max(white, 0.0) * core.scattering;
        for (size_t i = 0; i < inks.size(); ++i) {
            absorption += inks[i] * bands_[i][c].absorption;
            scattering += inks[i] * bands_[i][c].scattering;
        }
        const double ground =
            reflectance_of_thick(kOfAbsorption * core.absorption, kOfScattering * core.scattering);
        const double inner = reflectance_of_layer(kOfAbsorption * absorption,
                                                  kOfScattering * scattering, skin_mm, ground);
        linear[c] = (1 - kMirrored) * (1 - kKeptInside) * inner / (1 - kKeptInside * inner);
    }
    return to_lab(xyz_of_linear(linear));
}

}  // namespace openfab::color
