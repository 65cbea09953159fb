// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Targets: the parts of a variable or a value that swizzles, members and indices select. A varying
// index selects one of several alternatives by a condition; it is clamped to the array, so that it
// always selects an element.
#include "compiler/translate/targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "compiler/ir/arithmetic.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

namespace {

constexpr size_t kMaxAlternatives = 16384;
// Of more than these a read is one Pick, and conditions are only made for those who ask.
constexpr size_t kMostChosen = 8;

}  // namespace

/// Returns the condition under which a varying index, clamped to 0 … count - 1, is `k`.
ValueId Targets::index_is(ValueId index, int k, int count) {
    const ir::Type type = emit_.type(index);
    const auto number = [&](int value) {
        return emit_.constant(type, static_cast<uint32_t>(value));
    };
    if (count == 1) return emit_.constant(true);
    if (k == count - 1) return emit_.binary(Op::kGe, index, number(k));
    return emit_.binary(k == 0 ? Op::kLe : Op::kEq, index, number(k));
}

/// Replaces each alternative of `target` by its element at the index.
void Targets::pick_element(const check::Expr& expr, Target* target) {
    const check::Type& type = expr.args[0]->type;
    const auto count = static_cast<size_t>(type.length());
    const ValueId index = expressions_.scalar(*expr.args[1]);
    const auto element = [&](const Alternative& alternative, size_t k) {
        const size_t width = alternative.lanes.size() / count;
        const auto first = alternative.lanes.begin() + static_cast<ptrdiff_t>(k * width);
        return std::vector<size_t>(first, first + static_cast<ptrdiff_t>(width));
    };
    if (emit_.is_constant(index)) {
        const int32_t at = ir::as_int(emit_.instr(index).bits);
        if (at < 0 || at >= type.length()) {
            sink_->report(expr.args[1]->span, diag::kOutOfRange, "index", at, 0, type.length() - 1);
        }
        const size_t k = static_cast<size_t>(std::clamp(at, 0, type.length() - 1));
        for (Alternative& alternative : target->alternatives)
            alternative.lanes = element(alternative, k);
        return;
    }
    if (target->alternatives.size() * count > kMaxAlternatives) {
        if (!budget_.gave_up) {
            sink_->report(expr.span, diag::kTooComplex,
                          fmt::format("a varying index that may pick more than {} elements",
                                      kMaxAlternatives));
        }
        budget_.gave_up = true;
        return;
    }
    target->indices.push_back({index, count});
    std::vector<Alternative> alternatives;
    for (size_t k = 0; k < count; ++k) {
        for (const Alternative& alternative : target->alternatives)
            alternatives.push_back({ir::kNoValue, element(alternative, k)});
    }
    target->alternatives = std::move(alternatives);
    if (target->alternatives.size() <= kMostChosen) make_conditions(target);
}

/// Emits the condition of each alternative, unless they are there: those of the first index change
/// fastest.
void Targets::make_conditions(Target* target) {
    std::vector<Alternative>& alternatives = target->alternatives;
    if (alternatives.empty() || alternatives[0].condition != ir::kNoValue) return;
    std::vector<ValueId> conditions = {emit_.constant(true)};
    for (const auto& [index, count] : target->indices) {
        std::vector<ValueId> next;
        for (size_t k = 0; k < count; ++k) {
            const ValueId here = index_is(index, static_cast<int>(k), static_cast<int>(count));
            for (const ValueId condition : conditions)
                next.push_back(emit_.logical_and(condition, here));
        }
        conditions = std::move(next);
    }
    for (size_t k = 0; k < conditions.size(); ++k)
        alternatives[k].condition = conditions[k];
}

/// Returns which alternative of a target with indices is picked, within their number.
ValueId Targets::picked_alternative(const Target& target) {
    if (target.indices.size() == 1) return target.indices[0].value;
    ValueId sum = emit_.constant(0);
    size_t apart = 1;
    for (const auto& [index, count] : target.indices) {
        // Clamped as they are: a uint above 2^31 is the far end.
        const ir::Type type = emit_.type(index);
        const ValueId last = emit_.constant(type, static_cast<uint32_t>(count - 1));
        ValueId at = emit_.binary(Op::kMin, index, last);
        if (type == ir::Type::kInt) at = emit_.binary(Op::kMax, at, emit_.constant(0));
        at = emit_.convert(at, ir::Type::kInt);
        at = emit_.binary(Op::kMul, at, emit_.constant(static_cast<int32_t>(apart)));
        sum = emit_.binary(Op::kAdd, sum, at);
        apart *= count;
    }
    return sum;
}

/// Called once per occurrence in the program, since an index may have side effects.
Target Targets::target(const check::Expr& expr) {
    Target out;
    const bool part = expr.kind == check::ExprKind::kSwizzle ||
                      expr.kind == check::ExprKind::kMember || expr.kind == check::ExprKind::kIndex;
    if (!part) {
        const bool variable = expr.kind == check::ExprKind::kVariable &&
                              paths_.frame.variables.count(expr.symbol) != 0;
        if (variable) {
            out.symbol = expr.symbol;
        } else {
            out.value = expressions_.expression(expr);
        }
        out.alternatives.push_back({emit_.constant(true), {}});
        out.alternatives[0].lanes.resize(variable ? layout_.component_count(expr.type)
                                                  : out.value.size());
        std::iota(out.alternatives[0].lanes.begin(), out.alternatives[0].lanes.end(), size_t{0});
        return out;
    }
    out = target(*expr.args[0]);
    if (budget_.gave_up) return {};
    if (expr.kind == check::ExprKind::kIndex) {
        pick_element(expr, &out);
        return budget_.gave_up ? Target{} : out;
    }
    std::vector<size_t> picked(expr.lanes.begin(),
                               expr.lanes.begin() + std::min(expr.type.size, 4));
    if (expr.kind == check::ExprKind::kMember) {
        const auto [first, count] = layout_.member_range(expr.args[0]->type, expr.bits);
        picked.resize(count);
        std::iota(picked.begin(), picked.end(), first);
    }
    for (Alternative& alternative : out.alternatives) {
        std::vector<size_t> lanes;
        for (size_t lane : picked)
            lanes.push_back(alternative.lanes[lane]);
        alternative.lanes = std::move(lanes);
    }
    return out;
}

/// Reports a read of a variable before it has a value.
void Targets::check_read(const Target& of, const source::Span& span) {
    const check::Symbol& symbol = *of.symbol;
    const Variable& v = paths_.variables[paths_.variable_of(symbol)];
    if (v.assigned.empty()) return;
    const auto is_assigned = [&](size_t lane) { return emit_.is_true(v.assigned[lane]); };
    if (std::all_of(of.alternatives.begin(), of.alternatives.end(), [&](const Alternative& one) {
            return std::all_of(one.lanes.begin(), one.lanes.end(), is_assigned);
        }))
        return;
    Target target = of;
    make_conditions(&target);
    const bool first_trip = facts_.first_trip_comes_here();
    bool never = true;
    bool maybe = false;
    for (const Alternative& alternative : target.alternatives) {
        bool unset = false;
        for (size_t lane : alternative.lanes) {
            const ValueId assigned = v.assigned[lane];
            unset = unset || emit_.is_false(assigned) ||
                    (first_trip && facts_.unassigned_in_first_trip(assigned));
            maybe = maybe || !(emit_.is_true(assigned) ||
                               facts_.is_implied(assigned, alternative.condition));
        }
        never = never && unset;
    }
    if (never) {
        sink_->report(span, diag::kUninitialized, symbol.name)
            .note(symbol.span, fmt::format("`{}` is declared here", symbol.name));
    } else if (maybe) {
        sink_->report(span, diag::kMaybeUninitialized, symbol.name)
            .note(symbol.span, fmt::format("`{}` is declared here", symbol.name))
            .help("initialize it where it is declared");
    } else {
        return;
    }
    take_as_assigned(target);
}

/// Marks a variable as assigned after a report, so that later reads are not reported too.
void Targets::take_as_assigned(const Target& target) {
    Variable& v = paths_.variables[paths_.variable_of(*target.symbol)];
    for (const Alternative& alternative : target.alternatives) {
        for (const size_t lane : alternative.lanes)
            v.assigned[lane] = emit_.constant(true);
    }
}

Value Targets::read(const Target& target, const check::Expr& expr) {
    if (target.alternatives.empty()) return layout_.zero(expr.type);
    if (target.symbol != nullptr) check_read(target, expr.span);
    const Value& whole = target.symbol != nullptr
                             ? paths_.variables[paths_.variable_of(*target.symbol)].value
                             : target.value;
    Value out;
    if (target.alternatives.size() > kMostChosen) {
        const ValueId picked = picked_alternative(target);
        for (size_t i = 0; i < target.alternatives[0].lanes.size(); ++i) {
            Value elements;
            for (const Alternative& alternative : target.alternatives)
                elements.push_back(whole[alternative.lanes[i]]);
            out.push_back(emit_.pick(picked, elements));
        }
        return out;
    }
    // The last alternative applies where no condition before it holds.
    for (size_t lane : target.alternatives.back().lanes)
        out.push_back(whole[lane]);
    for (size_t p = target.alternatives.size() - 1; p-- > 0;) {
        const Alternative& alternative = target.alternatives[p];
        for (size_t i = 0; i < out.size(); ++i)
            out[i] = emit_.select(alternative.condition, whole[alternative.lanes[i]], out[i]);
    }
    return out;
}

void Targets::store(Target target, const Value& value) {
    if (target.symbol == nullptr) return;
    const size_t begin = emit_.size();
    if (target.indices.size() > 1 && target.alternatives.size() > kMostChosen) {
        // By their number in the whole: tests that differ in nothing else.
        const auto count = static_cast<int>(target.alternatives.size());
        const ValueId picked = picked_alternative(target);
        for (int k = 0; k < count; ++k)
            target.alternatives[static_cast<size_t>(k)].condition = index_is(picked, k, count);
    } else {
        make_conditions(&target);
    }
    const VariableId id = paths_.variable_of(*target.symbol);
    Variable v = paths_.variables[id];
    for (const Alternative& alternative : target.alternatives) {
        for (size_t i = 0; i < alternative.lanes.size(); ++i) {
            const size_t lane = alternative.lanes[i];
            v.value[lane] = emit_.select(alternative.condition, value[i], v.value[lane]);
            if (v.assigned.empty()) continue;
            // Of a vector's components any may be the one: loops over them are taken to come to all.
            v.assigned[lane] = emit_.constant(true);
        }
    }
    if (target.alternatives.size() > kMostChosen) emit_.count_as_step(begin);
    paths_.set(id, std::move(v));
}

}  // namespace openfab::translate
