// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A print of which any slice can be read, also while it is still being written: an `.ofr` file
// (ofr_print.h), a folder of slices (folder_print.h), a GCVF (gcvf_print.h) or a store of Zarr (zarr_print.h).

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::prints {

/// Buffers that a reader keeps from slice to slice.
struct SliceBuffers {
    std::vector<uint8_t> frame;
    std::vector<uint8_t> rows;  ///< packed rows of the slice, lowest y first
    std::vector<uint8_t> slab;  ///< likewise of a slab, of a print that is read by slabs
    uint64_t slab_digest = 0;   ///< that the slab's data have; 0: it has none
};

/// All functions are thread-safe.
class PrintFile {
  public:
    /// Opens a file or a folder, and finds the slices that are there. Refuses slices that take more
    /// than a fourth of `memory_bytes`. Errors name the file.
    static Result<std::unique_ptr<PrintFile>> open(const std::string& path, int64_t memory_bytes);
    virtual ~PrintFile() = default;

    const pipeline::PrintInfo& info() const { return info_; }
    const std::string& path() const { return path_; }
    size_t row_bytes() const { return row_bytes_; }
    int64_t slice_bytes() const { return static_cast<int64_t>(row_bytes_) * info_.size.y; }

    /// Returns the number of slices that can be read, from info().slice_begin on.
    virtual int32_t whole_slices() const = 0;
    /// Returns the totals once the print is complete.
    virtual std::optional<pipeline::PrintTotals> totals() const = 0;
    /// Finds what was written since. Returns whether there is anything new.
    virtual bool look_again() = 0;
    /// Returns whether the path leads to another print by now, or this one was begun anew.
    virtual bool was_replaced() const = 0;

    /// What a file tells of the whole print in other words than those of its format; none tells nothing.
    struct Note {
        int32_t slice_begin = 0, slice_end = 0, slices_of_whole = 0;
        bool flipped_x = false;  ///< its pictures are mirrored
        uint64_t hash = 0;       ///< of its slices, as the print had them
    };
    virtual std::optional<Note> note() const { return {}; }

    /// Reads one slice into `buffers->rows` and checks it.
    virtual Result<void> read_slice(int32_t z, SliceBuffers* buffers) const = 0;
    /// Sums the hashes of all slices, from what is read of them.
    Result<uint64_t> hash_of_slices() const;

  protected:
    explicit PrintFile(std::string path) : path_(std::move(path)) {}
    Error error(const std::string& what) const;
    /// Refuses slices of which `bytes_a_slice` are needed to read one, where that is too much.
    Result<void> check_memory(int64_t bytes_a_slice, int64_t memory_bytes) const;

    std::string path_;
    pipeline::PrintInfo info_;
    size_t row_bytes_ = 0;
};

}  // namespace openfab::prints
