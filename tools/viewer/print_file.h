// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// An `.ofr` file of which any slice can be read, also while a print still writes it. A finished
// file is opened by its index; of one without, slices are found from head to head, so that what was
// written since costs a few bytes a slice to see.

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "backends/ofr/format.h"
#include "base/input_file.h"
#include "base/result.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::viewer {

/// Buffers that a reader keeps from slice to slice.
struct SliceBuffers {
    std::vector<uint8_t> frame;
    std::vector<uint8_t> rows;  ///< packed rows of the slice, lowest y first
};

/// All functions are thread-safe.
class PrintFile {
  public:
    /// Opens and reads the header, and finds the slices that are there. Refuses slices that take
    /// more than a fourth of `memory_bytes`. Errors name the file.
    static Result<std::unique_ptr<PrintFile>> open(const std::string& path, int64_t memory_bytes);

    const pipeline::PrintInfo& info() const { return info_; }
    const std::string& path() const { return path_; }
    size_t row_bytes() const { return row_bytes_; }
    int64_t slice_bytes() const { return static_cast<int64_t>(row_bytes_) * info_.size.y; }

    /// Returns the number of slices that can be read, from info().slice_begin on.
    int32_t whole_slices() const;
    /// Returns the totals once the file is complete.
    std::optional<pipeline::PrintTotals> totals() const;
    /// Finds what was written since. Returns whether there is anything new.
    bool look_again();
    /// Returns whether the path leads to another file by now, or this one was begun anew.
    bool was_replaced() const;

    /// Reads one slice into `buffers->rows` and checks it against its checksum.
    Result<void> read_slice(int32_t z, SliceBuffers* buffers) const;

  private:
    PrintFile(std::string path, InputFile file) : path_(std::move(path)), file_(std::move(file)) {}

    Result<void> read_header();
    /// Returns whether the file has an index, which then is taken.
    bool take_index(uint64_t offset);
    bool take_index_at_end();
    int64_t bytes_now() const;
    bool read_exactly(uint64_t at, void* to, size_t bytes) const;
    Error error(const std::string& what) const;

    std::string path_;
    InputFile file_;
    pipeline::PrintInfo info_;
    size_t row_bytes_ = 0;
    mutable std::mutex mutex_;  ///< of all below
    std::vector<uint64_t> offsets_;
    uint64_t end_ = 0;  ///< of the last whole slice
    std::optional<pipeline::PrintTotals> totals_;
};

}  // namespace openfab::viewer
