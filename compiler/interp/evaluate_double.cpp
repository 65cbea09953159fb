// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/interp/evaluate_double.h"

#include <array>
#include <bit>
#include <cmath>

#include "compiler/functions/functions.h"
#include "compiler/interp/evaluate.h"
#include "compiler/interp/evaluator.h"

namespace openfab::interp {

namespace {

using ir::Op;
using ir::Type;
using Word = uint64_t;

double number(Word word) {
    return std::bit_cast<double>(word);
}
Word word(double number) {
    return std::bit_cast<Word>(number);
}

Word float_operation(Op op, double a, double b) {
    switch (op) {
        case Op::kAdd:
            return word(a + b);
        case Op::kSub:
            return word(a - b);
        case Op::kMul:
            return word(a * b);
        case Op::kDiv:
            return word(a / b);
        case Op::kMod:
            return word(a - b * std::trunc(a / b));
        case Op::kNeg:
            return word(-a);
        case Op::kAbs:
            return word(std::fabs(a));
        case Op::kMin:
            return word(a < b ? a : b);
        case Op::kMax:
            return word(a > b ? a : b);
        case Op::kSqrt:
            return word(std::sqrt(a));
        case Op::kFloor:
            return word(std::floor(a));
        case Op::kCeil:
            return word(std::ceil(a));
        case Op::kRound:
            return word(std::nearbyint(a));
        case Op::kTrunc:
            return word(std::trunc(a));
        case Op::kIsNan:
            return std::isnan(a) ? 1 : 0;
        case Op::kEq:
            return a == b ? 1 : 0;
        case Op::kNe:
            return a != b ? 1 : 0;
        case Op::kLt:
            return a < b ? 1 : 0;
        case Op::kLe:
            return a <= b ? 1 : 0;
        case Op::kGt:
            return a > b ? 1 : 0;
        case Op::kGe:
            return a >= b ? 1 : 0;
            OPENFAB_IR_CASES(BITS)
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(STRUCTURE)
            break;
    }
    return 0;
}

class DoubleMachine {
  public:
    using Word = interp::Word;
    explicit DoubleMachine(const DoubleEnvironment& environment) : environment_(environment) {}

    Word constant(const ir::Instr& instr) const { return from_bits(instr.type, instr.bits); }
    Word input(Type type, int32_t kind, int32_t a, int32_t b) const {
        return type == Type::kFloat ? word(environment_.number(kind, a, b))
                                    : environment_.bits(kind, a, b);
    }
    Word sample(const ir::Instr& instr, std::span<const Word> args) const {
        if (args[0] == 0) return word(0);
        std::vector<uint32_t> bits = {1};
        for (const Word arg : args.subspan(1))
            bits.push_back(to_bits(Type::kFloat, arg));
        return from_bits(Type::kFloat,
                         evaluate_sample(environment_.texture(instr.a), instr.b, bits));
    }
    Word sample_bound(const ir::Instr& /*instr*/, std::span<const Word> /*args*/) const {
        return word(std::nan(""));
    }
    Word query(const ir::Instr& query, const ir::Instr& result, std::span<const Word> args) const {
        const std::array<double, 3> point = {number(args[1]), number(args[2]), number(args[3])};
        const double out = environment_.query(query, result, point);
        return result.type == Type::kFloat ? word(out)
                                           : static_cast<uint32_t>(static_cast<int64_t>(out));
    }
    void printf(const ir::Printf& /*call*/, std::span<const Word> /*values*/) const {}
    Word function(const ir::Instr& instr, std::span<const Word> args) const {
        if (instr.op == Op::kHash) {
            const std::vector<uint32_t> bits(args.begin(), args.end());
            return functions::evaluate(instr, bits);
        }
        // Of a noise, periods and the seed follow the coordinates.
        std::vector<double> values;
        const bool periodic = instr.op == Op::kNoise && (instr.a & ir::kPeriodic) != 0;
        const size_t floats = ir::family(instr.op) != ir::Family::kNoise ? args.size()
                              : periodic                                 ? (args.size() - 1) / 2
                                                                         : args.size() - 1;
        for (size_t k = 0; k < args.size(); ++k) {
            const auto bits = static_cast<uint32_t>(args[k]);
            const bool seed = k + 1 == args.size();
            values.push_back(k < floats ? number(args[k])
                             : seed     ? static_cast<double>(bits)
                                        : static_cast<double>(ir::as_int(bits)));
        }
        return word(functions::evaluate_wide(instr, values));
    }
    Word convert(Type from, Type to, Word x) const {
        if (from == Type::kFloat && to != Type::kFloat)
            return ir::eval_convert(from, to, to_bits(from, x));
        if (to != Type::kFloat || from == Type::kFloat)
            return from == to ? x : ir::eval_convert(from, to, static_cast<uint32_t>(x));
        const auto bits = static_cast<uint32_t>(x);
        return word(from == Type::kInt ? static_cast<double>(ir::as_int(bits))
                                       : static_cast<double>(bits));
    }
    Word operation(const ir::Instr& instr, Type type, Word a, Word b) const {
        if (instr.op == Op::kBitCast) return from_bits(instr.type, to_bits(type, a));
        if (type == Type::kFloat) return float_operation(instr.op, number(a), number(b));
        return ir::eval(instr.op, type, static_cast<uint32_t>(a), static_cast<uint32_t>(b), 0);
    }

  private:
    static Word from_bits(Type type, uint32_t bits) {
        return type == Type::kFloat ? word(ir::as_float(bits)) : bits;
    }
    static uint32_t to_bits(Type type, Word x) {
        return type == Type::kFloat ? ir::as_bits(static_cast<float>(number(x)))
                                    : static_cast<uint32_t>(x);
    }

    const DoubleEnvironment& environment_;
};

}  // namespace

double DoubleEnvironment::query(const ir::Instr& /*query*/, const ir::Instr& /*result*/,
                                std::span<const double, 3> /*point*/) const {
    return 0;
}

std::vector<double> evaluate_double(const ir::Stage& stage, const DoubleEnvironment& environment) {
    const std::vector<Word> values = Evaluator(stage, DoubleMachine(environment)).run();
    std::vector<double> out;
    for (const ir::Output& output : stage.outputs) {
        const Word value = values[output.value];
        out.push_back(stage.instrs[output.value].type == Type::kFloat ? number(value)
                                                                      : static_cast<double>(value));
    }
    return out;
}

}  // namespace openfab::interp
