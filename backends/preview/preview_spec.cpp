// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/preview/preview_spec.h"

#include <fmt/format.h>

#include <charconv>
#include <string_view>
#include <vector>

namespace openfab::preview {

namespace {

Result<void> set_view(std::string_view value, PreviewSpec* spec) {
    constexpr std::string_view kSlice = "slice:";
    if (value == "front") {
        spec->view = View::kFront;
    } else if (value == "back") {
        spec->view = View::kBack;
    } else if (value == "section") {
        spec->view = View::kSection;
    } else if (value.starts_with(kSlice)) {
        const std::string_view number = value.substr(kSlice.size());
        auto [rest, status] =
            std::from_chars(number.data(), number.data() + number.size(), spec->slice);
        if (status != std::errc() || rest != number.data() + number.size() || spec->slice < 0) {
            return usage_error(
                fmt::format("`--preview`: `{}` is no slice number; write `view=slice:12`", number));
        }
        spec->view = View::kSlice;
    } else {
        return usage_error(fmt::format(
            "`--preview`: there is no view `{}`; choose from front, back, section, slice:N",
            value));
    }
    return {};
}

}  // namespace

Result<PreviewSpec> parse_preview(const std::string& text) {
    // The file's name may hold commas, so options are taken off the end, as long as they look like
    // some.
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
        return usage_error(fmt::format(
            "`--preview`: `{}` is no name of a .png file; write `--preview card.png,view=back`",
            rest));
    }
    for (std::string_view setting : settings) {
        const std::string_view name = setting.substr(0, setting.find('='));
        const std::string_view value = setting.substr(name.size() + 1);
        if (name == "view") {
            if (Result<void> done = set_view(value, &spec); !done) return done.error();
        } else if (name == "light" && (value == "transmitted" || value == "reflected")) {
            spec.transmitted = value == "transmitted";
        } else if (name == "light") {
            return usage_error(fmt::format(
                "`--preview`: there is no light `{}`; choose from reflected, transmitted", value));
        } else {
            return usage_error(fmt::format(
                "`--preview`: there is no setting `{}`; choose from view, light", name));
        }
    }
    if (spec.transmitted && (spec.view == View::kSection || spec.view == View::kSlice)) {
        return usage_error("`--preview`: light=transmitted goes with view=front or view=back");
    }
    return spec;
}

}  // namespace openfab::preview
