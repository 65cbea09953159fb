// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/passes/interval.h"

namespace openfab::passes {

/// Emits whether an output of the volume stage may depend on the nearest surface point of a voxel
/// of the box, if its distance is within the bounds. Where it is false, any distance within them,
/// with any attributes, gives all outputs the value that the true ones give (0 and -0 count as
/// equal): a value that follows from the distance but is the same at both of its ends says nothing
/// of it, as `distance(p) < -2` in a box that is deep enough, and what a decided condition leaves
/// out is not looked at, as an attribute in a layer that no voxel of the box lies in.
///
/// `intervals` are those of `volume` (IntervalForm::run), emitted by `builder`, where attributes
/// have no bounds. Nothing if no output follows from the distance.
std::optional<ir::ValueId> form_looks(const ir::Stage& volume,
                                      const std::vector<Interval>& intervals, ir::Builder* builder);

/// Emits whether the value of a shape may depend on distances to objects within their bounds. Where it is false, any
/// distances within them give it the bits that the true ones give. Also the larger or smaller of two values does not
/// follow from the one that bounds leave no chance, as a skin in the middle of which a lattice is cut.
std::optional<ir::ValueId> form_shape_looks(const ir::Stage& shape,
                                            const std::vector<Interval>& intervals,
                                            ir::Builder* builder);

}  // namespace openfab::passes
