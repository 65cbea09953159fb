// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// From amounts to 16-bit fractions, in Halide: the end of every slab kernel, and the kernel for
// amounts that are there already (abi/stage_table.h, which has the meaning of channels). Its twin
// in tests/support/reference gives the same bits.
//
// The Funcs, where the dots are the columns:
//   amounts(z, slot, …)      what the stage gives
//   total(z, …)              their sum, whatever the material; to know whether it is too large
//   scaled(z, slot, …)       amounts that can be added up in any order
//   sums(z, channel, …)      of the slots of one material so far
//   whole(z, …)              the sum over materials
//   rounded(z, channel, …)   each material's share of 65535
//   remainder(z, …)          what rounding left, the largest share, and whose it is
//   unusable(z, …)           how many amounts are negative or NaN

#include <Halide.h>

#include <vector>

#include "compiler/lower/algorithm/kernel.h"

namespace openfab::lower {

struct Normalised {
    Halide::Expr code;      ///< uint8
    Halide::Expr unusable;  ///< uint16
    Halide::Func rounded, remainder;
    Halide::ImageParam channels;
    Halide::Var lane, column;
    std::vector<NamedFunc> funcs;  ///< consumers first

    /// Returns the fraction of a channel, uint16.
    Halide::Expr fraction(const Halide::Expr& channel) const;
    /// Returns the material of a channel, -1 for none, and that of the largest fraction, int32.
    Halide::Expr material(const Halide::Expr& channel) const;
    Halide::Expr largest() const;
};

/// Defines the Funcs on `amounts`(lane, slot, column). `slots` may be a constant; loops over few
/// are written out then.
Normalised normalise(const Halide::Func& amounts, const Halide::Expr& slots,
                     const Halide::ImageParam& channels, const Halide::Var& lane,
                     const Halide::Var& column);

/// Sets the shape (3, channel) of the table of channels, of slots + 1 channels.
void shape_channels(Halide::ImageParam* channels, const Halide::Expr& slots);

}  // namespace openfab::lower
