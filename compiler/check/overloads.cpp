// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/overloads.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/check/nodes.h"

namespace openfab::check {

namespace {

constexpr int kNoMatch = 1 << 20;

/// The cost of converting an argument to a parameter: 0 the same, 1 widened, 4 broadcast, 16
/// narrowed.
int conversion_cost(const Type& from, const Type& to) {
    if (from == to) return 0;
    if (from.is_matrix() && to.is_matrix()) {
        return from.rows >= to.rows && from.size >= to.size ? 16 : kNoMatch;
    }
    if (from.is_scalar() && to.is_matrix()) return from.base == to.base ? 4 : 5;
    if (!from.is_numeric() || !to.is_numeric()) return kNoMatch;
    int cost = 0;
    if (from.size < to.size) {
        if (from.size != 1) return kNoMatch;
        cost += 4;
    }
    if (from.size > to.size) cost += 16;
    if (from.base < to.base) cost += 1;
    if (from.base > to.base) cost += 16;
    return cost;
}

int call_cost(const Function& f, const std::vector<ExprPtr>& args) {
    if (f.parameters.size() < args.size()) return kNoMatch;
    int cost = 0;
    for (size_t i = args.size(); i < f.parameters.size(); ++i) {
        if (f.parameters[i]->fallback == nullptr) return kNoMatch;
        cost = 1;  // a function of exactly these arguments is preferred
    }
    for (size_t i = 0; i < args.size(); ++i) {
        const Type& type = f.parameters[i]->type;
        if (type.is_error()) continue;
        // An `out` argument must have the parameter's type: there is no conversion on the way out.
        if (f.parameters[i]->is_out && args[i]->type != type) return kNoMatch;
        cost += conversion_cost(args[i]->type, type);
    }
    return std::min(cost, kNoMatch);
}

std::string signature(const Function& f) {
    std::string out = f.name + "(";
    for (size_t i = 0; i < f.parameters.size(); ++i) {
        const Symbol& p = *f.parameters[i];
        const char* way = p.is_out ? (p.is_in ? "inout " : "out ") : "";
        out += fmt::format("{}{}{} {}", i == 0 ? "" : ", ", way, type_name(p.type), p.name);
    }
    return out + ")";
}

}  // namespace

bool any_match(const std::vector<const Function*>& candidates, const std::vector<ExprPtr>& args) {
    return std::any_of(candidates.begin(), candidates.end(),
                       [&](const Function* f) { return call_cost(*f, args) < kNoMatch; });
}

ExprPtr Overloads::call(const ast::Expr& callee, const source::Span& span,
                        const std::vector<const Function*>& candidates,
                        std::vector<ExprPtr> args) const {
    const Function* best = nullptr;
    const Function* rival = nullptr;
    int best_cost = kNoMatch;
    for (const Function* f : candidates) {
        const int cost = call_cost(*f, args);
        if (cost >= kNoMatch || cost > best_cost) continue;
        rival = cost == best_cost ? best : nullptr;
        best = f;
        best_cost = cost;
    }
    if (best == nullptr) {
        diag::Diagnostic& d =
            sink_->report(callee.span, diag::kNoOverload, callee.text, type_list(args));
        for (const Function* f : candidates) {
            d.note(f->span, fmt::format("`{}` is here", signature(*f)));
            for (size_t i = 0; i < std::min(args.size(), f->parameters.size()); ++i) {
                const Symbol& p = *f->parameters[i];
                if (!p.is_out || args[i]->type == p.type || candidates.size() > 1) continue;
                d.help(fmt::format("an argument for `{}` is a variable of type `{}`", p.name,
                                   type_name(p.type)));
            }
        }
        return poison(span);
    }
    if (rival != nullptr) {
        sink_->report(callee.span, diag::kAmbiguousCall, callee.text)
            .note(rival->span, fmt::format("candidate `{}`", signature(*rival)))
            .note(best->span, fmt::format("candidate `{}`", signature(*best)));
        return poison(span);
    }
    ExprPtr out = make(ExprKind::kCall, best->return_type, span);
    out->function = best;
    names_.record_use(callee.span, *best);
    if (place_.function != nullptr) place_.function->calls.push_back({best, callee.span});
    for (size_t i = args.size(); i < best->parameters.size(); ++i) {
        const Symbol& fallback = *best->parameters[i]->fallback;
        args.push_back(make(ExprKind::kVariable, fallback.type, span));
        args.back()->symbol = &fallback;
    }
    for (size_t i = 0; i < args.size(); ++i) {
        const Symbol& p = *best->parameters[i];
        if (p.is_out) {
            if (!targets_.assignable(*args[i])) return poison(span);
        } else {
            args[i] = conversions_.implicit(std::move(args[i]), p.type);
        }
    }
    out->args = std::move(args);
    return out;
}

}  // namespace openfab::check
