// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How a print is made. What of it decides voxels is in provenance.cpp.

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "base/units.h"
#include "base/vec.h"
#include "runtime/dither/dither_rule.h"
#include "runtime/pipeline/fraction_sink.h"
#include "runtime/pipeline/slab_clock.h"
#include "runtime/process/effect.h"

namespace openfab::pipeline {

/// The end of a range of slices that is open.
constexpr int32_t kToTheEnd = INT32_MAX;

/// Which derivatives a print has.
struct Rates {
    int32_t columns = 0;  ///< numbers of uniforms
    std::vector<std::vector<int32_t>>
        of_parts;  ///< [part][direction of its fablet]: the column, or -1
};

struct PrintOptions {
    int64_t memory_bytes = kDefaultMemoryBytes;  ///< without the reserved part
    int64_t reserved_bytes = 0;                  ///< part of the user's budget, for previews
    /// What a print that needs more than memory_bytes may take instead of being refused; 0: no more.
    int64_t most_memory_bytes = 0;
    int32_t threads = 0;  ///< 0: all cores
    std::string dither = dither::kOwnDitherName;
    uint64_t seed = 0;
    std::optional<Vec2<double>> z_range_mm;  ///< --z, above the grid's lowest corner
    std::optional<Vec2<int32_t>> slices;  ///< --slices A:B, B exclusive; kToTheEnd: all from A on
    std::optional<Vec2<int32_t>> part;    ///< --part I/N: the I-th of N, of about as many slabs
    bool culling = true;                  ///< off: every covered block is evaluated voxel by voxel
    bool infer_identity = true;
    int32_t slabs_in_flight =
        0;  ///< 0: from threads and memory; the output never depends on it, which tests check
    /// Number of blocks of the first slab; if culling leaves more, its first slice is printed
    /// alone, then the others, which evaluates the blocks twice: about a second once, but the first
    /// slice is ready seconds earlier. Tests vary it, too.
    int64_t most_blocks_at_first = 40'000;
    openfab_isa isa = OPENFAB_ISA_AVX512;  ///< the best to use
    /// Once set, set-up and run end soon; set-up fails. It must outlive the print.
    const std::atomic<bool>* interrupt = nullptr;
    SlabClock* clock = nullptr;  ///< told which slabs are made; null: nobody watches
    bool interrupted() const {
        return interrupt != nullptr && interrupt->load(std::memory_order_relaxed);
    }
    /// The age of the process when this print began, if it is not the process's only one: times in
    /// events and statistics count from it.
    double began_seconds = 0;
    FractionSink* fractions =
        nullptr;  ///< takes what the dither takes, too; must outlive the print
    /// Of a print of volumes with derivatives, which `fractions` gets, too.
    Rates rates;
    std::vector<process::Effect*> effects;  ///< of the machine; they must outlive the print
    int64_t sink_bytes_per_column = 0;      ///< memory of the sink for each voxel of a slice
    /// Receives the lines of printf, in an order that does not depend on threads; called from one
    /// thread.
    std::function<void(const std::string& line)> print_line;
};

}  // namespace openfab::pipeline
