// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `--fractions-supersample N`: means of the fractions over the N x N x N parts of each voxel, from a
// second print without slices at an N-th of the pitch.

#include <atomic>

#include "abi/fablet_table.h"
#include "program/options.h"
#include "program/progress.h"
#include "runtime/pipeline/fraction_sink.h"

namespace openfab::program {

/// What the second print takes from the first: its grid and, at the end, its totals.
class CoarsePrint : public pipeline::FractionSink {
  public:
    Result<void> begin(const pipeline::PrintInfo& info, int32_t) override {
        info_ = info;
        return {};
    }
    void write(int32_t, int32_t, int32_t, std::span<const float>) override {}
    Result<void> status() const override { return {}; }
    Result<void> finish(const pipeline::PrintTotals& totals) override {
        totals_ = totals;
        return {};
    }

    const pipeline::PrintInfo& info() const { return info_; }
    const pipeline::PrintTotals& totals() const { return totals_; }

  private:
    pipeline::PrintInfo info_;
    pipeline::PrintTotals totals_;
};

/// Writes `options.fractions_file`, as the print `coarse`, with the same options, has left it to do.
Result<void> write_supersampled(const CoarsePrint& coarse, const Options& options,
                                const openfab_fablet_list& fablets,
                                const std::atomic<bool>& interrupt, Progress* progress);

}  // namespace openfab::program
