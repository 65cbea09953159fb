// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The argument list of a stage's kernel, from its inputs, lookups and outputs, in a fixed order, so
// that table and code agree and equal stages give equal kernels.

#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "compiler/ir/ir.h"

namespace openfab::lower {

openfab_scalar_type scalar_type(ir::Type type);
ir::Type ir_type(openfab_scalar_type type);

struct KernelArgs {
    std::vector<openfab_arg> inputs;  ///< by kind, a, b; live ones only
    std::vector<openfab_arg>
        outputs;  ///< in the order of Stage::outputs; of the slab: codes, unusable, fractions, choice

    std::vector<openfab_arg> all() const;
    bool packed = false;  ///< openfab_kernel::packed
};

/// The stages that a slab kernel has inside, beside the volume; each may be null.
struct SlabStages {
    const ir::Stage* demand = nullptr;  ///< which voxels need their nearest surface point
    const ir::Stage* dither = nullptr;  ///< the fablet's rule
    /// Whether the volume is the last of segments: what it reads of nearest surface points was asked
    /// for before them, and is an input as their states are.
    bool after_segments = false;
};

/// `inside`: of a slab kernel. Outputs of a kernel that may have many are packed where there are more
/// than kMostResults.
constexpr size_t kMostResults = 16;
KernelArgs collect_args(const ir::Stage& stage, const SlabStages& inside = {});

/// True for what is read of a voxel's nearest surface point.
bool is_field(int32_t kind);
/// Lists what a volume stage reads of it, in order: the fields of its kernel's extern stage.
std::vector<openfab_arg> collect_fields(const ir::Stage& volume);

/// Returns whether kernels of a kind evaluate the groups of 8 lanes of a list; in the slab kernel and in that
/// of demand these are columns of voxels.
bool lists_groups(ir::StageKind kind);

/// Returns whether an argument is a scalar, not a buffer.
bool is_scalar(openfab_arg_kind kind);

/// Returns the name of an argument in generated code and in `emit`: "nearest_0_1".
std::string arg_name(const openfab_arg& arg);

}  // namespace openfab::lower
