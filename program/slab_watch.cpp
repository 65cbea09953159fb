// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/slab_watch.h"

#include <fmt/format.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "base/clean_exit.h"
#include "base/clock.h"
#include "base/units.h"
#include "program/messages.h"
#include "program/stop_reason.h"

namespace openfab::program {

namespace {

using pipeline::SlabClock;

constexpr double kPatienceSeconds = 30;
constexpr auto kLook = std::chrono::milliseconds(50);
/// How long a slab has to end in order: some stages look at nothing while they run.
constexpr double kGraceSeconds = 1;

Error too_long_error(const SlabClock::Slab& slab, double limit, int32_t slices_before) {
    return user_error(fmt::format(messages::kSlabTooLong, slab.first, slab.end - 1,
                                  format_seconds(limit), slices_before),
                      messages::kSlabTooLongHelp);
}

/// A thread that looks at the clock until it is destroyed.
class Watch {
  public:
    Watch(const SlabClock& clock, std::optional<double> limit, const std::atomic<bool>& interrupt,
          Progress* progress, job::Record* record)
        : clock_(clock),
          limit_(limit),
          patience_(limit),
          interrupt_(interrupt),
          progress_(*progress),
          record_(record) {
        thread_ = std::thread([this] { run(); });
    }
    ~Watch() {
        {
            const std::lock_guard lock(mutex_);
            ends_ = true;
        }
        ended_.notify_all();
        thread_.join();
    }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

    /// Set once the print is to end.
    const std::atomic<bool>& stop() const { return stop_; }
    /// Is told how far the print is.
    void update(int32_t slices_done) { slices_done_.store(slices_done); }
    /// Returns why it ended the print; none where it did not.
    std::optional<Error> why() const {
        const std::lock_guard lock(mutex_);
        if (!too_long_) return {};
        return too_long_error(*too_long_, *limit_, slices_done_.load());
    }

  private:
    void run() {
        std::unique_lock lock(mutex_);
        while (!ended_.wait_for(lock, kLook, [&] { return ends_; })) {
            if (interrupt_.load() && !stop_.exchange(true) && record_ != nullptr)
                record_->stop(signal_reason());
            const std::optional<SlabClock::Slab> slab = clock_.oldest();
            if (!slab) continue;
            const double now = seconds_now();
            if (patience_.tells(*slab, now))
                progress_.slow(slab->first, slab->end - 1, now - slab->began_seconds);
            if (!stop_.load() && patience_.is_over(*slab, now)) {
                too_long_ = slab;
                over_seconds_ = now;
                stop_.store(true);
                if (record_ != nullptr) {
                    record_->stop(stop_reason(too_long_error(*slab, *limit_, slices_done_.load())));
                }
            }
            if (too_long_ && too_long_->first == slab->first &&
                now - over_seconds_ > kGraceSeconds) {
                // As after a signal: whole slices stay.
                const Error error = too_long_error(*slab, *limit_, slices_done_.load());
                progress_.fail(error, {});
                end_cleanly(exit_code(error.code));
            }
        }
    }

    const SlabClock& clock_;
    const std::optional<double> limit_;
    SlabPatience patience_;
    const std::atomic<bool>& interrupt_;
    Progress& progress_;
    job::Record* record_;
    std::atomic<bool> stop_{false};
    std::atomic<int32_t> slices_done_{0};
    std::optional<SlabClock::Slab> too_long_;  ///< it and the next: guarded by the mutex
    double over_seconds_ = 0;
    mutable std::mutex mutex_;
    std::condition_variable ended_;
    bool ends_ = false;
    std::thread thread_;
};

}  // namespace

bool SlabPatience::tells(const SlabClock::Slab& slab, double now_seconds) {
    const double taken = now_seconds - slab.began_seconds;
    if (slab.began_seconds != began_) {
        began_ = slab.began_seconds;
        due_ = kPatienceSeconds;
    }
    if (taken < due_) return false;
    while (due_ <= taken)
        due_ *= 2;
    return true;
}

Result<void> run_watched(pipeline::PrintJob* print, pipeline::SliceSink& sink,
                         const std::function<void(const pipeline::ProgressEvent&)>& update,
                         const std::atomic<bool>& interrupt, const SlabClock& clock,
                         const Options& options, Progress* progress,
                         pipeline::PrintStatistics* statistics, job::Record* record) {
    Watch watch(clock, options.slab_limit_seconds, interrupt, progress, record);
    const auto told = [&](const pipeline::ProgressEvent& event) {
        watch.update(event.slices_done);
        update(event);
    };
    // A signal is seen at once where no limit may end the print, too.
    Result<void> done =
        print->run(sink, told, options.slab_limit_seconds ? watch.stop() : interrupt, statistics);
    if (done || done.error().code != ErrorCode::kInterrupted) return done;
    const std::optional<Error> why = watch.why();
    return why ? Result<void>(*why) : done;
}

}  // namespace openfab::program
