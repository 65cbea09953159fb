// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/scan_number.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "base/messages.h"

namespace openfab {
namespace {

/// Compared as doubles: converting an out-of-range double to float is undefined.
bool fits_float(double value) {
    return std::fabs(value) <= std::numeric_limits<float>::max();
}

/// Returns whether a decimal out of the range of double is too large, not too small. Digits count
/// as well as the exponent: 0.00…01 has none.
bool is_large(std::string_view text) {
    const size_t exponent = std::min(text.find_first_of("eE"), text.size());
    const std::string_view digits = text.substr(0, exponent);
    const size_t point = std::min(digits.find('.'), digits.size());
    const size_t first = digits.find_first_of("123456789");
    const int64_t power = static_cast<int64_t>(point) - static_cast<int64_t>(first);
    std::string_view written = text.substr(std::min(exponent + 1, text.size()));
    const bool minus = written.starts_with('-');
    if (minus || written.starts_with('+')) written.remove_prefix(1);
    constexpr int64_t kEnough = int64_t{1} << 60;  // far beyond the length of any text
    int64_t scale = 0;
    for (const char c : written)
        scale = std::min(scale * 10 + (c - '0'), kEnough / 16);
    return power + (minus ? 0 - scale : scale) > 0;
}

}  // namespace

Decimal read_decimal(std::string_view text, double* out) {
    const char* last = text.data() + text.size();
    const auto [end, code] = std::from_chars(text.data(), last, *out);
    if (end != last || code == std::errc::invalid_argument) return Decimal::kNoNumber;
    if (code != std::errc::result_out_of_range) return Decimal::kFine;
    if (is_large(text)) return Decimal::kTooLarge;
    *out = text.starts_with('-') ? -0.0 : 0.0;
    return Decimal::kFine;
}

std::string scan_number(std::string_view token, double* out) {
    std::string_view digits = token;
    if (digits.starts_with('+')) digits.remove_prefix(1);
    const Decimal read = read_decimal(digits, out);
    if (read == Decimal::kNoNumber) return fmt::format(messages::kNotANumber, token.substr(0, 40));
    if (read == Decimal::kTooLarge) *out = HUGE_VAL;
    if (!fits_float(*out)) return fmt::format(messages::kNotFinite, token.substr(0, 40));
    return {};
}

std::string scan_integer(std::string_view token, int64_t least, int64_t most, int64_t* out) {
    const char* last = token.data() + token.size();
    const auto [end, code] = std::from_chars(token.data(), last, *out);
    if (code == std::errc() && end == last && *out >= least && *out <= most) return {};
    return fmt::format(messages::kNotWholeNumber, token.substr(0, 40), least, most);
}

std::string_view take_word(std::string_view* text) {
    constexpr std::string_view kBlanks = " \t\r\n";
    text->remove_prefix(std::min(text->find_first_not_of(kBlanks), text->size()));
    const std::string_view word = text->substr(0, text->find_first_of(kBlanks));
    text->remove_prefix(word.size());
    return word;
}

bool is_position(double x, double y, double z) {
    return fits_float(x) && fits_float(y) && fits_float(z);
}

}  // namespace openfab
