// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/parameters.h"

#include <fmt/format.h>

#include <charconv>
#include <string_view>

#include "base/text.h"
#include "tools/viewer/messages.h"

namespace openfab::viewer {

void Parameters::fail(const std::string& name, const std::string& rule) {
    if (failed_.empty()) failed_ = fmt::format(messages::kParameterIs, name, rule);
}

const std::string* Parameters::find(const std::string& name) {
    const auto found = request_.query.find(name);
    return found == request_.query.end() ? nullptr : &found->second;
}

int32_t Parameters::whole(const std::string& name, int32_t least, int32_t most) {
    const std::string* text = find(name);
    int32_t value = least;
    if (text != nullptr) {
        const auto [rest, status] =
            std::from_chars(text->data(), text->data() + text->size(), value);
        if (status == std::errc() && rest == text->data() + text->size() && value >= least &&
            value <= most)
            return value;
    }
    fail(name, fmt::format(messages::kWholeNumberFromTo, least, most));
    return least;
}

int32_t Parameters::whole_or(const std::string& name, int32_t otherwise, int32_t least,
                             int32_t most) {
    return find(name) == nullptr ? otherwise : whole(name, least, most);
}

int32_t Parameters::one_of(const std::string& name, const std::string& words) {
    const std::string* text = find(name);
    int32_t place = 0;
    for (size_t from = 0; text != nullptr && from <= words.size(); ++place) {
        const size_t to = std::min(words.find('|', from), words.size());
        if (std::string_view(words).substr(from, to - from) == *text) return place;
        from = to + 1;
    }
    fail(name, fmt::format(messages::kOneOf, words));
    return 0;
}

Palette Parameters::palette(const std::string& name) {
    Palette palette;
    palette.fill({255, 0, 255, 255});
    palette[0] = {};
    const std::string* text = find(name);
    constexpr size_t kDigits = 8;
    if (text == nullptr || text->empty() || text->size() % kDigits != 0 ||
        text->size() / kDigits > palette.size()) {
        fail(name, messages::kEightHexDigits);
        return palette;
    }
    for (size_t code = 0; code < text->size() / kDigits; ++code) {
        for (size_t c = 0; c < 4; ++c) {
            const char* from = text->data() + code * kDigits + c * 2;
            const auto [rest, status] = std::from_chars(from, from + 2, palette[code][c], 16);
            if (status != std::errc() || rest != from + 2) {
                fail(name, messages::kEightHexDigits);
                return palette;
            }
        }
    }
    return palette;
}

}  // namespace openfab::viewer
