// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/scenes/random_schedules.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <utility>
#include <vector>

#include "compiler/frontend/frontend.h"
#include "compiler/lower/code/fablet_data.h"
#include "tests/support/schedules/schedule_space.h"

namespace openfab::testing {

void write_random_schedules(const std::filesystem::path& source,
                            const std::filesystem::path& folder, std::mt19937* random) {
    source::SourceManager sources;
    diag::Sink sink;
    std::string fault;
    const std::optional<ir::Module> module =
        frontend::compile_to_ir(sources, source.string(), sink, &fault);
    ASSERT_TRUE(module.has_value()) << fault;
    std::vector<passes::PipelineResult> fablets;
    for (const ir::Fablet& fablet : module->fablets)
        fablets.push_back(passes::run_pipeline(fablet));
    // Fablets share schedules, as segments do.
    std::map<std::string, std::vector<lower::KernelRequest>> kernels;
    for (const passes::PipelineResult& fablet : fablets) {
        for (const lower::KernelSlot& slot : lower::kernel_slots(fablet.stages)) {
            // Derived values are computed once.
            if (slot.stage->kind == ir::StageKind::kDerived) continue;
            kernels[lower::schedule_name(slot.stage->kind)].push_back(
                {slot.stage, slot.inside, "kernel", OPENFAB_ISA_AVX2});
        }
    }
    std::filesystem::create_directories(folder);
    for (auto& [name, requests] : kernels) {
        std::ofstream(folder / (name + ".sched"))
            << ScheduleSpace(std::move(requests)).sample(random);
    }
}

}  // namespace openfab::testing
