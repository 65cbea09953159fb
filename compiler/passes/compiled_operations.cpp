// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/compiled_operations.h"

#include <algorithm>

#include "compiler/passes/cut_segments.h"
#include "compiler/passes/split_kernel.h"

namespace openfab::passes {

namespace {

// Of more than these not even the segments are formed: at a microsecond for each that takes half a
// second.
constexpr size_t kMostUncut = 500'000;

/// Adds the operations of one kernel.
void add(const ir::Stage& kernel, size_t most, CompiledOperations* sum) {
    const bool before = sum->count <= most;
    if (before) {
        const ir::ValueId at = first_beyond(kernel, most - sum->count);
        if (at != ir::kNoValue) sum->beyond = kernel.instrs[at].span;
    }
    sum->count += kernel_operations(kernel);
}

}  // namespace

CompiledOperations compiled_operations(const ir::Stage& stage, size_t most) {
    CompiledOperations whole;
    add(stage, most, &whole);
    if (whole.count <= most || whole.count > kMostUncut) return whole;
    ir::Stage live = stage;
    ir::drop_dead_values(&live);
    const SegmentedStage segments = cut_segments(live);
    if (segments.elements.empty()) return whole;
    CompiledOperations cut;
    for (const ir::Stage& kernel : segments.kernels)
        add(kernel, most, &cut);
    add(segments.last, most, &cut);
    return cut;
}

}  // namespace openfab::passes
