// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Passes slices on, and has the record of the print tell its story.

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "backends/job/record.h"

namespace openfab::job {

class RecordedSink : public pipeline::SliceSink {
  public:
    /// `record` must outlive this. `from`: see Record::start.
    /// `cut`: the reason of a stop of which only this sink knows, unless its host said why before.
    RecordedSink(std::unique_ptr<pipeline::SliceSink> sink, Record* record, std::string from = {},
                 StopReason cut = {})
        : sink_(std::move(sink)), record_(record), from_(std::move(from)), cut_(std::move(cut)) {}

    Result<void> begin(const pipeline::PrintInfo& info) override {
        info_ = info;
        return sink_->begin(info);
    }
    Result<int32_t> resume(const std::function<bool(const pipeline::SliceView&)>& show) override {
        Result<int32_t> kept = sink_->resume(show);
        if (kept) record_->start(info_, *kept, from_);
        return kept;
    }
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override {
        return sink_->encode(slice);
    }
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override {
        Result<void> done = sink_->commit(z, std::move(bytes));
        if (done) record_->add(1);
        return done;
    }
    /// Tells of the end where the print is complete; why it is not, its host knows, unless it said so before.
    Result<void> finish(const pipeline::PrintTotals& totals) override {
        Result<void> done = sink_->finish(totals);
        if (done && totals.complete) record_->complete(totals.hash);
        if (!totals.complete && !cut_.by.empty() && !record_->has_stopped()) record_->stop(cut_);
        return done;
    }

  private:
    std::unique_ptr<pipeline::SliceSink> sink_;
    Record* record_;
    std::string from_;
    StopReason cut_;
    pipeline::PrintInfo info_;
};

}  // namespace openfab::job
