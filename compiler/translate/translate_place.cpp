// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Places: the parts of a variable or of a value that swizzles, members and indices pick. An index
// that varies picks one of several, which a condition tells; it is clamped to the array, so that
// whatever it is, something of the array is meant.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "compiler/ir/arithmetic.h"
#include "compiler/translate/translate_state.h"

namespace openfab::sema {

using ir::Op;
using ir::ValueId;

namespace {

constexpr size_t kMaxPlaces = 4096;

}  // namespace

/// Where the components of member `index` begin, and how many there are.
std::pair<size_t, size_t> StageTranslator::member_range(const Type& type, size_t index) const {
    const std::vector<StructMember>& members =
        type.is(Base::kSurfacePoint) ? fablet_.point_members : type.record->members;
    size_t first = 0;
    for (size_t i = 0; i < index; ++i)
        first += component_count(members[i].type);
    return {first, component_count(members[index].type)};
}

/// The condition under which a varying index, clamped to 0 … count - 1, is `k`.
ValueId StageTranslator::index_is(ValueId index, int k, int count) {
    const ir::Type type = emit_.type(index);
    const auto number = [&](int value) {
        return emit_.constant(type, static_cast<uint32_t>(value));
    };
    if (count == 1) return emit_.constant(true);
    if (k == count - 1) return emit_.binary(Op::kGe, index, number(k));
    return emit_.binary(k == 0 ? Op::kLe : Op::kEq, index, number(k));
}

/// Each place of `target` becomes its element at `index_expr`.
void StageTranslator::pick_element(const Expr& expr, Target* target) {
    const Type& type = expr.args[0]->type;
    const auto count = static_cast<size_t>(type.length());
    const ValueId index = scalar(*expr.args[1]);
    const auto element = [&](const Place& place, size_t k) {
        const size_t width = place.lanes.size() / count;
        const auto first = place.lanes.begin() + static_cast<ptrdiff_t>(k * width);
        return std::vector<size_t>(first, first + static_cast<ptrdiff_t>(width));
    };
    if (emit_.is_constant(index)) {
        const int32_t at = ir::as_int(emit_.instr(index).bits);
        if (at < 0 || at >= type.length()) {
            sink_->report(expr.args[1]->span, diag::kOutOfRange, "index", at, 0, type.length() - 1);
        }
        const size_t k = static_cast<size_t>(std::clamp(at, 0, type.length() - 1));
        for (Place& place : target->places)
            place.lanes = element(place, k);
        return;
    }
    if (target->places.size() * count > kMaxPlaces) {
        if (!gave_up_) {
            sink_->report(
                expr.span, diag::kTooComplex,
                fmt::format("a varying index that may pick more than {} elements", kMaxPlaces));
        }
        gave_up_ = true;
        return;
    }
    std::vector<Place> places;
    for (size_t k = 0; k < count; ++k) {
        const ValueId here = index_is(index, static_cast<int>(k), static_cast<int>(count));
        for (const Place& place : target->places) {
            places.push_back({emit_.logical_and(place.condition, here), element(place, k)});
        }
    }
    target->places = std::move(places);
}

/// Once for each time that the program names it: an index may have side effects.
StageTranslator::Target StageTranslator::target(const Expr& expr) {
    Target out;
    const bool part = expr.kind == ExprKind::kSwizzle || expr.kind == ExprKind::kMember ||
                      expr.kind == ExprKind::kIndex;
    if (!part) {
        const bool variable =
            expr.kind == ExprKind::kVariable && frame_.variables.count(expr.symbol) != 0;
        if (variable) {
            out.symbol = expr.symbol;
        } else {
            out.value = expression(expr);
        }
        out.places.push_back({emit_.constant(true), {}});
        out.places[0].lanes.resize(variable ? component_count(expr.type) : out.value.size());
        std::iota(out.places[0].lanes.begin(), out.places[0].lanes.end(), size_t{0});
        return out;
    }
    out = target(*expr.args[0]);
    if (gave_up_) return {};
    if (expr.kind == ExprKind::kIndex) {
        pick_element(expr, &out);
        return gave_up_ ? Target{} : out;
    }
    std::vector<size_t> picked(expr.lanes.begin(),
                               expr.lanes.begin() + std::min(expr.type.size, 4));
    if (expr.kind == ExprKind::kMember) {
        const auto [first, count] = member_range(expr.args[0]->type, expr.bits);
        picked.resize(count);
        std::iota(picked.begin(), picked.end(), first);
    }
    for (Place& place : out.places) {
        std::vector<size_t> lanes;
        for (size_t lane : picked)
            lanes.push_back(place.lanes[lane]);
        place.lanes = std::move(lanes);
    }
    return out;
}

/// Reports what is read of a variable before it has a value.
void StageTranslator::check_read(const Target& target, const source::Span& span) {
    const Symbol& symbol = *target.symbol;
    const Variable& v = variables_[variable_of(symbol)];
    if (v.assigned.empty()) return;
    const bool first_trip = first_trip_comes_here();
    bool never = true;
    bool maybe = false;
    for (const Place& place : target.places) {
        bool unset = false;
        for (size_t lane : place.lanes) {
            const ValueId assigned = v.assigned[lane];
            unset = unset || emit_.is_false(assigned) ||
                    (first_trip && unassigned_in_first_trip(assigned));
            maybe = maybe || !(emit_.is_true(assigned) || holds(assigned, place.condition));
        }
        never = never && unset;
    }
    if (never) {
        sink_->report(span, diag::kUninitialized, symbol.name)
            .note(symbol.span, fmt::format("`{}` is declared here", symbol.name));
    } else if (maybe && !outer_live_.empty()) {
        return doubt(target, span);
    } else if (maybe) {
        report_maybe(symbol, span);
    } else {
        return;
    }
    take_as_assigned(target);
}

void StageTranslator::report_maybe(const Symbol& symbol, const source::Span& span) {
    sink_->report(span, diag::kMaybeUninitialized, symbol.name)
        .note(symbol.span, fmt::format("`{}` is declared here", symbol.name))
        .help("give it a value where it is declared");
}

/// What the trips of a loop assign is known at its end only.
void StageTranslator::doubt(const Target& target, const source::Span& span) {
    const Variable& v = variables_[variable_of(*target.symbol)];
    DoubtfulRead read{target.symbol, span, live_, {}};
    for (const Place& place : target.places) {
        read.places.push_back({place.condition, {}});
        for (const size_t lane : place.lanes)
            read.places.back().assigned.push_back(v.assigned[lane]);
    }
    doubts_.push_back(std::move(read));
}

/// What was reported of a variable is not said again where it is read next.
void StageTranslator::take_as_assigned(const Target& target) {
    Variable& v = variables_[variable_of(*target.symbol)];
    for (const Place& place : target.places) {
        for (const size_t lane : place.lanes)
            v.assigned[lane] = emit_.constant(true);
    }
}

Value StageTranslator::read(const Target& target, const Expr& expr) {
    if (target.places.empty()) return zero(expr.type);
    if (target.symbol != nullptr) check_read(target, expr.span);
    const Value& whole =
        target.symbol != nullptr ? variables_[variable_of(*target.symbol)].value : target.value;
    // The last place is what is left where no condition before it holds.
    Value out;
    for (size_t lane : target.places.back().lanes)
        out.push_back(whole[lane]);
    for (size_t p = target.places.size() - 1; p-- > 0;) {
        const Place& place = target.places[p];
        for (size_t i = 0; i < out.size(); ++i)
            out[i] = emit_.select(place.condition, whole[place.lanes[i]], out[i]);
    }
    return out;
}

void StageTranslator::store(const Target& target, const Value& value) {
    if (target.symbol == nullptr) return;
    const VariableId id = variable_of(*target.symbol);
    Variable v = variables_[id];
    for (const Place& place : target.places) {
        for (size_t i = 0; i < place.lanes.size(); ++i) {
            const size_t lane = place.lanes[i];
            v.value[lane] = emit_.select(place.condition, value[i], v.value[lane]);
            if (v.assigned.empty()) continue;
            v.assigned[lane] =
                emit_.select(place.condition, emit_.constant(true), v.assigned[lane]);
        }
    }
    set(id, std::move(v));
}

/// The numbers that an index of a texture, a material or an object may have, ascending; `all` where
/// it cannot be told.
std::vector<int32_t> StageTranslator::possible_indices(ValueId value, int32_t all) const {
    std::vector<int32_t> out;
    std::vector<ValueId> open = {value};
    std::set<ValueId> seen;
    while (!open.empty()) {
        const ValueId id = open.back();
        open.pop_back();
        if (!seen.insert(id).second) continue;
        const ir::Instr& instr = emit_.instr(id);
        if (instr.op == Op::kConst) {
            out.push_back(ir::as_int(instr.bits));
        } else if (instr.op == Op::kSelect) {
            open.push_back(instr.args[1]);
            open.push_back(instr.args[2]);
        } else {
            out.resize(static_cast<size_t>(all));
            std::iota(out.begin(), out.end(), 0);
            return out;
        }
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

}  // namespace openfab::sema
