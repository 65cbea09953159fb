// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/schedule/scheduled_kernel.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "compiler/lower/algorithm/constant.h"

namespace openfab::lower {

namespace {

namespace internal = Halide::Internal;

std::optional<int64_t> constant_of(const Halide::Expr& e) {
    if (!e.defined()) return std::nullopt;
    return integer_constant(internal::simplify(e));
}

/// Collects the Funcs that a definition reads.
class Reads : public internal::IRGraphVisitor {
  public:
    std::vector<internal::Function> functions;

  private:
    using internal::IRGraphVisitor::visit;
    void visit(const internal::Call* op) override {
        if (op->call_type == internal::Call::Halide) functions.emplace_back(op->func);
        IRGraphVisitor::visit(op);
    }
};

/// Returns the length of a loop if the kernel fixes it.
std::optional<int64_t> fixed_extent(const internal::Function& function,
                                    const internal::StageSchedule& stage, const std::string& var) {
    for (const internal::ReductionVariable& rvar : stage.rvars()) {
        if (rvar.var == var) return constant_of(rvar.extent);
    }
    for (const internal::Bound& bound : function.schedule().bounds()) {
        if (bound.var == var) return constant_of(bound.extent);
    }
    return std::nullopt;
}

/// Returns what the kernel itself has made of a loop.
Loop::Kind kind_of(const internal::Dim& dim) {
    // No switch: which values the enumeration has differs between versions of Halide.
    using internal::ForType;
    if (dim.for_type == ForType::Unrolled) return Loop::Kind::kUnrolled;
    if (dim.for_type == ForType::Vectorized) return Loop::Kind::kVector;
    return dim.for_type == ForType::Parallel ? Loop::Kind::kParallel : Loop::Kind::kSerial;
}

LoopNest initial_nest(const internal::Function& function, const Halide::Stage& stage) {
    LoopNest nest{stage};
    for (const internal::Dim& dim : stage.get_schedule().dims()) {
        if (dim.var == Halide::Var::outermost().name()) continue;
        std::string name = dim.var;
        std::replace(name.begin(), name.end(), '$', '_');
        nest.names.insert(name);
        nest.loops.push_back({name, Halide::VarOrRVar(dim.var, dim.is_rvar()),
                              fixed_extent(function, stage.get_schedule(), dim.var), kind_of(dim),
                              dim.is_rvar()});
    }
    nest.given = nest.loops.size();
    return nest;
}

}  // namespace

bool LoopNest::is_changed() const {
    return names.size() > given || std::any_of(loops.begin(), loops.end(), [](const Loop& loop) {
               return loop.kind != Loop::Kind::kSerial;
           });
}

Loop* LoopNest::find(const std::string& name) {
    const auto found =
        std::find_if(loops.begin(), loops.end(), [&](const Loop& l) { return l.name == name; });
    return found == loops.end() ? nullptr : &*found;
}

std::optional<schedule::Word> ScheduledFunc::placed_by() const {
    if (store && store->directive) return store->directive;
    return compute.directive ? compute.directive : last_word;
}

LoopNames::LoopNames(const ScheduledFunc& func, size_t definition, const Loop& loop)
    : begin(fmt::format("{}.s{}.", func.func.name(), definition)), end("." + loop.var.name()) {}

ScheduledKernel::ScheduledKernel(const Kernel& kernel) : output_(kernel.output) {
    for (const NamedFunc& named : kernel.funcs)
        add(named.func, named.name, &named);
    add_calls();
    std::vector<bool> read(funcs_.size(), false);
    for (const ScheduledFunc& func : funcs_) {
        for (const std::set<size_t>& calls : func.calls) {
            for (const size_t call : calls)
                read[call] = true;
        }
    }
    for (size_t k = 0; k < funcs_.size(); ++k) {
        ScheduledFunc& func = funcs_[k];
        func.is_result = !read[k] || func.func.name() == output_.name();
        if (func.is_result) func.compute.level = Placement::Level::kRoot;
    }
    join_fused();
}

void ScheduledKernel::add(const Halide::Func& func, const std::string& name,
                          const NamedFunc* named) {
    ScheduledFunc out;
    out.name = name;
    out.func = func;
    out.is_listed = named != nullptr;
    const internal::Function function = func.function();
    if (!func.is_extern()) {
        out.definitions.push_back({initial_nest(function, Halide::Stage(out.func))});
        for (int k = 0; k < func.num_update_definitions(); ++k)
            out.definitions.push_back({initial_nest(function, out.func.update(k))});
    }
    // Where the kernel itself put it: a level may be asked once it is locked, and still replaced.
    Halide::LoopLevel level = function.schedule().compute_level();
    if (level.lock().is_root()) out.compute.level = Placement::Level::kRoot;
    funcs_.push_back(std::move(out));
}

size_t ScheduledKernel::index_of(const internal::Function& function) {
    for (size_t k = 0; k < funcs_.size(); ++k) {
        if (funcs_[k].func.name() == function.name()) return k;
    }
    add(Halide::Func(function), function.name(), nullptr);
    return funcs_.size() - 1;
}

void ScheduledKernel::add_calls() {
    // Funcs that the list does not name are found, and added, on the way.
    for (size_t k = 0; k < funcs_.size(); ++k) {
        const internal::Function function = funcs_[k].func.function();
        std::vector<Reads> reads(1 + static_cast<size_t>(function.updates().size()));
        std::vector<Reads> conditions(reads.size());
        if (function.has_extern_definition()) {
            for (const Halide::ExternFuncArgument& arg : function.extern_arguments()) {
                if (arg.is_func()) reads[0].functions.emplace_back(arg.func);
                if (arg.is_expr()) arg.expr.accept(&reads[0]);
            }
        } else {
            function.definition().accept(&reads[0]);
            for (size_t u = 1; u < reads.size(); ++u) {
                const internal::Definition& update = function.update(static_cast<int>(u) - 1);
                update.accept(&reads[u]);
                update.predicate().accept(&conditions[u]);
            }
        }
        for (const Reads& each : reads) {
            std::set<size_t> calls;
            for (const internal::Function& called : each.functions) {
                const size_t index = index_of(called);
                if (index != k) calls.insert(index);
                if (funcs_[k].is_extern()) funcs_[index].is_read_by_extern = true;
            }
            funcs_[k].calls.push_back(std::move(calls));
        }
        for (const Reads& each : conditions) {
            std::set<size_t> calls;
            for (const internal::Function& called : each.functions)
                calls.insert(index_of(called));
            funcs_[k].conditions.push_back(std::move(calls));
        }
    }
}

void ScheduledKernel::join_fused() {
    const auto partner = [&](size_t k) -> std::optional<size_t> {
        if (funcs_[k].is_extern()) return std::nullopt;
        Halide::LoopLevel level =
            funcs_[k].func.function().definition().schedule().fuse_level().level;
        level.lock();
        if (level.is_inlined() || level.is_root()) return std::nullopt;
        for (size_t other = 0; other < funcs_.size(); ++other) {
            if (funcs_[other].func.name() == level.func()) return other;
        }
        return std::nullopt;
    };
    for (size_t k = 0; k < funcs_.size(); ++k) {
        size_t last = k;
        for (auto next = partner(k); next; next = partner(last))
            last = *next;
        if (last == k) continue;
        funcs_[last].calls[0].merge(funcs_[k].calls[0]);
        funcs_[k].calls[0].clear();
    }
}

std::optional<size_t> ScheduledKernel::find(std::string_view name) const {
    for (size_t k = 0; k < funcs_.size(); ++k) {
        if (funcs_[k].is_listed && funcs_[k].name == name) return k;
    }
    return std::nullopt;
}

std::vector<std::string> ScheduledKernel::names() const {
    std::vector<std::string> out;
    for (const ScheduledFunc& func : funcs_) {
        if (func.is_listed) out.push_back(func.name);
    }
    return out;
}

std::optional<Halide::Expr> ScheduledKernel::result_extent(const std::string& var) const {
    const std::vector<Halide::Var> args = output_.args();
    for (size_t d = 0; d < args.size(); ++d) {
        if (args[d].name() != var) continue;
        Halide::Func output = output_;
        return output.output_buffers()[0].dim(static_cast<int>(d)).extent();
    }
    return std::nullopt;
}

std::set<ScheduledKernel::Use> ScheduledKernel::uses(size_t func) const {
    std::set<Use> out;
    std::set<size_t> seen;
    const std::function<void(size_t)> collect = [&](size_t read) {
        if (!seen.insert(read).second) return;
        for (size_t k = 0; k < funcs_.size(); ++k) {
            for (size_t d = 0; d < funcs_[k].calls.size(); ++d) {
                if (!funcs_[k].calls[d].contains(read)) continue;
                if (funcs_[k].is_inline()) {
                    collect(k);
                } else {
                    out.insert({k, d});
                }
            }
        }
    };
    collect(func);
    return out;
}

bool ScheduledKernel::reads(size_t reader, size_t func) const {
    std::vector<bool> seen(funcs_.size(), false);
    std::vector<size_t> open = {reader};
    while (!open.empty()) {
        const size_t k = open.back();
        open.pop_back();
        for (const std::set<size_t>& calls : funcs_[k].calls) {
            if (calls.contains(func)) return true;
            for (const size_t call : calls) {
                if (!seen[call]) open.push_back(call);
                seen[call] = true;
            }
        }
    }
    return false;
}

bool ScheduledKernel::decides(size_t func, size_t reduction) const {
    for (const std::set<size_t>& condition : funcs_[reduction].conditions) {
        for (const size_t call : condition) {
            if (call == func) return true;
            if (call != reduction && funcs_[call].is_inline() && reads_inline(func, call))
                return true;
        }
    }
    return false;
}

bool ScheduledKernel::reads_inline(size_t func, size_t part) const {
    for (const std::set<size_t>& calls : funcs_[part].calls) {
        for (const size_t call : calls) {
            if (call == func) return true;
            if (funcs_[call].is_inline() && reads_inline(func, call)) return true;
        }
    }
    return false;
}

std::set<size_t> ScheduledKernel::definitions_that_need(size_t at, size_t func) const {
    std::set<size_t> out;
    std::vector<bool> seen(funcs_.size(), false);
    std::vector<size_t> open = {func};
    while (!open.empty()) {
        const size_t k = open.back();
        open.pop_back();
        for (const Use& use : uses(k)) {
            if (use.func == at) {
                out.insert(use.definition);
            } else if (!seen[use.func]) {
                seen[use.func] = true;
                const std::vector<LoopSite> sites = path(use.func);
                const bool inside = std::any_of(sites.begin(), sites.end(),
                                                [&](const auto& site) { return site.func == at; });
                if (inside) open.push_back(use.func);
            }
        }
    }
    return out;
}

std::vector<LoopSite> ScheduledKernel::loops_around_uses(size_t func) const {
    std::optional<std::vector<LoopSite>> common;
    for (const Use& use : uses(func)) {
        std::vector<LoopSite> path = this->path(use.func);
        if (!funcs_[use.func].is_extern()) {
            const LoopNest& own = funcs_[use.func].definitions[use.definition][0];
            for (auto loop = own.loops.rbegin(); loop != own.loops.rend(); ++loop)
                path.push_back({use.func, &*loop});
        }
        const auto vector = std::find_if(path.begin(), path.end(), [](const LoopSite& site) {
            return site.loop->kind == Loop::Kind::kVector;
        });
        path.erase(vector, path.end());
        if (!common) common = path;
        size_t same = 0;
        while (same < std::min(common->size(), path.size()) &&
               (*common)[same].loop == path[same].loop)
            ++same;
        common->resize(same);
    }
    return common.value_or(std::vector<LoopSite>());
}

std::vector<LoopSite> ScheduledKernel::path(size_t func) const {
    const Placement& placement = funcs_[func].compute;
    if (placement.level != Placement::Level::kAt) return {};
    const ScheduledFunc& at = funcs_[placement.func];
    std::vector<LoopSite> out = path(placement.func);
    // Loops of one name may be in several definitions.
    std::set<size_t> needing;
    if (at.is_reduction()) needing = definitions_that_need(placement.func, func);
    for (size_t d = 0; d < at.definitions.size(); ++d) {
        const LoopNest& nest = at.definitions[d][0];
        if (!needing.empty() && !needing.contains(d)) continue;
        if (nest.find(placement.var) == nullptr) continue;
        for (auto loop = nest.loops.rbegin(); loop != nest.loops.rend(); ++loop) {
            out.push_back({placement.func, &*loop});
            if (loop->name == placement.var) return out;
        }
    }
    return out;
}

std::vector<LoopNames> ScheduledKernel::unrolled() const {
    std::vector<LoopNames> out;
    for (const ScheduledFunc& func : funcs_) {
        for (size_t d = 0; d < func.definitions.size(); ++d) {
            for (const LoopNest& nest : func.definitions[d]) {
                for (const Loop& loop : nest.loops) {
                    if (loop.kind == Loop::Kind::kUnrolled) out.emplace_back(func, d, loop);
                }
            }
        }
    }
    return out;
}

void ScheduledKernel::unroll_loops() {
    for (ScheduledFunc& func : funcs_) {
        for (std::vector<LoopNest>& definition : func.definitions) {
            for (LoopNest& nest : definition) {
                for (const Loop& loop : nest.loops) {
                    if (loop.kind == Loop::Kind::kUnrolled) nest.stage.unroll(loop.var);
                }
            }
        }
    }
}

bool ScheduledKernel::has_part_vectors() const {
    return std::any_of(funcs_.begin(), funcs_.end(),
                       [](const ScheduledFunc& func) { return !func.part_vectors.empty(); });
}

void ScheduledKernel::vectorize_parts() {
    for (ScheduledFunc& func : funcs_) {
        for (const PartVector& part : func.part_vectors) {
            LoopNest& nest = func.definitions[part.definition][0];
            nest.stage.vectorize(nest.find(part.loop)->var);
        }
    }
}

size_t ScheduledKernel::loops_to_storage(size_t func) const {
    const std::vector<LoopSite> around = path(func);
    const std::optional<Placement>& store = funcs_[func].store;
    if (!store) return around.size();
    if (store->level == Placement::Level::kRoot) return 0;
    const auto site = std::find_if(around.begin(), around.end(), [&](const LoopSite& s) {
        return s.func == store->func && s.loop->name == store->var;
    });
    return static_cast<size_t>(site - around.begin()) + 1;
}

}  // namespace openfab::lower
