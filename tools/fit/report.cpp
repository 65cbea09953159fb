// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What a fit has found: for people, for programs, and its history.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/json_text.h"
#include "base/text.h"
#include "base/units.h"
#include "tools/fit/fit.h"
#include "tools/fit/messages.h"

namespace openfab::fit {

namespace {

std::string unit_in(const Fit& fit, const Goal& goal) {
    return goal.quantity == Quantity::kCost ? " " + printable(fit.currency) : unit_of(goal);
}

std::string wanted_text(const Wanted& wanted) {
    if (wanted.aim != 0) return wanted.aim < 0 ? "least" : "most";
    if (!wanted.at_least) return fmt::format("<= {:.6g}", *wanted.at_most);
    if (!wanted.at_most) return fmt::format(">= {:.6g}", *wanted.at_least);
    if (*wanted.at_least == *wanted.at_most) return fmt::format("{:.6g}", *wanted.at_least);
    return fmt::format("{:.6g} to {:.6g}", *wanted.at_least, *wanted.at_most);
}

std::string unknown_text(const Unknown& unknown, double value) {
    if (unknown.is_discrete()) return unknown.choices[static_cast<size_t>(value)];
    return fmt::format("{}", static_cast<float>(value));
}

/// What a step from one number to another costs.
std::string difference(double from, double to) {
    if (std::isnan(to)) return "-";
    return from == to ? "0" : fmt::format("{:+.2g}", to - from);
}

}  // namespace

std::string fit_table(const Fit& fit) {
    std::string out;
    for (size_t u = 0; u < fit.unknowns.size(); ++u) {
        const Unknown& unknown = fit.goals.unknowns[u];
        const std::string range = unknown.is_discrete()
                                      ? fmt::format(messages::kOfChoices, unknown.choices.size())
                                      : fmt::format(messages::kFromTo, unknown.min, unknown.max);
        out += fmt::format("{:<30}{}  ({})\n", printable(unknown.name),
                           printable(unknown_text(unknown, fit.unknowns[u])), range);
    }
    out += messages::kHead;
    for (size_t g = 0; g < fit.numbers.size(); ++g) {
        const Goal& goal = fit.goals.goals[g];
        const GoalNumbers& numbers = fit.numbers[g];
        const std::string name = printable(goal.name) + unit_in(fit, goal);
        const std::string wanted = wanted_text(goal.wanted);
        if (fit.interrupted) {
            out += fmt::format("{:<30}{:>14}{:>14.6g}{:>14}\n", name, wanted, numbers.searched,
                               "not counted");
            continue;
        }
        const bool met = std::abs(goal.wanted.beyond(numbers.last())) <= 1;
        const std::string printed =
            std::isnan(numbers.printed) ? "not known" : fmt::format("{:.6g}", numbers.printed);
        out +=
            fmt::format("{:<30}{:>14}{:>14.6g}{:>14}{:>12}{:>12}{}\n", name, wanted, numbers.mixed,
                        printed, difference(numbers.searched, numbers.mixed),
                        difference(numbers.mixed, numbers.printed), met ? "" : messages::kMissed);
    }
    std::string sets;
    std::vector<std::string> settings = fit.given;  // the last of a uniform counts
    settings.insert(settings.end(), fit.settings.begin(), fit.settings.end());
    for (const std::string& setting : settings) {
        const bool plain = setting.find_first_of(" \"'[]{}$`\\*?&|;<>()#~!") == std::string::npos;
        sets += plain ? " --set " + setting : " --set '" + setting + "'";
    }
    const std::string on =
        fit.goals.regions.empty() ? "" : fmt::format(messages::kSearchedOn, fit.search_pitch);
    out += fmt::format(messages::kEffort, fit.history.size(), on,
                       format_seconds(fit.search_seconds), format_seconds(fit.set_up_seconds),
                       fit.rounds, fit.rounds == 1 ? "round" : "rounds");
    out += fmt::format(messages::kSets, printable(sets));
    return out;
}

std::string fit_json(const Fit& fit) {
    JsonText w(JsonText::Layout::kIndentedLists);
    w.begin_object().member("reached", fit.reached).member("interrupted", fit.interrupted);
    w.key("unknowns").begin_object();
    for (size_t u = 0; u < fit.unknowns.size(); ++u) {
        const Unknown& unknown = fit.goals.unknowns[u];
        w.key(unknown.name);
        if (unknown.is_discrete()) {
            const Result<JsonValue> choice =
                parse_json(unknown_text(unknown, fit.unknowns[u]), "choice");
            choice ? w.value(*choice) : w.null();
        } else {
            w.value(fit.unknowns[u]);
        }
    }
    w.end_object().key("goals").begin_array();
    for (size_t g = 0; g < fit.numbers.size(); ++g) {
        const Goal& goal = fit.goals.goals[g];
        const GoalNumbers& numbers = fit.numbers[g];
        w.begin_object().member("name", goal.name);
        const std::string unit = unit_in(fit, goal);
        if (unit.size() > 1) w.member("unit", unit.substr(1));
        if (goal.wanted.at_least) w.member("at_least", *goal.wanted.at_least);
        if (goal.wanted.at_most) w.member("at_most", *goal.wanted.at_most);
        if (goal.wanted.aim != 0) w.member("aim", goal.wanted.aim < 0 ? "least" : "most");
        w.member("within", goal.wanted.within).member("searched", numbers.searched);
        if (!fit.interrupted) {
            w.member("mixtures", numbers.mixed).member("printed", numbers.printed);
            w.member("reached", std::abs(goal.wanted.beyond(numbers.last())) <= 1);
        }
        w.end_object();
    }
    w.end_array().member("rounds", fit.rounds);
    w.member("evaluations", static_cast<int64_t>(fit.history.size()));
    w.member("search_pitch", fit.search_pitch);
    w.member("set_up_seconds", fit.set_up_seconds).member("search_seconds", fit.search_seconds);
    w.key("settings").begin_array();
    for (const std::string& setting : fit.settings)
        w.value(setting);
    w.end_array().key("notes").begin_array();
    for (const std::string& text : fit.notes)
        w.value(text);
    w.end_array().key("history").begin_array();
    for (const Trial& trial : fit.history) {
        w.begin_list();
        for (const auto* numbers : {&trial.unknowns, &trial.values}) {
            for (const double number : *numbers)
                w.value(number);
        }
        w.end_array();
    }
    w.end_array().end_object();
    return w.take() + "\n";
}

std::string history_csv(const Fit& fit) {
    const auto quoted = [](const std::string& name) {
        std::string out = "\"";
        for (const char c : name)
            out += c == '"' ? std::string("\"\"") : std::string(1, c);
        return out + "\"";
    };
    std::string out = "evaluation";
    for (const Unknown& unknown : fit.goals.unknowns)
        out += "," + quoted(unknown.name);
    for (const Goal& goal : fit.goals.goals)
        out += "," + quoted(goal.name + unit_in(fit, goal));
    out += "\n";
    for (size_t n = 0; n < fit.history.size(); ++n) {
        out += fmt::format("{}", n + 1);
        for (size_t u = 0; u < fit.history[n].unknowns.size(); ++u)
            out +=
                "," + (fit.goals.unknowns[u].is_discrete()
                           ? quoted(unknown_text(fit.goals.unknowns[u], fit.history[n].unknowns[u]))
                           : fmt::format("{}", fit.history[n].unknowns[u]));
        for (const double value : fit.history[n].values)
            out += fmt::format(",{}", value);
        out += "\n";
    }
    return out;
}

std::string history_svg(const Fit& fit) {
    // A panel for each goal: its values in order, and what is wanted as a line.
    constexpr double kWidth = 640, kHeight = 140, kLeft = 90, kTop = 24;
    const double all = static_cast<double>(fit.goals.goals.size()) * (kHeight + kTop) + kTop;
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.0f}\" height=\"{:.0f}\" "
        "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" "
        "fill=\"#ffffff\"/>\n",
        kWidth + kLeft + 20, all);
    const auto escaped = [](const std::string& text) {
        std::string safe;
        for (const char c : printable(text))
            safe += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
        return safe;
    };
    for (size_t g = 0; g < fit.goals.goals.size(); ++g) {
        const Goal& goal = fit.goals.goals[g];
        double least = fit.history.front().values[g], most = least;
        const std::optional<double> lines[] = {goal.wanted.at_least, goal.wanted.at_most};
        for (const Trial& trial : fit.history) {
            least = std::min(least, trial.values[g]);
            most = std::max(most, trial.values[g]);
        }
        for (const std::optional<double>& line : lines) {
            least = std::min(least, line.value_or(least));
            most = std::max(most, line.value_or(most));
        }
        const double range = most > least ? most - least : 1;
        const double top = kTop + static_cast<double>(g) * (kHeight + kTop);
        const auto y_of = [&](double value) {
            return top + (kHeight - 20) * (1 - (value - least) / range) + 10;
        };
        const auto count = static_cast<double>(std::max<size_t>(fit.history.size(), 2) - 1);
        out += fmt::format("<text x=\"{}\" y=\"{:.1f}\">{}</text>\n", kLeft, top - 2,
                           escaped(goal.name + unit_in(fit, goal)));
        for (const double value : {least, most})
            out += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{:.4g}</text>\n",
                               kLeft - 6, y_of(value) + 4, value);
        for (const std::optional<double>& line : lines) {
            if (!line) continue;
            out += fmt::format(
                "<line x1=\"{}\" x2=\"{}\" y1=\"{:.1f}\" y2=\"{:.1f}\" "
                "stroke=\"#c03020\" stroke-dasharray=\"4 3\"/>\n",
                kLeft, kLeft + kWidth, y_of(*line), y_of(*line));
        }
        out += "<polyline fill=\"none\" stroke=\"#23415e\" points=\"";
        for (size_t n = 0; n < fit.history.size(); ++n)
            out += fmt::format("{:.1f},{:.1f} ", kLeft + kWidth * static_cast<double>(n) / count,
                               y_of(fit.history[n].values[g]));
        out += "\"/>\n";
    }
    return out + "</svg>\n";
}

}  // namespace openfab::fit
