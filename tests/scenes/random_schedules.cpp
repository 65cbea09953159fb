// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/scenes/random_schedules.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>

#include "compiler/frontend/frontend.h"
#include "compiler/lower/fablet_data.h"
#include "compiler/lower/kernel.h"
#include "tests/support/schedules/schedule_space.h"

namespace openfab::testing {

bool write_random_schedules(const std::filesystem::path& source,
                            const std::filesystem::path& folder, std::mt19937* random) {
    source::SourceManager sources;
    diag::Sink sink;
    std::string fault;
    const std::optional<ir::Module> module =
        frontend::compile_to_ir(sources, source.string(), sink, &fault);
    EXPECT_TRUE(module.has_value()) << fault;
    if (!module || module->fablets.size() != 1) return false;
    const passes::PipelineResult result = passes::run_pipeline(module->fablets[0]);
    std::filesystem::create_directories(folder);
    for (const lower::KernelSlot& slot : lower::kernel_slots(result.stages)) {
        // Segments share one schedule, and derived values are computed once.
        if (slot.kernel == nullptr || slot.stage->kind == ir::StageKind::kDerived) continue;
        const ScheduleSpace space(
            [&] { return lower::make_kernel(*slot.stage, slot.inside, OPENFAB_ISA_AVX2); });
        std::ofstream(folder / fmt::format("{}.sched", slot.name)) << space.sample(random);
    }
    return true;
}

}  // namespace openfab::testing
