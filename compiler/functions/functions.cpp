// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/functions/functions.h"

#include <utility>

#include "compiler/functions/cellular.h"
#include "compiler/functions/exponential.h"
#include "compiler/functions/simplex.h"
#include "compiler/functions/trigonometry.h"
#include "compiler/ir/arithmetic.h"

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
            OPENFAB_IR_CASES(HASHES)
            OPENFAB_IR_CASES(NOISES)
            OPENFAB_IR_CASES(LEAVES)
            OPENFAB_IR_CASES(CHOICES)
            OPENFAB_IR_CASES(LOOKUPS)
            OPENFAB_IR_CASES(CONTROL)
            OPENFAB_IR_CASES(DERIVATIVES)
            OPENFAB_IR_CASES(OPERATIONS)
            break;
    }
    return x;
}

template <typename M, size_t kAxes>
std::array<typename M::F, kAxes> coordinates(const ir::Instr& instr, const auto& arg) {
    std::array<typename M::F, kAxes> out;
    for (size_t k = 0; k < kAxes; ++k)
        out[k] = arg.template number<typename M::F>(instr, k);
    return out;
}

/// `arg.number<T>(instr, k)` is argument k as the machine's type T.
template <typename M, size_t kAxes>
typename M::F noise_of(const ir::Instr& instr, size_t count, const auto& arg) {
    using F = typename M::F;
    const auto seed = arg.template number<typename M::U>(instr, count - 1);
    const std::array<F, kAxes> p = coordinates<M, kAxes>(instr, arg);
    if constexpr (kAxes == 2 || kAxes == 3) {
        if (instr.op == Op::kCellular) {
            return cellular<M, kAxes>(p, seed, static_cast<CellularResult>(instr.a));
        }
    }
    if constexpr (kAxes >= 2) {
        if (instr.op == Op::kSimplex) return SimplexNoise<M, kAxes>::result(p, seed, instr.a);
    }
    const bool periodic = (instr.a & ir::kPeriodic) != 0;
    std::array<Cell<M>, kAxes> cells;
    for (size_t k = 0; k < kAxes; ++k) {
        cells[k] = periodic ? cell_of<M>(p[k], arg.template number<typename M::I>(instr, kAxes + k))
                            : cell_of<M>(p[k]);
    }
    return PerlinNoise<M, kAxes>::result(cells, seed, instr.a & ~ir::kPeriodic);
}

template <typename M>
typename M::F noise(const ir::Instr& instr, size_t count, const auto& arg) {
    const bool periodic = instr.op == Op::kNoise && (instr.a & ir::kPeriodic) != 0;
    switch (periodic ? count / 2 : count - 1) {
        case 1:
            return noise_of<M, 1>(instr, count, arg);
        case 2:
            return noise_of<M, 2>(instr, count, arg);
        case 3:
            return noise_of<M, 3>(instr, count, arg);
        default:
            return noise_of<M, 4>(instr, count, arg);
    }
}

struct PlainArgs {
    std::span<const uint32_t> bits;
    template <typename T>
    T number(const ir::Instr&, size_t k) const {
        return std::bit_cast<T>(bits[k]);
    }
};

struct WideArgs {
    std::span<const double> values;
    template <typename T>
    T number(const ir::Instr&, size_t k) const {
        return static_cast<T>(values[k]);
    }
};

struct EmitArgs {
    ir::Builder* builder;
    template <typename T>
    T number(const ir::Instr& instr, size_t k) const {
        return {builder, instr.args[k]};
    }
};

double elementary_wide(Op op, double x, double y) {
    switch (op) {
        case Op::kSin:
            return std::sin(x);
        case Op::kCos:
            return std::cos(x);
        case Op::kTan:
            return std::tan(x);
        case Op::kAsin:
            return std::asin(x);
        case Op::kAcos:
            return std::acos(x);
        case Op::kAtan:
            return std::atan(x);
        case Op::kAtan2:
            return std::atan2(x, y);
        case Op::kSinh:
            return std::sinh(x);
        case Op::kCosh:
            return std::cosh(x);
        case Op::kTanh:
            return std::tanh(x);
        case Op::kExp:
            return std::exp(x);
        case Op::kExp2:
            return std::exp2(x);
        case Op::kLog:
            return std::log(x);
        case Op::kLog2:
            return std::log2(x);
        case Op::kLog10:
            return std::log10(x);
        case Op::kPow:
            return std::pow(x, y);
        case Op::kCbrt:
            return std::cbrt(x);
            OPENFAB_IR_CASES(HASHES)
            OPENFAB_IR_CASES(NOISES)
            OPENFAB_IR_CASES(LEAVES)
            OPENFAB_IR_CASES(CHOICES)
            OPENFAB_IR_CASES(LOOKUPS)
            OPENFAB_IR_CASES(CONTROL)
            OPENFAB_IR_CASES(DERIVATIVES)
            OPENFAB_IR_CASES(OPERATIONS)
            break;
    }
    return x;
}

bool is_noise(Op op) {
    return ir::family(op) == ir::Family::kNoise;
}

/// Returns whether the result depends on nothing but the arguments.
bool is_operation(Op op) {
    switch (op) {
        OPENFAB_IR_CASES(LEAVES)
        OPENFAB_IR_CASES(CONTROL)
        case Op::kSample:
        case Op::kSampleBound:
        case Op::kTable:
            return false;
        case Op::kBitCast:
        case Op::kPick:
            OPENFAB_IR_CASES(CHOICES)
            OPENFAB_IR_CASES(FUNCTIONS)
            OPENFAB_IR_CASES(DERIVATIVES)
            OPENFAB_IR_CASES(OPERATIONS)
            return true;
    }
    return false;
}

}  // namespace

uint32_t evaluate(const ir::Instr& instr, std::span<const uint32_t> args) {
    if (is_noise(instr.op)) {
        return ir::as_bits(noise<Plain>(instr, args.size(), PlainArgs{args}));
    }
    if (instr.op == Op::kHash) {
        return hash<Plain>({args.begin(), args.end()}, static_cast<uint32_t>(instr.a));
    }
    const float x = ir::as_float(args[0]);
    return ir::as_bits(elementary<Plain>(instr.op, x, args.size() > 1 ? ir::as_float(args[1]) : x));
}

double evaluate_wide(const ir::Instr& instr, std::span<const double> args) {
    if (is_noise(instr.op)) return noise<Wide>(instr, args.size(), WideArgs{args});
    return elementary_wide(instr.op, args[0], args.back());
}

std::optional<uint32_t> fold(const ir::Stage& stage, const ir::Instr& instr) {
    if (!is_operation(instr.op) || instr.args.empty()) return std::nullopt;
    std::vector<uint32_t> bits;
    if (instr.op == Op::kPick) {
        const ir::Instr& index = stage.instrs[instr.args[0]];
        if (index.op != Op::kConst) return std::nullopt;
        const size_t element = ir::picked_element(index.type, index.bits, instr.args.size() - 1);
        const ir::Instr& value = stage.instrs[instr.args[1 + element]];
        return value.op == Op::kConst ? std::optional(value.bits) : std::nullopt;
    }
    for (const ir::ValueId arg : instr.args) {
        if (stage.instrs[arg].op != Op::kConst) return std::nullopt;
        bits.push_back(stage.instrs[arg].bits);
    }
    if (instr.op == Op::kDerivative) return 0;  // the derivative of a constant
    if (ir::is_function(instr.op)) return evaluate(instr, bits);
    const ir::Type type = stage.instrs[instr.args[instr.op == Op::kSelect ? 1 : 0]].type;
    if (instr.op == Op::kConvert) return ir::eval_convert(type, instr.type, bits[0]);
    bits.resize(3, 0);
    return ir::eval(instr.op, type, bits[0], bits[1], bits[2]);
}

ir::ValueId expand(const ir::Instr& instr, ir::Builder* builder) {
    const EmitArgs args{builder};
    if (is_noise(instr.op)) return noise<Emit>(instr, instr.args.size(), args).id;
    if (instr.op == Op::kHash) {
        std::vector<Emit::U> words;
        for (const ir::ValueId arg : instr.args)
            words.push_back({builder, arg});
        return hash<Emit>(words, static_cast<uint32_t>(instr.a)).id;
    }
    const Emit::F x{builder, instr.args[0]};
    return elementary<Emit>(instr.op, x, {builder, instr.args.back()}).id;
}

size_t operations(const ir::Instr& instr) {
    ir::Stage scratch;
    ir::Builder builder(&scratch);
    ir::Instr copy = instr;
    // Only the types of the arguments matter.
    const size_t ints =
        instr.op == Op::kNoise && (instr.a & ir::kPeriodic) != 0 ? (instr.args.size() - 1) / 2 : 0;
    for (size_t k = 0; k < copy.args.size(); ++k) {
        ir::Type type = ir::Type::kFloat;
        const bool seed = is_noise(instr.op) && k + 1 == copy.args.size();
        if (seed || instr.op == Op::kHash) {
            type = ir::Type::kUint;
        } else if (ints > 0 && k >= ints) {
            type = ir::Type::kInt;
        }
        copy.args[k] = builder.input(type, OPENFAB_ARG_UNIFORM, static_cast<int32_t>(k), 0);
    }
    expand(copy, &builder);
    return scratch.instrs.size() - copy.args.size();
}

}  // namespace openfab::functions
