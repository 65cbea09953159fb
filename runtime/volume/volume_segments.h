// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The volume stage of a fablet whose loops or queries cut it into segments, on a batch of blocks.
// One per thread.

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "runtime/segments/driver.h"
#include "runtime/volume/kernel_arguments.h"
#include "runtime/volume/point_queries.h"
#include "runtime/volume/printf_log.h"

namespace openfab::volume {

class VolumeSegments : private segments::Arguments, private segments::Handler {
  public:
    /// Returns the start of a buffer of the batch: blocks of 512 values, dense.
    using Input = std::function<const void*(const openfab_arg& arg)>;

    explicit VolumeSegments(size_t parts) : queries_(parts) {}

    /// Runs the stage on n blocks: `corners` 3 part-relative indices, `owned` 64 bytes each.
    /// Amounts go to weights[block][slot][512].
    abi::KernelStatus run(const PlacedPart& part, openfab_isa isa, const int32_t* corners,
                          const uint8_t* owned, int32_t n, const Input& input, float* weights,
                          PrintfLog* log);

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
    PrintfLog* log_ = nullptr;
    const int32_t* corners_ = nullptr;  ///< of the current blocks
    int32_t first_ = 0, count_ = 0;     ///< those blocks
    float* weights_ = nullptr;
    std::vector<std::unique_ptr<abi::KernelBuffer>> buffers_;
    size_t buffers_used_ = 0;
};

}  // namespace openfab::volume
