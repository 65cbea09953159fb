// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "compiler/ir/ir.h"

namespace openfab::ir {

namespace {

bool obeys(Operands rule, Type type) {
    switch (rule) {
        case Operands::kNumbers:
            return type != Type::kBool;
        case Operands::kIntegers:
            return type == Type::kInt || type == Type::kUint;
        case Operands::kFloats:
            return type == Type::kFloat;
        case Operands::kBools:
            return type == Type::kBool;
        case Operands::kAny:
        case Operands::kOwn:
            return true;
    }
    return false;
}

class Verifier {
  public:
    explicit Verifier(const Stage& stage) : stage_(stage) {}

    std::string run() {
        for (ValueId id = 0; id < stage_.instrs.size(); ++id) {
            std::string fault = check_scope(id);
            if (fault.empty()) fault = check(id);
            if (!fault.empty()) {
                return fmt::format("%{} = {}: {}", id, spelling(stage_.instrs[id].op), fault);
            }
            enter_and_leave(id);
        }
        if (!open_.empty()) return fmt::format("%{} = loop: no end", open_.back());
        for (const Output& output : stage_.outputs) {
            if (output.value >= stage_.instrs.size()) {
                return fmt::format("output {}: no value %{}", output.name, output.value);
            }
            if (!in_scope(output.value)) {
                return fmt::format("output {}: %{} is inside a loop", output.name, output.value);
            }
        }
        return "";
    }

  private:
    bool in_scope(ValueId value) const {
        const ValueId loop = inside_[value];
        return loop == kNoValue || std::find(open_.begin(), open_.end(), loop) != open_.end();
    }

    std::string check_scope(ValueId id) const {
        const Instr& instr = stage_.instrs[id];
        for (size_t k = 0; k < instr.args.size(); ++k) {
            const ValueId arg = instr.args[k];
            if (arg >= id) return fmt::format("argument %{} does not come earlier", arg);
            if (!in_scope(arg)) return fmt::format("argument %{} is inside a loop that ended", arg);
            const bool head = k == 0;
            bool fits = true;
            switch (stage_.instrs[arg].op) {
                case Op::kLoop:
                    fits = head && (instr.op == Op::kLoopVar || instr.op == Op::kLoopEnd);
                    break;
                case Op::kLoopEnd:
                    fits = head && instr.op == Op::kLoopResult;
                    break;
                case Op::kQuery:
                    fits = head && instr.op == Op::kQueryResult;
                    break;
                case Op::kPrintf:
                    fits = false;
                    break;
                case Op::kLoopVar:
                case Op::kLoopResult:
                case Op::kQueryResult:
                    OPENFAB_IR_CASES(LEAVES)
                    OPENFAB_IR_CASES(CHOICES)
                    OPENFAB_IR_CASES(LOOKUPS)
                    OPENFAB_IR_CASES(FUNCTIONS)
                    OPENFAB_IR_CASES(DERIVATIVES)
                    OPENFAB_IR_CASES(OPERATIONS)
                    break;
            }
            if (!fits) return fmt::format("argument %{} is not a value", arg);
        }
        return "";
    }

    void enter_and_leave(ValueId id) {
        const Op op = stage_.instrs[id].op;
        if (op == Op::kLoopEnd) open_.pop_back();
        inside_.push_back(open_.empty() ? kNoValue : open_.back());
        if (op == Op::kLoop) open_.push_back(id);
    }

    Type type_of(const Instr& instr, size_t arg) const {
        return stage_.instrs[instr.args[arg]].type;
    }

    std::string check(ValueId id) const {
        const Instr& instr = stage_.instrs[id];
        const int count = static_cast<int>(instr.args.size());
        if (arity(instr.op) >= 0 && arity(instr.op) != count) {
            return fmt::format("{} arguments, not {}", count, arity(instr.op));
        }
        const Operands rule = traits(instr.op).operands;
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
                if (count != 4 && count != 10 && count != 5 && count != 14)
                    return "4 or 10 arguments are right, in a volume 5 or 14";
                return check_sample(instr);
            case Op::kSampleBound:
                if (count != 12 && count != 17) return "12 arguments are right, in a volume 17";
                return check_sample(instr);
            case Op::kLoop:
                return check_guarded(instr);
            case Op::kLoopVar:
                return check_loop_var(id, instr);
            case Op::kLoopEnd:
                return check_loop_end(instr);
            case Op::kLoopResult:
                return check_loop_result(instr);
            case Op::kQuery:
                return check_query(instr);
            case Op::kQueryResult:
                return check_query_result(instr);
            case Op::kPrintf:
                if (count == 0) return "no guard";
                if (instr.a < 0 || static_cast<size_t>(instr.a) >= stage_.printfs.size()) {
                    return "no such printf";
                }
                return check_guarded(instr);
            case Op::kBitCast:
                if (instr.type == Type::kBool || type_of(instr, 0) == Type::kBool) {
                    return "a bool has no bits";
                }
                return "";
            case Op::kPick:
                return check_pick(instr);
            case Op::kTable:
                if (!obeys(Operands::kIntegers, type_of(instr, 0)))
                    return "the index is no integer";
                if (instr.a < 0 || instr.b < 1 || instr.bits < 1) return "no such values";
                return "";
            case Op::kHash:
                if (instr.args.empty() || instr.type != Type::kUint) return "a uint of uints";
                return check_operands(instr, Operands::kIntegers);
            case Op::kDerivative:
                if (instr.a < 0 || instr.a > 1) return "no such axis";
                return check_operands(instr, Operands::kFloats);
            case Op::kNoise:
            case Op::kSimplex:
            case Op::kCellular:
                return check_noise(instr);
                OPENFAB_IR_CASES(ELEMENTARY)
                OPENFAB_IR_CASES(OPERATIONS)
                return check_operands(instr, rule);
        }
        return "";
    }

    /// Coordinates, as many periods or none, the seed.
    std::string check_noise(const Instr& instr) const {
        if (instr.type != Type::kFloat) return "the result is a float";
        size_t axes = 0;
        while (axes < instr.args.size() && type_of(instr, axes) == Type::kFloat)
            ++axes;
        if (axes < 1 || axes > 4) return "1 to 4 coordinates are right";
        size_t periods = 0;
        while (axes + periods < instr.args.size() && type_of(instr, axes + periods) == Type::kInt)
            ++periods;
        const bool periodic = instr.op == Op::kNoise && (instr.a & kPeriodic) != 0;
        if (periods != (periodic ? axes : 0)) return "periods that do not fit";
        if (instr.args.size() != axes + periods + 1 ||
            type_of(instr, axes + periods) != Type::kUint) {
            return "the seed, a uint, comes last";
        }
        const int32_t result = periodic ? instr.a - kPeriodic : instr.a;
        return result < 0 || result > 4 ? "no such result" : "";
    }

    std::string check_guarded(const Instr& instr) const {
        if (instr.type != Type::kBool) return "the type is bool";
        return type_of(instr, 0) != Type::kBool ? "the guard is not a bool" : "";
    }

    std::string check_query(const Instr& instr) const {
        if (!is_walk(instr) && instr.args.size() != 4) return "4 arguments are right, of a walk 6";
        for (size_t k = 1; k < instr.args.size(); ++k) {
            const Type type = k < 5 ? Type::kFloat : Type::kInt;
            if (type_of(instr, k) != type) return fmt::format("argument {} has a wrong type", k);
        }
        return check_guarded(instr);
    }

    std::string check_query_result(const Instr& instr) const {
        const Instr& query = stage_.instrs[instr.args[0]];
        if (query.op != Op::kQuery) return "not of a query";
        const bool of_walk = instr.kind == OPENFAB_QUERY_END || instr.kind == OPENFAB_QUERY_END_ON;
        if (instr.kind < 0 || instr.kind > OPENFAB_QUERY_END_ON || of_walk != is_walk(query))
            return "no such result";
        return "";
    }

    std::string check_loop_var(ValueId id, const Instr& instr) const {
        if (open_.empty() || instr.args[0] != open_.back()) return "not of the loop around it";
        if (id - open_.back() != static_cast<ValueId>(instr.a) + 1) {
            return "not in its place after the loop";
        }
        if (instr.args[1] > open_.back()) return "its first value is inside the loop";
        return type_of(instr, 1) != instr.type ? "its first value differs in type" : "";
    }

    std::string check_loop_end(const Instr& instr) const {
        if (instr.args.size() < kLoopEndNext) return "too few arguments";
        if (open_.empty() || instr.args[0] != open_.back()) return "not of the loop around it";
        if (instr.type != Type::kBool) return "the type is bool";
        if (type_of(instr, 1) != Type::kBool) return "the condition is not a bool";
        size_t vars = 0;
        while (stage_.instrs[open_.back() + 1 + vars].op == Op::kLoopVar)
            ++vars;
        if (instr.args.size() != kLoopEndNext + vars) {
            return fmt::format("{} values for {} variables", instr.args.size() - kLoopEndNext,
                               vars);
        }
        for (size_t k = 0; k < vars; ++k) {
            if (type_of(instr, kLoopEndNext + k) != stage_.instrs[open_.back() + 1 + k].type) {
                return fmt::format("value {} differs in type from its variable", k);
            }
        }
        return "";
    }

    std::string check_loop_result(const Instr& instr) const {
        const Instr& end = stage_.instrs[instr.args[0]];
        if (end.op != Op::kLoopEnd) return "not of a loop's end";
        const size_t index = kLoopEndNext + static_cast<size_t>(instr.a);
        if (instr.a < 0 || index >= end.args.size()) return "no such variable";
        return type_of(end, index) != instr.type ? "its variable differs in type" : "";
    }

    std::string check_select(const Instr& instr) const {
        if (type_of(instr, 0) != Type::kBool) return "the condition is not a bool";
        if (type_of(instr, 1) != instr.type || type_of(instr, 2) != instr.type) {
            return "the two sides and the result differ in type";
        }
        return "";
    }

    std::string check_pick(const Instr& instr) const {
        if (instr.args.size() < 2) return "no elements";
        if (!obeys(Operands::kIntegers, type_of(instr, 0))) return "the index is no integer";
        for (size_t i = 1; i < instr.args.size(); ++i) {
            if (type_of(instr, i) != instr.type) return "elements and result differ in type";
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

    std::string check_operands(const Instr& instr, Operands rule) const {
        const Type type = type_of(instr, 0);
        for (size_t i = 1; i < instr.args.size(); ++i) {
            if (type_of(instr, i) != type) return "operands of different types";
        }
        if (!obeys(rule, type)) {
            return fmt::format("not defined on {}", spelling(type));
        }
        const bool gives_bool = traits(instr.op).result == Result::kBool;
        if (instr.type != (gives_bool ? Type::kBool : type)) {
            return fmt::format("a result of type {}", spelling(instr.type));
        }
        return "";
    }

    const Stage& stage_;
    std::vector<ValueId> open_;    ///< loops around the current instruction
    std::vector<ValueId> inside_;  ///< innermost loop around each instruction so far
};

}  // namespace

std::string verify(const Stage& stage) {
    return Verifier(stage).run();
}

}  // namespace openfab::ir
