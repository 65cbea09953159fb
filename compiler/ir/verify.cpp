// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "compiler/ir/ir.h"

namespace openfab::ir {

namespace {

enum class Rule { kNumbers, kIntegers, kFloats, kBools, kAny };

Rule operand_rule(Op op) {
    switch (op) {
        case Op::kAdd:
        case Op::kSub:
        case Op::kMul:
        case Op::kDiv:
        case Op::kMod:
        case Op::kNeg:
        case Op::kMin:
        case Op::kMax:
        case Op::kAbs:
        case Op::kLt:
        case Op::kLe:
        case Op::kGt:
        case Op::kGe:
            return Rule::kNumbers;
        case Op::kBitAnd:
        case Op::kBitOr:
        case Op::kBitXor:
        case Op::kBitNot:
        case Op::kShl:
        case Op::kShr:
            return Rule::kIntegers;
        case Op::kSqrt:
        case Op::kFloor:
        case Op::kCeil:
        case Op::kRound:
        case Op::kTrunc:
        case Op::kIsNan:
            return Rule::kFloats;
        case Op::kAnd:
        case Op::kOr:
        case Op::kNot:
            return Rule::kBools;
        default:
            return Rule::kAny;
    }
}

bool obeys(Rule rule, Type type) {
    switch (rule) {
        case Rule::kNumbers:
            return type != Type::kBool;
        case Rule::kIntegers:
            return type == Type::kInt || type == Type::kUint;
        case Rule::kFloats:
            return type == Type::kFloat;
        case Rule::kBools:
            return type == Type::kBool;
        case Rule::kAny:
            return true;
    }
    return false;
}

class Verifier {
  public:
    explicit Verifier(const Stage& stage) : stage_(stage) {}

    std::string run() {
        for (size_t id = 0; id < stage_.instrs.size(); ++id) {
            std::string fault = check(id);
            if (!fault.empty()) {
                return fmt::format("%{} = {}: {}", id, spelling(stage_.instrs[id].op), fault);
            }
        }
        for (const Output& output : stage_.outputs) {
            if (output.value >= stage_.instrs.size()) {
                return fmt::format("output {}: no value %{}", output.name, output.value);
            }
        }
        return "";
    }

  private:
    Type type_of(const Instr& instr, size_t arg) const {
        return stage_.instrs[instr.args[arg]].type;
    }

    std::string check(size_t id) const {
        const Instr& instr = stage_.instrs[id];
        const int count = static_cast<int>(instr.args.size());
        for (ValueId arg : instr.args) {
            if (arg >= id) return fmt::format("argument %{} does not come earlier", arg);
        }
        if (arity(instr.op) >= 0 && arity(instr.op) != count) {
            return fmt::format("{} arguments, not {}", count, arity(instr.op));
        }
        switch (instr.op) {
            case Op::kConst:
                if (instr.type == Type::kBool && instr.bits > 1) return "a bool is 0 or 1";
                return "";
            case Op::kInput:
                return instr.kind < 0 ? "a negative kind" : "";
            case Op::kConvert:
                return "";
            case Op::kSelect:
                return check_select(instr);
            case Op::kSample:
                if (count != 4 && count != 10) return "4 or 10 arguments are right";
                return check_sample(instr);
            case Op::kSampleBound:
                if (count != 12) return "12 arguments are right";
                return check_sample(instr);
            default:
                return check_operands(instr);
        }
    }

    std::string check_select(const Instr& instr) const {
        if (type_of(instr, 0) != Type::kBool) return "the condition is not a bool";
        if (type_of(instr, 1) != instr.type || type_of(instr, 2) != instr.type) {
            return "the two sides and the result differ in type";
        }
        return "";
    }

    std::string check_sample(const Instr& instr) const {
        if (instr.type != Type::kFloat) return "the result is a float";
        if (instr.a < 0 || instr.b < 0) return "a negative texture or channel";
        if (type_of(instr, 0) != Type::kBool) return "the guard is not a bool";
        for (size_t i = 1; i < instr.args.size(); ++i) {
            if (type_of(instr, i) != Type::kFloat) {
                return fmt::format("argument {} is not a float", i);
            }
        }
        return "";
    }

    std::string check_operands(const Instr& instr) const {
        const Type type = type_of(instr, 0);
        for (size_t i = 1; i < instr.args.size(); ++i) {
            if (type_of(instr, i) != type) return "operands of different types";
        }
        if (!obeys(operand_rule(instr.op), type)) {
            return fmt::format("not defined on {}", spelling(type));
        }
        const bool compares =
            (instr.op >= Op::kEq && instr.op <= Op::kGe) || instr.op == Op::kIsNan;
        if (instr.type != (compares ? Type::kBool : type)) {
            return fmt::format("a result of type {}", spelling(instr.type));
        }
        return "";
    }

    const Stage& stage_;
};

}  // namespace

std::string verify(const Stage& stage) {
    return Verifier(stage).run();
}

}  // namespace openfab::ir
