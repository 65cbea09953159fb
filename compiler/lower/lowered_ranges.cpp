// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/lowered_ranges.h"

#include <fmt/format.h>

#include <algorithm>

namespace openfab::lower {

namespace {

namespace internal = Halide::Internal;
using Halide::Expr;
using internal::Interval;

constexpr const char* kQuery = ".bounds_query";

/// Returns the kernel's Func of a name of Halide's.
const ScheduledFunc* func_named(const ScheduledKernel& kernel, const std::string& name) {
    for (const ScheduledFunc& func : kernel.funcs()) {
        if (func.func.name() == name) return &func;
    }
    return nullptr;
}

}  // namespace

std::optional<int64_t> constant_extent(const ScheduledFunc& func, const std::string& var) {
    for (const internal::Bound& bound : func.func.function().schedule().bounds()) {
        const int64_t* extent =
            bound.extent.defined() ? internal::as_const_int(bound.extent) : nullptr;
        if (bound.var == var && extent != nullptr) return *extent;
    }
    return std::nullopt;
}

bool RegionQueries::note(const std::string& name, const Expr& value) {
    const size_t at = name.find(kQuery);
    if (at != std::string::npos) {
        note_query(name, name.substr(0, name.rfind('.', at - 1)),
                   name.substr(at + std::string(kQuery).size()), value);
        return true;
    }
    if (const auto* call = value.as<internal::Call>();
        call != nullptr && call->is_intrinsic(internal::Call::make_struct))
        structs_[name] = value;
    if (value.type() != Halide::Int(32)) return false;
    Expr known = resolve(value);
    if (known.same_as(value)) return values_.contains(name);
    values_[name] = internal::simplify(known);
    return true;
}

Expr RegionQueries::visit(const internal::Variable* op) {
    const auto found = values_.find(op->name);
    return found == values_.end() ? Expr(op) : found->second;
}

Expr RegionQueries::visit(const internal::Call* op) {
    constexpr const char* kGet = "_halide_buffer_get_";
    if (!op->name.starts_with(kGet) || op->args.size() != 2) return IRMutator::visit(op);
    const auto* buffer = op->args[0].as<internal::Variable>();
    const int64_t* d = internal::as_const_int(op->args[1]);
    const auto region =
        buffer == nullptr ? regions_.end() : regions_.find(current(buffer->name));
    if (d == nullptr || region == regions_.end() ||
        *d >= static_cast<int64_t>(region->second.size()))
        return op;
    const Side& side = region->second[static_cast<size_t>(*d)];
    if (!side.min.defined()) return op;
    const std::string what = op->name.substr(std::string(kGet).size());
    return what == "min"      ? side.min
           : what == "extent" ? side.extent
           : what == "max"    ? side.min + side.extent - 1
                              : Expr(op);
}

/// Inner regions are clamped to outer ones, which they never leave: only the latest matters.
std::string RegionQueries::current(const std::string& name) const {
    const size_t at = name.find(kQuery);
    if (at == std::string::npos) return name;
    const bool of_reader = name.compare(at + std::string(kQuery).size(), 1, ".") == 0;
    const auto latest = latest_.find(name.substr(0, name.rfind('.', at - 1)));
    return of_reader || latest == latest_.end() ? name : latest->second;
}

RegionQueries::Side RegionQueries::bound_of(const ScheduledFunc& func, const std::string& var) {
    for (const internal::Bound& bound : func.func.function().schedule().bounds()) {
        if (bound.var == var && bound.min.defined()) return {bound.min, bound.extent};
    }
    return {};
}

void RegionQueries::note_query(const std::string& name, const std::string& func, const std::string& rest,
                const Expr& value) {
    if (!rest.starts_with(".")) {
        // A closure is passed the buffer; it is known by its name.
        std::vector<Side> sides = sides_of(value);
        if (sides.empty()) return;
        regions_[name] = std::move(sides);
        latest_[func] = name;
        return;
    }
    // `.answer`, or `.answer_1`: names of lets are made different by numbers.
    std::string reader = rest.substr(1);
    if (!latest_.contains(reader)) reader = reader.substr(0, reader.rfind('_'));
    const ScheduledFunc* from = func_named(kernel_, reader);
    const ScheduledFunc* to = func_named(kernel_, func);
    const auto asked = latest_.find(reader);
    if (from == nullptr || to == nullptr || asked == latest_.end()) return;
    std::vector<Side>& region = regions_[name];
    region.clear();
    for (const Halide::Var& var : to->func.args()) {
        const std::vector<Halide::Var> args = from->func.args();
        const auto same = std::find_if(args.begin(), args.end(), [&](const Halide::Var& v) {
            return v.name() == var.name();
        });
        const auto d = static_cast<size_t>(same - args.begin());
        const std::vector<Side>& source = regions_[asked->second];
        region.push_back(d < source.size() ? source[d] : bound_of(*to, var.name()));
    }
}

/// Reads minima and extents out of the making of a buffer.
std::vector<RegionQueries::Side> RegionQueries::sides_of(const Expr& value) {
    class Finder : public internal::IRVisitor {
      public:
        explicit Finder(const std::map<std::string, Expr>& structs) : structs_(structs) {}
        const internal::Call* shape = nullptr;

      private:
        using internal::IRVisitor::visit;
        void visit(const internal::Variable* op) override {
            const auto found = structs_.find(op->name);
            if (found != structs_.end()) shape = found->second.as<internal::Call>();
        }
        void visit(const internal::Call* op) override {
            if (op->is_intrinsic(internal::Call::make_struct)) shape = op;
            IRVisitor::visit(op);
        }
        const std::map<std::string, Expr>& structs_;
    } finder(structs_);
    value.accept(&finder);
    std::vector<Side> out;
    if (finder.shape == nullptr) return out;
    constexpr size_t kFields = 4;  // of halide_dimension_t
    for (size_t k = 0; k + 1 < finder.shape->args.size(); k += kFields) {
        out.push_back({internal::simplify(resolve(finder.shape->args[k])),
                       internal::simplify(resolve(finder.shape->args[k + 1]))});
    }
    return out;
}

void RangeWalk::walk(const Halide::Module& module) {
    for (const internal::LoweredFunc& function : module.functions()) {
        for (const internal::LoweredArgument& arg : function.args) {
            if (!arg.is_buffer()) continue;
            for (int d = 0; d < arg.dimensions; ++d) {
                push(fmt::format("{}.extent.{}", arg.name, d), 0, places_);
                push(fmt::format("{}.min.{}", arg.name, d), 0, 0);
            }
        }
    }
    // Twice: the body of a parallel loop is a function of its own, maybe before the one that knows
    // the ranges of what it is passed. Variables have names of their own in all of them.
    for (const bool last : {false, true}) {
        begin(last);
        for (const internal::LoweredFunc& function : module.functions())
            enter(function);
    }
}

void RangeWalk::push(const std::string& name, int64_t least, int64_t most) {
    scope_.push(name,
                Interval(Expr(static_cast<int32_t>(least)), Expr(static_cast<int32_t>(most))));
}

void RangeWalk::visit(const internal::LetStmt* op) {
    if (!queries_.note(op->name, op->value) && op->value.type() == Halide::Int(32)) {
        const Interval range = internal::find_constant_bounds(op->value, scope_);
        // What comes from memory keeps the range that its name is known by.
        if (range.has_upper_bound() || range.has_lower_bound() || !scope_.contains(op->name))
            scope_.push(op->name, range);
    }
    op->body.accept(this);
}

void RangeWalk::visit(const internal::For* op) {
    const Expr least = queries_.resolve(op->min);
    const Expr most = internal::simplify(least + queries_.resolve(op->extent) - 1);
    scope_.push(op->name, Interval(internal::find_constant_bounds(least, scope_).min,
                                   internal::find_constant_bounds(most, scope_).max));
    op->body.accept(this);
}

void RangeWalk::visit(const internal::IfThenElse* op) {
    op->then_case.accept(this);
    if (op->else_case.defined()) op->else_case.accept(this);
}

}  // namespace openfab::lower
