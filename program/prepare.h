// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Everything of a print but its sink: what a print binary and other hosts of the runtime do before
// the first slice.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "abi/fablet_table.h"
#include "backends/common/format.h"
#include "program/job.h"
#include "program/options.h"
#include "runtime/pipeline/fraction_sink.h"
#include "runtime/pipeline/print_job.h"

namespace openfab::program {

/// What a host adds to the options of a print. All of it must outlive the print.
struct PrintHooks {
    const std::atomic<bool>& interrupt;            ///< ends set-up and print early
    std::function<void(const Job& job)> loaded{};  ///< called with the job before the long set-up
    std::function<void(const std::string& line)> print_line{};  ///< takes lines of printf
    pipeline::FractionSink* fractions = nullptr;
    /// Tells which derivatives `fractions` gets of a job whose volumes have them; empty: none.
    std::function<Result<pipeline::Rates>(const Job& job)> rates{};
    /// Memory of sinks that the options do not name, for each voxel of a slice, and for each of its
    /// materials.
    int64_t sink_bytes_per_column = 0, sink_bytes_per_fraction = 0;
    std::optional<Box3d> window_mm{};  ///< see pipeline::PrintInput
    double began_seconds = 0;          ///< see pipeline::PrintOptions
    pipeline::SlabClock* clock = nullptr;
    world::World* world = nullptr;  ///< receives the world, which is dropped otherwise
};

struct PreparedPrint {
    Job job;
    const backends::Format* format = nullptr;  ///< of the output, see choose_format
    pipeline::PrintOptions options;
    /// Through which the output gets mixtures, see open_output; null: it wants none.
    std::unique_ptr<backends::MixtureInlet> mixtures;
    std::unique_ptr<pipeline::PrintJob> print;  ///< declared last: it uses the others
};

/// Reads the world, checks it, the outputs and the printer's build volume, and sets the print up.
/// The fablets must outlive it.
Result<PreparedPrint> prepare_print(const Options& options, const openfab_fablet_list& fablets,
                                    const PrintHooks& hooks);

}  // namespace openfab::program
