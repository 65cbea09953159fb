// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes as IR what built-in functions compute: the formulas that compiler/check/intrinsics.def
// and OPENFL.md state, on values alone. Of variables, paths and stages they know nothing. Formulas
// that are not said here: compiler/functions.

#include <array>
#include <cstdint>
#include <vector>

#include "compiler/check/tree.h"
#include "compiler/translate/emitter.h"

namespace openfab::translate {

/// Components of a value: of a composition one per slot, of a material or texture its index.
using Value = std::vector<ir::ValueId>;

class Formulas {
  public:
    explicit Formulas(Emitter* emit) : emit_(*emit) {}

    /// Component by component; a `b` of one component goes with each of `a`.
    Value binary(ir::Op op, const Value& a, const Value& b);
    ir::ValueId clamp(ir::ValueId x, ir::ValueId lo, ir::ValueId hi);
    /// From the first to the last; of nothing 0.
    ir::ValueId sum(const Value& values);

    /// `min` to `isfinite`, of one component of each argument.
    ir::ValueId component(check::Intrinsic id, const std::vector<ir::ValueId>& x);
    /// Writes one component: a function of the IR, or one that looks at bits. Those of one argument
    /// do not look at `y`.
    ir::ValueId elementary(check::Intrinsic id, ir::ValueId x, ir::ValueId y);
    static bool is_elementary(check::Intrinsic id);
    /// Writes functions of whole vectors: `any`, `dot`, `refract`, …
    Value geometric(check::Intrinsic id, const std::vector<Value>& args);
    static bool is_geometric(check::Intrinsic id);
    /// Noises and hashes; `size` components come out.
    Value field(check::Intrinsic id, int32_t size, const std::vector<Value>& args);
    /// Writes the two results of frexp.
    std::array<ir::ValueId, 2> mantissa_and_exponent(ir::ValueId x);

    /// Matrices, row by row. The product of sums of `inner` terms each.
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
    ir::ValueId noise_value(ir::Op op, int32_t which, const Value& p, ir::ValueId seed);
    Value noise(check::Intrinsic id, int32_t size, const std::vector<Value>& args);
    ir::ValueId octaves(check::Intrinsic id, const std::vector<Value>& args);
    Value curl(const std::vector<Value>& args);
    Value hash(check::Intrinsic id, int32_t size, const std::vector<Value>& args);

    Emitter& emit_;
};

}  // namespace openfab::translate
