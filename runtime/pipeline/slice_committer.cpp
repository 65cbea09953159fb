// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/slice_committer.h"

#include <fmt/format.h>

#include <numeric>
#include <utility>

#include "base/check.h"
#include "base/clock.h"
#include "base/stage_timer.h"
#include "runtime/pipeline/messages.h"

namespace openfab::pipeline {

int64_t solid_of(const SliceTotals& totals) {
    return std::accumulate(totals.by_code.begin() + 1, totals.by_code.end(), int64_t{0});
}

PrintTotals print_totals(const SliceTotals& counted, size_t materials) {
    PrintTotals totals;
    totals.voxels_by_code.assign(
        counted.by_code.begin(),
        counted.by_code.begin() + static_cast<std::ptrdiff_t>(materials + 1));
    totals.voxels_solid = solid_of(counted);
    totals.hash = counted.hash;
    totals.tight = counted.tight;
    return totals;
}

void SliceCommitter::commit(FinishedSlices slab) {
    if (failed_ || ended_) return;
    if (!slab.status.ok()) {
        ended_ = true;
        stop_.failed.store(true);
        if (slab.status.is_stopped()) return;
        fail(internal_error(fmt::format(messages::kKernelFailed, slab.first, slab.end - 1,
                                        slab.status.code(), slab.kernel_error)));
        return;
    }
    if (!show_log(slab.log)) return;
    if (!slab.outcome) return fail(slab.outcome.error());
    for (FinishedSlices::Slice& slice : slab.slices) {
        if (slice.z < info_.slice_begin + resumed_) {
            if (!matches_resumed_slice(slice)) return;
            continue;
        }
        OPENFAB_CHECK_EQ(slice.z, info_.slice_begin + slices_);  // the sink requires it
        const auto bytes = static_cast<int64_t>(slice.bytes.size());
        Result<void> written;
        {
            const StageTimer timer(Stage::kCommit, &seconds_commit_);
            written = sink_.commit(slice.z, std::move(slice.bytes));
        }
        if (!written) {
            fail(written.error());
            return;
        }
        bytes_ += bytes;
        if (slices_ == resumed_) first_slice_ = process_age_seconds() - began_;
        ++slices_;
        totals_.add(slice.totals);
        report();
    }
}

bool SliceCommitter::count_resumed(const SliceView& slice) {
    OPENFAB_CHECK_EQ(slice.z, info_.slice_begin + slices_);
    const SliceTotals totals = count_slice(slice, info_.bits);
    last_resumed_[static_cast<size_t>(slice.z & 7)] = totals.hash;
    totals_.add(totals);
    ++slices_;
    resumed_ = slices_;
    return !stop_.requested();
}

void SliceCommitter::end_resumed() {
    solid_resumed_ = solid_of(totals_);
    if (info_.support_code != 0) solid_resumed_ -= totals_.by_code[info_.support_code];
}

void SliceCommitter::fail(Error error) {
    failed_ = true;
    stop_.failed.store(true);
    error_ = std::move(error);
}

void SliceCommitter::end_log() {
    if (!print_line_) return;
    for (const auto& [print, count] : log_.left_out()) {
        print_line_(fmt::format(messages::kLinesNotShown, print->source, print->line, count,
                                count == 1 ? "" : "s"));
    }
}

bool SliceCommitter::show_log(segments::PrintfLog& log) {
    if (log.empty()) return true;
    const size_t shown = log_.lines().size();
    log_.append(&log);
    for (size_t i = shown; i < log_.lines().size(); ++i) {
        const segments::PrintfLog::Line& line = log_.lines()[i];
        if (line.print->is_assert != 0) {
            fail(user_error(line.text));
            return false;
        }
        if (print_line_) print_line_(line.text);
    }
    return true;
}

/// Resumed slices must equal those of this print: those of the first slab are printed again and
/// compared.
bool SliceCommitter::matches_resumed_slice(const FinishedSlices::Slice& slice) {
    if (slice.totals.hash == last_resumed_[static_cast<size_t>(slice.z & 7)]) return true;
    fail(user_error(fmt::format(messages::kSliceDiffers, slice.z)));
    return false;
}

void SliceCommitter::report() {
    if (!progress_) return;
    const int64_t slice_voxels = int64_t{info_.size.x} * info_.size.y;
    ProgressEvent event;
    event.slices_done = slices_;
    event.slices_total = info_.slice_end - info_.slice_begin;
    event.voxels_done = slices_ * slice_voxels;
    event.voxels_total = event.slices_total * slice_voxels;
    event.seconds = process_age_seconds() - began_;
    progress_(event);
}

}  // namespace openfab::pipeline
