// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One stage as a Halide pipeline, not yet scheduled. Its Funcs, in our own names (Halide renames a
// second "x" to "x$1"):
//
//   volume      weights(z, x, y, n)                          the output; of volume_demand: demand
//   phases      phase(lane, group)                           the output; group counts the listed
//   ones others      vertices | patches | bounds (lane, group)    8 places of n at a time
//               store(n)                                     the output, from the Func above;
//               writes only what n holds
//   values_k(lane, …)         what later Funcs need of a stretch of the stage's operations
//   each texture look-up k (one per distinct place, any number of channels)
//               footprint_k(lane, …)     level, taps and direction
//               taps_k(…)                how many taps the lanes of the 8 take, inside the
//                                        picture and at its border; 0 where no path reaches it
//               texture_inner_k(lane, …), texture_k(lane, …)   the sums over these taps; their
//                                        update loops over them
// where lane is z in the volume stage and the dots are the other loops. What keeps kernels inside
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

/// The stage must pass ir::verify and have an output.
Kernel make_kernel(const ir::Stage& stage);

/// The place of a voxel, vertex or block inside a kernel, and the buffers it reads. Shared by
/// kernel.cpp and sample.cpp.
struct Site {
    std::vector<Halide::Var> vars;  ///< lane first
    std::map<std::pair<int32_t, int32_t>, Halide::ImageParam>
        textures;  ///< texture, openfab_texture_buffer
    std::vector<NamedFunc>* funcs = nullptr;
    int32_t lookups = 0;
};

/// Channels of one look-up; `args` as of ir::Op::kSample.
std::vector<Value> lower_sample(Site* site, int32_t texture, const std::vector<int32_t>& channels,
                                const std::vector<Value>& args);
/// Both ends of a SampleBound of one channel; `args` as of ir::Op::kSampleBound.
std::array<Value, 2> lower_sample_bound(Site* site, int32_t texture, int32_t channel,
                                        const std::vector<Value>& args);

}  // namespace openfab::lower
