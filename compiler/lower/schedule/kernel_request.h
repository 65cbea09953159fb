// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What a kernel is made from: its stages, and the schedule that makes loops of them.
#pragma once

#include <string>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/lower/algorithm/args.h"
#include "compiler/schedule/schedule.h"

namespace openfab::lower {

struct KernelRequest {
    const ir::Stage* stage = nullptr;
    SlabStages inside;     ///< of a volume stage: see make_kernel
    std::string function;  ///< C name; its argv form is `<function>_argv`
    openfab_isa isa = OPENFAB_ISA_SSE41;
    const schedule::Schedule* schedule = nullptr;  ///< null: the default one
    bool profiled = false;                         ///< see kernel_profile.h
};

/// Returns the name of a kernel's schedule file: "surface", "surface_bounds", "slab",
/// "volume_bounds", …
const char* schedule_name(ir::StageKind kind);
/// Returns those of all kinds.
const std::vector<std::string>& pipeline_names();

/// Returns the schedule of a kernel: the request's, else the built-in one.
const schedule::Schedule& schedule_of(const KernelRequest& request);

}  // namespace openfab::lower
