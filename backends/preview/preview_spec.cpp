// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/preview/preview_spec.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "backends/preview/messages.h"

namespace openfab::preview {

namespace {

/// Of a view of the model, which is painted slice by slice.
constexpr double kLeastTilt = 5;

/// `model`, `model:TURN` or `model:TURN:TILT`, in degrees.
Result<void> set_angles(std::string_view value, PreviewSpec* spec) {
    double* const angles[2]{&spec->turn_deg, &spec->tilt_deg};
    std::string_view rest = value.substr(std::string_view("model").size());
    for (double* angle : angles) {
        if (rest.empty()) break;
        auto [end, status] = std::from_chars(rest.data() + 1, rest.data() + rest.size(), *angle);
        if (status != std::errc() || rest.front() != ':') break;
        rest = rest.substr(static_cast<size_t>(end - rest.data()));
    }
    const bool usable =
        std::abs(spec->turn_deg) <= 360 && spec->tilt_deg >= kLeastTilt && spec->tilt_deg <= 90;
    if (!rest.empty() || !usable) {
        return usage_error(fmt::format(messages::kNotAModelView, value));
    }
    return {};
}

Result<void> set_view(std::string_view value, PreviewSpec* spec) {
    constexpr std::string_view kSlice = "slice:";
    // Whose sides `openfab view` and `import --side` call so. A view of the model is never level.
    constexpr std::pair<std::string_view, double> kSides[] = {
        {"front", 0}, {"right", 90}, {"back", 180}, {"left", 270}};
    for (const auto& [side, turn_deg] : kSides) {
        if (value != side) continue;
        spec->view = View::kModel;
        spec->turn_deg = turn_deg;
        spec->tilt_deg = kLeastTilt;
        return {};
    }
    if (value == "top") {
        spec->view = View::kTop;
    } else if (value == "bottom") {
        spec->view = View::kBottom;
    } else if (value == "section") {
        spec->view = View::kSection;
    } else if (value.starts_with(kSlice)) {
        const std::string_view number = value.substr(kSlice.size());
        auto [rest, status] =
            std::from_chars(number.data(), number.data() + number.size(), spec->slice);
        if (status != std::errc() || rest != number.data() + number.size() || spec->slice < 0) {
            return usage_error(fmt::format(messages::kNotASliceNumber, number));
        }
        spec->view = View::kSlice;
    } else if (value == "model" || value.starts_with("model:")) {
        spec->view = View::kModel;
        return set_angles(value, spec);
    } else {
        return usage_error(fmt::format(messages::kNoSuchView, value));
    }
    return {};
}

/// Makes the error for a name that does not end in .png; most likely a view without `view=`.
std::string without_png(std::string_view text) {
    const size_t comma = text.rfind(',');
    const std::string_view end = comma == std::string_view::npos ? text : text.substr(comma + 1);
    const std::string_view file = text.substr(0, text.size() - end.size());
    PreviewSpec ignored;
    const bool view = comma != std::string_view::npos && set_view(end, &ignored).has_value();
    if (view || end == "transmitted" || end == "reflected") {
        return fmt::format(messages::kNeedsName, end, file, view ? "view" : "light", end);
    }
    return fmt::format(messages::kNotPng, text);
}

Result<PreviewSpec> parse_settings(PreviewSpec spec,
                                   const std::vector<std::string_view>& settings) {
    for (std::string_view setting : settings) {
        const size_t equals = setting.find('=');
        const std::string_view name = setting.substr(0, equals);
        const std::string_view value =
            equals == std::string_view::npos ? "" : setting.substr(equals + 1);
        if (name == "view") {
            if (Result<void> done = set_view(value, &spec); !done) return done.error();
        } else if (name == "cut" && (value == "x" || value == "y" || value == "xy")) {
            spec.cut = value == "x" ? Cut::kX : value == "y" ? Cut::kY : Cut::kXY;
        } else if (name == "cut") {
            return usage_error(fmt::format(messages::kNoSuchCut, value));
        } else if (name == "light" && (value == "transmitted" || value == "reflected")) {
            spec.transmitted = value == "transmitted";
        } else if (name == "light") {
            return usage_error(fmt::format(messages::kNoSuchLight, value));
        } else {
            return usage_error(fmt::format(messages::kNoSuchSetting, name));
        }
    }
    if (spec.cut != Cut::kNone && spec.view != View::kModel) {
        return usage_error(messages::kCutWithoutModel);
    }
    if (spec.transmitted && spec.view != View::kTop && spec.view != View::kBottom) {
        return usage_error(messages::kLightWithoutSide);
    }
    return spec;
}

}  // namespace

Result<PreviewSpec> parse_preview(const std::string& text) {
    // The file name may contain commas, so options are stripped from the end, as long as they look
    // like options.
    std::string_view rest = text;
    std::vector<std::string_view> settings;
    for (size_t comma = rest.rfind(','); comma != std::string_view::npos; comma = rest.rfind(',')) {
        const std::string_view setting = rest.substr(comma + 1);
        if (setting.find('=') == std::string_view::npos) break;
        settings.push_back(setting);
        rest = rest.substr(0, comma);
    }
    PreviewSpec spec;
    spec.file = rest;
    if (!rest.ends_with(".png") || rest.size() < 5) {
        return usage_error(without_png(rest));
    }
    return parse_settings(std::move(spec), settings);
}

Result<PreviewSpec> parse_view(const std::string& text) {
    std::string_view rest = text;
    std::vector<std::string_view> settings;
    for (size_t comma = rest.find(','); comma != std::string_view::npos; comma = rest.find(',')) {
        settings.push_back(rest.substr(0, comma));
        rest = rest.substr(comma + 1);
    }
    settings.push_back(rest);
    return parse_settings({}, settings);
}

}  // namespace openfab::preview
