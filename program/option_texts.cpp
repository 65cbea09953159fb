// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/option_texts.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <system_error>

#include "base/units.h"
#include "program/messages.h"
#include "runtime/pipeline/print_options.h"

namespace openfab::program {

namespace {

template <typename T>
bool parse_number(std::string_view text, T* value) {
    auto [rest, status] = std::from_chars(text.data(), text.data() + text.size(), *value);
    return status == std::errc() && rest == text.data() + text.size() && !text.empty();
}

/// `A:B`
template <typename T, typename Parse>
Result<Vec2<T>> parse_range(const char* option, const std::string& text, const char* example,
                            const Parse& parse) {
    const size_t colon = text.find(':');
    if (colon == std::string::npos) return bad_value(option, text, messages::kNotARange, example);
    const Result<T> from = parse(text.substr(0, colon));
    if (!from) return from.error();
    const Result<T> to = parse(text.substr(colon + 1));
    if (!to) return to.error();
    return Vec2<T>{*from, *to};
}

}  // namespace

Error bad_value(std::string_view option, std::string_view text, std::string_view what,
                std::string_view example) {
    return usage_error(fmt::format(messages::kBadValue, option, text, what, option, example));
}

Result<double> parse_length(std::string_view option, const std::string& text) {
    Result<double> mm = parse_length_mm(text);
    if (!mm) return usage_error(fmt::format(messages::kOfOption, option, mm.error().text()));
    return mm;
}

Result<Vec2<double>> parse_dpi(const std::string& text) {
    const size_t x = text.find('x');
    Vec2<double> dpi;
    const std::string_view all(text);
    const bool fine =
        x == std::string::npos
            ? parse_number(all, &dpi.x) && parse_number(all, &dpi.y)
            : parse_number(all.substr(0, x), &dpi.x) && parse_number(all.substr(x + 1), &dpi.y);
    if (!fine) return bad_value("--dpi", text, messages::kNotAResolution, "600x300");
    return dpi;
}

Result<Vec2<double>> parse_heights(const std::string& text) {
    return parse_range<double>("--z", text, "3mm:5mm",
                               [](const std::string& part) { return parse_length("--z", part); });
}

Result<Vec2<int32_t>> parse_slices(const std::string& text) {
    const std::string from_start = text.starts_with(':') && text.size() > 1 ? "0" + text : text;
    const std::string whole = from_start.ends_with(':') && from_start.size() > 1
                                  ? fmt::format("{}{}", from_start, pipeline::kToTheEnd)
                                  : from_start;
    return parse_range<int32_t>(
        "--slices", whole, "0:64", [&](const std::string& part) -> Result<int32_t> {
            int32_t value = 0;
            if (parse_whole(part, &value)) return value;
            return bad_value("--slices", text, messages::kNotARange, "0:64");
        });
}

Result<Vec2<int32_t>> parse_part(const std::string& text) {
    const size_t slash = text.find('/');
    Vec2<int32_t> part;
    if (slash != std::string::npos && parse_whole(text.substr(0, slash), &part.x) &&
        parse_whole(text.substr(slash + 1), &part.y))
        return part;
    return bad_value("--part", text, messages::kNotAPart, "3/4");
}

Result<Vec3d> parse_vector(std::string_view option, const std::string& text,
                           std::string_view example) {
    Vec3d out;
    size_t from = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const size_t to = axis < 2 ? text.find(',', from) : text.size();
        const bool fine =
            to != std::string::npos && from <= to &&
            parse_number(std::string_view(text).substr(from, to - from), &out[axis]) &&
            std::isfinite(out[axis]);
        if (!fine) return bad_value(option, text, messages::kNotThreeNumbers, example);
        from = to + 1;
    }
    return out;
}

bool parse_whole(std::string_view text, int32_t* value) {
    return parse_number(text, value);
}

bool parse_whole(std::string_view text, uint64_t* value) {
    return parse_number(text, value);
}

}  // namespace openfab::program
