// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Emits the IR of built-in functions, by the formulas that compiler/check/intrinsics.h and
// OPENFL.md state. Works on values alone, without variables, paths or stages. Other formulas are in
// compiler/functions.

#include <array>
#include <cstdint>
#include <vector>

#include "compiler/check/tree.h"
#include "compiler/translate/emitter.h"

namespace openfab::translate {

/// Components of a value: one per slot for a composition, the index for a material or texture.
using Value = std::vector<ir::ValueId>;

class Formulas {
  public:
    explicit Formulas(Emitter* emit) : emit_(*emit) {}

    /// Applies an operation component-wise; a scalar `b` is broadcast.
    Value binary(ir::Op op, const Value& a, const Value& b);
    ir::ValueId clamp(ir::ValueId x, ir::ValueId lo, ir::ValueId hi);
    /// Sums from the first to the last; 0 for no terms.
    ir::ValueId sum(const Value& values);

    /// Emits `min` to `isfinite`, for one component of each argument.
    ir::ValueId component(check::Intrinsic id, const std::vector<ir::ValueId>& x);
    /// Emits one component: a function of the IR, or one on bits. Unary ones ignore `y`.
    ir::ValueId elementary(check::Intrinsic id, ir::ValueId x, ir::ValueId y);
    static bool is_elementary(check::Intrinsic id);
    /// Emits functions of whole vectors: `any`, `dot`, `refract`, …
    Value geometric(check::Intrinsic id, const std::vector<Value>& args);
    static bool is_geometric(check::Intrinsic id);
    /// Emits noises and hashes with `size` result components.
    Value field(check::Intrinsic id, int32_t size, const std::vector<Value>& args);
    /// Emits the two results of frexp.
    std::array<ir::ValueId, 2> mantissa_and_exponent(ir::ValueId x);

    /// Row-major matrices. The product of sums of `inner` terms each.
    Value product(const Value& a, const Value& b, size_t inner);
    ir::ValueId determinant(const Value& m, size_t n);
    Value inverse(const Value& m, size_t n);

  private:
    ir::ValueId dot(const Value& a, const Value& b);
    Value refract(const std::vector<Value>& args);
    ir::ValueId uint_constant(uint32_t value);
    ir::ValueId float_bits(ir::ValueId x);
    ir::ValueId exchange_bits(ir::ValueId x, uint32_t mask, uint32_t width);
    ir::ValueId reverse_bits(ir::ValueId x);
    ir::ValueId count_bits(ir::ValueId x);

    // field_formulas.cpp
    ir::ValueId noise_value(ir::Op op, int32_t which, const Value& p, ir::ValueId seed);
    Value noise(check::Intrinsic id, int32_t size, const std::vector<Value>& args);
    ir::ValueId octaves(check::Intrinsic id, const std::vector<Value>& args);
    Value curl(const std::vector<Value>& args);
    Value hash(check::Intrinsic id, int32_t size, const std::vector<Value>& args);

    Emitter& emit_;
};

}  // namespace openfab::translate
