// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A store of Zarr that OpenFab has written, read slice by slice, also while it is being filled: from the first slice
// of the first list on, as far as the lists go without a gap. A slab is decoded once for all its slices.

#include <mutex>
#include <vector>

#include "backends/read/print_file.h"
#include "backends/zarr/store.h"

namespace openfab::prints {

class ZarrPrint final : public PrintFile {
  public:
    static Result<std::unique_ptr<PrintFile>> open(const std::string& path, int64_t memory_bytes);

    int32_t whole_slices() const override;
    std::optional<pipeline::PrintTotals> totals() const override;
    bool look_again() override;
    bool was_replaced() const override;
    Result<void> read_slice(int32_t z, SliceBuffers* buffers) const override;

  private:
    ZarrPrint(std::string path, zarr::Store store)
        : PrintFile(std::move(path)), store_(std::move(store)) {}
    bool take_lists(const std::vector<zarr::ShardList>& lists);

    zarr::Store store_;
    mutable std::mutex mutex_;  ///< of all below
    std::vector<zarr::ShardDigest> shards_;
    std::optional<pipeline::PrintTotals> totals_;
};

}  // namespace openfab::prints
