// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fit/print_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "base/say.h"
#include "program/cost.h"
#include "program/progress.h"
#include "tools/fit/messages.h"
#include "world/world.h"

namespace openfab::fit {

namespace {

/// Choices that are searched through, of all unknowns that have some together.
constexpr size_t kMostChoices = 1000;

/// Returns a curve with other values of its keys, as worlds write it.
std::string curve_text(const world::Curve& curve, std::span<const double> values) {
    std::string keys;
    size_t next = 0;
    for (const std::vector<double>& key : curve.keys) {
        keys += fmt::format("{}[{}", keys.empty() ? "" : ", ", key[0]);
        for (size_t k = 1; k < key.size(); ++k)
            keys += fmt::format(", {}", static_cast<float>(values[next++]));
        keys += "]";
    }
    const char* how = curve.interpolation ? world::interpolation_name(*curve.interpolation) : "";
    return fmt::format("{{\"keys\": [{}]{}}}", keys,
                       curve.interpolation ? fmt::format(", \"interpolation\": \"{}\"", how) : "");
}

/// Says with which values of the unknowns a print was none.
Error with_settings(Error error, const std::vector<std::string>& settings) {
    if (error.code != ErrorCode::kUserInput) return error;
    error.message.insert(0, fmt::format(messages::kWithSettings, fmt::join(settings, "`, `")));
    if (!error.help.empty()) error.help += "; ";
    error.help += messages::kWithSettingsHelp;
    return error;
}

}  // namespace

Result<std::unique_ptr<PrintValues>> PrintValues::create(const program::Options& print,
                                                         const driver::ScheduleOptions& schedules,
                                                         const std::string& goals,
                                                         const std::atomic<bool>& interrupt) {
    std::unique_ptr<PrintValues> out(new PrintValues(print, interrupt));
    if (Result<void> done = out->set_up(schedules, goals); !done) return done.error();
    return out;
}

Result<void> PrintValues::set_up(const driver::ScheduleOptions& schedules,
                                 const std::string& goals) {
    auto workload = tuner::Workload::create(print_, schedules);
    if (!workload) return workload.error();
    workload_ = std::move(*workload);
    auto loaded = workload_->compile(workload_->program_options());
    if (const auto* fault = std::get_if<lower::Fault>(&loaded)) return workload_->report(*fault);
    program_ = std::move(std::get<std::unique_ptr<lower::LoadedProgram>>(loaded));
    print_ = workload_->print();
    const Result<world::World> world = world::load_world(
        print_.input, world::rules_of(print_.allow, print_.memory_bytes), world::MeshFiles::kSkip);
    if (!world) return world.error();
    Result<Goals> read = read_goals(goals, *world, program_->fablets(), print_.settings);
    if (!read) return read.error();
    goals_ = std::move(*read);
    filled_.assign(goals_.regions.size(), false);
    size_t choices = 1;
    for (const Unknown& unknown : goals_.unknowns) {
        if (unknown.is_discrete()) choices *= unknown.choices.size();
        if (choices > kMostChoices)
            return error_at(unknown.location, fmt::format(messages::kTooManyChoices, kMostChoices));
    }
    // Support is no part of what fablets mix, but costs something.
    if (!goals_.ask_cost()) print_.support = "off";
    auto kept = program::KeptPrint::create(print_, program_->fablets(), interrupt_);
    if (!kept) return kept.error();
    kept_ = std::move(*kept);
    for (const Region& region : goals_.regions) {
        if (region.object.empty() || objects_.contains(region.object)) continue;
        program::Options alone = print_;
        alone.only_object = region.object;
        auto object = program::KeptPrint::create(alone, program_->fablets(), interrupt_);
        if (!object) return object.error();
        objects_[region.object] = std::move(*object);
    }
    if (!std::ranges::all_of(goals_.goals, &Goal::is_amount)) {
        auto mechanics =
            MechanicsValues::create(print_, kept_->info(program::SumPitch::kPrinter).pitch_mm);
        if (!mechanics) return mechanics.error();
        mechanics_ = std::move(*mechanics);
    }
    if (Result<void> done = set_up_slopes(); !done) return done;
    const auto paid = std::ranges::find(goals_.goals, Quantity::kCost, &Goal::quantity);
    if (paid == goals_.goals.end()) return {};
    const auto cost = cost_of(std::vector<double>(kept_->world().materials.size()));
    if (!cost) {
        return error_at(paid->location, fmt::format(messages::kNoPrices, kept_->printer().name),
                        messages::kNoPricesHelp);
    }
    currency_ = cost->currency;
    return {};
}

Box3d PrintValues::extent_mm() const {
    const pipeline::PrintInfo& info = kept_->info(program::SumPitch::kPrinter);
    Box3d out{info.origin_mm, info.origin_mm};
    for (int axis = 0; axis < 3; ++axis)
        out.hi[axis] += info.size[axis] * info.pitch_mm[axis];
    return out;
}

double PrintValues::search_pitch() const {
    return kept_->info(program::SumPitch::kCoarse).pitch_mm.x /
           kept_->info(program::SumPitch::kPrinter).pitch_mm.x;
}

std::map<std::string, std::vector<size_t>> PrintValues::regions_by_object() const {
    std::map<std::string, std::vector<size_t>> out;
    for (size_t r = 0; r < goals_.regions.size(); ++r)
        out[goals_.regions[r].object].push_back(r);
    return out;
}

Result<std::vector<program::RegionSums>> PrintValues::amounts(
    const std::vector<std::string>& settings, program::SumPitch pitch, bool printed) {
    std::vector<program::RegionSums> out(goals_.regions.size());
    for (const auto& [object, regions] : regions_by_object()) {
        std::vector<program::SumRegion> asked;
        for (const size_t r : regions)
            asked.push_back(goals_.regions[r].voxels);
        program::KeptPrint& print = object.empty() ? *kept_ : *objects_.at(object);
        auto sums = print.sums(settings, asked, pitch, printed);
        if (!sums) return with_settings(sums.error(), settings);
        for (size_t k = 0; k < regions.size(); ++k) {
            out[regions[k]] = std::move((*sums)[k]);
            const std::vector<double>& ml = out[regions[k]].mixed_ml;
            if (std::ranges::any_of(ml, [](double one) { return one > 0; }))
                filled_[regions[k]] = true;
        }
    }
    return out;
}

std::optional<pipeline::PrintCost> PrintValues::cost_of(const std::vector<double>& ml) const {
    const pipeline::PrintInfo& info = kept_->info(program::SumPitch::kPrinter);
    std::vector<double> by_code{0};
    by_code.insert(by_code.end(), ml.begin(), ml.end());
    return program::print_cost(kept_->printer(), info, info.slice_end - info.slice_begin, by_code);
}

/// Returns the value of a goal for millilitres by material.
double PrintValues::value_of(const Goal& goal, const std::vector<double>& ml) const {
    // A support of its own, which comes last, is neither weighed nor measured, but paid.
    const std::vector<world::Material>& materials = kept_->world().materials;
    double all = 0, of = 0;
    for (size_t m = 0; m < materials.size(); ++m) {
        const double amount =
            ml[m] * (goal.quantity == Quantity::kWeight ? materials[m].density_g_cm3 : 1);
        all += amount;
        if (goal.material < 0 || static_cast<size_t>(goal.material) == m) of += amount;
    }
    switch (goal.quantity) {
        case Quantity::kShare:
            return all > 0 ? of / all : 0;
        case Quantity::kVolume:
        case Quantity::kWeight:
            return of;
        case Quantity::kCost: {
            const std::optional<pipeline::PrintCost> cost = cost_of(ml);
            return cost ? cost->money : 0;
        }
        case Quantity::kProperty:
        case Quantity::kMoved:
        case Quantity::kDeflection:
        case Quantity::kWork:
        case Quantity::kOhm:
        case Quantity::kKelvinPerWatt:
        case Quantity::kYoung:
        case Quantity::kPoisson:
        case Quantity::kStiffness:
            break;
    }
    return 0;
}

std::vector<double> PrintValues::unknowns_at(std::span<const double> x,
                                             const Choices& choices) const {
    std::vector<double> out;
    size_t next = 0;
    for (size_t u = 0; u < goals_.unknowns.size(); ++u) {
        const Unknown& unknown = goals_.unknowns[u];
        if (unknown.is_discrete()) {
            out.push_back(static_cast<double>(choices[u]));
            continue;
        }
        const double value = unknown.min + x[next++] * (unknown.max - unknown.min);
        // As it is written: the nearest float, never beyond its bounds.
        out.push_back(std::clamp(double{static_cast<float>(value)}, unknown.min, unknown.max));
    }
    return out;
}

std::vector<std::string> PrintValues::settings_of(const std::vector<double>& unknowns) const {
    std::map<std::string, std::vector<double>> numbers;
    std::map<std::string, const world::Curve*> curves;
    std::map<std::string, std::string> texts;
    for (size_t u = 0; u < unknowns.size(); ++u) {
        const Unknown& unknown = goals_.unknowns[u];
        const std::string name = unknown.object + "." + unknown.uniform;
        if (unknown.is_discrete()) {
            texts[name] = unknown.choices[static_cast<size_t>(unknowns[u])];
            continue;
        }
        auto& values = numbers.try_emplace(name, unknown.now).first->second;
        values[static_cast<size_t>(std::max(unknown.component, 0))] = unknowns[u];
        if (unknown.curve) curves[name] = &*unknown.curve;
    }
    for (const auto& [name, values] : numbers) {
        if (const auto curve = curves.find(name); curve != curves.end()) {
            texts[name] = curve_text(*curve->second, values);
            continue;
        }
        std::string text;
        for (const double value : values)
            text += fmt::format("{}{}", text.empty() ? "" : ", ", static_cast<float>(value));
        texts[name] = values.size() == 1 ? text : "[" + text + "]";
    }
    std::vector<std::string> out;
    for (const auto& [name, text] : texts)
        out.push_back(fmt::format("{}={}", name, text));
    return out;
}

Result<std::vector<double>> PrintValues::searched(const std::vector<double>& unknowns) {
    if (const auto known = known_.find(unknowns); known != known_.end()) return known->second;
    const std::vector<std::string> settings = settings_of(unknowns);
    const auto amounts = this->amounts(settings, program::SumPitch::kCoarse, goals_.ask_cost());
    if (!amounts) return amounts.error();
    std::vector<double> values;
    for (const Goal& goal : goals_.goals) {
        if (goal.is_amount()) {
            values.push_back(mixed_value(goal, (*amounts)[goal.region]));
            continue;
        }
        const Result<double> solved =
            mechanics_->value(goal, settings, MechanicsValues::Elements::kAsked);
        if (!solved) return solved.error();
        values.push_back(*solved);
    }
    history_.push_back({unknowns, values});
    known_[unknowns] = values;
    show_progress();
    return values;
}

double PrintValues::mixed_value(const Goal& goal, const program::RegionSums& sums) const {
    return goal.quantity == Quantity::kProperty ? sums.mixed_mean : value_of(goal, mixed_ml(sums));
}

std::vector<double> PrintValues::mixed_ml(const program::RegionSums& sums) const {
    std::vector<double> out = sums.mixed_ml;
    for (size_t m = kept_->world().materials.size(); m < sums.printed_ml.size(); ++m)
        out[m] = sums.printed_ml[m];
    return out;
}

void PrintValues::show_progress() const {
    if (print_.progress == program::ProgressMode::kNone || history_.size() % 100 != 0) return;
    say(fmt::format(messages::kProgress, history_.size()));
}

Result<PrintValues::Counted> PrintValues::count(const std::vector<double>& unknowns) {
    const std::vector<std::string> settings = settings_of(unknowns);
    const auto amounts = this->amounts(settings, program::SumPitch::kPrinter, true);
    if (!amounts) return amounts.error();
    Counted out;
    for (const Goal& goal : goals_.goals) {
        if (goal.is_amount()) {
            out.mixed.push_back(mixed_value(goal, (*amounts)[goal.region]));
            const program::RegionSums& sums = (*amounts)[goal.region];
            out.printed.push_back(goal.quantity == Quantity::kProperty
                                      ? sums.printed_mean
                                      : value_of(goal, sums.printed_ml));
            continue;
        }
        const Result<double> mixed =
            mechanics_->value(goal, settings, MechanicsValues::Elements::kHalf);
        if (!mixed) return mixed.error();
        out.mixed.push_back(*mixed);
        const Result<double> printed =
            mechanics_->value(goal, settings, MechanicsValues::Elements::kPrinted);
        if (!printed && printed.error().code == ErrorCode::kInterrupted) return printed.error();
        if (!printed)
            out.notes.push_back(
                fmt::format(messages::kNotPrinted, goal.name, printed.error().message));
        out.printed.push_back(printed ? *printed : std::numeric_limits<double>::quiet_NaN());
    }
    return out;
}

}  // namespace openfab::fit
