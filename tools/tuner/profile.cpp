// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/tuner/profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "backends/common/output_file.h"
#include "backends/common/tee_sink.h"
#include "base/clock.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "base/stage_timer.h"
#include "compiler/lower/code/kernel_profile.h"
#include "compiler/lower/schedule/func_costs.h"
#include "program/interrupt.h"
#include "tools/tuner/space.h"
#include "tools/tuner/workload.h"

namespace openfab::tuner {

namespace {

constexpr std::array<const char*, kStages> kNames = {"coverage", "culling", "rows",    "nearest",
                                                     "slab",     "dither",  "support", "pack",
                                                     "count",    "encode",  "commit"};

/// Slabs that are neighbours share what was found for the first of them.
constexpr int32_t kRun = 4;

/// Counters of the slabs that were traced alone: statistics sum up over a job.
struct Counted {
    int64_t queries = 0, blocks = 0, columns = 0, nearest_bytes = 0, slab_bytes = 0, sink_bytes = 0;

    explicit Counted(const pipeline::PrintStatistics& s)
        : queries(s.queries_asked),
          blocks(s.blocks_total),
          columns(s.columns_evaluated),
          nearest_bytes(s.nearest_bytes),
          slab_bytes(s.slab_bytes),
          sink_bytes(s.sink_bytes) {}

    /// Leaves what came after `before`. The sink's bytes are of the last run anyway.
    void subtract(const Counted& before) {
        queries -= before.queries;
        blocks -= before.blocks;
        columns -= before.columns;
        nearest_bytes -= before.nearest_bytes;
        slab_bytes -= before.slab_bytes;
    }
};

class Profiler {
  public:
    Profiler(const ProfileOptions& options, const std::atomic<bool>& interrupt)
        : options_(options), interrupt_(interrupt) {}

    Result<Profile> run() {
        std::vector<program::NamedOutput> outputs;
        if (!options_.json_file.empty()) outputs.push_back({"--json", options_.json_file});
        const Result<program::Options> print =
            parse_print(options_.print, "openfab profile", std::move(outputs));
        if (!print) return print.error();
        Result<std::unique_ptr<Workload>> workload = Workload::create(*print, options_.schedules);
        if (!workload) return workload.error();
        workload_ = std::move(*workload);
        const lower::ProgramOptions plain = workload_->program_options();
        lower::ProgramOptions profiled = plain;
        profiled.profiled = true;
        for (auto* program : {&program_, &plain_, &profiled_}) {
            auto loaded = workload_->compile(program == &profiled_ ? profiled : plain);
            if (const auto* fault = std::get_if<lower::Fault>(&loaded))
                return workload_->report(*fault);
            *program = std::move(std::get<std::unique_ptr<lower::LoadedProgram>>(loaded));
        }
        if (const Result<void> made = set_up(); !made) return made.error();
        profile_.machine = measure_machine(threads(), workload_->isa());
        if (const Result<void> divided = divide_slab(); !divided) return divided.error();
        if (const Result<void> traced = profile_.whole ? trace_whole() : trace_sample(); !traced)
            return traced.error();
        divide_among_funcs();
        return std::move(profile_);
    }

  private:
    int32_t threads() const {
        return print_threads_ > 0 ? print_threads_ : workload_->print().threads.value_or(0);
    }

    Result<void> set_up() {
        const double start = seconds_now(), processor = processor_seconds();
        auto job = workload_->set_up(program_->fablets(), interrupt_);
        if (!job) return job.error();
        job_ = std::move(*job);
        print_threads_ = job_->threads();
        profile_.set_up_seconds = seconds_now() - start;
        set_up_processor_seconds_ = processor_seconds() - processor;
        profile_.title = job_->info().title;
        range_ = job_->slabs();
        profile_.slabs_total = range_.y - range_.x;
        return {};
    }

    /// Prints a few slabs with kernels that note their Funcs, and chooses the slabs to trace.
    Result<void> divide_slab() {
        backends::NullSink nowhere;
        const auto run = [&](int32_t count, pipeline::PrintStatistics* statistics) {
            return job_->run_slabs(spread_slabs(range_, count, kRun, 0.5), nowhere, interrupt_,
                                   statistics);
        };
        // The first fills caches, and tells how many the time is enough for.
        const Result<pipeline::SlabsRun> probe = run(kRun, nullptr);
        if (!probe) return probe.error();
        const auto slabs_in = [&](double seconds) {
            const double each = std::max(1e-6, (probe->end - probe->begin) / kRun);
            const double most = profile_.slabs_total;
            return static_cast<int32_t>(
                std::clamp(seconds / each, std::min(1.0 * kRun, most), most));
        };
        use_slab_kernels(profiled_->fablets(), program_->fablets(), workload_->isa());
        lower::KernelProfile samples;
        pipeline::PrintStatistics statistics;
        const int32_t some = slabs_in(0.3 * options_.seconds);
        // A small print's slabs are too quick for samples: it is printed a few times.
        constexpr double kLeastSeconds = 0.3;
        const double begin = seconds_now();
        do {
            const Result<pipeline::SlabsRun> done = run(some, &statistics);
            if (!done) return done.error();
        } while (seconds_now() - begin < std::min(kLeastSeconds, 0.3 * options_.seconds));
        samples_ = samples.finish();
        use_slab_kernels(plain_->fablets(), program_->fablets(), workload_->isa());
        before_.emplace(statistics);
        chosen_ = slabs_in(0.6 * options_.seconds);
        profile_.whole = options_.whole || chosen_ == profile_.slabs_total;
        return {};
    }

    /// The whole print, set up anew: nothing is in its caches yet.
    Result<void> trace_whole() {
        job_.reset();
        before_.reset();
        if (const Result<void> made = set_up(); !made) return made;
        return trace(
            [&](pipeline::SliceSink& sink, pipeline::PrintStatistics* statistics) -> Result<void> {
                const double processor = processor_seconds();
                begin_ = seconds_now();
                const Result<void> done = job_->run(sink, nullptr, interrupt_, statistics);
                end_ = seconds_now();
                profile_.processor_seconds = processor_seconds() - processor;
                profile_.slabs = profile_.slabs_total;
                return done;
            });
    }

    Result<void> trace_sample() {
        return trace(
            [&](pipeline::SliceSink& sink, pipeline::PrintStatistics* statistics) -> Result<void> {
                // Slabs that the caches have not seen.
                const std::vector<int32_t> slabs = spread_slabs(range_, chosen_, kRun, 0.0);
                const Result<pipeline::SlabsRun> done =
                    job_->run_slabs(slabs, sink, interrupt_, statistics);
                if (!done) return done.error();
                begin_ = done->begin;
                end_ = done->end;
                profile_.processor_seconds = done->processor_seconds;
                profile_.slabs = static_cast<int32_t>(slabs.size());
                return {};
            });
    }

    template <typename Run>
    Result<void> trace(const Run& run) {
        const Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
        if (!folder) return folder.error();
        auto sink = workload_->open_sink((*folder)->path());
        if (!sink) return sink.error();
        pipeline::PrintStatistics statistics;
        const Trace trace;
        if (const Result<void> done = run(**sink, &statistics); !done) return done;
        profile_.seconds = end_ - begin_;
        Counted counted(statistics);
        if (before_) counted.subtract(*before_);
        add_stages(trace, counted, statistics);
        find_alone(trace);
        return {};
    }

    void add_stages(const Trace& trace, const Counted& counted,
                    const pipeline::PrintStatistics& statistics) {
        const pipeline::PrintInfo& info = job_->info();
        const int64_t slice = int64_t{info.size.x} * info.size.y;
        const int64_t rows = (int64_t{info.size.x} * info.bits + 7) / 8 * info.size.y;
        const int64_t voxels = profile_.voxels = slice * statistics.slices;
        const int64_t packed = rows * statistics.slices;
        const int64_t columns = 8 * counted.columns, blocks = 512 * counted.blocks;
        const int64_t solid = statistics.voxels_solid;
        const auto add = [&](Stage stage, int64_t seen, int64_t read, int64_t written) {
            StageCost& cost = profile_.stages.emplace_back();
            const auto k = static_cast<size_t>(stage);
            cost.name = kNames[k];
            for (const Trace::Thread& thread : trace.threads()) {
                cost.by_thread.push_back(thread.seconds[k]);
                cost.seconds += thread.seconds[k];
            }
            cost.voxels = seen;
            cost.bytes_read = read;
            cost.bytes_written = written;
        };
        // Masks have a bit a voxel; bands a byte, and the fractions.
        add(Stage::kCoverage, voxels, 0, voxels / 8);
        add(Stage::kCulling, blocks, blocks / 8, 0);
        add(Stage::kRows, blocks, blocks / 8, solid);
        add(Stage::kNearest, counted.queries, columns, counted.nearest_bytes);
        add(Stage::kSlab, columns, counted.nearest_bytes, counted.slab_bytes);
        add(Stage::kDither, columns, counted.slab_bytes, columns);
        add(Stage::kSupport, voxels, 0, statistics.voxels_support);
        add(Stage::kPack, voxels, voxels, packed);
        add(Stage::kCount, voxels, packed, 0);
        add(Stage::kEncode, voxels, packed, counted.sink_bytes);
        add(Stage::kCommit, voxels, counted.sink_bytes, counted.sink_bytes);
        StageCost other, waiting;
        other.name = "other";
        other.seconds = profile_.processor_seconds;
        waiting.name = "waiting";
        waiting.seconds = profile_.thread_seconds() - profile_.processor_seconds;
        const size_t came = trace.threads().size();
        waiting.by_thread.assign(std::max(came, static_cast<size_t>(threads())), profile_.seconds);
        for (StageCost& cost : profile_.stages) {
            other.seconds -= cost.seconds;
            cost.by_thread.resize(waiting.by_thread.size(), 0);
            for (size_t t = 0; t < cost.by_thread.size(); ++t)
                waiting.by_thread[t] -= cost.by_thread[t];
        }
        profile_.stages.push_back(std::move(other));
        profile_.stages.push_back(std::move(waiting));
    }

    void find_alone(const Trace& trace) {
        const std::vector<double> busy = seconds_by_busy_threads(trace.threads(), begin_, end_);
        const double scale = profile_.whole ? 1
                                            : static_cast<double>(profile_.slabs_total) /
                                                  static_cast<double>(profile_.slabs);
        // Of set-up only the processor's seconds are known: as if one thread or all of them worked.
        const double threads = profile_.machine.threads;
        const double set_up_alone =
            threads > 1
                ? (threads * profile_.set_up_seconds - set_up_processor_seconds_) / (threads - 1)
                : profile_.set_up_seconds;
        profile_.alone_seconds = std::clamp(set_up_alone, 0.0, profile_.set_up_seconds) +
                                 scale * (busy.size() > 1 ? busy[1] : 0);
        profile_.print_seconds = profile_.set_up_seconds + scale * profile_.seconds;
    }

    /// Shares the slab kernel's seconds among its Funcs as they were seen.
    void divide_among_funcs() {
        const auto slab = std::find_if(profile_.stages.begin(), profile_.stages.end(),
                                       [](const StageCost& stage) { return stage.name == "slab"; });
        // Of several fablets the mean.
        std::map<std::string, lower::FuncCost> costs;
        int64_t kernels = 0;
        std::set<std::string> functions;
        lower::ProgramOptions options = workload_->program_options();
        options.profiled = true;
        for (const lower::KernelUnit& unit :
             lower::list_kernels(workload_->compilation().fablets(), options)) {
            // The row has the seconds of segments, too, whose Funcs are not seen.
            if (unit.request.stage->kind != ir::StageKind::kVolume ||
                unit.request.inside.after_segments)
                continue;
            ++kernels;
            functions.insert(unit.request.function);
            for (const lower::FuncCost& cost : lower::func_costs(unit.request)) {
                lower::FuncCost& sum = costs[pattern_of(cost.func)];
                sum.operations += cost.operations;
                sum.bytes_read += cost.bytes_read;
                sum.bytes_written += cost.bytes_written;
            }
        }
        std::map<std::string, int64_t> seen;
        for (const lower::FuncSamples& func : samples_) {
            // Nearest has a row of its own. Halide calls what is between Funcs overhead. Between
            // numbered Funcs LLVM moves operations, so that only together they have a time.
            if (!functions.contains(func.function) || func.func == "nearest") continue;
            seen[pattern_of(func.func)] += func.samples;
            profile_.samples += func.samples;
        }
        for (const auto& [name, samples] : seen) {
            StageCost& func = profile_.funcs.emplace_back();
            func.name = name;
            func.seconds = slab->seconds * static_cast<double>(samples) /
                           static_cast<double>(profile_.samples);
            func.voxels = slab->voxels;
            const auto cost = costs.find(name);
            if (cost == costs.end()) continue;
            func.bytes_read = cost->second.bytes_read * func.voxels / kernels;
            func.bytes_written = cost->second.bytes_written * func.voxels / kernels;
            func.operations = static_cast<double>(cost->second.operations * func.voxels) /
                              static_cast<double>(kernels);
            slab->operations += func.operations;
        }
        std::stable_sort(
            profile_.funcs.begin(), profile_.funcs.end(),
            [](const StageCost& a, const StageCost& b) { return a.seconds > b.seconds; });
        for (auto* rows : {&profile_.stages, &profile_.funcs}) {
            for (StageCost& stage : *rows)
                stage.bound = bound_of(stage, profile_.machine);
        }
    }

    const ProfileOptions& options_;
    const std::atomic<bool>& interrupt_;
    std::unique_ptr<Workload> workload_;
    /// The one that is printed with, whose slab kernels those of the others replace in turn.
    std::unique_ptr<lower::LoadedProgram> program_;
    std::unique_ptr<lower::LoadedProgram> plain_, profiled_;
    std::unique_ptr<pipeline::PrintJob> job_;
    int32_t print_threads_ = 0;
    double set_up_processor_seconds_ = 0;
    Vec2<int32_t> range_;
    int32_t chosen_ = 0;
    std::vector<lower::FuncSamples> samples_;
    std::optional<Counted> before_;
    double begin_ = 0, end_ = 0;
    Profile profile_;
};

}  // namespace

std::string bound_of(const StageCost& stage, const Machine& machine) {
    if (stage.name == "waiting") return "waiting";
    if (stage.name == "encode" || stage.name == "commit") return "sink";
    // Half of what memory gives a thread is about what real loops reach.
    constexpr double kNearLimit = 0.5;
    const double bytes = static_cast<double>(stage.bytes_read + stage.bytes_written);
    // Funcs of a kernel pass on what they compute in caches, or in registers.
    if (stage.by_thread.empty()) return "arithmetic";
    const double memory = stage.seconds > 0 ? bytes / stage.seconds / machine.bandwidth_each() : 0;
    return memory >= kNearLimit ? "memory" : "arithmetic";
}

Result<void> run_profile(const ProfileOptions& options) {
    const std::atomic<bool>& interrupt =
        program::install_interrupt(exit_code(ErrorCode::kInterrupted), "error: interrupted\n");
    const Result<Profile> profile = Profiler(options, interrupt).run();
    if (!profile) return profile.error();
    show(profile_table(*profile));
    if (options.json_file.empty()) return {};
    return backends::write_whole_file(options.json_file, profile_json(*profile));
}

}  // namespace openfab::tuner
