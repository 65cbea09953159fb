// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/print_job.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "abi/halide_hooks.h"
#include "abi/voxel_hash.h"
#include "base/check.h"
#include "base/clock.h"
#include "base/deadline.h"
#include "base/stage_timer.h"
#include "runtime/pipeline/check.h"
#include "runtime/pipeline/grid.h"
#include "runtime/pipeline/memory_needs.h"
#include "runtime/pipeline/memory_planner.h"
#include "runtime/pipeline/provenance.h"
#include "runtime/pipeline/slab.h"
#include "runtime/pipeline/slice_committer.h"
#include "runtime/pipeline/slice_totals.h"

namespace openfab::pipeline {

namespace {

/// Of an estimate: seconds for the coverage of the first slab that it tries.
constexpr double kCoverageSeconds = 3;

/// Returns the bits of slices [first, end) of one slab, as SlabRun::run takes them.
uint8_t bits_of_slices(int32_t first, int32_t end) {
    return static_cast<uint8_t>(((1 << (end - first)) - 1) << (first & 7));
}

/// Slices of one slab.
struct SlabSlices {
    int32_t slab = -1;
    int32_t first = 0, end = 0;
    int32_t shift = 0;  ///< to their numbers in the sink
};

Error interrupted_early() {
    return Error{ErrorCode::kInterrupted, "interrupted before the first slice"};
}

/// Takes slices of slabs on trial as if they followed each other.
struct TrialSlices {
    pipeline::SliceSink* sink;  ///< may be null
    int32_t next;
};

class PrintJobImpl final : public PrintJob {
  public:
    PrintJobImpl(PrintInput input, PrintOptions options)
        : input_(std::move(input)), options_(std::move(options)) {}

    Result<void> set_up();
    const pipeline::PrintInfo& info() const override { return info_; }
    PrintEstimate estimate() const override;
    const std::vector<std::string>& warnings() const override { return warnings_; }
    Result<TimeSample> sample_time(double seconds, pipeline::SliceSink* sink,
                                   const std::atomic<bool>& interrupt) override;
    Result<void> run(pipeline::SliceSink& sink,
                     const std::function<void(const ProgressEvent&)>& progress,
                     const std::atomic<bool>& interrupt, PrintStatistics* statistics) override;
    int32_t threads() const override { return threads_; }
    Vec2<int32_t> slabs() const override { return {range_.x / 8, (range_.y + 7) / 8}; }
    Result<SlabsRun> run_slabs(std::span<const int32_t> slabs, pipeline::SliceSink& sink,
                               const std::atomic<bool>& interrupt,
                               PrintStatistics* statistics) override;

  private:
    void stop_surfaces_by(const std::atomic<bool>* stop) const;
    bool owns_surface(size_t part) const { return owners_[part] == static_cast<int32_t>(part); }
    Result<void> set_up_surfaces(const MemoryPlanner& planner, const CacheBudgets& caches);
    Result<void> set_up_grid();
    void set_up_parts(size_t crossing_bytes);
    void place_parts(size_t crossing_bytes);
    void set_up_slabs();
    Result<MemoryPlan> plan_memory(const MemoryPlanner& planner, const CacheBudgets& caches,
                                   const SurfaceCounts& displaced, int64_t textures) const;
    void fill_info();
    Result<void> slab_outcome() const;
    Result<void> surface_status() const;
    Result<void> resume(pipeline::SliceSink& sink, SliceCommitter* committer);
    void show_surface_logs(SliceCommitter* committer);
    Result<void> set_up_support();
    void print_slabs(pipeline::SliceSink& sink, SliceCommitter* committer);
    /// Prints what `next` gives, up to a negative number.
    void print_all(const std::function<SlabSlices()>& next, const pipeline::SliceSink& sink,
                   SliceCommitter* committer);
    void fill_voxels(const PrintTotals& totals, PrintStatistics* statistics) const;
    void print_first_slab(int32_t slab, const pipeline::SliceSink& sink, SliceCommitter* committer);
    FinishedSlices print_slab(const SlabSlices& slab, const pipeline::SliceSink& sink,
                              SliceCommitter* committer);
    SlabSlices slices_of(int32_t slab) const {
        return {slab, std::max(8 * slab, range_.x), std::min(8 * slab + 8, range_.y), 0};
    }
    FinishedSlices print_slices(const SlabSlices& slices, abi::KernelStatus begun, SlabRun* run,
                                const pipeline::SliceSink& sink, SliceCommitter* committer);
    void encode(const pipeline::SliceSink& sink, const SlabRun& run, int32_t shift,
                FinishedSlices* finished);
    Result<SlabTrial> try_slab(const SlabTry& wanted, const std::atomic<bool>& interrupt,
                               TrialSlices* slices);
    int64_t patches_diced() const;
    void fill_statistics(const SliceCommitter& committer, PrintStatistics* statistics);

    PrintInput input_;
    PrintOptions options_;
    part::Grid grid_;
    Vec2<int32_t> range_;
    pipeline::PrintInfo info_;
    surface::SurfaceOptions surface_options_;
    std::vector<int32_t> owners_;  ///< by part: the first one with its surface
    std::vector<std::shared_ptr<const surface::Surface>> surfaces_;  ///< by part
    std::shared_ptr<nearest::PatchCache> trees_;                     ///< of displaced patches
    std::vector<std::unique_ptr<volume::PlacedPart>> parts_;
    SlabSetup setup_;
    std::unique_ptr<const support_material::DepthMap> support_;
    MemoryPlan plan_;
    int32_t threads_ = 1;
    double seconds_set_up_ = 0;
    std::vector<std::string> warnings_;  ///< of set-up
    Pool<SlabRun> runs_;
    Pool<volume::BlockEvaluator> evaluators_;
    std::mutex encode_mutex_;
    double seconds_encode_ = 0, seconds_count_ = 0, seconds_finish_ = 0;
};

Result<void> PrintJobImpl::set_up() {
    const double start = seconds_now();
    threads_ = options_.threads > 0 ? options_.threads : tbb::info::default_concurrency();
    options_.isa = abi::best_isa(options_.isa);
    if (const Result<void> checked = check_input(input_, options_); !checked) return checked;
    const MemoryPlanner planner({options_.memory_bytes, options_.reserved_bytes}, threads_);
    const int64_t textures = texture_bytes(input_.parts);

    owners_ = volume::surface_owners(input_.parts);
    SurfaceCounts displaced;
    for (size_t i = 0; i < owners_.size(); ++i) {
        if (input_.parts[i].fablet->has_surface == 0) continue;
        ++displaced.parts;
        displaced.surfaces += owns_surface(i) ? 1 : 0;
    }
    const CacheBudgets caches = planner.caches(displaced, resident_bytes(), textures);
    if (const Result<void> made = set_up_surfaces(planner, caches); !made) return made;
    if (const Result<void> made = set_up_grid(); !made) return made;
    trees_ = nearest::make_patch_cache(caches.trees);
    nearest::set_max_pinned(trees_.get(), planner.max_pinned_bytes());
    set_up_parts(caches.crossings);
    if (options_.interrupted()) return interrupted_early();
    set_up_slabs();
    if (const Result<void> made = set_up_support(); !made) return made;
    if (options_.interrupted()) return interrupted_early();

    const Result<MemoryPlan> plan = plan_memory(planner, caches, displaced, textures);
    if (!plan) return plan.error();
    plan_ = *plan;
    for (const auto& surface : surfaces_)
        surface->set_cache_bytes(plan_.caches.micropolygons);
    nearest::set_budget(trees_.get(), plan_.caches.trees);
    setup_.rows_in_flight = plan_.rows_in_flight;
    fill_info();
    seconds_set_up_ = seconds_now() - start;
    return {};
}

/// Splits and dices displaced meshes; fails before allocating what cannot fit.
Result<void> PrintJobImpl::set_up_surfaces(const MemoryPlanner& planner,
                                           const CacheBudgets& caches) {
    surface::SurfaceOptions& options = surface_options_;
    options.micro_edge_mm = std::cbrt(input_.pitch_mm.x * input_.pitch_mm.y * input_.pitch_mm.z);
    options.isa = options_.isa;
    options.infer_identity = options_.infer_identity;
    options.stop = options_.interrupt;
    options.cache_bytes = caches.micropolygons;
    if (const Result<void> split = volume::split_meshes(owners_, options, &input_.parts); !split)
        return split;
    int64_t bytes = 0;
    for (size_t i = 0; i < owners_.size(); ++i)
        bytes += owns_surface(i) ? surface_bytes(input_.parts[i]) : 0;
    if (const Result<void> fits = planner.check(bytes, resident_bytes()); !fits) return fits;
    auto surfaces = volume::make_surfaces(input_.parts, owners_, options);
    if (!surfaces) return surfaces.error();
    surfaces_ = std::move(*surfaces);
    if (options_.interrupted()) return interrupted_early();
    warnings_ = crowded_warnings(input_.parts, owners_, surfaces_);
    bytes = 0;
    for (size_t i = 0; i < owners_.size(); ++i) {
        if (owns_surface(i))
            bytes += tree_bytes(*surfaces_[i], volume::asks_surface(*input_.parts[i].fablet));
    }
    return planner.check(bytes, resident_bytes());
}

/// Finds the grid around all surfaces and the slices of it that are printed.
Result<void> PrintJobImpl::set_up_grid() {
    Result<part::Grid> grid =
        make_grid(input_.parts, surfaces_, input_.pitch_mm,
                  abi::voxel_bits(static_cast<int32_t>(input_.materials.size())), input_.crop_mm,
                  input_.window_mm);
    if (options_.interrupted()) return interrupted_early();
    if (!grid) return grid.error();
    if (const Result<void> diced = surface_status(); !diced) return diced;
    grid_ = *grid;
    Result<Vec2<int32_t>> range = slice_range(grid_, options_);
    if (!range) return range.error();
    range_ = *range;
    return {};
}

/// Places the parts on the grid and orders them: higher priority first, then the later in the build
/// list.
void PrintJobImpl::set_up_parts(size_t crossing_bytes) {
    for (size_t i = 0; i < input_.parts.size(); ++i) {
        parts_.push_back(std::make_unique<volume::PlacedPart>(input_.parts[i]));
        parts_.back()->index = static_cast<int32_t>(i);
        parts_.back()->surface = surfaces_[i];
        setup_.order.push_back(static_cast<int32_t>(i));
    }
    place_parts(crossing_bytes);
    volume::resolve_object_queries(parts_, options_.isa, trees_);
    std::sort(setup_.order.begin(), setup_.order.end(), [&](int32_t a, int32_t b) {
        const int32_t pa = parts_[a]->part->priority;
        const int32_t pb = parts_[b]->part->priority;
        return pa != pb ? pa > pb : a > b;
    });
}

void PrintJobImpl::set_up_slabs() {
    setup_.parts = &parts_;
    const auto materials = static_cast<int32_t>(input_.materials.size());
    setup_.materials = model_materials(input_.parts, materials, input_.support_code);
    setup_.channels = dither::fraction_channels(setup_.materials);
    setup_.bits = abi::voxel_bits(materials);
    setup_.isa = options_.isa;
    setup_.dither = *dither::find_dither(options_.dither);
    setup_.seed = options_.seed;
    setup_.size = grid_.size;
    setup_.culling = options_.culling;
    setup_.interrupt = options_.interrupt;
    setup_.fractions = options_.fractions;
    setup_.separate_mixtures =
        setup_.fractions != nullptr &&
        std::any_of(parts_.begin(), parts_.end(), [](const auto& p) { return p->own_dither; });
}

Result<MemoryPlan> PrintJobImpl::plan_memory(const MemoryPlanner& planner,
                                             const CacheBudgets& caches,
                                             const SurfaceCounts& displaced,
                                             int64_t textures) const {
    SurfaceCounts diced;
    for (size_t i = 0; i < surfaces_.size(); ++i) {
        if (surfaces_[i]->identity()) continue;
        ++diced.parts;
        diced.surfaces += owns_surface(i) ? 1 : 0;
    }
    const int64_t columns = int64_t{grid_.size.x} * grid_.size.y;
    MemoryNeeds needs =
        memory_needs(parts_, grid_.size, setup_.channels, setup_.bits, planner.max_pinned_bytes());
    needs.fixed += textures + options_.sink_bytes_per_column * columns;
    if (options_.fractions != nullptr && setup_.separate_mixtures) needs.per_row *= 2;
    if (options_.fractions != nullptr)
        needs.per_row += int64_t{grid_.size.x} * setup_.materials * int64_t{sizeof(float)};
    const int32_t slabs = (range_.y + 7) / 8 - range_.x / 8;
    return planner.plan(needs, caches, displaced, diced, slabs, options_.slabs_in_flight);
}

void PrintJobImpl::fill_info() {
    info_.size = grid_.size;
    info_.pitch_mm = grid_.pitch_mm;
    info_.origin_mm = grid_.origin_mm;
    info_.slice_begin = range_.x;
    info_.slice_end = range_.y;
    info_.bits = setup_.bits;
    info_.materials = input_.materials;
    info_.support_code = input_.support_code;
    info_.printer = input_.printer;
    info_.title = input_.title;
    info_.seed = options_.seed;
    info_.provenance = provenance(input_, options_);
}

Result<void> PrintJobImpl::set_up_support() {
    if (input_.support_code == 0) return {};
    std::vector<support_material::SupportedPart> supported;
    for (const auto& part : parts_) {
        if (part->part->support)
            supported.push_back({part->part, part->surface.get(), part->patches.get(), part->box});
    }
    Result<support_material::DepthMap> map = support_material::DepthMap::create(
        supported, grid_, options_.memory_bytes - resident_bytes());
    if (!map) return map.error();
    support_ = std::make_unique<const support_material::DepthMap>(std::move(*map));
    setup_.support = {support_.get(), static_cast<uint8_t>(input_.support_code)};
    return {};
}

// In parallel: parts that own their surface first, since the others share theirs.
void PrintJobImpl::place_parts(size_t crossing_bytes) {
    for (const bool owners : {true, false}) {
        tbb::parallel_for(size_t{0}, parts_.size(), [&](size_t i) {
            if (owns_surface(i) != owners) return;
            parts_[i]->set_grid(grid_, options_.isa, trees_, crossing_bytes, *parts_[owners_[i]]);
            if (options_.dither == dither::kOwnDitherName)
                parts_[i]->set_own_dither(abi::fold_seed(options_.seed));
        });
    }
}

PrintEstimate PrintJobImpl::estimate() const {
    // Voxels of the grid per second and thread, typical of one evaluated layer around a culled
    // core.
    constexpr double kTypicalRate = 15e6;
    PrintEstimate estimate;
    estimate.size = grid_.size;
    estimate.voxels_total = int64_t{grid_.size.x} * grid_.size.y * (range_.y - range_.x);
    estimate.memory_bytes = plan_.total_bytes;
    estimate.seconds = static_cast<double>(estimate.voxels_total) / (kTypicalRate * threads_);
    return estimate;
}

int64_t PrintJobImpl::patches_diced() const {
    int64_t diced = 0;
    for (size_t i = 0; i < surfaces_.size(); ++i)
        diced += owns_surface(i) ? surfaces_[i]->counts().cache_misses : 0;
    return diced;
}

/// Does what TrySlab says. The coverage of the first slab has time of its own, and its seconds begin
/// with its blocks: its time is not known without some of them.
Result<SlabTrial> PrintJobImpl::try_slab(const SlabTry& wanted, const std::atomic<bool>& interrupt,
                                         TrialSlices* slices) {
    const auto evaluated = [&] {
        int64_t blocks = 0;
        for (const auto& e : evaluators_.all())
            blocks += e->counts.evaluated;
        return blocks;
    };
    const bool first = evaluators_.all().empty();
    if (wanted.drop_trees) {
        nearest::set_budget(trees_.get(), 0);
        nearest::set_budget(trees_.get(), plan_.caches.trees);
    }
    const int64_t before = evaluated(), diced = patches_diced();
    const int64_t trees = nearest::built_bytes(*trees_);
    const double start = seconds_now(), start_processor = processor_seconds();
    Deadline deadline(interrupt);
    setup_.interrupt = &deadline.passed();  // checked from one batch of blocks to the next
    deadline.start(first ? kCoverageSeconds : wanted.seconds);
    SlabRun* run = runs_.take([&] { return std::make_unique<SlabRun>(setup_); });
    abi::KernelStatus status = run->begin(wanted.slab, &evaluators_);
    SlabTrial trial;
    trial.blocks = status.ok() ? run->blocks_to_evaluate() : -1;
    trial.processor_seconds_begun = processor_seconds() - start_processor;
    trial.patches_begun = patches_diced() - diced;
    if (first) deadline.start(wanted.seconds);
    FinishedSlices finished;
    const SlabSlices of_slab = slices_of(wanted.slab);
    finished.first = of_slab.first;
    finished.end = of_slab.end;
    const StopFlags flags{deadline.passed()};
    trial.pieces = wanted.pieces;
    if (status.ok()) {
        status = run->try_rows(bits_of_slices(of_slab.first, of_slab.end), &evaluators_, flags,
                               &trial.pieces);
    }
    setup_.interrupt = options_.interrupt;
    segments::PrintfLog dropped;
    if (!run->log().empty()) dropped.append(&run->log());
    Result<void> taken;
    if (status.ok() && wanted.pieces == kAllPieces && slices->sink != nullptr) {
        encode(*slices->sink, *run, slices->next - of_slab.first, &finished);
        for (FinishedSlices::Slice& slice : finished.slices) {
            // In low prints slabs are tried again.
            if (slices->next == range_.y || !taken) break;
            taken = slices->sink->commit(slices->next++, std::move(slice.bytes));
        }
    }
    runs_.give(run);
    if (!taken) return taken.error();
    if (!status.ok() && !status.is_stopped()) {
        return internal_error(fmt::format("slices from {}: a kernel failed with code {}: {}",
                                          8 * wanted.slab, status.code(),
                                          abi::take_kernel_error()));
    }
    if (!status.ok() || wanted.pieces != kAllPieces) {
        trial.share = std::min(1.0, static_cast<double>(evaluated() - before) /
                                        static_cast<double>(std::max<int64_t>(trial.blocks, 1)));
    }
    trial.seconds = seconds_now() - start;
    trial.processor_seconds = processor_seconds() - start_processor;
    trial.patches_diced = patches_diced() - diced;
    trial.tree_bytes = nearest::built_bytes(*trees_) - trees;
    return trial;
}

Result<TimeSample> PrintJobImpl::sample_time(double seconds, pipeline::SliceSink* sink,
                                             const std::atomic<bool>& interrupt) {
    const double began = process_age_seconds() - options_.began_seconds;
    const double began_processor = processor_seconds();
    if (sink != nullptr) {
        if (const Result<void> begun = sink->begin(info_); !begun) return begun.error();
    }
    PatchNeeds needs;
    needs.tree_room = static_cast<int64_t>(plan_.caches.trees);
    for (size_t i = 0; i < surfaces_.size(); ++i) {
        if (owns_surface(i) && !surfaces_[i]->identity())
            needs.patches += static_cast<int64_t>(surfaces_[i]->patches().size());
    }
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<size_t>(threads_));
    tbb::task_arena arena(threads_);
    TrialSlices slices{sink, range_.x};
    Result<TimeSample> sample = arena.execute([&] {
        return pipeline::sample_time(slabs(), seconds, needs, [&](const SlabTry& wanted) {
            return try_slab(wanted, interrupt, &slices);
        });
    });
    if (sink != nullptr) {
        // It is told that the print ended early, and may say so.
        const Result<void> ended = sink->finish(pipeline::PrintTotals());
        (void)ended;
    }
    if (interrupt.load()) return Error{ErrorCode::kInterrupted, "interrupted"};
    if (sample) {
        sample->seconds += began;
        sample->processor_seconds += began_processor;
    }
    return sample;
}

Result<void> PrintJobImpl::run(pipeline::SliceSink& sink,
                               const std::function<void(const ProgressEvent&)>& progress,
                               const std::atomic<bool>& interrupt, PrintStatistics* statistics) {
    SliceCommitter committer(sink, progress, interrupt, info_, options_.print_line,
                             options_.began_seconds);
    if (const Result<void> begun = resume(sink, &committer); !begun) {
        committer.fail(begun.error());
    } else {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                        static_cast<size_t>(threads_));
        tbb::task_arena arena(threads_);
        arena.execute([&] {
            show_surface_logs(&committer);
            if (!committer.failed()) print_slabs(sink, &committer);
        });
    }
    committer.end_log();
    const bool complete = !committer.failed() && committer.slices() == range_.y - range_.x;

    pipeline::PrintTotals totals = print_totals(committer.totals(), input_.materials.size());
    totals.complete = complete;
    const double finish_start = seconds_now();
    Result<void> finished = sink.finish(totals);
    if (options_.fractions != nullptr) {
        const Result<void> fractions = options_.fractions->finish(totals);
        if (finished) finished = fractions;
    }
    seconds_finish_ = seconds_now() - finish_start;
    if (!finished && !committer.failed()) committer.fail(finished.error());

    fill_statistics(committer, statistics);
    statistics->complete = complete && !committer.failed();
    fill_voxels(totals, statistics);
    if (committer.failed()) return committer.error();
    if (!complete) {
        return Error{ErrorCode::kInterrupted,
                     fmt::format("interrupted after {} of {} slices; what was written is kept",
                                 committer.slices(), range_.y - range_.x)};
    }
    return {};
}

void PrintJobImpl::fill_voxels(const PrintTotals& totals, PrintStatistics* statistics) const {
    statistics->voxels_by_code = totals.voxels_by_code;
    if (input_.support_code != 0)
        statistics->voxels_support = totals.voxels_by_code[input_.support_code];
    statistics->voxels_solid = totals.voxels_solid - statistics->voxels_support;
}

Result<SlabsRun> PrintJobImpl::run_slabs(std::span<const int32_t> slabs, pipeline::SliceSink& sink,
                                         const std::atomic<bool>& interrupt,
                                         PrintStatistics* statistics) {
    std::vector<SlabSlices> all;
    PrintInfo info = info_;
    if (!slabs.empty()) info.slice_begin = slices_of(slabs.front()).first;
    info.slice_end = info.slice_begin;
    for (const int32_t slab : slabs) {
        SlabSlices& slices = all.emplace_back(slices_of(slab));
        slices.shift = info.slice_end - slices.first;
        info.slice_end += slices.end - slices.first;
    }
    const std::function<void(const ProgressEvent&)> no_progress;
    const std::function<void(const std::string&)> no_lines;
    SliceCommitter committer(sink, no_progress, interrupt, info, no_lines, options_.began_seconds);
    SlabsRun run;
    if (const Result<void> begun = sink.begin(info); !begun) return begun.error();
    // Else every second run of the same slabs would find crossings that the one before has left.
    for (const auto& part : parts_)
        part->voxeliser->drop_waiting();
    const double processor = processor_seconds();
    run.begin = seconds_now();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<size_t>(threads_));
    tbb::task_arena arena(threads_);
    size_t next = 0;
    setup_.interrupt = &interrupt;
    // Its own interrupt is looked at between batches of blocks; patches are always whole, since what
    // is made of them stays in caches for the next run.
    stop_surfaces_by(nullptr);
    arena.execute([&] {
        print_all([&] { return next < all.size() ? all[next++] : SlabSlices{}; }, sink, &committer);
    });
    stop_surfaces_by(options_.interrupt);
    setup_.interrupt = options_.interrupt;
    run.end = seconds_now();
    run.processor_seconds = processor_seconds() - processor;
    run.hash = committer.totals().hash;
    const bool complete =
        !committer.failed() && committer.slices() == info.slice_end - info.slice_begin;
    pipeline::PrintTotals totals = print_totals(committer.totals(), input_.materials.size());
    totals.complete = complete;
    const Result<void> finished = sink.finish(totals);
    if (committer.failed()) return committer.error();
    if (!complete) return Error{ErrorCode::kInterrupted, "interrupted"};
    if (!finished) return finished.error();
    if (statistics != nullptr) {
        fill_statistics(committer, statistics);
        statistics->complete = true;
        fill_voxels(totals, statistics);
    }
    return run;
}

void PrintJobImpl::stop_surfaces_by(const std::atomic<bool>* stop) const {
    for (size_t i = 0; i < surfaces_.size(); ++i) {
        if (owns_surface(i)) surfaces_[i]->set_stop(stop);
    }
}

/// Begins the sink, and counts slices that an earlier print has written.
Result<void> PrintJobImpl::resume(pipeline::SliceSink& sink, SliceCommitter* committer) {
    if (const Result<void> begun = sink.begin(info_); !begun) return begun;
    if (options_.fractions != nullptr) {
        const Result<void> begun = options_.fractions->begin(info_, setup_.materials);
        if (!begun) return begun;
    }
    const Result<int32_t> resumed = sink.resume(
        [&](const pipeline::SliceView& slice) { return committer->count_resumed(slice); });
    if (!resumed) return resumed.error();
    committer->end_resumed();
    return {};
}

Result<void> PrintJobImpl::slab_outcome() const {
    Result<void> outcome = surface_status();
    if (outcome && options_.fractions != nullptr) outcome = options_.fractions->status();
    return outcome;
}

/// A patch whose kernel failed is empty in all slabs from the first one that needed it.
Result<void> PrintJobImpl::surface_status() const {
    for (size_t i = 0; i < surfaces_.size(); ++i) {
        if (!owns_surface(i)) continue;
        const Result<void> status = surfaces_[i]->status();
        if (status) continue;
        return with_context(status.error(), fmt::format("part `{}`: ", input_.parts[i].name));
    }
    return {};
}

/// Shows what surface stages print, before the voxels: of surfaces of their own on which nothing is
/// inferred, since those that are printed are evaluated where, and as often as, they are needed.
void PrintJobImpl::show_surface_logs(SliceCommitter* committer) {
    surface::SurfaceOptions options = surface_options_;
    options.infer_identity = false;
    for (size_t i = 0; i < input_.parts.size(); ++i) {
        const part::Part& part = input_.parts[i];
        if (!owns_surface(i) || part.fablet->surface_segments.printf_count == 0) continue;
        if (committer->stopped()) return;
        const auto surface = surface::Surface::create(part, options);
        if (!surface) return committer->fail(surface.error());
        segments::PrintfLog log;
        (*surface)->log(&log);
        if (const Result<void> status = (*surface)->status(); !status)
            return committer->fail(status.error());
        if (!committer->show_log(log)) return;
    }
}

void PrintJobImpl::print_slabs(pipeline::SliceSink& sink, SliceCommitter* committer) {
    if (committer->slices() == range_.y - range_.x) return;
    // Start with the slab of the last resumed slice.
    int32_t next = (range_.x + std::max(committer->resumed() - 1, 0)) / 8;
    const int32_t end = (range_.y + 7) / 8;
    // The first slab runs alone: all threads work on its rows, and the first slices are early.
    if (next < end) print_first_slab(next++, sink, committer);
    print_all([&] { return next < end ? slices_of(next++) : SlabSlices{}; }, sink, committer);
}

void PrintJobImpl::print_all(const std::function<SlabSlices()>& next,
                             const pipeline::SliceSink& sink, SliceCommitter* committer) {
    const auto source = [&](tbb::flow_control& control) {
        SlabSlices slices;
        if (!committer->stopped()) slices = next();
        if (slices.slab < 0) control.stop();
        return slices;
    };
    const auto print = [&](const SlabSlices& slab) {
        return std::make_shared<FinishedSlices>(print_slab(slab, sink, committer));
    };
    const auto commit = [&](const std::shared_ptr<FinishedSlices>& finished) {
        committer->commit(std::move(*finished));
    };
    // A slab's token is released when its slices are written, which throttles the others if the
    // sink is slow.
    using Finished = std::shared_ptr<FinishedSlices>;
    tbb::parallel_pipeline(
        static_cast<size_t>(plan_.slabs_in_flight),
        tbb::make_filter<void, SlabSlices>(tbb::filter_mode::serial_in_order, source) &
            tbb::make_filter<SlabSlices, Finished>(tbb::filter_mode::parallel, print) &
            tbb::make_filter<Finished, void>(tbb::filter_mode::serial_in_order, commit));
}

void PrintJobImpl::print_first_slab(int32_t slab, const pipeline::SliceSink& sink,
                                    SliceCommitter* committer) {
    SlabRun* run = runs_.take([&] { return std::make_unique<SlabRun>(setup_); });
    const abi::KernelStatus begun = run->begin(slab, &evaluators_);
    SlabSlices slices = slices_of(slab);
    // printf lines are ordered by column of a slab, which printing a single slice would break.
    const bool has_printf = std::any_of(parts_.begin(), parts_.end(), [](const auto& p) {
        return p->part->fablet->volume_segments.printf_count > 0;
    });
    if (slices.first + 1 < slices.end &&
        run->blocks_to_evaluate() > options_.most_blocks_at_first && !has_printf) {
        const SlabSlices alone{slab, slices.first, slices.first + 1, 0};
        committer->commit(print_slices(alone, begun, run, sink, committer));
        ++slices.first;
    }
    committer->commit(print_slices(slices, begun, run, sink, committer));
    runs_.give(run);
}

FinishedSlices PrintJobImpl::print_slab(const SlabSlices& slab, const pipeline::SliceSink& sink,
                                        SliceCommitter* committer) {
    SlabRun* run = runs_.take([&] { return std::make_unique<SlabRun>(setup_); });
    const abi::KernelStatus begun = run->begin(slab.slab, &evaluators_);
    FinishedSlices finished = print_slices(slab, begun, run, sink, committer);
    runs_.give(run);
    return finished;
}

// Prints slices of the slab that `run` has begun with the status `begun`.
FinishedSlices PrintJobImpl::print_slices(const SlabSlices& slices, abi::KernelStatus begun,
                                          SlabRun* run, const pipeline::SliceSink& sink,
                                          SliceCommitter* committer) {
    FinishedSlices finished;
    finished.first = slices.first;
    finished.end = slices.end;
    const uint8_t bits = bits_of_slices(slices.first, slices.end);
    finished.status = begun.ok() ? run->run(bits, &evaluators_, committer->stop_flags()) : begun;
    if (!run->log().empty()) finished.log.append(&run->log());
    if (!finished.status.ok()) {
        finished.kernel_error = abi::take_kernel_error();
    } else if (finished.outcome = slab_outcome(); !finished.outcome) {
        // Slices printed with an empty patch, or without their fractions, must not be committed.
    } else if (committer->stopped()) {
        finished.status = abi::KernelStatus::stopped();
    } else {
        encode(sink, *run, slices.shift, &finished);
    }
    return finished;
}

void PrintJobImpl::encode(const pipeline::SliceSink& sink, const SlabRun& run, int32_t shift,
                          FinishedSlices* finished) {
    const dither::SlabPlanes& planes = run.planes();
    const int32_t first = finished->first, end = finished->end;
    finished->slices.resize(static_cast<size_t>(end - first));
    tbb::this_task_arena::isolate([&] {
        tbb::parallel_for(first, end, [&](int32_t z) {
            FinishedSlices::Slice& slice = finished->slices[static_cast<size_t>(z - first)];
            pipeline::SliceView view;
            view.z = z + shift;
            view.data = planes.data.get() + (z & 7) * planes.plane_bytes;
            view.row_bytes = static_cast<size_t>(planes.row_bytes);
            view.width = planes.width;
            view.height = planes.height;
            slice.z = view.z;
            double counting = 0, encoding = 0;
            {
                const StageTimer timer(Stage::kCount, &counting);
                slice.totals = count_slice(view, info_.bits);
            }
            {
                const StageTimer timer(Stage::kEncode, &encoding);
                slice.bytes = sink.encode(view);
            }
            const std::lock_guard lock(encode_mutex_);
            seconds_count_ += counting;
            seconds_encode_ += encoding;
        });
    });
}

void PrintJobImpl::fill_statistics(const SliceCommitter& committer, PrintStatistics* s) {
    *s = {};
    s->tight = committer.totals().tight;
    if (!s->tight.empty()) {
        const Vec3i size = s->tight.size();
        s->voxels_total = int64_t{size.x} * size.y * size.z;
    }
    s->slices = committer.slices();
    s->slices_resumed = committer.resumed();
    s->voxels_solid_resumed = committer.solid_resumed();
    s->hash = committer.totals().hash;
    s->threads = threads_;
    s->sink_bytes = committer.bytes();
    s->warnings = input_.warnings;
    s->warnings.insert(s->warnings.end(), warnings_.begin(), warnings_.end());
    volume::EvaluationCounts sum;
    double seconds_nearest = 0;
    for (const auto& e : evaluators_.all()) {
        const nearest::QueryCounts queries = e->query_counts();
        s->queries_asked += queries.queried;
        s->queries_skipped += queries.skipped;
        s->blocks_total += e->counts.total;
        s->blocks_filled += e->counts.filled;
        s->blocks_evaluated += e->counts.evaluated;
        s->weights_not_usable += e->counts.unusable;
        s->columns_evaluated += e->counts.columns;
        s->nearest_bytes += e->counts.nearest_bytes;
        s->slab_bytes += e->counts.slab_bytes;
        sum.seconds_bounds += e->counts.seconds_bounds;
        // What threads of a kernel's own took is not part of its caller's time.
        const double nearest = e->seconds_nearest();
        seconds_nearest += nearest;
        sum.seconds_slab += std::max(0.0, e->counts.seconds_slab - nearest);
    }
    SlabTimes times;
    Overlaps overlaps;
    for (const auto& r : runs_.all()) {
        times.coverage += r->times.coverage;
        times.dither += r->times.dither;
        times.support += r->times.support;
        times.pack += r->times.pack;
        overlaps.add(r->overlaps());
    }
    for (std::string& line : overlaps.report(input_.parts, grid_))
        s->late_warnings.push_back(std::move(line));
    s->seconds_by_stage = {{"set_up", seconds_set_up_},
                           {"coverage", times.coverage},
                           {"volume_bounds", sum.seconds_bounds},
                           {"nearest", seconds_nearest},
                           {"slab", sum.seconds_slab},
                           {"dither", times.dither},
                           {"support", times.support},
                           {"pack", times.pack},
                           {"count", seconds_count_},
                           {"encode", seconds_encode_},
                           {"commit", committer.seconds_commit()},
                           {"finish", seconds_finish_}};
    for (size_t i = 0; i < surfaces_.size(); ++i) {
        if (!owns_surface(i)) continue;
        const surface::SurfaceCounts counts = surfaces_[i]->counts();
        s->cache_hits += counts.cache_hits;
        s->cache_misses += counts.cache_misses;
        s->cache_evictions += counts.cache_evictions;
        s->cache_peak_bytes += counts.cache_peak_bytes;
        s->displacements_not_finite += counts.not_finite;
        s->displacements_cut += counts.cut_to_bound;
        for (std::string& line : surface::displacement_warnings(input_.parts[i], counts))
            s->late_warnings.push_back(std::move(line));
    }
    s->warnings.insert(s->warnings.end(), s->late_warnings.begin(), s->late_warnings.end());
    s->peak_rss_bytes = peak_resident_bytes();
    s->seconds_first_slice = committer.first_slice();
    s->seconds_total = process_age_seconds() - options_.began_seconds;
}

}  // namespace

Result<std::unique_ptr<PrintJob>> PrintJob::create(PrintInput input, PrintOptions options) {
    auto job = std::make_unique<PrintJobImpl>(std::move(input), std::move(options));
    const Result<void> made = job->set_up();
    if (!made) return made.error();
    return std::unique_ptr<PrintJob>(std::move(job));
}

}  // namespace openfab::pipeline
