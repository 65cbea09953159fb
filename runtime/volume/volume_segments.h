// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The segments of a volume stage that loops or queries cut, but for the last one, which is in the
// slab kernel: on a batch of blocks. One per thread.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "runtime/segments/driver.h"
#include "runtime/segments/printf_log.h"
#include "runtime/volume/kernel_arguments.h"
#include "runtime/volume/point_queries.h"

namespace openfab::volume {

class VolumeSegments : private segments::Arguments, private segments::Handler {
  public:
    /// Returns the start of a buffer of the batch: blocks of 512 values, dense.
    using Input = std::function<const void*(const openfab_arg& arg)>;

    explicit VolumeSegments(size_t parts) : queries_(parts) {}

    /// Returns how many blocks it takes at once: as many as their states stay in cache for.
    static int32_t most_blocks(const PlacedPart& part);

    /// Runs the segments on up to most_blocks: `corners` 3 part-relative indices, `owned` 64 bytes
    /// each; until `stop` is set, if it is not null.
    abi::KernelStatus run(const PlacedPart& part, openfab_isa isa, const int32_t* corners,
                          const uint8_t* owned, int32_t n, const Input& input,
                          segments::PrintfLog* log, const std::atomic<bool>* stop);
    /// Returns a state as the last run left it: blocks of 512 values, defined in columns with an
    /// owned voxel.
    const uint32_t* state(int32_t number) const { return driver_.states()[number]; }

    nearest::QueryCounts query_counts() const { return queries_.counts(); }

  private:
    const void* input(const openfab_arg& arg) override;
    segments::OutputView output(const openfab_arg& arg) override;
    abi::KernelStatus query(const openfab_query& query, std::span<const int32_t> groups,
                            const segments::States& states) override;
    void printf(const openfab_printf& call, std::span<const int32_t> groups,
                const segments::States& states) override;
    abi::KernelBuffer* next_buffer();

    segments::Driver driver_;
    PointQueries queries_;
    const PlacedPart* part_ = nullptr;
    const Input* inputs_ = nullptr;
    segments::PrintfLog* log_ = nullptr;
    const int32_t* corners_ = nullptr;  ///< of the blocks
    int32_t count_ = 0;                 ///< of blocks
    std::vector<std::unique_ptr<abi::KernelBuffer>> buffers_;
    size_t buffers_used_ = 0;
};

}  // namespace openfab::volume
