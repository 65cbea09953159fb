// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/exec/random_stage.h"

#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace openfab::testing {

namespace {

using ir::Op;
using ir::Type;
using ir::ValueId;

constexpr size_t kOutputsPerType = 4;

const std::vector<Op> kChoices = {
    Op::kAdd,   Op::kAdd,  Op::kSub,    Op::kSub,    Op::kMul,    Op::kMul,     Op::kDiv,
    Op::kMod,   Op::kNeg,  Op::kBitAnd, Op::kBitOr,  Op::kBitXor, Op::kBitNot,  Op::kShl,
    Op::kShr,   Op::kAnd,  Op::kOr,     Op::kNot,    Op::kEq,     Op::kNe,      Op::kLt,
    Op::kLe,    Op::kGt,   Op::kGe,     Op::kSelect, Op::kSelect, Op::kConvert, Op::kConvert,
    Op::kMin,   Op::kMax,  Op::kAbs,    Op::kSqrt,   Op::kFloor,  Op::kCeil,    Op::kRound,
    Op::kTrunc, Op::kIsNan};

class Generator {
  public:
    explicit Generator(uint32_t seed) : random_(seed) { stage_.kind = ir::StageKind::kVolume; }

    ir::Stage run(int32_t operations) {
        add_inputs();
        for (int32_t k = 0; k < 6; ++k) {
            note(b_.constant(random_float(&random_)));
            note(b_.constant(random_int(&random_)));
        }
        note(b_.constant(uint32_t{3}));
        note(b_.constant(true));
        add_operations(operations);
        add_outputs();
        return std::move(stage_);
    }

    void allow_loops() {
        loops_ = true;
        stage_.printfs = {{"%f %d", false, {1, 2}, {}}};
    }

    void allow_functions() { functions_ = true; }

  private:
    void add_operations(int32_t operations) {
        for (int32_t made = 0; made < operations;) {
            if (functions_ && random_() % 6 == 0) {
                add_function();
                ++made;
                continue;
            }
            const uint32_t draw = loops_ ? random_() % 64 : 0;
            if (draw == 1 && depth_ < 3) {
                made += add_loop(operations - made);
            } else if (draw == 2) {
                add_query();
                ++made;
            } else if (draw == 3 && random_() % 2 == 0) {
                const ValueId guard = pick(Type::kBool);
                b_.printf(0, {guard, pick(Type::kFloat), pick(Type::kInt)});
            } else {
                made += add_operation() ? 1 : 0;
            }
        }
    }

    /// Up to 7 iterations, fewer depending on a value; values inside are not used outside.
    int32_t add_loop(int32_t most) {
        const ValueId limit = b_.constant(static_cast<int32_t>(1 + random_() % 7));
        const ValueId zero = b_.constant(int32_t{0});
        const size_t count = random_() % 4;
        std::vector<Type> types;
        std::vector<ValueId> firsts;
        for (size_t k = 0; k < count; ++k) {
            types.push_back(static_cast<Type>(random_() % 4));
            firsts.push_back(pick(types.back()));
        }
        const ValueId loop = b_.loop(pick(Type::kBool));
        const std::map<Type, std::vector<ValueId>> outside = values_;
        const ValueId counter = b_.loop_var(loop, 0, zero);
        note(counter);
        for (size_t k = 0; k < count; ++k)
            note(b_.loop_var(loop, static_cast<int32_t>(k + 1), firsts[k]));
        ++depth_;
        const int32_t inside = std::min(most, static_cast<int32_t>(3 + random_() % 20));
        add_operations(inside);
        --depth_;
        const ValueId next = b_.emit(Op::kAdd, {counter, b_.constant(int32_t{1})});
        ValueId again = b_.emit(Op::kLt, {next, limit});
        if (random_() % 3 != 0) again = b_.emit(Op::kAnd, {again, pick(Type::kBool)});
        std::vector<ValueId> nexts = {next};
        for (const Type type : types)
            nexts.push_back(pick(type));
        const ValueId end = b_.loop_end(loop, again, nexts);
        values_ = outside;
        for (size_t k = 0; k < nexts.size(); ++k)
            note(b_.loop_result(end, static_cast<int32_t>(k)));
        return inside;
    }

    void add_function() {
        ir::Instr instr;
        instr.op = static_cast<Op>(static_cast<uint32_t>(Op::kSin) +
                                   random_() % (static_cast<uint32_t>(Op::kCellular) -
                                                static_cast<uint32_t>(Op::kSin) + 1));
        instr.type = instr.op == Op::kHash ? Type::kUint : Type::kFloat;
        if (ir::arity(instr.op) > 0) {
            for (int k = 0; k < ir::arity(instr.op); ++k)
                instr.args.push_back(pick(Type::kFloat));
        } else if (instr.op == Op::kHash) {
            instr.a = static_cast<int32_t>(random_() % 4);
            instr.args = {pick(Type::kUint), pick(Type::kUint)};
        } else {
            const bool cellular = instr.op == Op::kCellular;
            const bool perlin = instr.op == Op::kNoise;
            const bool periodic = perlin && random_() % 3 == 0;
            const uint32_t axes = perlin     ? 1 + random_() % 4
                                  : cellular ? 2 + random_() % 2
                                             : 2 + random_() % 3;
            for (uint32_t k = 0; k < axes; ++k)
                instr.args.push_back(pick(Type::kFloat));
            for (uint32_t k = 0; periodic && k < axes; ++k)
                instr.args.push_back(pick(Type::kInt));
            // Mostly a seed that does not vary.
            instr.args.push_back(random_() % 4 == 0
                                     ? pick(Type::kUint)
                                     : b_.constant(static_cast<uint32_t>(random_())));
            instr.a = static_cast<int32_t>(random_() % (cellular ? 3 : axes + 1));
            if (periodic) instr.a += ir::kPeriodic;
        }
        note(b_.append(std::move(instr)));
    }

    void add_query() {
        const ValueId query = b_.query(
            -1, pick(Type::kBool), {pick(Type::kFloat), pick(Type::kFloat), pick(Type::kFloat)});
        note(b_.query_result(query, Type::kFloat, OPENFAB_QUERY_DISTANCE, 0, 0));
        note(b_.query_result(query, Type::kFloat, OPENFAB_QUERY_POSITION, 0, 1));
        note(b_.query_result(query, Type::kInt, OPENFAB_QUERY_ATTRIBUTE, 1, 0));
        const ValueId walk = b_.walk(-1, pick(Type::kBool),
                                     {pick(Type::kFloat), pick(Type::kFloat), pick(Type::kFloat)},
                                     pick(Type::kFloat), pick(Type::kInt));
        note(b_.query_result(walk, Type::kFloat, OPENFAB_QUERY_END, 0, 1));
        note(b_.query_result(walk, Type::kInt, OPENFAB_QUERY_END_ON, 0, 0));
    }

    void note(ValueId value) { values_[b_.type(value)].push_back(value); }
    void add_inputs() {
        for (int32_t k = 0; k < kRandomFloats; ++k) {
            note(b_.input(Type::kFloat, OPENFAB_ARG_NEAREST, 0, k));
            note(b_.input(Type::kFloat, ir::kVoxelCoord, k, 0));
        }
        for (int32_t k = 0; k < kRandomInts; ++k) {
            note(b_.input(Type::kInt, OPENFAB_ARG_NEAREST, 1, k));
        }
        note(b_.input(Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0));
        note(b_.input(Type::kFloat, OPENFAB_ARG_UNIFORM, kFloatUniform, 0));
        note(b_.input(Type::kInt, OPENFAB_ARG_UNIFORM, kIntUniform, 0));
    }

    ValueId pick(Type type) {
        const std::vector<ValueId>& all = values_[type];
        // Recent values twice as often, so that chains grow.
        const size_t from = random_() % 2 == 0 ? all.size() / 2 : 0;
        return all[from + random_() % (all.size() - from)];
    }

    bool add_operation() {
        const Op op = kChoices[random_() % kChoices.size()];
        const Type type = std::vector<Type>{Type::kFloat, Type::kFloat, Type::kInt, Type::kUint,
                                            Type::kBool}[random_() % 5];
        if (op == Op::kConvert) {
            const Type to = static_cast<Type>(random_() % 4);
            if (to == type) return false;
            note(b_.convert(pick(type), to));
            return true;
        }
        if (op == Op::kSelect) {
            note(b_.select(pick(Type::kBool), pick(type), pick(type)));
            return true;
        }
        std::vector<ValueId> args;
        for (int k = 0; k < ir::arity(op); ++k)
            args.push_back(pick(type));
        note(b_.emit(op, args));
        if (ir::verify(stage_).empty()) return true;
        // Not defined on this type: drop it.
        values_[b_.type(static_cast<ValueId>(stage_.instrs.size() - 1))].pop_back();
        stage_.instrs.pop_back();
        return false;
    }

    void add_outputs() {
        for (auto& [type, all] : values_) {
            const size_t count = std::min(kOutputsPerType, all.size());
            for (size_t k = all.size() - count; k < all.size(); ++k) {
                const auto slot = static_cast<int32_t>(stage_.outputs.size());
                stage_.outputs.push_back({ir::spelling(type) + std::to_string(slot),
                                          OPENFAB_ARG_WEIGHT, slot, 0, all[k]});
            }
        }
    }

    std::mt19937 random_;
    ir::Stage stage_;
    ir::Builder b_{&stage_};
    std::map<Type, std::vector<ValueId>> values_;
    bool loops_ = false;
    bool functions_ = false;
    int depth_ = 0;
};

}  // namespace

float random_float(std::mt19937* random) {
    const float unit = static_cast<float>((*random)() >> 8) * 0x1p-24f;
    switch ((*random)() % 10) {
        case 0:
            return 0.0f;
        case 1:
            return static_cast<float>(static_cast<int>((*random)() % 9) - 4);
        case 2:
            return std::ldexp(unit - 0.5f, static_cast<int>((*random)() % 120));
        case 3:
            return std::ldexp(unit - 0.5f, -static_cast<int>((*random)() % 140));
        case 4:
            return unit;
        default:
            return (unit - 0.5f) * 20.0f;
    }
}

int32_t random_int(std::mt19937* random) {
    switch ((*random)() % 6) {
        case 0:
            return static_cast<int32_t>((*random)());
        case 1:
            return std::numeric_limits<int32_t>::min();
        case 2:
            return std::numeric_limits<int32_t>::max();
        default:
            return static_cast<int32_t>((*random)() % 21) - 10;
    }
}

ir::Stage random_stage_with_functions(uint32_t seed, int32_t operations) {
    Generator generator(seed);
    generator.allow_functions();
    return generator.run(operations);
}

ir::Stage random_stage(uint32_t seed, int32_t operations) {
    return Generator(seed).run(operations);
}

ir::Stage random_looping_stage(uint32_t seed, int32_t operations) {
    Generator generator(seed);
    generator.allow_loops();
    return generator.run(operations);
}

}  // namespace openfab::testing
