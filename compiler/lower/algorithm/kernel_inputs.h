// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a kernel is called with: buffers and scalars, and the values that a stage reads from them.

#include <Halide.h>

#include <array>
#include <map>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/lower/algorithm/args.h"
#include "compiler/lower/algorithm/kernel.h"

namespace openfab::lower {

struct Normalised;

class KernelInputs {
  public:
    /// `fields`: what the kernel asks of the nearest surface point itself. Lanes and groups are as in
    /// the kernel's results.
    KernelInputs(ir::StageKind kind, std::vector<openfab_arg> fields, Halide::Var lane,
                 Halide::Var group)
        : kind_(kind),
          fields_(std::move(fields)),
          lane_(std::move(lane)),
          group_(std::move(group)) {}

    /// Textures go to the context, the values that tables load from to `deferred`.
    void add(const openfab_arg& arg, LoweringContext* context, Deferred* deferred);
    /// Sets the Func of the fields.
    void set_nearest(const Halide::Func& nearest) { nearest_ = nearest; }
    /// Sets what a dither rule reads its fractions from, while it is lowered; null: none.
    void set_normalised(const Normalised* normalised) { normalised_ = normalised; }

    /// Returns the value of an instruction that is an input.
    Value value(const ir::Instr& instr) const;

    const std::vector<Halide::Argument>& arguments() const { return arguments_; }
    const std::vector<openfab_arg>& fields() const { return fields_; }
    const Halide::Param<void*>& nearest_source() const { return source_; }
    const Halide::ImageParam& channels() const { return buffers_.at({OPENFAB_ARG_CHANNELS, 0, 0}); }

  private:
    using Key = std::array<int32_t, 3>;

    /// Returns the index of this lane along n; lanes past the end repeat the last one, so that no
    /// read is out of bounds.
    Halide::Expr index_along(const Halide::ImageParam& image, int dimension) const;
    /// Returns the group at this index of the list.
    Halide::Expr listed_group() const;
    Value load(const Key& key, ir::Type type) const;
    /// Returns the part-relative index of the voxel along an axis.
    Value voxel_index(int32_t axis) const;
    /// Returns float(index) + 0.5 of the voxel, or of the first or last voxel of the block.
    Value voxel_coord(const ir::Instr& instr) const;
    /// Returns the threshold that the mask of a face has at the voxel. Its column is a row of the
    /// mask's table, from the pixel of the column's lowest voxel on.
    Value blue_noise(int32_t face) const;

    const ir::StageKind kind_;
    const std::vector<openfab_arg> fields_;
    const Halide::Var lane_, group_;
    Halide::Func nearest_;         ///< of a slab kernel with fields
    Halide::Param<void*> source_;  ///< likewise
    const Normalised* normalised_ = nullptr;
    std::map<Key, Halide::Param<>> scalars_;
    std::map<Key, Halide::ImageParam> buffers_;
    std::vector<Halide::Argument> arguments_;
};

}  // namespace openfab::lower
