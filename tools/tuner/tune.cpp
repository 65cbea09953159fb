// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/tuner/tune.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include "abi/kernel_call.h"
#include "backends/common/output_file.h"
#include "base/allowance.h"
#include "base/caret.h"
#include "base/clock.h"
#include "base/hash.h"
#include "base/json.h"
#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "program/interrupt.h"
#include "tools/tuner/candidates.h"
#include "tools/tuner/journal.h"
#include "tools/tuner/machine.h"
#include "tools/tuner/messages.h"
#include "tools/tuner/space.h"
#include "tools/tuner/stand.h"
#include "tools/tuner/verdict.h"

namespace openfab::tuner {

namespace {

/// Neighbours that are printed together.
constexpr int32_t kRun = 2;
/// Of the budget, for the comparison at the end.
constexpr double kVerifyShare = 0.2;
/// Places at which schedules are compared at the end, of neighbours each.
constexpr size_t kPlaces = 8;
/// A file that is larger is no schedule.
constexpr size_t kMostBytes = size_t{1} << 20;

class Tuner {
  public:
    Tuner(const TuneOptions& options, const std::atomic<bool>& interrupt,
          program::DeferredInterrupt* deferred)
        : options_(options), interrupt_(interrupt), deferred_(deferred) {}

    Result<void> run() {
        if (const Result<void> begun = begin(); !begun) return begun;
        const Result<void> searched = search();
        if (interrupt_.load()) return interrupted();
        if (!searched) return searched;
        return conclude();
    }

  private:
    double elapsed() const { return seconds_now() - start_; }
    /// Returns whether the search has to end: for the time that is left, schedules are verified.
    bool over() const {
        return interrupt_.load() || elapsed() > options_.budget_seconds * (1 - kVerifyShare);
    }

    Result<void> begin() {
        const std::string journal =
            options_.journal.empty() ? options_.output + ".journal" : options_.journal;
        const Result<program::Options> print = parse_print(
            options_.print, "openfab tune", {{"-o", options_.output}, {"--journal", journal}});
        if (!print) return print.error();
        auto workload = Workload::create(*print, options_.schedules);
        if (!workload) return workload.error();
        workload_ = std::move(*workload);
        if (const Result<void> made = make_space(); !made) return made;
        auto stand = Stand::create(workload_.get(), interrupt_);
        if (!stand) return stand.error();
        stand_ = std::move(*stand);
        if (const Result<void> chosen = choose_slabs(); !chosen) return chosen;
        Result<Journal> opened = Journal::open(journal, key());
        if (!opened) return opened.error();
        journal_ = std::make_unique<Journal>(std::move(*opened));
        candidates_ = std::make_unique<Candidates>(space_.get(), journal_.get(), first_text_);
        if (journal_->size() > 0)
            say(fmt::format(messages::kSchedulesKnown, journal_->size(), journal));
        read_output();
        if (std::error_code none; !std::filesystem::exists(options_.output, none)) {
            if (const Result<void> written = write(nullptr, {}); !written) return written;
        }
        deferred_->say(render_error(interrupted()));
        // From here on: a world may take long to set up, which is no one's choice.
        start_ = seconds_now();
        return {};
    }

    /// Finds the schedule to begin with, and the largest kernel that it is for.
    Result<void> make_space() {
        const driver::Schedules& schedules = workload_->compilation().schedules();
        const lower::ProgramOptions program = workload_->program_options();
        std::vector<lower::KernelUnit> units =
            lower::list_kernels(workload_->compilation().fablets(), program);
        std::erase_if(units, [](const lower::KernelUnit& unit) {
            return unit.request.stage->kind != ir::StageKind::kVolume;
        });
        if (units.empty()) {
            return user_error(messages::kNoSlabKernel, messages::kNoSlabKernelHelp);
        }
        auto sites = lower::list_sites(units.front().request);
        if (const auto* fault = std::get_if<schedule::Fault>(&sites))
            return workload_->report({*fault, {}});
        const std::string target = abi::isa_name(workload_->isa());
        const schedule::Schedule& bound = lower::schedule_of(units.front().request);
        space_ = std::make_unique<Space>(schedules.file("slab", workload_->isa()), target,
                                         schedules.params(), bound,
                                         std::get<std::vector<lower::FuncSites>>(sites));
        first_text_ = schedule::text_of(bound);
        return {};
    }

    Result<void> choose_slabs() {
        const double seconds = std::clamp(options_.budget_seconds / 400, 0.02, 1.0);
        const Result<int32_t> count = stand_->slabs_in(seconds, interrupt_);
        if (!count) return count.error();
        const Vec2<int32_t> all = stand_->slabs();
        // Of a low print, half are left for the comparison at the end.
        const int32_t most = std::max(1, (all.y - all.x) / 2);
        seen_ = spread_slabs(all, std::min(*count, most), kRun, 0.5);
        std::vector<int32_t> others;
        for (int32_t slab = all.x; slab < all.y; ++slab) {
            if (!std::binary_search(seen_.begin(), seen_.end(), slab)) others.push_back(slab);
        }
        // A print of one slab has no others.
        sees_all_ = others.empty();
        if (sees_all_) others = seen_;
        const auto chosen = spread_slabs({0, static_cast<int32_t>(others.size())},
                                         static_cast<int32_t>(seen_.size()), kRun, 0.5);
        const size_t places = std::min(kPlaces, chosen.size());
        for (size_t place = 0; place < places; ++place) {
            std::vector<int32_t>& slabs = places_.emplace_back();
            const size_t end = (place + 1) * chosen.size() / places;
            for (size_t k = place * chosen.size() / places; k < end; ++k)
                slabs.push_back(others[static_cast<size_t>(chosen[k])]);
            slabs_compared_ += slabs.size();
        }
        // Fills caches, and tells what voxels there are.
        if (const Result<double> run = stand_->run(nullptr, seen_, interrupt_); !run)
            return run.error();
        for (const std::vector<int32_t>& slabs : places_) {
            if (const Result<double> run = stand_->run(nullptr, slabs, interrupt_); !run)
                return run.error();
        }
        return {};
    }

    /// Reads the schedule that the output has from an earlier search, to be verified again. What is no
    /// schedule is none.
    void read_output() {
        std::error_code status;
        if (!std::filesystem::is_regular_file(options_.output, status)) return;
        const Result<std::string> text = read_text_file(options_.output, kMostBytes);
        if (!text) return;
        const auto schedule =
            schedule::read({options_.output, *text}, {.target = abi::isa_name(workload_->isa())});
        if (!std::holds_alternative<schedule::Schedule>(schedule)) return;
        kept_text_ = schedule::text_of(std::get<schedule::Schedule>(schedule));
        if (kept_text_ == first_text_) kept_text_.clear();
        if (!kept_text_.empty()) say(fmt::format(messages::kHasSchedule, options_.output));
    }

    /// Describes all that a ratio depends on.
    std::string key() const {
        Hasher hash;
        hash.add_text(first_text_);
        hash.add_text(abi::isa_name(workload_->isa()));
        hash.add_text(processor_name());
        for (const lower::FabletUnit& fablet : workload_->compilation().fablets())
            hash.add(fablet.hash);
        const pipeline::PrintInfo& info = stand_->info();
        for (const int32_t size : {info.size.x, info.size.y, info.slice_begin, info.slice_end})
            hash.add(int64_t{size});
        for (const auto& [name, value] : info.provenance) {
            hash.add_text(name);
            hash.add_text(value);
        }
        return fmt::format("{} {:016x}", info.title, hash.value());
    }

    /// Compiles those that are to be measured.
    Result<void> prepare(const std::vector<Candidate*>& candidates) {
        std::vector<Candidate*> missing;
        std::vector<std::string> texts;
        for (Candidate* candidate : candidates) {
            if (!candidate->usable() || candidate->contender.program != nullptr) continue;
            missing.push_back(candidate);
            texts.push_back(candidate->text);
        }
        std::vector<Contender> made = stand_->compile(texts);
        for (size_t k = 0; k < missing.size(); ++k) {
            missing[k]->contender = std::move(made[k]);
            missing[k]->trial.refused = missing[k]->contender.refused;
            if (missing[k]->usable()) continue;
            if (const Result<void> noted = note_trial(*missing[k]); !noted) return noted;
        }
        return {};
    }

    Result<void> note_trial(const Candidate& candidate) {
        const Trial& trial = candidate.trial;
        const std::string changes = fmt::format("{}", fmt::join(trial.changes, "; "));
        if (trial.refused.empty()) {
            say(fmt::format(messages::kOfFirstsTime, format_seconds(elapsed()), candidate.ratio(),
                            printable(changes)));
        } else {
            say(fmt::format(messages::kTrialRefused, format_seconds(elapsed()), printable(changes),
                            printable(trial.refused)));
        }
        return journal_->add(candidate.text, trial);
    }

    /// Measures each once, between two runs of the first schedule.
    Result<void> measure(const std::vector<Candidate*>& candidates) {
        Result<double> before = stand_->run(nullptr, seen_, interrupt_);
        if (interrupt_.load()) return {};
        for (Candidate* candidate : candidates) {
            if (!candidate->usable()) continue;
            if (!before) return before.error();
            const Result<double> run = stand_->run(&candidate->contender, seen_, interrupt_);
            if (interrupt_.load()) return {};
            if (!run) {
                candidate->trial.refused = run.error().message;
                warn(fmt::format(messages::kScheduleFails, run.error().text()));
                if (const Result<void> noted = note_trial(*candidate); !noted) return noted;
                continue;
            }
            const Result<double> after = stand_->run(nullptr, seen_, interrupt_);
            if (interrupt_.load()) return {};
            if (!after) return after.error();
            candidate->trial.ratios.push_back(2 * *run / (*before + *after));
            before = after;
            if (const Result<void> noted = note_trial(*candidate); !noted) return noted;
        }
        return {};
    }

    /// Measures all once, the better half once more, and so on.
    Result<void> halve(std::vector<Candidate*> left) {
        for (size_t round = 0; round < kRounds && !left.empty() && !over(); ++round) {
            // What the journal knows of a round is not measured again.
            std::vector<Candidate*> missing;
            for (Candidate* candidate : left) {
                if (candidate->usable() && candidate->trial.ratios.size() <= round)
                    missing.push_back(candidate);
            }
            const size_t at_once = 2 * static_cast<size_t>(usable_cores());
            for (size_t first = 0; first < missing.size() && !over(); first += at_once) {
                const std::vector<Candidate*> some(
                    missing.begin() + static_cast<ptrdiff_t>(first),
                    missing.begin() +
                        static_cast<ptrdiff_t>(std::min(first + at_once, missing.size())));
                if (const Result<void> ready = prepare(some); !ready) return ready;
                // Even where time is over by now: else it would have been compiled for nothing.
                if (interrupt_.load()) break;
                if (const Result<void> measured = measure(some); !measured) return measured;
            }
            sort_by_ratio(&left);
            left.resize((left.size() + 1) / 2);
            if (left.size() == 1 && round + 1 >= kRounds) break;
        }
        // Code of those that are out is not needed any more.
        const Candidate* best = candidates_->best();
        for (Candidate& candidate : candidates_->all()) {
            if (&candidate != best) candidate.contender.program.reset();
        }
        return {};
    }

    Result<void> search() {
        std::vector<Candidate*> generation = candidates_->first_generation();
        say(fmt::format(messages::kChangesToTry, seen_.size(),
                        stand_->slabs().y - stand_->slabs().x, generation.size()));
        while (!generation.empty() && !over()) {
            if (const Result<void> halved = halve(generation); !halved) return halved;
            generation = candidates_->next_generation();
        }
        return {};
    }

    /// Compares on slabs that the search has not seen, if there are any, for as long as `until` says.
    Result<Verdict> verify(Candidate* contender, double until) {
        const size_t least = 7, most = 25;
        std::vector<std::vector<Triple>> runs;
        while (runs.size() < least || (runs.size() < most && elapsed() < until)) {
            std::vector<Triple>& run = runs.emplace_back();
            for (const std::vector<int32_t>& slabs : places_) {
                Triple& triple = run.emplace_back();
                const auto measure = [&](const Contender* kernels, double* out) -> Result<void> {
                    const Result<double> seconds = stand_->run(kernels, slabs, interrupt_);
                    if (!seconds) return seconds.error();
                    *out = *seconds;
                    return {};
                };
                Result<void> done = measure(nullptr, &triple.before);
                if (done) done = measure(&contender->contender, &triple.contender);
                if (done) done = measure(nullptr, &triple.after);
                if (!done) return done.error();
            }
        }
        return judge(runs);
    }

    /// Writes the best of those that are verified: the one that the output has, and what was best in the
    /// search; or the first schedule where none is faster.
    Result<void> conclude() {
        // Also those that time was enough for a single round of: this comparison is what counts.
        std::vector<Candidate*> ranked;
        for (Candidate& candidate : candidates_->all())
            ranked.push_back(&candidate);
        sort_by_ratio(&ranked);
        std::erase_if(
            ranked, [](const Candidate* candidate) { return candidate->ratio() > 1 - kLeastGain; });
        Candidate* const kept = kept_text_.empty() ? nullptr : candidates_->with_text(kept_text_);
        if (kept != nullptr) {
            std::erase(ranked, kept);
            ranked.insert(ranked.begin(), kept);
        }
        constexpr size_t kTries = 3;
        ranked.resize(std::min(kTries, ranked.size()));
        Candidate* winner = nullptr;
        Verdict best;
        std::string lost;
        for (size_t k = 0; k < ranked.size(); ++k) {
            Candidate* candidate = ranked[k];
            if (const Result<void> ready = prepare({candidate}); !ready) return ready;
            if (!candidate->usable()) continue;
            if (const Result<void> fits = stand_->fits(candidate->contender); !fits) {
                candidate->trial.refused = fits.error().message;
                if (const Result<void> noted = note_trial(*candidate); !noted) return noted;
                continue;
            }
            const double left = options_.budget_seconds - elapsed();
            const Result<Verdict> verdict =
                verify(candidate, elapsed() + left / static_cast<double>(ranked.size() - k));
            if (interrupt_.load()) return interrupted();
            if (!verdict) return verdict.error();
            const std::string result = described(*verdict);
            say(fmt::format(
                messages::kCompared, result,
                printable(fmt::format("{}", fmt::join(candidate->trial.changes, "; ")))));
            candidate->trial.won = verdict->wins(candidate->trial.won);
            if (const Result<void> noted = journal_->add(candidate->text, candidate->trial); !noted)
                return noted;
            if (!candidate->trial.won) {
                lost +=
                    fmt::format("#   {}: {}\n", fmt::join(candidate->trial.changes, "; "), result);
            } else if (winner == nullptr || verdict->ratio < best.ratio) {
                winner = candidate;
                best = *verdict;
            }
            // The next was worse in the search. The one that was kept is no measure of it.
            if (winner != nullptr && candidate != kept) break;
        }
        if (winner == nullptr) say(messages::kNoneFaster);
        return write(winner, best, lost);
    }

    static std::string described(const Verdict& verdict) {
        return fmt::format(messages::kVerdictIs, verdict.ratio, verdict.bound, verdict.of_places.x,
                           verdict.of_places.y);
    }

    Result<void> write(const Candidate* winner, const Verdict& verdict,
                       const std::string& lost = {}) {
        size_t refused = 0, measured = 0;
        std::vector<Candidate*> ranked;
        for (Candidate& candidate : candidates_->all()) {
            refused += candidate.usable() ? 0 : 1;
            measured += candidate.usable() && !candidate.trial.ratios.empty() ? 1 : 0;
            ranked.push_back(&candidate);
        }
        sort_by_ratio(&ranked);
        std::string out = fmt::format(
            "# Made by `openfab tune` for {} on {}, for {}.\n"
            "# Tried: {} schedules, and {} that were refused, on {} slabs of {}; ratios are of "
            "processor time to\n# that of {}.\n",
            printable(stand_->info().title), processor_name(), abi::isa_name(workload_->isa()),
            measured, refused, seen_.size(), stand_->slabs().y - stand_->slabs().x, base_name());
        if (winner != nullptr) {
            out += fmt::format(
                "# Won, with {};\n# in {} runs at {} places, on {} slabs{}:\n", described(verdict),
                verdict.runs, verdict.places, slabs_compared_,
                sees_all_ ? " (the print has no others)" : " that the search had not seen");
            for (const std::string& change : winner->trial.changes)
                out += fmt::format("#   {}\n", change);
        } else {
            out += "# None was faster beyond noise: these are the lines it began with.\n";
            if (!lost.empty())
                out += "# Not faster on slabs that the search had not seen:\n" + lost;
        }
        constexpr size_t kShown = 10;
        out += "# The best in the search:\n";
        for (size_t k = 0; k < std::min(kShown, ranked.size()); ++k)
            out += fmt::format("#   {:.3f}  {}\n", ranked[k]->ratio(),
                               fmt::join(ranked[k]->trial.changes, "; "));
        out += "pipeline slab\n" + (winner != nullptr ? winner->text : first_text_);
        return backends::write_whole_file(options_.output, out);
    }

    /// What was found is compared again before it counts, for which there is no time now.
    Error interrupted() const {
        return {ErrorCode::kInterrupted,
                fmt::format(messages::kInterruptedBest, options_.output),
                messages::kInterruptedBestHelp,
                {}};
    }

    std::string base_name() const {
        return workload_->compilation().schedules().file("slab", workload_->isa()).path;
    }

    const TuneOptions& options_;
    const std::atomic<bool>& interrupt_;
    program::DeferredInterrupt* const deferred_;
    double start_ = 0;
    std::unique_ptr<Workload> workload_;
    std::unique_ptr<Stand> stand_;
    std::unique_ptr<Space> space_;
    std::unique_ptr<Journal> journal_;
    std::string first_text_;
    std::string kept_text_;  ///< of the schedule that the output has; empty: none but the first
    std::vector<int32_t> seen_;
    /// Those of the comparison at the end, by place: others, unless the search sees all.
    std::vector<std::vector<int32_t>> places_;
    size_t slabs_compared_ = 0;
    bool sees_all_ = false;
    std::unique_ptr<Candidates> candidates_;
};

}  // namespace

Result<void> run_tune(const TuneOptions& options) {
    if (options.output.empty()) {
        return usage_error(messages::kNoOutput);
    }
    if (!options.output.ends_with(".sched"))
        return usage_error(fmt::format(messages::kNameEnds, options.output));
    const std::atomic<bool>& interrupt = program::install_interrupt(
        exit_code(ErrorCode::kInterrupted), "error: interrupted before the search began\n");
    program::DeferredInterrupt deferred;
    return Tuner(options, interrupt, &deferred).run();
}

}  // namespace openfab::tuner
