// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/stated_light.h"

#include <algorithm>
#include <cmath>

#include "base/scan_number.h"
#include "tools/color/lab.h"
#include "tools/color/table_text.h"

namespace openfab::color {

namespace {

constexpr std::string_view kDigits = "0123456789";

bool holds(std::string_view text, std::string_view words) {
    return text.find(words) != std::string_view::npos;
}

/// Returns the first whole number of a text, or -1.
int first_number(std::string_view text) {
    text.remove_prefix(std::min(text.find_first_of(kDigits), text.size()));
    text = text.substr(0, text.find_first_not_of(kDigits));
    double value = 0;
    return scan_number(text, &value).empty() && value < 1e6 ? static_cast<int>(value) : -1;
}

std::string_view behind(std::string_view text, size_t at) {
    text.remove_prefix(std::min(at, text.size()));
    text.remove_prefix(std::min(text.find_first_not_of(" \t=:,"), text.size()));
    return text;
}

}  // namespace

void StatedLight::note_other(std::string_view text) {
    if (other_.empty()) other_ = text;
}

void StatedLight::take_light(std::string_view text) {
    constexpr std::string_view kRight = "D50";
    const std::string name = upper(text);
    if (name.find_first_not_of(" \t-") == std::string::npos || name == "NONE") return;
    const size_t at = name.find(kRight);
    if (at == std::string::npos && !name.starts_with("5000") && !name.starts_with("5003"))
        return note_other(text);
    // `D50/10`
    if (at != std::string::npos && first_number(behind(name, at + kRight.size())) == 10)
        note_other(text);
}

/// `2 degree`, `10`, `CIE 1931 2 degree`, `CIE 1964`
void StatedLight::take_observer(std::string_view text) {
    const int number = first_number(text);
    if (number == 10 || number == 1964) note_other(text);
}

/// `Illumination=D50 ObserverAngle=2 WhiteBase=Absolute`, as X-Rite's programs have it.
void StatedLight::take_source(std::string_view text) {
    const std::string name = upper(text);
    const auto value = [&](std::string_view key) {
        const size_t at = name.find(key);
        if (at == std::string::npos) return std::string_view();
        // The key's own rest, as in `ObserverAngle`.
        const size_t equals = name.find_first_of("=:", at);
        if (equals == std::string::npos) return std::string_view();
        const std::string_view rest = behind(text, equals);
        return rest.substr(0, rest.find_first_of(" \t,;"));
    };
    take_light(value("ILLUM"));
    take_observer(value("OBSERVER"));
    const std::string white = upper(value("WHITEBASE"));
    relative_ = relative_ || white.starts_with("PAP") || white.starts_with("REL");
}

void StatedLight::take(std::string_view keyword, const std::vector<std::string_view>& values) {
    const std::string key = upper(keyword);
    if (values.empty()) return;
    std::string all;
    for (const std::string_view value : values)
        all += (all.empty() ? "" : " ") + std::string(value);
    if (key == "WEIGHTING_FUNCTION") {
        // `"ILLUMINANT, D65"`, `"OBSERVER, 10 degree"`
        const std::string name = upper(all);
        const size_t light = name.find("ILLUMINANT"), observer = name.find("OBSERVER");
        if (light != std::string::npos) {
            const std::string_view text =
                behind(all, light + std::string_view("ILLUMINANT").size());
            take_light(text.substr(0, text.find_first_of(",;")));
        }
        if (observer != std::string::npos) take_observer(std::string_view(all).substr(observer));
    } else if (key == "ILLUMINANT_WHITE_POINT_XYZ") {
        // `"95.106486 100.000000 108.844025"`, as Argyll has it.
        std::string_view text = all;
        std::array<double, 3> white{};
        for (double& v : white)
            if (!scan_number(take_word(&text), &v).empty()) return;
        constexpr double kSlack = 0.02;
        if (std::abs(white[0] / white[1] - kD50.x) > kSlack ||
            std::abs(white[2] / white[1] - kD50.z) > kSlack)
            note_other(all);
    } else if (key == "MEASUREMENT_SOURCE") {
        take_source(all);
    } else if (key == "ILLUMINATION_NAME" || key == "ILLUMINANT" || key == "ILLUMINATION") {
        take_light(all);
    } else if (holds(key, "OBSERVER")) {
        take_observer(all);
    }
}

}  // namespace openfab::color
