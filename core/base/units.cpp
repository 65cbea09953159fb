// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/units.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "base/allowance.h"
#include "base/messages.h"

namespace openfab {

namespace {

using Unit = std::pair<std::string_view, double>;

template <size_t N>
Result<double> parse_quantity(std::string_view text, const std::array<Unit, N>& units,
                              const char* what, const char* example, std::string_view usual_unit) {
    double number = 0;
    const char* begin = text.data();
    const char* end = begin + text.size();
    auto [rest, status] = std::from_chars(begin, end, number);
    if (status != std::errc() || !std::isfinite(number)) {
        return usage_error(fmt::format(messages::kNotAQuantity, text, what, example));
    }
    std::string_view unit(rest, static_cast<size_t>(end - rest));
    while (!unit.empty() && unit.front() == ' ')
        unit.remove_prefix(1);
    for (const Unit& candidate : units) {
        if (candidate.first == unit) return number * candidate.second;
    }
    const std::string_view digits = text.substr(0, static_cast<size_t>(rest - begin));
    const std::string usual = std::string(digits) + std::string(usual_unit);
    if (unit.empty()) return usage_error(fmt::format(messages::kNoUnit, digits, usual));
    std::string others;
    for (const Unit& candidate : units) {
        if (candidate.first != usual_unit)
            others += (others.empty() ? "" : ", ") + std::string(candidate.first);
    }
    return usage_error(fmt::format(messages::kWrongUnit, text, unit, usual, others));
}

}  // namespace

Result<double> parse_length_mm(std::string_view text) {
    static constexpr std::array<Unit, 5> kUnits{
        {{"mm", 1.0}, {"um", 1e-3}, {"cm", 10.0}, {"m", 1000.0}, {"in", 25.4}}};
    return parse_quantity(text, kUnits, messages::kALength, "0.1mm", "mm");
}

Result<int64_t> parse_bytes(std::string_view text) {
    static constexpr std::array<Unit, 7> kUnits{{{"B", 1.0},
                                                 {"kB", 1e3},
                                                 {"MB", 1e6},
                                                 {"GB", 1e9},
                                                 {"KiB", 1024.0},
                                                 {"MiB", 1048576.0},
                                                 {"GiB", 1073741824.0}}};
    Result<double> bytes = parse_quantity(text, kUnits, messages::kASize, "1.5GB", "MB");
    if (!bytes) return bytes.error();
    if (*bytes < 0 || *bytes > 1e15)
        return usage_error(fmt::format(messages::kNotAMemorySize, text));
    return static_cast<int64_t>(std::llround(*bytes));
}

Result<double> parse_duration(std::string_view text) {
    static constexpr std::array<Unit, 5> kUnits{
        {{"s", 1.0}, {"ms", 1e-3}, {"min", 60.0}, {"m", 60.0}, {"h", 3600.0}}};
    return parse_quantity(text, kUnits, messages::kATime, "10s", "s");
}

std::string format_bytes(int64_t bytes) {
    const double size = static_cast<double>(bytes);
    if (size >= 1e9) return fmt::format("{:.2f} GB", size * 1e-9);
    if (size >= 1e6) return fmt::format("{:.0f} MB", size * 1e-6);
    if (size >= 1e3) return fmt::format("{:.0f} kB", size * 1e-3);
    return fmt::format("{} B", bytes);
}

std::string format_seconds(double seconds) {
    if (seconds < 60) return fmt::format("{:.1f} s", seconds);
    const int64_t whole = std::llround(seconds);
    if (whole < 3600) return fmt::format("{} min {:02d} s", whole / 60, whole % 60);
    return fmt::format("{} h {:02d} min", whole / 3600, whole % 3600 / 60);
}

Result<int64_t> parse_memory_option(const std::string& text) {
    if (text.empty()) return default_memory_bytes();
    Result<int64_t> bytes = parse_bytes(text);
    if (!bytes) return usage_error(fmt::format(messages::kMemoryOption, bytes.error().text()));
    return bytes;
}

}  // namespace openfab
