// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/check_lowered.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "compiler/lower/apply_schedule.h"
#include "compiler/lower/lowered_ranges.h"

namespace openfab::lower {

namespace {

namespace internal = Halide::Internal;
using Halide::Expr;

/// A check in lowered code that may fail.
struct Doubt {
    std::string error;  ///< the function of Halide's runtime that would report it
    std::string text;   ///< its strings
};

Doubt doubt_of(const internal::Call& error) {
    Doubt out{error.name, {}};
    for (const Expr& arg : error.args) {
        if (const auto* text = arg.as<internal::StringImm>()) out.text += text->value + " ";
    }
    return out;
}

/// Finds checks of storage, and those of what a Func is computed for that the ranges of variables do
/// not prove.
class DoubtWalk : public RangeWalk {
  public:
    using RangeWalk::RangeWalk;

    std::vector<Doubt> all;

  private:
    void begin(bool /*last*/) override { all.clear(); }

    using RangeWalk::visit;

    void visit(const internal::AssertStmt* op) override {
        const auto* error = op->message.as<internal::Call>();
        if (error == nullptr) return;
        const bool of_storage = error->name == "halide_error_storage_bound_too_small" ||
                                error->name == "halide_error_fold_factor_too_small" ||
                                error->name == "halide_error_bad_fold";
        const bool of_region = error->name == "halide_error_explicit_bounds_too_small" &&
                               !internal::can_prove(queries_.resolve(op->condition), scope_);
        if (of_storage || of_region) all.push_back(doubt_of(*error));
    }

    void visit(const internal::LetStmt* op) override {
        op->value.accept(this);
        RangeWalk::visit(op);
    }

    // That a fold holds what an extern stage asks for is checked inside an expression.
    void visit(const internal::Call* op) override {
        if (op->name == "halide_error_bad_extern_fold") all.push_back(doubt_of(*op));
        RangeWalk::visit(op);
    }
};

/// Computes the checks of buffers that come before any loop, for a call with so many places.
class BufferChecks : public internal::IRVisitor {
  public:
    BufferChecks(const ScheduledKernel& kernel, const internal::LoweredFunc& function,
                 int64_t places)
        : queries_(kernel), values_(this) {
        for (const internal::LoweredArgument& arg : function.args) {
            if (!arg.is_buffer()) continue;
            std::vector<int64_t>& extents = extents_[arg.name + ".buffer"];
            extents.assign(arg.dimensions, arg.name.starts_with(kList) ? places : kUnknown);
            const ScheduledFunc* func =
                arg.is_output() ? func_of_storage(kernel, arg.name) : nullptr;
            if (func == nullptr) continue;
            const std::vector<Halide::Var> vars = func->func.args();
            for (size_t d = 0; d < extents.size(); ++d)
                extents[d] = constant_extent(*func, vars[d].name()).value_or(places);
        }
    }

    std::vector<Doubt> all;

    /// Returns how many places come at a time.
    static int64_t unit(const ScheduledKernel& kernel) {
        for (const ScheduledFunc& func : kernel.funcs()) {
            if (!func.is_result) continue;
            for (const internal::Bound& bound : func.func.function().schedule().bounds()) {
                const int64_t* unit =
                    bound.modulus.defined() ? internal::as_const_int(bound.modulus) : nullptr;
                if (unit != nullptr) return *unit;
            }
        }
        return 1;
    }

  private:
    static constexpr int64_t kUnknown = -1;
    /// Of what a kernel reads, only the list has as many entries as the result has places.
    static constexpr const char* kList = "groups";

    /// Puts what is known of this call into an expression.
    class Values : public internal::IRMutator {
      public:
        explicit Values(const BufferChecks* of) : of_(of) {}
        std::map<std::string, Expr> of_lets;

      private:
        using internal::IRMutator::visit;
        Expr visit(const internal::Variable* op) override {
            const auto found = of_lets.find(op->name);
            return found == of_lets.end() ? Expr(op) : found->second;
        }
        Expr visit(const internal::Call* op) override {
            const bool min = op->name == "_halide_buffer_get_min";
            if ((!min && op->name != "_halide_buffer_get_extent") || op->args.size() != 2)
                return IRMutator::visit(op);
            const auto* buffer = op->args[0].as<internal::Variable>();
            const int64_t* d = internal::as_const_int(op->args[1]);
            const auto extents =
                buffer == nullptr ? of_->extents_.end() : of_->extents_.find(buffer->name);
            if (d == nullptr || extents == of_->extents_.end()) return op;
            if (min) return Expr(0);
            const int64_t extent = extents->second.at(static_cast<size_t>(*d));
            return extent == kUnknown ? Expr(op) : Expr(static_cast<int32_t>(extent));
        }
        const BufferChecks* of_;
    };

    Expr known(const Expr& e) {
        return internal::simplify(values_.mutate(queries_.resolve(e)));
    }

    using internal::IRVisitor::visit;
    void visit(const internal::For*) override {}
    void visit(const internal::Allocate*) override {}
    void visit(const internal::LetStmt* op) override {
        queries_.note(op->name, op->value);
        if (op->value.type() == Halide::Int(32) || op->value.type().is_bool()) {
            const Expr value = known(op->value);
            if (internal::is_const(value)) values_.of_lets[op->name] = value;
        }
        op->body.accept(this);
    }
    void visit(const internal::AssertStmt* op) override {
        const auto* error = op->message.as<internal::Call>();
        if (error == nullptr || error->name != "halide_error_access_out_of_bounds") return;
        const Doubt doubt = doubt_of(*error);
        const Expr holds = known(op->condition);
        // Of other buffers, whose sizes are not known here, what is read is clamped.
        const bool is_list = doubt.text.find(kList) != std::string::npos;
        if (internal::is_const_zero(holds) || (is_list && !internal::is_const_one(holds)))
            all.push_back(doubt);
    }

    std::map<std::string, std::vector<int64_t>> extents_;  ///< of buffers, by the handle's name
    RegionQueries queries_;
    Values values_;
};

/// Returns the first check of buffers that fails for some number of places.
std::optional<Doubt> check_buffers(const ScheduledKernel& kernel, const Halide::Module& module,
                                   int64_t places) {
    const int64_t unit = BufferChecks::unit(kernel);
    // Around what loops are split by; all there are where 64 places come at a time.
    constexpr int64_t kSteps = 17;
    std::vector<int64_t> numbers = {places};
    for (int64_t k = 1; k <= kSteps && k * unit < places; ++k)
        numbers.push_back(k * unit);
    for (const internal::LoweredFunc& function : module.functions()) {
        for (const int64_t number : numbers) {
            BufferChecks checks(kernel, function, number);
            function.body.accept(&checks);
            if (!checks.all.empty()) return checks.all.front();
        }
    }
    return std::nullopt;
}

/// Returns the word that placed a Func, else the last line that names it.
schedule::Word place_of(const schedule::Schedule& schedule, const ScheduledFunc* func) {
    if (func == nullptr) return schedule::start_of(schedule);
    if (func->store && func->store->directive) return *func->store->directive;
    if (func->compute.directive) return *func->compute.directive;
    return func->last_word.value_or(schedule::start_of(schedule));
}

/// "12.5 MiB"; small sizes in KiB.
std::string size_text(int64_t bytes) {
    const double kib = static_cast<double>(bytes) / 1024;
    return kib < 1024 ? fmt::format("{:.0f} KiB", kib) : fmt::format("{:.1f} MiB", kib / 1024);
}

std::variant<KernelMemory, schedule::Fault> check_size(const schedule::Schedule& schedule,
                                                       const ScheduledKernel& kernel,
                                                       const Halide::Module& module,
                                                       int64_t places) {
    std::string unbounded;
    const std::optional<KernelMemory> memory = measure_memory(kernel, module, places, &unbounded);
    if (!memory) {
        const ScheduledFunc* func = func_of_storage(kernel, unbounded);
        return schedule::fault_at(place_of(schedule, func),
                                  fmt::format("how much of `{}` is stored here depends on the data",
                                              func != nullptr ? func->name : unbounded),
                                  "compute it at an inner loop");
    }
    const bool stack = memory->stack_bytes > kMostStackBytes;
    const int64_t bytes = stack ? memory->stack_bytes : memory->bytes;
    const int64_t most = stack ? kMostStackBytes : kMostStoredBytes;
    if (bytes <= most) return *memory;
    const std::vector<FuncStorage> all = list_storage(kernel, module, places);
    const auto largest = std::max_element(
        all.begin(), all.end(), [](const auto& a, const auto& b) { return a.bytes < b.bytes; });
    const ScheduledFunc* func = func_of_storage(kernel, largest->func);
    return schedule::fault_at(
        place_of(schedule, func),
        fmt::format(
            "this schedule stores up to {}{} a thread, `{}` the most of it; the limit is {}",
            size_text(bytes), stack ? " on the stack of" : " for",
            func != nullptr ? func->name : largest->func, size_text(most)),
        stack ? "compute it at an inner loop, or write store_in(heap)"
              : "compute it at an inner loop");
}

}  // namespace

std::variant<KernelMemory, schedule::Fault> check_lowered(const schedule::Schedule& schedule,
                                                          const ScheduledKernel& kernel,
                                                          const Halide::Module& module,
                                                          int64_t places) {
    DoubtWalk walk(kernel, places);
    walk.walk(module);
    for (const Doubt& doubt : walk.all) {
        if (doubt.error == "halide_error_explicit_bounds_too_small")
            return fault_of_overlap(schedule, kernel, doubt.text);
        const bool bound = doubt.error == "halide_error_storage_bound_too_small";
        return fault_of_storage(schedule, kernel, bound ? "bound_storage" : "fold_storage",
                                doubt.text);
    }
    if (const std::optional<Doubt> doubt = check_buffers(kernel, module, places))
        return fault_of_overlap(schedule, kernel, doubt->text);
    return check_size(schedule, kernel, module, places);
}

}  // namespace openfab::lower
