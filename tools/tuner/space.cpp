// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/tuner/space.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

namespace openfab::tuner {

namespace {

/// Values of a parameter to try: those that are listed, or powers of two in the range and its ends.
std::vector<int64_t> values_of(const schedule::Param& param) {
    if (!param.is_range) return param.choices;
    std::set<int64_t> values = {param.choices.front(), param.choices.back()};
    for (int64_t value = 1; value <= param.choices.back(); value *= 2) {
        if (param.allows(value)) values.insert(value);
    }
    return {values.begin(), values.end()};
}

/// Funcs that one pattern names, and all names that stand for them alone.
struct Group {
    std::string pattern;
    const lower::FuncSites* first = nullptr;
    std::vector<std::string> names;  ///< the pattern, unless it stands for others, too
};

std::vector<Group> groups_of(const std::vector<lower::FuncSites>& sites) {
    std::vector<Group> out;
    for (const lower::FuncSites& func : sites) {
        const std::string pattern = pattern_of(func.func);
        auto known = std::find_if(out.begin(), out.end(),
                                  [&](const Group& group) { return group.pattern == pattern; });
        if (known == out.end()) known = out.insert(out.end(), {pattern, &func, {}});
        known->names.push_back(func.func);
    }
    for (Group& group : out) {
        const std::string stem = group.pattern.substr(0, group.pattern.find('*'));
        const auto others = std::count_if(
            sites.begin(), sites.end(),
            [&](const lower::FuncSites& func) { return func.func.starts_with(stem); });
        if (group.pattern != stem && static_cast<size_t>(others) == group.names.size())
            group.names = {group.pattern};
    }
    // What computes the fablet's values comes last among the Funcs, and takes most of the time.
    std::reverse(out.begin(), out.end());
    return out;
}

Change change_of(const Group& group, const std::string& directive) {
    Change change;
    change.text = fmt::format("{}.{}", group.pattern, directive);
    for (const std::string& name : group.names)
        change.lines.push_back(fmt::format("{}.{}", name, directive));
    return change;
}

}  // namespace

std::string pattern_of(const std::string& func) {
    const std::string name = func.substr(0, func.find('$'));
    const size_t digits = name.find_last_not_of("0123456789");
    const bool numbered = digits + 1 < name.size() && name[digits] == '_';
    return numbered ? name.substr(0, digits + 1) + '*' : name;
}

Space::Space(const schedule::File& file, std::string target, std::map<std::string, int64_t> params,
             const schedule::Schedule& bound, const std::vector<lower::FuncSites>& sites)
    : file_(file), target_(std::move(target)), params_(std::move(params)) {
    add_params(bound);
    add_loops(sites);
    add_placements(sites);
}

void Space::add_params(const schedule::Schedule& bound) {
    for (const schedule::Param& param : bound.params) {
        Knob knob{param.name.text, {}};
        for (const int64_t value : values_of(param)) {
            if (value == param.value) continue;
            knob.changes.push_back(
                {fmt::format("{} = {}", param.name.text, value), {}, value, std::nullopt});
        }
        if (!knob.changes.empty()) knobs_.push_back(std::move(knob));
    }
}

void Space::add_placements(const std::vector<lower::FuncSites>& sites) {
    std::vector<Knob> storing;
    for (const Group& group : groups_of(sites)) {
        Knob knob{"place " + group.pattern, {}};
        const lower::FuncSites& func = *group.first;
        for (size_t k = 0; k < func.sites.size(); ++k) {
            if (k != func.current) knob.changes.push_back(change_of(group, func.sites[k]));
        }
        if (!knob.changes.empty()) knobs_.push_back(std::move(knob));
        if (func.current.value_or(0) == 0) continue;
        std::string outside = func.sites[*func.current - 1];
        outside.replace(0, std::string("compute").size(), "store");
        storing.push_back({"store " + group.pattern, {change_of(group, outside)}});
    }
    knobs_.insert(knobs_.end(), storing.begin(), storing.end());
}

void Space::add_loops(const std::vector<lower::FuncSites>& sites) {
    for (const Group& group : groups_of(sites)) {
        const std::vector<std::string>& loops = group.first->serial_loops;
        if (loops.empty()) continue;
        Knob unroll{"unroll " + group.pattern, {}};
        for (const int copies : {2, 4})
            unroll.changes.push_back(
                change_of(group, fmt::format("unroll({}, {})", loops.front(), copies)));
        knobs_.push_back(std::move(unroll));
        if (!group.first->is_result) continue;
        knobs_.push_back({"parallel " + group.pattern,
                          {change_of(group, fmt::format("parallel({})", loops.back()))}});
    }
    Knob lanes{"lanes", {}};
    for (const int64_t count : {4, 2})
        lanes.changes.push_back({fmt::format("vectors of {}", count), {}, std::nullopt, count});
    knobs_.push_back(std::move(lanes));
}

std::variant<std::string, schedule::Fault> Space::text(const Setting& setting) const {
    schedule::Binding binding{target_, params_};
    std::optional<int64_t> lanes;
    std::string added;
    for (const auto& [knob, index] : setting) {
        const Change& change = knobs_[knob].changes[index];
        if (change.value) binding.params[knobs_[knob].name] = *change.value;
        if (change.lanes) lanes = change.lanes;
        for (const std::string& line : change.lines)
            added += line + '\n';
    }
    auto bound = schedule::bind(file_, binding);
    if (auto* fault = std::get_if<schedule::Fault>(&bound)) return std::move(*fault);
    auto& schedule = std::get<schedule::Schedule>(bound);
    for (schedule::Line& line : schedule.lines) {
        for (schedule::Directive& directive : line.directives) {
            if (!lanes || directive.name.text != "vectorize" || directive.args.size() != 1)
                continue;
            schedule::Word number = directive.args[0];
            number.text = std::to_string(*lanes);
            directive.args.push_back(std::move(number));
        }
    }
    return schedule::text_of(schedule) + added;
}

std::vector<std::string> Space::changes(const Setting& setting) const {
    std::vector<std::string> out;
    for (const auto& [knob, index] : setting)
        out.push_back(knobs_[knob].changes[index].text);
    return out;
}

}  // namespace openfab::tuner
