// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <limits>

#include "compiler/ir/arithmetic.h"
#include "compiler/translate/translate_state.h"

namespace openfab::sema {

using ir::Op;
using ir::ValueId;

namespace {

constexpr float kPi = 3.14159265f;
constexpr float kRadiansPerDegree = 0.0174532925f;
constexpr float kDegreesPerRadian = 180.0f / kPi;
constexpr int32_t kMaxChannel = 63;  // no image format that is read here has more

bool is_geometric(Intrinsic id) {
    switch (id) {
        case Intrinsic::kAny:
        case Intrinsic::kAll:
        case Intrinsic::kDot:
        case Intrinsic::kLength:
        case Intrinsic::kDistance:
        case Intrinsic::kNormalize:
        case Intrinsic::kReflect:
        case Intrinsic::kFaceforward:
        case Intrinsic::kCross:
            return true;
        default:
            return false;
    }
}

}  // namespace

// The formulas are those that compiler/check/intrinsics.def states.

ValueId StageTranslator::clamp(ValueId x, ValueId lo, ValueId hi) {
    return emit_.binary(Op::kMin, emit_.binary(Op::kMax, x, lo), hi);
}

ValueId StageTranslator::dot(const Value& a, const Value& b) {
    ValueId sum = emit_.binary(Op::kMul, a[0], b[0]);
    for (size_t i = 1; i < a.size(); ++i) {
        sum = emit_.binary(Op::kAdd, sum, emit_.binary(Op::kMul, a[i], b[i]));
    }
    return sum;
}

Value StageTranslator::intrinsic(const Expr& expr) {
    if (is_function_intrinsic(expr.intrinsic)) return function_call(expr);
    std::vector<Value> args;
    for (const ExprPtr& arg : expr.args)
        args.push_back(expression(*arg));
    emit_.set_span(expr.span);
    if (is_geometric(expr.intrinsic)) return geometric(expr, args);
    Value out;
    for (size_t i = 0; i < args[0].size(); ++i) {
        std::vector<ValueId> component;
        for (const Value& arg : args)
            component.push_back(arg[arg.size() == 1 ? 0 : i]);
        out.push_back(component_intrinsic(expr, component));
    }
    return out;
}

ValueId StageTranslator::component_intrinsic(const Expr& expr, const std::vector<ValueId>& x) {
    const auto bin = [&](Op op, ValueId a, ValueId b) { return emit_.binary(op, a, b); };
    const ir::Type type = emit_.type(x[0]);
    const ValueId zero = emit_.constant(type, 0);
    const ValueId one = emit_.convert(emit_.constant(ir::Type::kInt, 1), type);
    switch (expr.intrinsic) {
        case Intrinsic::kAbs:
            return emit_.unary(Op::kAbs, x[0]);
        case Intrinsic::kSign: {
            const ValueId above = emit_.convert(bin(Op::kGt, x[0], zero), ir::Type::kInt);
            const ValueId below = emit_.convert(bin(Op::kLt, x[0], zero), ir::Type::kInt);
            return bin(Op::kSub, above, below);
        }
        case Intrinsic::kMin:
            return bin(Op::kMin, x[0], x[1]);
        case Intrinsic::kMax:
            return bin(Op::kMax, x[0], x[1]);
        case Intrinsic::kClamp:
            return clamp(x[0], x[1], x[2]);
        case Intrinsic::kMad:
            return bin(Op::kAdd, bin(Op::kMul, x[0], x[1]), x[2]);
        case Intrinsic::kSaturate:
            return clamp(x[0], zero, one);
        case Intrinsic::kFloor:
            return emit_.unary(Op::kFloor, x[0]);
        case Intrinsic::kCeil:
            return emit_.unary(Op::kCeil, x[0]);
        case Intrinsic::kRound:
            return emit_.unary(Op::kRound, x[0]);
        case Intrinsic::kTrunc:
            return emit_.unary(Op::kTrunc, x[0]);
        case Intrinsic::kFrac:
            return bin(Op::kSub, x[0], emit_.unary(Op::kFloor, x[0]));
        case Intrinsic::kFmod:
            return bin(Op::kMod, x[0], x[1]);
        case Intrinsic::kSqrt:
            return emit_.unary(Op::kSqrt, x[0]);
        case Intrinsic::kRsqrt:
            return bin(Op::kDiv, one, emit_.unary(Op::kSqrt, x[0]));
        case Intrinsic::kRcp:
            return bin(Op::kDiv, one, x[0]);
        case Intrinsic::kStep:
            return emit_.select(bin(Op::kGe, x[1], x[0]), one, zero);
        case Intrinsic::kSmoothstep: {
            const ValueId ratio =
                bin(Op::kDiv, bin(Op::kSub, x[2], x[0]), bin(Op::kSub, x[1], x[0]));
            const ValueId t = clamp(ratio, zero, one);
            const ValueId ramp =
                bin(Op::kSub, emit_.constant(3.0f), bin(Op::kMul, emit_.constant(2.0f), t));
            return bin(Op::kMul, bin(Op::kMul, t, t), ramp);
        }
        case Intrinsic::kLerp:
            return bin(Op::kAdd, x[0], bin(Op::kMul, x[2], bin(Op::kSub, x[1], x[0])));
        case Intrinsic::kRadians:
            return bin(Op::kMul, x[0], emit_.constant(kRadiansPerDegree));
        case Intrinsic::kDegrees:
            return bin(Op::kMul, x[0], emit_.constant(kDegreesPerRadian));
        case Intrinsic::kIsNan:
            return emit_.unary(Op::kIsNan, x[0]);
        case Intrinsic::kIsInf:
        case Intrinsic::kIsFinite: {
            const ValueId inf = emit_.constant(std::numeric_limits<float>::infinity());
            const Op op = expr.intrinsic == Intrinsic::kIsInf ? Op::kEq : Op::kLt;
            return bin(op, emit_.unary(Op::kAbs, x[0]), inf);
        }
        default:
            return x[0];
    }
}

Value StageTranslator::geometric(const Expr& expr, const std::vector<Value>& args) {
    const Value& a = args[0];
    const Value& b = args.size() > 1 ? args[1] : args[0];
    switch (expr.intrinsic) {
        case Intrinsic::kAny:
        case Intrinsic::kAll: {
            ValueId out = emit_.convert(a[0], ir::Type::kBool);
            for (size_t i = 1; i < a.size(); ++i) {
                const ValueId next = emit_.convert(a[i], ir::Type::kBool);
                out = expr.intrinsic == Intrinsic::kAny ? emit_.logical_or(out, next)
                                                        : emit_.logical_and(out, next);
            }
            return {out};
        }
        case Intrinsic::kDot:
            return {dot(a, b)};
        case Intrinsic::kLength:
            return {emit_.unary(Op::kSqrt, dot(a, a))};
        case Intrinsic::kDistance: {
            const Value d = binary_values(Op::kSub, a, b);
            return {emit_.unary(Op::kSqrt, dot(d, d))};
        }
        case Intrinsic::kNormalize:
            return binary_values(Op::kDiv, a, {emit_.unary(Op::kSqrt, dot(a, a))});
        case Intrinsic::kReflect: {
            const ValueId twice = emit_.binary(Op::kMul, emit_.constant(2.0f), dot(a, b));
            return binary_values(Op::kSub, a, binary_values(Op::kMul, b, {twice}));
        }
        case Intrinsic::kFaceforward: {
            const ValueId away = emit_.binary(Op::kLt, dot(args[1], args[2]), emit_.constant(0.0f));
            Value out;
            for (ValueId n : a)
                out.push_back(emit_.select(away, n, emit_.unary(Op::kNeg, n)));
            return out;
        }
        case Intrinsic::kCross: {
            Value out;
            for (size_t i = 0; i < 3; ++i) {
                const size_t j = (i + 1) % 3;
                const size_t k = (i + 2) % 3;
                out.push_back(emit_.binary(Op::kSub, emit_.binary(Op::kMul, a[j], b[k]),
                                           emit_.binary(Op::kMul, a[k], b[j])));
            }
            return out;
        }
        default:
            return a;
    }
}

Value StageTranslator::sample(const Expr& expr) {
    const ValueId texture = scalar(*expr.args[0]);
    const ValueId channel = scalar(*expr.args[1]);
    const ValueId width = scalar(*expr.args[2]);
    Value at;
    for (size_t i = 3; i < expr.args.size(); ++i) {
        const Value part = expression(*expr.args[i]);
        at.insert(at.end(), part.begin(), part.end());
    }
    if (gave_up_) return zero(expr.type);
    emit_.set_span(expr.span);
    if (!emit_.is_constant(channel)) {
        sink_->report(expr.args[1]->span, diag::kNotConstant, "the channel of a look-up");
        return zero(expr.type);
    }
    const int32_t first = ir::as_int(emit_.instr(channel).bits);
    if (first < 0 || first > kMaxChannel) {
        sink_->report(expr.args[1]->span, diag::kOutOfRange, "channel", first, 0, kMaxChannel);
        return zero(expr.type);
    }
    // Where the texture varies each that it may be is looked up by those who mean it.
    const std::vector<int32_t> textures = possible_indices(texture, fablet_.ir.texture_count);
    Value out = zero(expr.type);
    if (textures.size() > kMaxTextures) {
        sink_
            ->report(expr.span, diag::kTooComplex,
                     fmt::format("a varying index that may pick one of {} textures; at most {} "
                                 "can be looked up",
                                 textures.size(), kMaxTextures))
            .help("each of them is looked up by the voxels that mean it: pack them in one texture");
        return out;
    }
    for (int32_t index : textures) {
        const ValueId here =
            textures.size() == 1
                ? emit_.constant(true)
                : emit_.binary(Op::kEq, texture,
                               emit_.constant(ir::Type::kInt, static_cast<uint32_t>(index)));
        const ValueId guard = emit_.logical_and(live_, here);
        Value args = {guard};
        args.insert(args.end(), at.begin(), at.end());
        args.push_back(width);
        for (int32_t i = 0; i < expr.type.size; ++i) {
            const ValueId value = emit_.sample(index, first + i, args);
            out[static_cast<size_t>(i)] = emit_.select(here, value, out[static_cast<size_t>(i)]);
        }
    }
    return out;
}

ValueId StageTranslator::sum(const Value& amounts) {
    if (amounts.empty()) return emit_.constant(0.0f);
    ValueId out = amounts[0];
    for (size_t i = 1; i < amounts.size(); ++i)
        out = emit_.binary(Op::kAdd, out, amounts[i]);
    return out;
}

Value StageTranslator::composition(const Expr& expr) {
    const Expr& object = *expr.args[0];
    const Target to = target(object);
    if (expr.kind == ExprKind::kClear) {
        store(to, zero(object.type));
        return {};
    }
    Value amounts = read(to, object);
    if (expr.kind == ExprKind::kTotal) {
        return {sum(amounts)};
    }
    const ValueId material = scalar(*expr.args[1]);
    const auto is_slot = [&](size_t slot) {
        return emit_.binary(Op::kEq, material,
                            emit_.constant(ir::Type::kInt, static_cast<uint32_t>(slot)));
    };
    // The usual case, where one slot is meant.
    const bool known = emit_.is_constant(material);
    const size_t first = known ? emit_.instr(material).bits : 0;
    const size_t last = known ? first + 1 : amounts.size();
    if (expr.kind == ExprKind::kGet) {
        ValueId out = emit_.constant(0.0f);
        for (size_t i = first; i < last; ++i) {
            out = emit_.select(is_slot(i), amounts[i], out);
        }
        return {out};
    }
    const ValueId amount = scalar(*expr.args[2]);
    // The arguments may have changed it: `mc.Set(m, mc.Total())` does not, but a function with an
    // out parameter can.
    amounts = read(to, object);
    if (gave_up_) return {};
    emit_.set_span(expr.span);
    for (size_t i = first; i < last; ++i) {
        const ValueId value =
            expr.kind == ExprKind::kAdd ? emit_.binary(Op::kAdd, amounts[i], amount) : amount;
        amounts[i] = emit_.select(is_slot(i), value, amounts[i]);
    }
    store(to, amounts);
    return {};
}

/// The amounts of the upper one, and of the lower one what it leaves free:
/// above + below * (1 - saturate(above.Total())).
Value StageTranslator::over(const Expr& expr) {
    const Value above = expression(*expr.args[0]);
    const Value below = expression(*expr.args[1]);
    if (above.empty() || gave_up_) return zero(expr.type);
    emit_.set_span(expr.span);
    const ValueId total = clamp(sum(above), emit_.constant(0.0f), emit_.constant(1.0f));
    const ValueId rest = emit_.binary(Op::kSub, emit_.constant(1.0f), total);
    return binary_values(Op::kAdd, above, binary_values(Op::kMul, below, {rest}));
}

}  // namespace openfab::sema
