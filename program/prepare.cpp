// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/prepare.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "abi/kernel_call.h"
#include "base/allowance.h"
#include "base/clock.h"
#include "program/build_volume.h"
#include "program/messages.h"
#include "program/output_check.h"
#include "program/outputs.h"

namespace openfab::program {

namespace {

pipeline::PrintOptions pipeline_options(const Options& options, const backends::Format* format,
                                        size_t materials, const PrintHooks& hooks) {
    pipeline::PrintOptions result;
    result.interrupt = &hooks.interrupt;
    result.print_line = hooks.print_line;
    result.fractions = hooks.fractions;
    result.began_seconds = hooks.began_seconds;
    result.clock = hooks.clock;
    result.reserved_bytes = preview_bytes(options) + queue_bytes(options);
    result.memory_bytes = options.memory_bytes - result.reserved_bytes;
    if (!options.memory_given)
        result.most_memory_bytes = available_memory_bytes() / 2 - result.reserved_bytes;
    result.threads = options.threads.value_or(0);
    // A mesh of dithered voxels would consist of specks, which printers of meshes cannot print.
    if (is_mesh_format(format)) result.dither = "majority";
    if (!options.dither.empty()) result.dither = options.dither;
    result.seed = options.seed;
    result.z_range_mm = options.z_range_mm;
    result.slices = options.slices;
    result.part = options.part;
    result.culling = options.culling;
    result.slabs_in_flight = options.slabs_in_flight.value_or(0);
    result.isa = abi::best_isa(options.isa.value_or(OPENFAB_ISA_AVX512));
    result.sink_bytes_per_column = output_bytes_per_column(format, materials) +
                                   hooks.sink_bytes_per_column +
                                   hooks.sink_bytes_per_fraction * static_cast<int64_t>(materials);
    return result;
}

bool has_code(const openfab_kernel& kernel, openfab_isa isa) {
    return !abi::is_compiled(kernel) || abi::function_for(kernel.fn, isa) != nullptr;
}

bool has_code(const openfab_segments& segments, openfab_isa isa) {
    return std::all_of(segments.kernels, segments.kernels + segments.kernel_count,
                       [&](const openfab_kernel& kernel) { return has_code(kernel, isa); });
}

/// A program that was built for one instruction set may have come to a machine that lacks it.
Result<void> check_instruction_set(const openfab_fablet_list& fablets, openfab_isa isa) {
    for (int32_t k = 0; k < fablets.count; ++k) {
        const openfab_fablet& fablet = *fablets.fablets[k];
        const openfab_kernel* const kernels[] = {&fablet.surface, &fablet.surface_bounds,
                                                 &fablet.slab,    &fablet.volume_bounds,
                                                 &fablet.derived, &fablet.volume_demand};
        const bool whole =
            std::all_of(std::begin(kernels), std::end(kernels),
                        [&](const openfab_kernel* kernel) { return has_code(*kernel, isa); }) &&
            has_code(fablet.surface_segments, isa) && has_code(fablet.volume_segments, isa);
        if (whole) continue;
        Error error = user_error(
            fmt::format(messages::kOtherInstructionSets, fablet.name, abi::isa_title(isa)));
        error.help = messages::kOtherInstructionSetsHelp;
        return error;
    }
    return {};
}

}  // namespace

Result<PreparedPrint> prepare_print(const Options& options, const openfab_fablet_list& fablets,
                                    const PrintHooks& hooks) {
    const openfab_isa isa = abi::best_isa(options.isa.value_or(OPENFAB_ISA_AVX512));
    if (Result<void> runs = check_instruction_set(fablets, isa); !runs) return runs.error();
    Result<Job> job = load_job(options, fablets, hooks.world);
    if (!job) return job.error();
    // Reports a wrong output name before the work, not after.
    const Result<const backends::Format*> format = choose_format(options, job->printer);
    if (!format) return format.error();
    if (Result<void> apart = check_outputs(options, *format, job->input.materials, job->inputs);
        !apart)
        return apart.error();
    job->input.window_mm = hooks.window_mm;
    if (hooks.loaded) hooks.loaded(*job);
    PreparedPrint ready;
    ready.options = pipeline_options(options, *format, job->input.materials.size(), hooks);
    if (has_mesh_colors(*format, job->printer)) {
        ready.mixtures = std::make_unique<backends::MixtureInlet>(hooks.fractions);
        ready.options.fractions = ready.mixtures.get();
        // A slab more than threads may be in flight.
        const int32_t slices = 8 * (options.threads.value_or(usable_cores()) + 1);
        ready.options.sink_bytes_per_column += (*format)->mixture_bytes_per_column(slices);
    }
    if (hooks.rates) {
        Result<pipeline::Rates> rates = hooks.rates(*job);
        if (!rates) return rates.error();
        ready.options.rates = std::move(*rates);
        ready.options.sink_bytes_per_column += hooks.sink_bytes_per_fraction *
                                               ready.options.rates.columns *
                                               static_cast<int64_t>(job->input.materials.size());
    }
    for (const auto& effect : job->effects)
        ready.options.effects.push_back(effect.get());
    Result<std::unique_ptr<pipeline::PrintJob>> print =
        pipeline::PrintJob::create(job->input, ready.options);
    if (!print) return print.error();
    const bool around = job->input.around_vox > 0;  // the grid is larger than what is built
    if (Result<void> fits = around ? Result<void>()
                                   : check_build_volume((*print)->info(), job->printer,
                                                        job->input.parts, job->tray);
        !fits)
        return fits.error();
    ready.job = std::move(*job);
    ready.format = *format;
    ready.print = std::move(*print);
    return ready;
}

}  // namespace openfab::program
