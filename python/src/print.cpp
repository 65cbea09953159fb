// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "python/src/print.h"

#include <chrono>
#include <exception>
#include <new>
#include <utility>

#include "backends/common/tee_sink.h"
#include "backends/preview/preview.h"
#include "backends/raster/fraction_average.h"
#include "base/clock.h"
#include "program/cost.h"
#include "program/estimate.h"
#include "program/outputs.h"
#include "program/statistics.h"
#include "program/supersample.h"

namespace openfab::python {

namespace {

/// Passes slices on to a queue that outlives it.
class ToQueue : public pipeline::SliceSink {
  public:
    explicit ToQueue(SliceQueue* queue) : queue_(queue) {}
    Result<void> begin(const pipeline::PrintInfo& info) override { return queue_->begin(info); }
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override {
        return queue_->encode(slice);
    }
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override {
        return queue_->commit(z, std::move(bytes));
    }
    Result<void> finish(const pipeline::PrintTotals& totals) override {
        return queue_->finish(totals);
    }

  private:
    SliceQueue* queue_;
};

/// Passes means on, in slices without codes, once the finer print is past them.
class MeansToQueue : public backends::NullSink {
  public:
    MeansToQueue(SliceQueue* queue, raster::FractionAverage* average,
                 const pipeline::PrintInfo& coarse, int32_t parts_z)
        : queue_(*queue), average_(*average), coarse_(coarse), parts_z_(parts_z) {}
    Result<void> commit(int32_t z, std::vector<uint8_t>) override {
        average_.passed(z);
        if ((z + 1) % parts_z_ != 0) return {};
        const size_t voxels =
            static_cast<size_t>(coarse_.size.x) * static_cast<size_t>(coarse_.size.y);
        return queue_.commit(coarse_.slice_begin + z / parts_z_, std::vector<uint8_t>(voxels));
    }

  private:
    SliceQueue& queue_;
    raster::FractionAverage& average_;
    const pipeline::PrintInfo& coarse_;
    const int32_t parts_z_;
};

}  // namespace

Print::Print(std::shared_ptr<const Program> program, program::Options options, Target target,
             bool fractions, std::string output, std::optional<Box3d> window_mm,
             std::vector<std::string> derivatives)
    : program_(std::move(program)),
      target_(target),
      wants_fractions_(fractions),
      output_(std::move(output)),
      window_mm_(window_mm),
      derivatives_(std::move(derivatives)),
      options_(std::move(options)),
      queue_(fractions ? &planes_ : nullptr),
      thread_([this] { run(); }) {}

Print::~Print() {
    cancel();
    join();
}

void Print::cancel() {
    interrupt_ = true;
    queue_.close();
}

void Print::join() {
    if (thread_.joinable()) thread_.join();
}

Print::State Print::state() const {
    const std::lock_guard lock(mutex_);
    return state_;
}

Print::State Print::wait_while(State state, double seconds) const {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::duration<double>(seconds),
                      [&] { return state_ != state; });
    return state_;
}

void Print::set_state(State state) {
    {
        const std::lock_guard lock(mutex_);
        state_ = state;
    }
    changed_.notify_all();
}

pipeline::ProgressEvent Print::progress() const {
    const std::lock_guard lock(mutex_);
    return progress_;
}

std::vector<std::string> Print::take_notes() {
    const std::lock_guard lock(mutex_);
    return std::exchange(notes_, {});
}

std::vector<std::string> Print::take_warnings() {
    const std::lock_guard lock(mutex_);
    return std::exchange(warnings_, {});
}

std::vector<std::string> Print::take_lines() {
    const std::lock_guard lock(mutex_);
    return std::exchange(lines_, {});
}

void Print::run() {
    // Ours throws nothing, but libraries do where memory runs out; no exception may leave a thread.
    try {
        if (const Result<void> done = print(); !done) error_ = done.error();
    } catch (const std::bad_alloc&) {
        error_ = outside_error("memory ran out");
    } catch (const std::exception& exception) {
        error_ = internal_error(exception.what());
    }
    set_state(State::kEnded);
    queue_.close();
}

Result<void> Print::print() {
    options_.estimate = target_ == Target::kEstimate;
    program::PrintHooks hooks{.interrupt = interrupt_};
    hooks.window_mm = window_mm_;
    hooks.began_seconds = process_age_seconds();
    hooks.loaded = [this](const program::Job& job) {
        const std::lock_guard lock(mutex_);
        notes_ = job.notes;
        warnings_ = job.input.warnings;
    };
    hooks.print_line = [this](const std::string& line) {
        const std::lock_guard lock(mutex_);
        lines_.push_back(line);
    };
    Vec3i parts{1, 1, 1};
    if (wants_fractions_) {
        hooks.fractions = &planes_;
        hooks.loaded = [this, &parts, told = hooks.loaded](const program::Job& job) {
            told(job);
            const Vec3d &pitch = job.input.pitch_mm, &own = job.printer.pitch_mm;
            parts = program::fraction_parts(options_, pitch, own);
            std::string note = program::describe_parts(parts, options_, pitch, own);
            const std::lock_guard lock(mutex_);
            if (!note.empty()) notes_.push_back(std::move(note));
        };
    }
    if (!derivatives_.empty()) {
        hooks.rates = [this](const program::Job& job) {
            Result<pipeline::Rates> rates = program::find_rates(
                job, derivatives_,
                [this](const openfab_fablet& fablet) { return program_->directions(fablet); },
                &rate_columns_);
            if (rates) planes_.expect_rates(rates->columns);
            return rates;
        };
    }
    if (target_ == Target::kSlices) {
        // Those in the queue, and of four slabs in flight.
        constexpr int64_t kSlices = SliceQueue::kMostSlices + 4 * 8;
        hooks.sink_bytes_per_column = kSlices;
        if (wants_fractions_) hooks.sink_bytes_per_fraction = kSlices * int64_t{sizeof(float)};
    }
    Result<program::PreparedPrint> ready =
        program::prepare_print(options_, program_->fablets(), hooks);
    if (!ready) return ready.error();
    info_ = ready->print->info();
    estimate_ = ready->print->estimate();
    {
        const std::lock_guard lock(mutex_);
        for (const std::string& warning : ready->print->warnings())
            warnings_.push_back(warning);
    }
    if (target_ == Target::kNothing) return {};
    if (target_ == Target::kEstimate) return make_estimate(std::move(*ready));
    const std::string sizes = ready->print->part_sizes();
    ready->job.input = {};
    if (parts != Vec3i{1, 1, 1}) {
        ready->print.reset();  // and its memory
        return print_means(parts);
    }
    Result<std::unique_ptr<pipeline::SliceSink>> sink =
        open_sink(ready->job.printer, ready->mixtures.get());
    if (!sink) return sink.error();
    set_state(State::kPrinting);
    pipeline::PrintStatistics statistics;
    const Result<void> done = ready->print->run(
        **sink,
        [this](const pipeline::ProgressEvent& event) {
            const std::lock_guard lock(mutex_);
            progress_ = event;
        },
        interrupt_, &statistics);
    program::add_cost(ready->job.printer, info_, &statistics);
    std::vector<std::string> found = statistics.late_warnings;
    if (std::string lost =
            program::lost_mixtures(statistics, options_.dither, ready->format, ready->job.printer);
        !lost.empty())
        found.push_back(std::move(lost));
    const std::string nothing = program::nothing_printed(statistics, sizes);
    // A window may well be one of air.
    if (!nothing.empty() && !window_mm_) {
        statistics.warnings.push_back(nothing);
        found.push_back(nothing);
    }
    statistics_ = program::statistics_json(statistics, info_);
    const std::lock_guard lock(mutex_);
    warnings_.insert(warnings_.end(), found.begin(), found.end());
    if (nothing.empty())
        notes_.insert(notes_.end(), statistics.notes.begin(), statistics.notes.end());
    return done;
}

Result<void> Print::make_estimate(program::PreparedPrint ready) {
    set_state(State::kPrinting);
    const Result<program::Estimate> made =
        program::make_estimate(std::move(ready.print), ready.job.input, ready.options, options_,
                               ready.format, ready.job.printer, interrupt_);
    if (!made) return made.error();
    statistics_ = program::estimate_json(*made, info_);
    return {};
}

Result<void> Print::print_means(const Vec3i& parts) {
    program::PrintHooks hooks{.interrupt = interrupt_};
    hooks.window_mm = program::box_of_slices(info_);
    hooks.began_seconds = process_age_seconds();
    hooks.sink_bytes_per_fraction =
        program::bytes_of_means(options_, parts) +
        static_cast<int64_t>(SliceQueue::kMostSlices * sizeof(float)) / (parts.x * parts.y);
    raster::FractionAverage average(info_, parts, &planes_);
    hooks.fractions = &average;
    Result<program::PreparedPrint> ready = program::prepare_print(
        program::options_of_parts(options_, info_, parts), program_->fablets(), hooks);
    if (!ready) return ready.error();
    set_state(State::kPrinting);
    MeansToQueue sink(&queue_, &average, info_, parts.z);
    pipeline::PrintStatistics statistics;
    const Result<void> done = ready->print->run(
        sink,
        [&](const pipeline::ProgressEvent& event) {
            const std::lock_guard lock(mutex_);
            progress_ = event;
            progress_.slices_done /= parts.z;
            progress_.slices_total /= parts.z;
        },
        interrupt_, &statistics);
    statistics_ = program::statistics_json(statistics, ready->print->info());
    const std::lock_guard lock(mutex_);
    warnings_.insert(warnings_.end(), statistics.late_warnings.begin(),
                     statistics.late_warnings.end());
    return done;
}

Result<std::unique_ptr<pipeline::SliceSink>> Print::open_sink(const world::Printer& printer,
                                                              backends::MixtureInlet* mixtures) {
    if (target_ == Target::kSlices)
        return std::unique_ptr<pipeline::SliceSink>(std::make_unique<ToQueue>(&queue_));
    if (target_ == Target::kOutput) {
        if (!output_.empty()) options_.output = output_;
        return program::open_output(options_, printer, &interrupt_, mixtures);
    }
    std::vector<std::unique_ptr<backends::SliceObserver>> observers;
    pictures_.resize(options_.previews.size());
    for (size_t i = 0; i < pictures_.size(); ++i) {
        observers.push_back(preview::make_preview(
            options_.previews[i],
            [out = &pictures_[i]](const preview::Picture& picture) -> Result<void> {
                *out = {picture.width, picture.height, preview::to_rgba8(picture)};
                return {};
            }));
    }
    return std::unique_ptr<pipeline::SliceSink>(std::make_unique<backends::TeeSink>(
        std::make_unique<backends::NullSink>(), std::move(observers)));
}

}  // namespace openfab::python
