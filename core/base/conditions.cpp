// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/conditions.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

#include "base/messages.h"
#include "base/scan_number.h"
#include "base/units.h"

namespace openfab {

namespace {

constexpr double kAbsoluteZero = -273.15;
constexpr size_t kMostRows = 1000;
/// Of conditions as people round them.
constexpr double kSame = 1e-9;

/// Values by logarithm of the rate.
using Rates = std::map<double, double>;

/// Returns the logarithm of a value, linear between the nearest two keys; nothing outside of them.
std::optional<double> between(const std::map<double, double>& logs, double at) {
    const double slack = kSame * std::max(1.0, std::abs(at));
    const auto above = logs.lower_bound(at - slack);
    if (above == logs.end()) return {};
    if (above->first <= at + slack) return above->second;
    if (above == logs.begin()) return {};
    const auto below = std::prev(above);
    const double part = (at - below->first) / (above->first - below->first);
    return below->second + part * (above->second - below->second);
}

class Table {
  public:
    Table(const JsonValue& list, const std::string& name, const std::string& file)
        : list_(list), name_(name), file_(file) {}

    Result<double> at(const Conditions& asked) {
        if (Result<void> done = read(); !done) return done.error();
        if (!asked.temperature_C && by_temperature_.size() > 1)
            return wrong(list_,
                         fmt::format(messages::kTemperatureWanted, name_, lowest_temperature(),
                                     highest_temperature()),
                         messages::kTemperatureWantedHelp);
        if (!asked.rate_1_s && least_rate_ < most_rate_)
            return wrong(list_,
                         fmt::format(messages::kRateWanted, name_, std::exp(least_rate_),
                                     std::exp(most_rate_)),
                         messages::kRateWantedHelp);
        const double temperature = asked.temperature_C.value_or(lowest_temperature());
        std::map<double, double> logs;
        for (const auto& [each, rates] : by_temperature_) {
            const double rate = asked.rate_1_s ? std::log(*asked.rate_1_s) : rates.begin()->first;
            if (const std::optional<double> log = between(rates, rate)) logs[each] = *log;
        }
        if (const std::optional<double> log = between(logs, temperature)) return std::exp(*log);
        return wrong(
            list_, fmt::format(messages::kConditionOutside, name_, conditions_text(asked)),
            fmt::format(messages::kConditionOutsideHelp, lowest_temperature(),
                        highest_temperature(), std::exp(least_rate_), std::exp(most_rate_)));
    }

  private:
    Error wrong(const JsonValue& at, std::string what, std::string help = {}) const {
        return error_at({file_, at.line, at.column}, std::move(what), std::move(help));
    }
    double lowest_temperature() const { return by_temperature_.begin()->first; }
    double highest_temperature() const { return by_temperature_.rbegin()->first; }
    static std::string conditions_text(const Conditions& asked) {
        std::string out;
        if (asked.temperature_C) out = fmt::format("{:g} C", *asked.temperature_C);
        if (asked.rate_1_s)
            out += fmt::format("{}{:g}/s", out.empty() ? "" : " and ", *asked.rate_1_s);
        return out;
    }

    Result<void> read() {
        if (list_.items.empty() || list_.items.size() > kMostRows)
            return wrong(list_, fmt::format(messages::kConditionRows, name_, kMostRows));
        for (const JsonValue& item : list_.items) {
            std::array<double, 3> numbers{};
            constexpr std::array<const char*, 3> kKeys{"T_C", "rate_1_s", "value"};
            for (size_t i = 0; i < kKeys.size(); ++i) {
                const JsonMember* number = item.find(kKeys[i]);
                if (item.members.size() != kKeys.size() || number == nullptr ||
                    !number->value.is(JsonValue::Kind::kNumber) ||
                    !std::isfinite(number->value.number))
                    return wrong(item, messages::kConditionRow);
                numbers[i] = number->value.number;
            }
            const auto [temperature, rate, value] = numbers;
            if (!(temperature > kAbsoluteZero && rate > 0 && value > 0))
                return wrong(item, messages::kConditionRow);
            const double log_rate = std::log(rate);
            if (!by_temperature_[temperature].emplace(log_rate, std::log(value)).second)
                return wrong(item, fmt::format(messages::kConditionTwice, temperature, rate));
            least_rate_ = std::min(least_rate_, log_rate);
            most_rate_ = std::max(most_rate_, log_rate);
        }
        return {};
    }

    const JsonValue& list_;
    const std::string& name_;
    const std::string& file_;
    std::map<double, Rates> by_temperature_;
    double least_rate_ = HUGE_VAL, most_rate_ = -HUGE_VAL;
};

/// Returns the number before a unit, or nothing where the text has another unit.
std::optional<double> number_before(std::string_view text, std::string_view unit) {
    if (!text.ends_with(unit)) return {};
    double out = 0;
    const std::string number(text.substr(0, text.size() - unit.size()));
    if (read_decimal(number, &out) != Decimal::kFine || !std::isfinite(out)) return {};
    return out;
}

}  // namespace

Result<double> parse_temperature(const std::string& text) {
    const std::optional<double> out = number_before(text, "C");
    if (!out || !(*out > kAbsoluteZero))
        return usage_error(fmt::format(messages::kTemperatureText, text));
    return *out;
}

Result<double> parse_rate(const std::string& text) {
    std::optional<double> out = number_before(text, "/s");
    if (const std::optional<double> hertz = number_before(text, "Hz"))
        out = 2 * std::numbers::pi * *hertz;
    if (!out) {
        const Result<double> seconds = parse_duration(text);
        if (seconds && *seconds > 0) out = 1 / *seconds;
    }
    if (!out || !(*out > 0)) return usage_error(fmt::format(messages::kRateText, text));
    return *out;
}

Result<Conditions> parse_conditions(const std::string& temperature, const std::string& rate) {
    Conditions out;
    if (!temperature.empty()) {
        const Result<double> number = parse_temperature(temperature);
        if (!number) return number.error();
        out.temperature_C = *number;
    }
    if (!rate.empty()) {
        const Result<double> number = parse_rate(rate);
        if (!number) return number.error();
        out.rate_1_s = *number;
    }
    return out;
}

Result<ConditionedNumber> number_at(const JsonValue& value, const std::string& name,
                                    const Conditions& asked, const std::string& file) {
    if (value.is(JsonValue::Kind::kArray)) {
        const Result<double> out = Table(value, name, file).at(asked);
        if (!out) return out.error();
        return ConditionedNumber{*out, true};
    }
    if (!value.is(JsonValue::Kind::kNumber) || !std::isfinite(value.number))
        return error_at({file, value.line, value.column},
                        fmt::format(messages::kNumberOrList, name));
    if (!(value.number > 0))
        return error_at({file, value.line, value.column},
                        fmt::format(messages::kNumberNotAboveZero, name, value.number));
    return ConditionedNumber{value.number, false};
}

}  // namespace openfab
