// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fit/fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "backends/common/output_file.h"
#include "base/clock.h"
#include "base/say.h"
#include "program/interrupt.h"
#include "tools/fit/messages.h"
#include "tools/tuner/workload.h"
#include "world/edit/world_edit.h"

namespace openfab::fit {

namespace {

namespace fs = std::filesystem;

/// The second round aims off by what the first print was off; a third gains nothing but where steps are large.
constexpr int32_t kMostRounds = 3;
/// From where dependence is looked for, besides the start.
constexpr int32_t kOtherStarts = 3;

/// Splits the words of a print: the file of goals is that whose loss leaves a print of a world.
Result<std::pair<program::Options, std::string>> split_words(const FitOptions& options) {
    const std::vector<std::string>& words = options.print;
    std::vector<program::NamedOutput> outputs;
    const std::pair<const char*, const std::string*> files[] = {
        {"-o", &options.output},
        {"--json", &options.json_file},
        {"--history", &options.history_file}};
    for (const auto& [option, file] : files) {
        if (!file->empty()) outputs.push_back({option, *file});
    }
    std::optional<Error> first;
    size_t files_named = 0;
    for (size_t k = words.size(); k-- > 0;) {
        const std::string word = words[k];
        if (word.starts_with("-") || !word.ends_with(".json")) continue;
        ++files_named;
        std::vector<std::string> others = words;
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
        Result<program::Options> print = tuner::parse_print(others, "openfab fit", outputs);
        if (print && !print->help) return std::pair(std::move(*print), word);
        if (!print && !first) first = print.error();
    }
    if (files_named > 1 && first) return *first;
    return usage_error(messages::kNameBoth);
}

class Fitter {
  public:
    Fitter(const FitOptions& options, const std::atomic<bool>& interrupt)
        : options_(options), interrupt_(interrupt) {}

    Result<Fit> run() {
        const double began = seconds_now();
        if (Result<void> ready = set_up(); !ready) return ready.error();
        out_.set_up_seconds = seconds_now() - began;
        const program::DeferredInterrupt deferred;
        if (Result<void> fine = check_dependence(); !fine) return fine.error();
        std::vector<Wanted> wanted;
        for (const Goal& goal : out_.goals.goals)
            wanted.push_back(goal.wanted);
        for (int32_t round = 0; round < kMostRounds; ++round) {
            out_.rounds = round + 1;
            if (Result<void> found = search_all(wanted); !found) return found.error();
            if (out_.interrupted) break;
            if (Result<void> counted = count(); !counted) return counted.error();
            if (out_.interrupted || out_.reached || !is_searched_reached(wanted)) break;
            for (size_t g = 0; g < wanted.size(); ++g) {
                const Goal& goal = out_.goals.goals[g];
                const double off = out_.numbers[g].last() - out_.numbers[g].searched;
                if (wanted[g].at_least) wanted[g].at_least = *goal.wanted.at_least - off;
                if (wanted[g].at_most) wanted[g].at_most = *goal.wanted.at_most - off;
            }
        }
        if (!out_.interrupted && !out_.reached) {
            if (Result<void> looked = look_for_steps(); !looked) return looked.error();
        }
        out_.history = values_->history();
        out_.search_seconds = seconds_now() - began - out_.set_up_seconds;
        return std::move(out_);
    }

    const std::string& world() const { return world_; }

  private:
    Result<void> set_up() {
        auto words = split_words(options_);
        if (!words) return words.error();
        world_ = words->first.input;
        if (!words->first.settings.empty() && (options_.write || !options_.output.empty()))
            return usage_error(
                fmt::format(messages::kOutputSets, options_.write ? "--write" : "-o"));
        out_.given = words->first.settings;
        auto values =
            PrintValues::create(words->first, options_.schedules, words->second, interrupt_);
        if (!values) return values.error();
        values_ = std::move(*values);
        out_.goals = values_->goals();
        out_.currency = values_->currency();
        out_.search_pitch = values_->search_pitch();
        return {};
    }

    Result<std::vector<double>> values_at(std::span<const double> x) {
        return values_->searched(values_->unknowns_at(x, chosen_));
    }

    std::vector<double> start() const {
        std::vector<double> out;
        for (const Unknown& unknown : out_.goals.unknowns) {
            if (!unknown.is_discrete())
                out.push_back((unknown.start - unknown.min) / (unknown.max - unknown.min));
        }
        return out;
    }

    /// Finds goals and unknowns that have nothing to do with each other, by a few values of each unknown: at the start,
    /// and where that is not enough with all choices and from other starts, since unknowns may count together alone.
    Result<void> check_dependence() {
        const size_t count = out_.goals.unknowns.size();
        std::vector<std::vector<double>> starts{start()};
        uint64_t state = options_.search_seed;
        for (int32_t more = 0; more < kOtherStarts && !starts[0].empty(); ++more) {
            std::vector<double>& other = starts.emplace_back(starts[0]);
            for (double& x : other)
                x = next_number(&state);
        }
        chosen_.assign(count, 0);
        const Result<std::vector<double>> first = values_at(starts[0]);
        if (!first) return first.error();
        std::vector<bool> goal_moves(first->size()), unknown_moves(count);
        if (values_->has_slopes()) {
            if (Result<void> looked = look_at_slopes(starts[0], &goal_moves, &unknown_moves);
                !looked)
                return looked;
        }
        const std::vector<bool> goal_slopes = goal_moves, unknown_slopes = unknown_moves;
        const auto all = [](const std::vector<bool>& of) {
            return std::ranges::count(of, false) == 0;
        };
        for (const std::vector<double>& from : starts) {
            do {
                if (all(goal_moves) && all(unknown_moves)) break;
                if (Result<void> looked = look_around(from, *first, &goal_moves, &unknown_moves);
                    !looked)
                    return looked;
            } while (next_choice());
            chosen_.assign(count, 0);
        }
        // What moves without a slope comes and goes in whole voxels, as where all amounts come to 0.
        for (size_t u = 0; u < count; ++u) {
            if (unknown_moves[u] && !unknown_slopes[u] && !out_.goals.unknowns[u].is_discrete())
                values_->drop_slopes();
        }
        if (goal_moves != goal_slopes) values_->drop_slopes();
        for (size_t u = 0; u < count; ++u) {
            if (!unknown_moves[u])
                noted_.push_back(
                    fmt::format(messages::kUnknownMovesNothing, out_.goals.unknowns[u].name));
        }
        for (size_t g = 0; g < goal_moves.size(); ++g) {
            const Goal& goal = out_.goals.goals[g];
            if (goal_moves[g] || std::abs(goal.wanted.beyond((*first)[g])) <= 1) continue;
            if (values_->is_always_empty(goal)) {
                const Box3d print = values_->extent_mm();
                return error_at(goal.location, fmt::format(messages::kNothingInBox, goal.name),
                                fmt::format(messages::kNothingInBoxHelp, print.lo.x, print.lo.y,
                                            print.lo.z, print.hi.x, print.hi.y, print.hi.z));
            }
            return error_at(
                goal.location,
                fmt::format(messages::kGoalMovesNot, goal.name, (*first)[g], unit_of(goal)),
                messages::kGoalMovesNotHelp);
        }
        return {};
    }

    /// Notes which unknowns and goals have a slope at a place.
    Result<void> look_at_slopes(const std::vector<double>& at, std::vector<bool>* goal_moves,
                                std::vector<bool>* unknown_moves) {
        const Result<std::vector<double>> slopes =
            values_->slopes(values_->unknowns_at(at, chosen_));
        if (!slopes) return slopes.error();
        for (size_t g = 0; g < goal_moves->size(); ++g) {
            size_t next = 0;
            for (size_t u = 0; u < unknown_moves->size(); ++u) {
                if (out_.goals.unknowns[u].is_discrete()) continue;
                if ((*slopes)[g * at.size() + next++] != 0)
                    (*goal_moves)[g] = (*unknown_moves)[u] = true;
            }
        }
        return {};
    }

    /// Looks which unknowns, each alone, move any goal from a place; and which goals are not as at `first`.
    Result<void> look_around(const std::vector<double>& from, const std::vector<double>& first,
                             std::vector<bool>* goal_moves, std::vector<bool>* unknown_moves) {
        const Result<std::vector<double>> here = values_at(from);
        if (!here) return here.error();
        for (size_t g = 0; g < first.size(); ++g) {
            if ((*here)[g] != first[g]) (*goal_moves)[g] = true;
        }
        size_t next = 0;
        for (size_t u = 0; u < unknown_moves->size(); ++u) {
            const Unknown& unknown = out_.goals.unknowns[u];
            const size_t at = unknown.is_discrete() ? 0 : next++;
            const size_t values = unknown.is_discrete() ? unknown.choices.size() : 3;
            const size_t chosen = chosen_[u];
            for (size_t k = 0; k < values; ++k) {
                constexpr double kPlaces[] = {0.0, 0.381966, 1.0};
                std::vector<double> there = from;
                if (unknown.is_discrete()) {
                    chosen_[u] = k;
                } else {
                    there[at] = kPlaces[k];
                }
                const Result<std::vector<double>> values_there = values_at(there);
                chosen_[u] = chosen;
                if (!values_there) return values_there.error();
                for (size_t g = 0; g < first.size(); ++g) {
                    if ((*values_there)[g] == (*here)[g]) continue;
                    (*goal_moves)[g] = (*unknown_moves)[u] = true;
                }
            }
        }
        return {};
    }

    /// Searches for each combination of choices, in order, and takes the first that reaches all goals; where something is
    /// made least or most, the best of all.
    Result<void> search_all(const std::vector<Wanted>& wanted) {
        const std::vector<Unknown>& unknowns = out_.goals.unknowns;
        const Values values = [&](std::span<const double> x) { return values_at(x); };
        chosen_.assign(unknowns.size(), 0);
        std::optional<Point> best;
        const bool aims = std::ranges::any_of(wanted, [](const Wanted& w) { return w.aim != 0; });
        const std::vector<double> from = start();
        for (;;) {
            Point point;
            if (from.empty()) {
                Result<std::vector<double>> found = values_at(from);
                out_.interrupted = !found && found.error().code == ErrorCode::kInterrupted;
                if (!found && !out_.interrupted) return found.error();
                if (found) point = {from, std::move(*found)};
            } else {
                SearchOptions options{.seed = options_.search_seed, .interrupt = &interrupt_};
                if (values_->has_slopes())
                    options.slopes = [&](std::span<const double> x) {
                        return values_->slopes(values_->unknowns_at(x, chosen_));
                    };
                Result<SearchResult> found = search_unknowns(from, wanted, values, options);
                if (!found) return found.error();
                out_.interrupted = found->interrupted;
                point = std::move(found->best);
            }
            if (!point.values.empty() && (!best || is_better(point, *best, wanted))) {
                best = point;
                out_.unknowns = values_->unknowns_at(point.x, chosen_);
                out_.settings = values_->settings_of(out_.unknowns);
                out_.numbers.assign(wanted.size(), {});
                for (size_t g = 0; g < wanted.size(); ++g)
                    out_.numbers[g].searched = point.values[g];
            }
            const bool enough = best && !aims && is_reached(*best, wanted);
            if (out_.interrupted || enough || !next_choice()) break;
        }
        if (!best) return Error{ErrorCode::kInterrupted, messages::kInterruptedBefore};
        return {};
    }

    /// Goes on to the next combination of choices; false after the last.
    bool next_choice() {
        for (size_t u = 0; u < chosen_.size(); ++u) {
            const Unknown& unknown = out_.goals.unknowns[u];
            if (!unknown.is_discrete()) continue;
            if (++chosen_[u] < unknown.choices.size()) return true;
            chosen_[u] = 0;
        }
        return false;
    }

    bool is_searched_reached(const std::vector<Wanted>& wanted) const {
        Point point;
        for (const GoalNumbers& one : out_.numbers)
            point.values.push_back(one.searched);
        return is_reached(point, wanted);
    }

    /// Prints to nowhere at the printer's own voxels, and counts.
    Result<void> count() {
        const Result<PrintValues::Counted> counted = values_->count(out_.unknowns);
        out_.interrupted = !counted && counted.error().code == ErrorCode::kInterrupted;
        if (out_.interrupted) return {};
        if (!counted) return counted.error();
        out_.reached = true;
        out_.notes = noted_;
        out_.notes.insert(out_.notes.end(), counted->notes.begin(), counted->notes.end());
        for (size_t g = 0; g < out_.numbers.size(); ++g) {
            GoalNumbers& numbers = out_.numbers[g];
            numbers.mixed = counted->mixed[g];
            numbers.printed = counted->printed[g];
            out_.reached &= std::abs(out_.goals.goals[g].wanted.beyond(numbers.last())) <= 1;
        }
        return {};
    }

    /// Notes of each goal that was not reached what it can be, and whether it jumps over its bound.
    Result<void> look_for_steps() {
        for (size_t g = 0; g < out_.goals.goals.size(); ++g) {
            const Goal& goal = out_.goals.goals[g];
            const double beyond = goal.wanted.beyond(out_.numbers[g].last());
            if (std::abs(beyond) <= 1) continue;
            const double bound = beyond > 0 ? *goal.wanted.at_most : *goal.wanted.at_least;
            const auto by_value = [&](const Trial& a, const Trial& b) {
                return a.values[g] < b.values[g];
            };
            const auto [least, most] = std::ranges::minmax_element(values_->history(), by_value);
            out_.notes.push_back(fmt::format(messages::kRange, goal.name, least->values[g],
                                             most->values[g], unit_of(goal)));
            // The nearest on both sides of the bound, with the choices of the best.
            std::optional<Trial> below, above;
            for (const Trial& trial : values_->history()) {
                if (!has_choices_of_best(trial)) continue;
                const double value = trial.values[g];
                if (value < bound && (!below || value > below->values[g])) below = trial;
                if (value > bound && (!above || value < above->values[g])) above = trial;
            }
            if (!below || !above) continue;
            const Result<double> step = step_between(g, bound, *below, *above);
            if (!step) return step.error();
            if (*step <= goal.wanted.within) continue;
            out_.notes.push_back(fmt::format(messages::kSteps, goal.name, *step, unit_of(goal)));
        }
        return {};
    }

    bool has_choices_of_best(const Trial& trial) const {
        for (size_t u = 0; u < trial.unknowns.size(); ++u) {
            if (out_.goals.unknowns[u].is_discrete() && trial.unknowns[u] != out_.unknowns[u])
                return false;
        }
        return true;
    }

    /// Halves the way from one trial to another, whose values are on two sides of a bound, until hardly any is left.
    /// Returns by how much the value jumps there.
    Result<double> step_between(size_t goal, double bound, Trial below, Trial above) {
        constexpr int32_t kHalvings = 16;
        for (int32_t n = 0; n < kHalvings; ++n) {
            std::vector<double> x;
            for (size_t u = 0; u < below.unknowns.size(); ++u) {
                const Unknown& unknown = out_.goals.unknowns[u];
                const double middle = (below.unknowns[u] + above.unknowns[u]) / 2;
                if (unknown.is_discrete()) {
                    chosen_[u] = static_cast<size_t>(middle);
                } else {
                    x.push_back((middle - unknown.min) / (unknown.max - unknown.min));
                }
            }
            const Result<std::vector<double>> values = values_at(x);
            if (!values) return values.error();
            Trial& side = (*values)[goal] < bound ? below : above;
            side.unknowns = values_->unknowns_at(x, chosen_);
            side.values = *values;
        }
        return above.values[goal] - below.values[goal];
    }

    const FitOptions& options_;
    const std::atomic<bool>& interrupt_;
    std::string world_;
    std::unique_ptr<PrintValues> values_;
    Choices chosen_;
    std::vector<std::string> noted_;  ///< before the first round
    Fit out_;
};

/// Writes a world with the uniforms that were found, all else of which stays as it is written.
Result<void> write_world(const std::string& world, const std::string& output, const Fit& fit) {
    Result<world::WorldEdit> edit = world::WorldEdit::of_file(world);
    if (!edit) return edit.error();
    for (const std::string& setting : fit.settings) {
        const size_t equals = setting.find('=');
        const size_t dot = setting.rfind('.', equals);
        const Result<void> set =
            edit->set_uniform(setting.substr(0, dot), setting.substr(dot + 1, equals - dot - 1),
                              setting.substr(equals + 1));
        if (!set) return set.error();
    }
    const fs::path from = fs::absolute(world).parent_path();
    const fs::path to = fs::absolute(output).parent_path();
    if (from.lexically_normal() != to.lexically_normal()) {
        if (Result<void> moved = edit->relocate(from, to); !moved) return moved.error();
    }
    return backends::write_whole_file(output, edit->text());
}

}  // namespace

Result<void> run_fit(const FitOptions& options) {
    if (!options.history_file.empty() && !options.history_file.ends_with(".csv") &&
        !options.history_file.ends_with(".svg"))
        return usage_error(fmt::format(messages::kHistoryEnds, options.history_file));
    if (!options.output.empty() && !options.output.ends_with(".json"))
        return usage_error(fmt::format(messages::kOutputEnds, options.output));
    const std::atomic<bool>& interrupt =
        program::install_interrupt(exit_code(ErrorCode::kInterrupted), "error: interrupted\n");
    Fitter fitter(options, interrupt);
    const Result<Fit> fit = fitter.run();
    if (!fit) return fit.error();
    show(fit_table(*fit));
    for (const std::string& text : fit->notes)
        note(text);
    if (!options.json_file.empty()) {
        Result<void> written = backends::write_whole_file(options.json_file, fit_json(*fit));
        if (!written) return written;
    }
    if (!options.history_file.empty()) {
        const bool table = options.history_file.ends_with(".csv");
        Result<void> written = backends::write_whole_file(
            options.history_file, table ? history_csv(*fit) : history_svg(*fit));
        if (!written) return written;
    }
    const std::string& world = fitter.world();
    for (const std::string& output : {options.output, options.write ? world : std::string()}) {
        if (output.empty()) continue;
        if (Result<void> written = write_world(world, output, *fit); !written) return written;
    }
    if (fit->interrupted) return Error{ErrorCode::kInterrupted, messages::kInterruptedBest};
    if (!fit->reached) return user_error(messages::kNotReached, messages::kNotReachedHelp);
    return {};
}

}  // namespace openfab::fit
