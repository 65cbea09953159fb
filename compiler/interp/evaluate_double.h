// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Interprets the IR with floats in double: the oracle of derivatives, whose central differences need more digits than
// floats have. It is no twin of the kernels: where a comparison is close, it may take another branch.

#include <cstdint>
#include <span>
#include <vector>

#include "compiler/interp/sample.h"
#include "compiler/ir/ir.h"

namespace openfab::interp {

/// The inputs that a stage reads.
class DoubleEnvironment {
  public:
    virtual ~DoubleEnvironment() = default;
    /// Returns a float input; kind, a, b as in ir::Instr.
    virtual double number(int32_t kind, int32_t a, int32_t b) const = 0;
    /// Returns the bits of any other input.
    virtual uint32_t bits(int32_t kind, int32_t a, int32_t b) const = 0;
    /// A lookup itself is as kernels make it, its coordinates are rounded to float.
    virtual TextureView texture(int32_t index) const = 0;
    /// Returns one float result of a query whose guard holds: x, y, z are the evaluated point. The default is 0.
    virtual double query(const ir::Instr& query, const ir::Instr& result,
                         std::span<const double, 3> point) const;
};

/// Returns the value of every output, in the order of stage.outputs, integers and bools as numbers.
std::vector<double> evaluate_double(const ir::Stage& stage, const DoubleEnvironment& environment);

}  // namespace openfab::interp
