// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One stage as a Halide pipeline, not yet scheduled. Its Funcs, in our own names (Halide renames a
// second "x" to "x$1"):
//
//   kernel      Funcs
//   volume      weights(z, x, y, n)                          the output; of volume_demand: demand
//   phases      phase(lane, group)                           the output; group counts listed groups
//   others      vertices | patches | bounds (lane, group)    8 places of n at a time
//               store(n)                                     the output, from the Func above;
//                                                            writes only what n holds
//   all         values_k(lane, …)    what later Funcs need of a stretch of the stage's operations
//   each look-up k in a picture (one per distinct place, up to four channels)
//               places_k(lane, field, …)   where, as texture/look_up.h has it
//               picture_k(lane, result, …) what is there: an extern stage
//   each look-up k in a volume texture, or of its or a picture's bounds, likewise
//               footprint_k(lane, …)     place and level
//               taps_k(…)                how many trips the lanes of the 8 take; 0 where no path
//                                        reaches it
//               texture_k(lane, …)       the result; its update loops over trips
// where lane is z in the volume stage and the dots are the other loops. What a look-up in a picture
// may need is named values_early_k, texture_early_k and so on: it is computed for as many places at
// once as the look-up is. What keeps kernels inside
// their buffers (bounds of 8, clamped addresses, guarded tails) is set here and no schedule can
// undo it.

#include <Halide.h>

#include <map>
#include <string>
#include <vector>

#include "compiler/lower/args.h"
#include "compiler/lower/ops.h"

namespace openfab::lower {

struct NamedFunc {
    std::string name;
    Halide::Func func;
    std::vector<std::pair<std::string, Halide::Var>> vars;  ///< grows by the schedule's splits
};

struct Kernel {
    Halide::Func output;
    std::vector<Halide::Argument> arguments;
    std::vector<NamedFunc> funcs;  ///< consumers first
};

/// Name of the schedule file: "volume", "surface_bounds".
const char* kernel_name(ir::StageKind kind);

/// The stage must pass ir::verify and have an output. Look-ups in pictures are those of `isa`.
Kernel make_kernel(const ir::Stage& stage, openfab_isa isa);

/// The place of a voxel, vertex or block inside a kernel, and the buffers it reads. Shared by
/// kernel.cpp and sample.cpp.
struct Site {
    std::vector<Halide::Var> vars;  ///< lane first
    std::map<std::pair<int32_t, int32_t>, Halide::ImageParam>
        textures;  ///< texture, openfab_texture_buffer
    std::vector<NamedFunc>* funcs = nullptr;
    openfab_isa isa = OPENFAB_ISA_SSE41;
    bool early = false;  ///< a look-up in a picture follows
    int32_t lookups = 0;
};

/// Up to four channels of one look-up; `args` as of ir::Op::kSample.
std::vector<Value> lower_sample(Site* site, int32_t texture, const std::vector<int32_t>& channels,
                                const std::vector<Value>& args);
/// Both ends of a SampleBound of one channel; `args` as of ir::Op::kSampleBound.
std::array<Value, 2> lower_sample_bound(Site* site, int32_t texture, int32_t channel,
                                        const std::vector<Value>& args);

}  // namespace openfab::lower
