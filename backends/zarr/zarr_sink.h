// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes a print, or a range of its slabs, into a store (layout.h). Several processes may write ranges of their own
// into one store at once; the one that finds all others done makes the coarse levels and the manifest. The bytes
// are the same for any ranges.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backends/zarr/layout.h"
#include "backends/zarr/shard_list.h"
#include "backends/zarr/store_files.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::zarr {

class ZarrSink : public pipeline::SliceSink {
  public:
    /// `resume`: keeps the first slabs of the range whose shards are those of their list.
    ZarrSink(std::filesystem::path path, bool resume) : path_(std::move(path)), resume_(resume) {}

    /// Makes the store, or takes that of the same print. Fails for another print's, for slices that do not begin
    /// and end with slabs, and where another process writes them.
    Result<void> begin(const pipeline::PrintInfo& info) override;
    Result<int32_t> resume(const std::function<bool(const pipeline::SliceView&)>& show) override;
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override;
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override;
    Result<void> finish(const pipeline::PrintTotals& totals) override;

  private:
    Result<void> make_store();
    Result<void> begin_list();
    Result<void> write_slab();
    Error with_resume_state(const Error& error) const;
    int32_t next_slab() const { return info_.slice_begin / kSlab + slabs_; }

    std::filesystem::path path_;
    bool resume_;
    pipeline::PrintInfo info_;
    std::string identity_;
    std::vector<Level> levels_;
    std::optional<ListFile> list_;
    std::optional<ShardList> earlier_;           ///< of an earlier run, between begin and resume
    std::vector<std::vector<uint8_t>> waiting_;  ///< tiles of slices whose slab is not complete
    int32_t slabs_ = 0;                          ///< whole ones of the range
    uint64_t bytes_ = 0;                         ///< of their shards
    bool ended_ = false;                         ///< the list has its end
    bool broken_ = false;
};

}  // namespace openfab::zarr
