// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes an `.ofr` file or stream (backends/ofr/format.h).

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backends/common/output_file.h"
#include "backends/ofr/format.h"
#include "backends/ofr/ofr_reader.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::ofr {

class OfrSink : public pipeline::SliceSink {
  public:
    /// Creates the output; `path` may be `-` for standard output. The file exists from the start
    /// and always holds whole slices; on a full disk it is truncated to the last whole one.
    static Result<std::unique_ptr<pipeline::SliceSink>> create(const std::string& path);
    /// Reopens the file of an interrupted print, to be resumed; starts one that does not exist or
    /// has no complete header. Fails with a usage error for anything but a file.
    static Result<std::unique_ptr<pipeline::SliceSink>> reopen(const std::string& path);

    /// For a file that is resumed, fails where its header is not that of the same print.
    Result<void> begin(const pipeline::PrintInfo& info) override;
    Result<int32_t> resume(const std::function<bool(const pipeline::SliceView&)>& show) override;
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override;
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override;
    Result<void> finish(const pipeline::PrintTotals& totals) override;

  private:
    enum class State {
        kWriting,
        kReading,   ///< an earlier print's file, still unchanged
        kComplete,  ///< an earlier print's file that is complete
    };

    OfrSink(backends::OutputFile file, State state) : file_(std::move(file)), state_(state) {}
    /// Adds to an error how many slices are usable, and how much space the rest needs.
    Error with_resume_state(const Error& error) const;

    backends::OutputFile file_;
    State state_;
    std::unique_ptr<OfrReader> earlier_;  ///< between begin and resume
    pipeline::PrintInfo info_;
    std::vector<IndexEntry> entries_;
    bool broken_ = false;
};

}  // namespace openfab::ofr
