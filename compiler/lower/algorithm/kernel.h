// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One stage as a Halide pipeline, not yet scheduled. Its Funcs, in our own names (Halide renames a
// second "x" to "x$1"):
//
//   kernel      Funcs
//   slab        slab(z, column)                              the output, see normalise.h for what
//                                                            is between it and
//               weights(z, column)                           the amounts, by the volume stage or the last of
//                                                            its segments; column counts those listed
//               choice(z, column)                            of a dither rule: the code that it
//                                                            chooses; choice_k what it computes
//               nearest(z, field, column)                    what they read of the nearest surface
//                                                            point: an extern stage; none after segments,
//                                                            which were given the same
//               demand(z, column)                            which voxels read any of it
//               condition_k(z, column)                       what demand is computed from
//   demand      demand(z, column)                            the output, of stages of segments
//   segments    segment(lane, group)                         the output; group counts listed groups
//   others      vertices | patches | bounds (lane, group)    8 elements of n at a time
//               store(n)                                     the output, from the Func above;
//                                                            writes only what n holds
//   all         values_k(lane, …)    what is computed before a lookup and needed after it
//   each lookup k in a picture (one per distinct coordinate, up to four channels)
//               requests_k(lane, field, …) the coordinates, see texture/sample.h
//               samples_k(lane, result, …) the results: an extern stage
//   each lookup k in a volume texture, or of its or a picture's bounds, likewise
//               footprint_k(lane, …)     coordinates and level
//               taps_k(…)                iterations that the lanes of the 8 take; 0 where no path
//                                        reaches it
//               texture_k(lane, …)       the result; its update loops over trips
// Where there are more than kMostResults results, weights, segment, bounds, derived, store and slab have a
// dimension `output` between lane and group, and one value: the bits of the result of that number
// (Deferred::one_of). Those of slab, of 16 bits each, are code, unusable, the fractions and the choice.
// where lane is z where groups are columns, and the dots are the other loop. Values that a lookup in a
// picture may need are named values_early_k, texture_early_k and so on: they are computed for as
// many lanes at once as the lookup. What a Func stores of the stage's operations is a call like
// values.17, of instruction 17 (compiler/lower/algorithm/deferred.h). The directives that keep kernels inside their buffers (bounds
// of 8, clamped addresses, guarded tails) are set here, and no schedule can undo them.

#include <Halide.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "compiler/lower/algorithm/args.h"
#include "compiler/lower/algorithm/deferred.h"
#include "compiler/lower/algorithm/ops.h"

namespace openfab::lower {

struct NamedFunc {
    std::string name;
    Halide::Func func;
    std::vector<std::pair<std::string, Halide::Var>> vars;  ///< lane first
};

struct Kernel {
    Halide::Func output;
    std::vector<Halide::Argument> arguments;
    std::vector<NamedFunc> funcs;        ///< consumers first
    std::shared_ptr<Deferred> deferred;  ///< what the Funcs' calls of operations stand for
};

/// Returns the name of the schedule file: "slab", "surface_bounds".
const char* kernel_name(ir::StageKind kind);

/// Lowers a stage, which must pass ir::verify and have an output. Lookups in pictures call those of
/// `isa`. `inside`: the stages that belong to a volume stage.
Kernel make_kernel(const ir::Stage& stage, const SlabStages& inside, openfab_isa isa);

/// The loop variables and texture buffers of a kernel while it is lowered. Shared by kernel.cpp and
/// sample.cpp.
struct LoweringContext {
    std::vector<Halide::Var> vars;  ///< lane first
    std::map<std::pair<int32_t, int32_t>, Halide::ImageParam>
        textures;  ///< texture, openfab_texture_buffer
    std::vector<NamedFunc>* funcs = nullptr;
    openfab_isa isa = OPENFAB_ISA_SSE41;
    bool feeds_sample = false;  ///< a later lookup in a picture may need it
    int32_t sample_count = 0;
};

/// Lowers up to four channels of one lookup; `args` as in ir::Op::kSample.
std::vector<Value> lower_sample(LoweringContext* context, int32_t texture,
                                const std::vector<int32_t>& channels,
                                const std::vector<Value>& args);
/// Lowers both ends of a SampleBound of one channel; `args` as in ir::Op::kSampleBound.
std::array<Value, 2> lower_sample_bound(LoweringContext* context, int32_t texture, int32_t channel,
                                        const std::vector<Value>& args);

}  // namespace openfab::lower
