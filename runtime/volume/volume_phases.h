// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The volume stage of a fablet whose loops or queries cut it in phases, on a batch of blocks. One a
// thread.

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "runtime/segments/driver.h"
#include "runtime/volume/kernel_arguments.h"
#include "runtime/volume/point_prints.h"
#include "runtime/volume/point_queries.h"

namespace openfab::slab {

class VolumePhases : private phases::Arguments, private phases::Handler {
  public:
    /// Where a buffer of the batch begins: blocks of 512 values, dense.
    using Input = std::function<const void*(const openfab_arg& arg)>;

    explicit VolumePhases(size_t parts) : queries_(parts) {}

    /// n blocks: `corners` 3 part-relative indices, `owned` 64 bytes each. Amounts go to
    /// weights[block][slot][512].
    abi::KernelStatus run(const PrintPart& part, openfab_isa isa, const int32_t* corners,
                          const uint8_t* owned, int32_t n, const Input& input, float* weights,
                          PointPrints* prints);

    nearest::QueryCounts query_counts() const { return queries_.counts(); }

  private:
    const void* input(const openfab_arg& arg) override;
    phases::OutputPlace output(const openfab_arg& arg) override;
    abi::KernelStatus query(const openfab_query& query, std::span<const int32_t> groups,
                            const phases::States& states) override;
    void print(const openfab_print& print, std::span<const int32_t> groups,
               const phases::States& states) override;
    abi::KernelBuffer* next_buffer();

    phases::Driver driver_;
    PointQueries queries_;
    const PrintPart* part_ = nullptr;
    const Input* inputs_ = nullptr;
    PointPrints* prints_ = nullptr;
    const int32_t* corners_ = nullptr;  ///< of the blocks in hand
    int32_t first_ = 0, count_ = 0;     ///< those blocks
    float* weights_ = nullptr;
    std::vector<std::unique_ptr<abi::KernelBuffer>> buffers_;
    size_t buffers_used_ = 0;
};

}  // namespace openfab::slab
