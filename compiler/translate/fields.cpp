// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// `gradient(f, p, …)` and `mean_curvature(f, p, …)`. The body is translated once for unknown components of p, the
// seeds, then differentiated in forward mode, which emits ordinary operations (compiler/functions/differentiate.h); of
// a curvature twice. What is wanted is then emitted again with p in place of the seeds. What was emitted for seeds is
// dead; p itself could not have been differentiated by, since it may be constant, or have equal components.
#include "compiler/translate/fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "compiler/functions/differentiate.h"

namespace openfab::translate {

using ir::kNoValue;
using ir::Op;
using ir::ValueId;

namespace {

/// The values of a stage from a function's first instruction on that depend on its seeds.
class Field {
  public:
    Field(Emitter* emit, ValueId first, Value seeds)
        : emit_(*emit), first_(first), seeds_(std::move(seeds)) {}

    size_t axes() const { return seeds_.size(); }

    /// The changes of a value along each axis, constants where there is none. Sets `fault`.
    Value derivatives(ValueId of) {
        find_dependent();
        const std::vector<bool> needed =
            cone({of}, [&](const ir::Instr& i) { return decisive_args(i); });
        const auto end = static_cast<ValueId>(emit_.size());
        Value out;
        for (size_t axis = 0; axis < axes(); ++axis) {
            std::map<ValueId, ValueId> known;
            known[seeds_[axis]] = emit_.constant(1.0f);
            for (ValueId id = first_; id < end; ++id) {
                if (!needed[id - first_] || !depends(id) || known.contains(id)) continue;
                const ir::Instr instr = emit_.instr(id);
                std::vector<ValueId> changes;
                for (const ValueId arg : instr.args) {
                    const auto change = known.find(arg);
                    changes.push_back(change == known.end() ? kNoValue : change->second);
                }
                check(id, changes);
                known[id] =
                    functions::differentiate(id, instr, changes, functions::AtZero::kZero, &emit_);
            }
            const auto change = known.find(of);
            const bool none = change == known.end() || change->second == kNoValue;
            out.push_back(none ? emit_.constant(0.0f) : change->second);
        }
        return out;
    }

    /// The same values with other values in place of the seeds.
    Value at(const Value& values, const Value& p) {
        find_dependent();
        const std::vector<bool> needed = cone(values, [](const ir::Instr& i) { return i.args; });
        std::map<ValueId, ValueId> copies;
        for (size_t axis = 0; axis < axes(); ++axis)
            copies[seeds_[axis]] = p[axis];
        const auto end = static_cast<ValueId>(emit_.size());
        for (ValueId id = first_; id < end; ++id) {
            if (!needed[id - first_] || !depends(id) || copies.contains(id)) continue;
            ir::Instr instr = emit_.instr(id);
            const bool of_loop = instr.op == Op::kLoopResult;
            if (of_loop) fault = id;
            if (fault != kNoValue) return Value(values.size(), emit_.constant(0.0f));
            for (ValueId& arg : instr.args) {
                const auto copy = copies.find(arg);
                if (copy != copies.end()) arg = copy->second;
            }
            copies[id] = emit_.again(std::move(instr));
        }
        Value out;
        for (const ValueId value : values) {
            const auto copy = copies.find(value);
            out.push_back(copy == copies.end() ? value : copy->second);
        }
        return out;
    }

    ValueId fault = kNoValue;  ///< what cannot be differentiated

  private:
    bool depends(ValueId id) const { return id >= first_ && dependent_[id - first_]; }

    /// A loop depends where anything inside does.
    void find_dependent() {
        std::vector<ValueId> open;
        for (auto id = static_cast<ValueId>(first_ + dependent_.size()); id < emit_.size(); ++id) {
            const ir::Instr& instr = emit_.instr(id);
            bool any = std::find(seeds_.begin(), seeds_.end(), id) != seeds_.end();
            for (const ValueId arg : instr.args)
                any = any || depends(arg);
            if (instr.op == Op::kLoop) open.push_back(id);
            if (instr.op == Op::kLoopEnd) {
                for (ValueId inside = open.back(); inside < id; ++inside)
                    any = any || depends(inside);
                open.pop_back();
            }
            dependent_.push_back(any);
        }
    }

    template <typename ArgsOf>
    std::vector<bool> cone(const Value& of, const ArgsOf& args_of) const {
        std::vector<bool> in(emit_.size() - first_, false);
        for (const ValueId id : of) {
            if (id >= first_) in[id - first_] = true;
        }
        for (size_t k = in.size(); k-- > 0;) {
            if (!in[k]) continue;
            for (const ValueId arg : args_of(emit_.instr(static_cast<ValueId>(first_ + k)))) {
                if (arg >= first_) in[arg - first_] = true;
            }
        }
        return in;
    }

    /// What may change a value: through whole numbers, too, which may be the bits of others.
    std::vector<ValueId> decisive_args(const ir::Instr& instr) const {
        if (instr.type == ir::Type::kBool) return {};
        if (instr.op == Op::kConvert && emit_.type(instr.args[0]) == ir::Type::kFloat) return {};
        if (instr.op == Op::kSelect) return {instr.args[1], instr.args[2]};
        if (instr.type == ir::Type::kFloat && instr.op != Op::kConvert)
            return functions::differentiable_args(instr);
        return instr.args;
    }

    void check(ValueId id, const std::vector<ValueId>& changes) {
        const ir::Instr& instr = emit_.instr(id);
        const bool bits = instr.op == Op::kBitCast && changes[0] != kNoValue;
        const bool unknown = instr.op == Op::kSample || instr.op == Op::kQueryResult ||
                             instr.op == Op::kLoopResult || instr.op == Op::kDerivative;
        const bool number = instr.type == ir::Type::kFloat;
        if ((bits || (unknown && number)) && fault == kNoValue) fault = id;
    }

    Emitter& emit_;
    ValueId first_;
    Value seeds_;
    std::vector<bool> dependent_;  ///< from first_ on
};

/// div(n) / (axes - 1) of the unit normals n of a field, from its gradient and second derivatives.
ValueId curvature(const Value& gradient, const std::vector<Value>& second, Emitter* emit) {
    const size_t axes = gradient.size();
    const auto mul = [&](ValueId a, ValueId b) { return emit->binary(Op::kMul, a, b); };
    const auto add = [&](ValueId a, ValueId b) { return emit->binary(Op::kAdd, a, b); };
    ValueId square = emit->constant(0.0f);
    ValueId trace = square;
    ValueId along = square;  // the gradient's own change along itself
    for (size_t i = 0; i < axes; ++i) {
        square =
            i == 0 ? mul(gradient[i], gradient[i]) : add(square, mul(gradient[i], gradient[i]));
        trace = i == 0 ? second[i][i] : add(trace, second[i][i]);
        for (size_t j = 0; j <= i; ++j) {
            ValueId part = mul(mul(gradient[i], gradient[j]), second[i][j]);
            if (j < i) part = mul(part, emit->constant(2.0f));
            along = i == 0 ? part : add(along, part);
        }
    }
    const ValueId rise = emit->binary(Op::kSub, mul(square, trace), along);
    ValueId scale = mul(square, emit->unary(Op::kSqrt, square));
    if (axes == 3) scale = mul(scale, emit->constant(2.0f));
    const ValueId zero = emit->constant(0.0f);
    return emit->select(emit->binary(Op::kEq, scale, zero), zero,
                        emit->binary(Op::kDiv, rise, scale));
}

}  // namespace

Value Fields::field(const check::Expr& expr) {
    const check::Function& f = *expr.function;
    const bool curved = expr.kind == check::ExprKind::kMeanCurvature;
    if (budget_.too_complex(expr.span)) return layout_.zero(expr.type);
    std::vector<Variable> arguments;
    for (const check::ExprPtr& arg : expr.args)
        arguments.push_back({expressions_.expression(*arg), {}});
    if (budget_.gave_up) return layout_.zero(expr.type);
    emit_.set_span(expr.span);
    // Numbers below 0 are no result of a call.
    if (place_.alone) return calls_.result(f, expr.type, curved ? -2 : -1, arguments);
    const Value p = arguments[0].value;
    const auto first = static_cast<ValueId>(emit_.size());
    Value seeds;
    for (size_t axis = 0; axis < p.size(); ++axis)
        seeds.push_back(emit_.unknown(ir::Type::kFloat, kSeed, emit_.next_unknown(), 0, {}));
    arguments[0].value = seeds;
    calls_.add_inlined(f);
    // A message about seeds would mean nothing.
    const bool prints = std::exchange(printing_.enabled, false);
    std::vector<Value> results;
    const Value value =
        budget_.nested(expr.span, [&] { return calls_.run_body(f, arguments, &results); });
    printing_.enabled = prints;
    if (budget_.gave_up) return layout_.zero(expr.type);
    emit_.set_span(expr.span);
    Field field(&emit_, first, std::move(seeds));
    Value out = field.derivatives(value[0]);
    if (curved) {
        std::vector<Value> second;
        for (const ValueId slope : Value(out))
            second.push_back(field.derivatives(slope));
        out = {curvature(out, second, &emit_)};
    }
    // Dead from here on.
    emit_.count_none(first);
    out = field.at(out, p);
    if (field.fault == kNoValue) return out;
    report(expr, emit_.instr(field.fault));
    budget_.gave_up = true;
    return layout_.zero(expr.type);
}

void Fields::report(const check::Expr& expr, const ir::Instr& fault) {
    struct Reason {
        Op op;
        const char* what;
        const char* help;
    };
    constexpr Reason kReasons[] = {
        {Op::kSample, "looks up a texture, whose change is not known",
         "take differences: `(f(p + h) - f(p - h)) / (2 * d)` for each axis, `h` a step of `d`, a "
         "texel or more"},
        {Op::kQueryResult, "asks for the nearest surface, whose change is not known",
         "that of a distance points away from the nearest point: `normalize(p - "
         "nearest(p).position)`, or back where it is negative"},
        {Op::kDerivative, "asks for changes along the surface",
         "pass what `ddx` or `ddy` gave as another argument"},
        {Op::kBitCast, "looks at the bits of a number that changes with the point",
         "`hash` and `asuint` of whole numbers, as `floor(p)`, count as constant"},
        {Op::kLoopResult, "has a loop that is not unrolled",
         "loops of constant length are, up to 256 trips and 4000 operations"},
    };
    const Reason* reason = kReasons;
    while (reason->op != fault.op)
        ++reason;
    const bool curved = expr.kind == check::ExprKind::kMeanCurvature;
    sink_
        ->report(expr.span, diag::kBadField, curved ? "mean_curvature" : "gradient",
                 fmt::format("cannot differentiate `{}`: it {}", expr.function->name, reason->what))
        .note(fault.span, "here")
        .help(reason->help);
}

}  // namespace openfab::translate
