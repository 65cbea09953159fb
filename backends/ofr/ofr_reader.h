// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads an `.ofr` file or stream front to back and validates everything in it. Memory is bounded by
// the size of the file, not by what it claims.

#include <array>
#include <cstdio>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "backends/ofr/format.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::ofr {

class OfrReader {
  public:
    /// Opens and reads the header; `-` is standard input. Errors name the file. Slices that take
    /// more than `memory_bytes`, compressed and decompressed together, are refused.
    static Result<std::unique_ptr<OfrReader>> open(
        const std::string& path, int64_t memory_bytes = std::numeric_limits<int64_t>::max());
    /// Reads the totals of a complete file from the index at its end, without reading slices.
    static Result<pipeline::PrintTotals> read_totals(const std::string& path);
    ~OfrReader();
    OfrReader(const OfrReader&) = delete;
    OfrReader& operator=(const OfrReader&) = delete;

    const pipeline::PrintInfo& info() const { return info_; }
    /// Reads the next slice into slice(). Returns false at the end, if all slices were there and
    /// the index agrees. Errors name the slice that is damaged or missing and how many are good;
    /// slices already returned are good.
    Result<bool> next();
    /// Returns the bytes of the packed rows of a slice.
    int64_t slice_bytes() const { return static_cast<int64_t>(row_bytes_) * info_.size.y; }
    /// Returns the current slice; valid until the next call of next().
    const pipeline::SliceView& slice() const { return view_; }
    /// Return for all slices so far: voxels by code, and the print's hash
    /// (runtime/pipeline/print_hash.h).
    const std::vector<int64_t>& counts() const { return counts_; }
    uint64_t hash() const { return hash_; }
    /// Return the offsets of the slices, and the end of the last one read.
    const std::vector<IndexEntry>& entries() const { return entries_; }
    uint64_t slices_end() const { return slices_end_; }
    /// Returns whether data could not be read, although the file may have it.
    bool disk_failed() const { return disk_failed_; }
    int32_t whole_slices() const { return static_cast<int32_t>(entries_.size()); }
    /// Returns the totals; valid once next() has returned false.
    const pipeline::PrintTotals& totals() const { return totals_; }

  private:
    OfrReader(std::FILE* file, std::string name) : file_(file), name_(std::move(name)) {}

    Result<void> read_header();
    Result<void> read_slice(std::span<const uint8_t> head_bytes);
    Result<void> read_index();
    Result<void> check_index(const Index& index);
    Result<void> decode(const SliceHead& head);
    bool count_codes();
    /// Reads exactly `n` bytes into buffer_; returns false at the end of the file or on a read
    /// error.
    bool read_bytes(size_t n);
    Error error(const std::string& what) const;
    Error slice_error(const std::string& what) const;
    Error memory_error(int64_t bytes) const;

    std::FILE* file_;
    std::string name_;
    int64_t memory_bytes_ = std::numeric_limits<int64_t>::max();
    pipeline::PrintInfo info_;
    size_t row_bytes_ = 0;
    std::vector<uint8_t> buffer_;
    std::vector<uint8_t> rows_;
    std::vector<int64_t> slice_counts_;
    std::vector<int64_t> counts_;
    uint64_t hash_ = 0;
    std::vector<IndexEntry> entries_;
    uint64_t offset_ = 0;  ///< bytes read so far
    uint64_t slices_end_ = 0;
    bool disk_failed_ = false;
    pipeline::SliceView view_;
    pipeline::PrintTotals totals_;
};

}  // namespace openfab::ofr
