// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/functions/functions.h"

#include "compiler/functions/exponential.h"
#include "compiler/functions/trigonometry.h"

namespace openfab::functions {

namespace {

using ir::Op;

template <typename M>
typename M::F elementary(Op op, typename M::F x, typename M::F y) {
    switch (op) {
        case Op::kSin:
            return sin<M>(x);
        case Op::kCos:
            return cos<M>(x);
        case Op::kTan:
            return tan<M>(x);
        case Op::kAsin:
            return asin<M>(x);
        case Op::kAcos:
            return acos<M>(x);
        case Op::kAtan:
            return atan<M>(x);
        case Op::kAtan2:
            return atan2<M>(x, y);
        case Op::kSinh:
            return sinh<M>(x);
        case Op::kCosh:
            return cosh<M>(x);
        case Op::kTanh:
            return tanh<M>(x);
        case Op::kExp:
            return exp<M>(x);
        case Op::kExp2:
            return exp2<M>(x);
        case Op::kLog:
            return log<M>(x);
        case Op::kLog2:
            return log2<M>(x);
        case Op::kLog10:
            return log10<M>(x);
        case Op::kPow:
            return pow<M>(x, y);
        case Op::kCbrt:
            return cbrt<M>(x);
        default:
            return x;
    }
}

}  // namespace

uint32_t evaluate(const ir::Instr& instr, std::span<const uint32_t> args) {
    const float x = ir::as_float(args[0]);
    return ir::as_bits(elementary<Plain>(instr.op, x, args.size() > 1 ? ir::as_float(args[1]) : x));
}

ir::ValueId expand(const ir::Instr& instr, ir::Builder* builder) {
    const Emit::F x{builder, instr.args[0]};
    return elementary<Emit>(instr.op, x, {builder, instr.args.back()}).id;
}

}  // namespace openfab::functions
