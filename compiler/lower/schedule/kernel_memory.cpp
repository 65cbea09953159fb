// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/schedule/kernel_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>

#include "compiler/lower/algorithm/constant.h"

namespace openfab::lower {

namespace {

namespace internal = Halide::Internal;
using Halide::Expr;
using internal::Interval;

/// Returns the kernel's Func of a name of Halide's.
const ScheduledFunc* func_named(const ScheduledKernel& kernel, const std::string& name) {
    for (const ScheduledFunc& func : kernel.funcs()) {
        if (func.func.name() == name) return &func;
    }
    return nullptr;
}

/// Returns the kernel's Func whose storage has this name of Halide's.
const ScheduledFunc* func_of(const ScheduledKernel& kernel, const std::string& name) {
    for (const ScheduledFunc& func : kernel.funcs()) {
        const std::string& own = func.func.name();
        if (name == own || name.starts_with(own + ".")) return &func;
    }
    return nullptr;
}

/// The regions that extern stages are asked for, which lowered code finds by calling them without
/// memory: `answer.o0.bounds_query` holds what is asked of `answer`, and then
/// `asked.o0.bounds_query.answer` what that reads of `asked`.
class RegionQueries : public internal::IRMutator {
  public:
    explicit RegionQueries(const ScheduledKernel& kernel) : kernel_(kernel) {}

    /// Takes note of a let; returns whether its value comes from queries.
    bool note(const std::string& name, const Expr& value) {
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

    /// Puts regions in the place of queries.
    Expr resolve(const Expr& e) { return mutate(e); }

  private:
    struct Side {
        Expr min;
        Expr extent;
    };
    static constexpr const char* kQuery = ".bounds_query";

    using internal::IRMutator::visit;

    Expr visit(const internal::Variable* op) override {
        const auto found = values_.find(op->name);
        return found == values_.end() ? Expr(op) : found->second;
    }

    Expr visit(const internal::Call* op) override {
        constexpr const char* kGet = "_halide_buffer_get_";
        if (!op->name.starts_with(kGet) || op->args.size() != 2) return IRMutator::visit(op);
        const auto* buffer = op->args[0].as<internal::Variable>();
        const std::optional<int64_t> d = integer_constant(op->args[1]);
        const auto region =
            buffer == nullptr ? regions_.end() : regions_.find(current(buffer->name));
        if (!d || region == regions_.end() || *d >= static_cast<int64_t>(region->second.size()))
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
    std::string current(const std::string& name) const {
        const size_t at = name.find(kQuery);
        if (at == std::string::npos) return name;
        const bool of_reader = name.compare(at + std::string(kQuery).size(), 1, ".") == 0;
        const auto latest = latest_.find(name.substr(0, name.rfind('.', at - 1)));
        return of_reader || latest == latest_.end() ? name : latest->second;
    }

    void note_query(const std::string& name, const std::string& func, const std::string& rest,
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
            region.push_back(d < source.size() ? source[d] : Side{});
        }
    }

    /// Reads minima and extents out of the making of a buffer.
    std::vector<Side> sides_of(const Expr& value) {
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

    const ScheduledKernel& kernel_;
    std::map<std::string, std::vector<Side>> regions_;
    std::map<std::string, std::string> latest_;  ///< by Func: the last query of it
    std::map<std::string, Expr> values_;
    std::map<std::string, Expr> structs_;  ///< shapes with names of their own
};

/// Walks the statements of a function with the range of each variable, and adds up what is
/// allocated at a time.
class StorageWalk : public internal::IRVisitor {
  public:
    StorageWalk(const ScheduledKernel& kernel, int64_t places)
        : kernel_(kernel), places_(places), queries_(kernel) {}

    int64_t peak = 0;
    int64_t stack = 0;  ///< of all functions
    std::vector<FuncStorage> all;
    std::string unbounded;
    std::vector<std::pair<const ScheduledFunc*, schedule::Word>> too_small;  ///< folds

    void walk(const Halide::Module& module) {
        for (const internal::LoweredFunc& function : module.functions()) {
            for (const internal::LoweredArgument& arg : function.args) {
                if (!arg.is_buffer()) continue;
                for (int d = 0; d < arg.dimensions; ++d) {
                    push(fmt::format("{}.extent.{}", arg.name, d), 0, places_);
                    push(fmt::format("{}.min.{}", arg.name, d), 0, 0);
                }
            }
        }
        // Twice: the body of a parallel loop is a function of its own, maybe before the one that
        // knows the ranges of what it is passed. Variables have names of their own in all of them.
        for (const bool last : {false, true}) {
            // What a function allocates is alive while the functions run that its parallel loops
            // became.
            int64_t total = 0;
            all.clear();
            too_small.clear();
            unbounded.clear();
            stack = 0;
            for (const internal::LoweredFunc& function : module.functions()) {
                live_ = peak = 0;
                function.body.accept(this);
                total += peak;
            }
            if (last) peak = total;
        }
    }

  private:
    using internal::IRVisitor::visit;

    void push(const std::string& name, int64_t least, int64_t most) {
        scope_.push(name,
                    Interval(Expr(static_cast<int32_t>(least)), Expr(static_cast<int32_t>(most))));
    }

    /// Expressions allocate nothing.
    void visit(const internal::Store*) override {}
    void visit(const internal::Evaluate*) override {}
    void visit(const internal::AssertStmt*) override {}

    void visit(const internal::LetStmt* op) override {
        if (!queries_.note(op->name, op->value) && op->value.type() == Halide::Int(32)) {
            const Interval range = internal::find_constant_bounds(op->value, scope_);
            // What comes from memory keeps the range that its name is known by.
            if (range.has_upper_bound() || range.has_lower_bound() || !scope_.contains(op->name))
                scope_.push(op->name, range);
        }
        op->body.accept(this);
    }

    void visit(const internal::For* op) override {
        const Expr least = queries_.resolve(op->min);
        const Expr most = internal::simplify(least + queries_.resolve(op->extent) - 1);
        scope_.push(op->name, Interval(internal::find_constant_bounds(least, scope_).min,
                                       internal::find_constant_bounds(most, scope_).max));
        op->body.accept(this);
    }

    void visit(const internal::IfThenElse* op) override {
        op->then_case.accept(this);
        if (op->else_case.defined()) op->else_case.accept(this);
    }

    void visit(const internal::Allocate* op) override {
        const int64_t bytes = size_of(*op);
        if (is_on_stack(*op)) stack += bytes;
        all.push_back({op->name, bytes});
        live_ += bytes;
        peak = std::max(peak, live_);
        op->body.accept(this);
        live_ -= bytes;
    }

    int64_t size_of(const internal::Allocate& op) {
        constexpr int64_t kMost = std::numeric_limits<int64_t>::max() / 4096;
        int64_t bytes = int64_t{op.type.bytes()};
        for (size_t d = 0; d < op.extents.size(); ++d) {
            const Expr most =
                internal::find_constant_bound(internal::simplify(queries_.resolve(op.extents[d])),
                                              internal::Direction::Upper, scope_);
            const std::optional<int64_t> value = integer_constant(most);
            const int64_t factor = std::max<int64_t>(value ? *value : whole(op, d), 0);
            check_folds(op.name, d, factor);
            bytes = factor > 0 && bytes > kMost / factor ? kMost : bytes * factor;
        }
        return bytes;
    }

    /// A fold is enough where it holds what is stored for one step.
    void check_folds(const std::string& name, size_t dimension, int64_t extent) {
        const ScheduledFunc* func = func_of(kernel_, name);
        if (func == nullptr) return;
        for (const StorageFold& fold : func->folds) {
            const auto& dims = func->func.function().schedule().storage_dims();
            if (dimension < dims.size() && dims[dimension].var == fold.var && extent > fold.extent)
                too_small.emplace_back(func, fold.directive);
        }
    }

    /// Where the extent of a dimension is not seen through, it is at most that of the result, which
    /// everything is computed for place by place; what is no Func of the kernel is not bounded so.
    int64_t whole(const internal::Allocate& op, size_t dimension) {
        const ScheduledFunc* func = func_of(kernel_, op.name);
        if (func != nullptr) {
            const auto& dims = func->func.function().schedule().storage_dims();
            if (dimension < dims.size()) return most_extent(*func, dims[dimension].var);
        }
        unbounded = op.name;
        return 0;
    }

    /// Returns the bound of a Func's var, or of the result's var of that name; else the places.
    int64_t most_extent(const ScheduledFunc& func, const std::string& var) const {
        std::vector<const ScheduledFunc*> with_bounds = {&func};
        for (const ScheduledFunc& each : kernel_.funcs()) {
            if (each.is_result) with_bounds.push_back(&each);
        }
        for (const ScheduledFunc* each : with_bounds) {
            for (const internal::Bound& bound : each->func.function().schedule().bounds()) {
                const std::optional<int64_t> extent = integer_constant(bound.extent);
                if (bound.var == var && extent) return *extent;
            }
        }
        return places_;
    }

    const ScheduledKernel& kernel_;
    int64_t places_;
    int64_t live_ = 0;
    internal::Scope<Interval> scope_;
    RegionQueries queries_;
};

/// Collects the names of errors that lowered code may still report.
class Asserts : public internal::IRVisitor {
  public:
    struct Found {
        std::string error;
        std::string text;  ///< its strings
    };
    std::vector<Found> all;

  private:
    using internal::IRVisitor::visit;
    void visit(const internal::AssertStmt* op) override {
        const auto* call = op->message.as<internal::Call>();
        if (call == nullptr) return;
        Found found{call->name, {}};
        for (const Expr& arg : call->args) {
            if (const auto* text = arg.as<internal::StringImm>()) found.text += text->value + " ";
        }
        all.push_back(std::move(found));
    }
    void visit(const internal::Store*) override {}
    void visit(const internal::Evaluate*) override {}
};

/// Finds whether every loop of a name has one length, and whether there is one.
class LoopLengths : public internal::IRVisitor {
  public:
    LoopLengths(LoopNames names, int64_t length) : names_(std::move(names)), length_(length) {}
    bool found = false, same = true;

  private:
    using internal::IRVisitor::visit;
    void visit(const internal::For* op) override {
        if (names_.has(op->name)) {
            found = true;
            same = same && internal::is_const(op->extent, length_);
        }
        op->body.accept(this);
    }
    void visit(const internal::Store*) override {}
    void visit(const internal::Evaluate*) override {}

    const LoopNames names_;
    const int64_t length_;
};

schedule::Word place_of(const schedule::Schedule& schedule, const ScheduledFunc* func) {
    const auto placed = func != nullptr ? func->placed_by() : std::nullopt;
    return placed.value_or(schedule::start_of(schedule));
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
        const ScheduledFunc* func = func_of(kernel, unbounded);
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
    const ScheduledFunc* func = func_of(kernel, largest->func);
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

bool is_on_stack(const internal::Allocate& op) {
    const int32_t constant = op.constant_allocation_size();
    return op.memory_type == Halide::MemoryType::Stack ||
           (op.memory_type == Halide::MemoryType::Auto && constant > 0 &&
            internal::can_allocation_fit_on_stack(int64_t{constant} * op.type.bytes()));
}

std::optional<KernelMemory> measure_memory(const ScheduledKernel& kernel,
                                           const Halide::Module& module, int64_t places,
                                           std::string* unbounded) {
    StorageWalk walk(kernel, places);
    walk.walk(module);
    if (walk.unbounded.empty()) return KernelMemory{walk.peak, walk.stack};
    if (unbounded != nullptr) *unbounded = walk.unbounded;
    return std::nullopt;
}

std::vector<FuncStorage> list_storage(const ScheduledKernel& kernel, const Halide::Module& module,
                                      int64_t places) {
    StorageWalk walk(kernel, places);
    walk.walk(module);
    return std::move(walk.all);
}

std::optional<schedule::Fault> check_part_vectors(const ScheduledKernel& kernel,
                                                  const Halide::Module& module) {
    for (const ScheduledFunc& func : kernel.funcs()) {
        for (const PartVector& part : func.part_vectors) {
            const Loop& loop = *func.definitions[part.definition][0].find(part.loop);
            LoopLengths lengths(LoopNames(func, part.definition, loop), *loop.extent);
            for (const internal::LoweredFunc& function : module.functions())
                function.body.accept(&lengths);
            if (lengths.found && lengths.same) continue;
            return schedule::fault_at(
                part.directive,
                fmt::format("where `{}` is computed, it is not certain that vectors of {} fill all "
                            "that is needed at a time",
                            func.name, *loop.extent),
                "choose a factor that divides it, or an outer loop to compute it in");
        }
    }
    return std::nullopt;
}

std::variant<KernelMemory, schedule::Fault> check_lowered(const schedule::Schedule& schedule,
                                                          const ScheduledKernel& kernel,
                                                          const Halide::Module& module,
                                                          int64_t places) {
    Asserts asserts;
    for (const internal::LoweredFunc& function : module.functions())
        function.body.accept(&asserts);
    for (const Asserts::Found& found : asserts.all) {
        if (found.error == "halide_error_storage_bound_too_small")
            return fault_of_bound(schedule, kernel, found.text);
    }
    StorageWalk walk(kernel, places);
    walk.walk(module);
    for (const auto& [func, directive] : walk.too_small)
        return storage_fault(directive, func->name);
    return check_size(schedule, kernel, module, places);
}

}  // namespace openfab::lower
