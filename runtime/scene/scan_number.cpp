// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/scan_number.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace openfab::scene {
namespace {

bool fits_float(double value) {
    return std::isfinite(value) && std::isfinite(static_cast<float>(value));
}

}  // namespace

std::string scan_number(std::string_view token, double* out) {
    std::string_view digits = token;
    if (digits.starts_with('+')) digits.remove_prefix(1);
    const char* last = digits.data() + digits.size();
    const auto [end, code] = std::from_chars(digits.data(), last, *out);
    if (code == std::errc::result_out_of_range && end == last) {
        const bool small = digits.find("e-") != std::string_view::npos ||
                           digits.find("E-") != std::string_view::npos;
        *out = small ? 0 : HUGE_VAL;
    } else if (code != std::errc() || end != last) {
        return fmt::format("`{}` is no number", token.substr(0, 40));
    }
    if (!fits_float(*out))
        return fmt::format("`{}` is not finite or too large", token.substr(0, 40));
    return {};
}

std::string scan_integer(std::string_view token, int64_t least, int64_t most, int64_t* out) {
    const char* last = token.data() + token.size();
    const auto [end, code] = std::from_chars(token.data(), last, *out);
    if (code == std::errc() && end == last && *out >= least && *out <= most) return {};
    return fmt::format("`{}` is no whole number from {} to {}", token.substr(0, 40), least, most);
}

bool is_position(double x, double y, double z) {
    return fits_float(x) && fits_float(y) && fits_float(z);
}

}  // namespace openfab::scene
