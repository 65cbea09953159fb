// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/schedule/func_costs.h"

#include <Halide.h>

#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "compiler/lower/algorithm/kernel.h"

namespace openfab::lower {

namespace {

namespace internal = Halide::Internal;

/// Counts each expression once, however often it is used.
class Counter : public internal::IRGraphVisitor {
  public:
    int64_t operations = 0;
    int64_t bytes_read = 0;

  private:
    using internal::IRGraphVisitor::visit;

    template <typename Op>
    void count(const Op* op) {
        ++operations;
        IRGraphVisitor::visit(op);
    }
    void visit(const internal::Add* op) override { count(op); }
    void visit(const internal::Sub* op) override { count(op); }
    void visit(const internal::Mul* op) override { count(op); }
    void visit(const internal::Div* op) override { count(op); }
    void visit(const internal::Mod* op) override { count(op); }
    void visit(const internal::Min* op) override { count(op); }
    void visit(const internal::Max* op) override { count(op); }
    void visit(const internal::EQ* op) override { count(op); }
    void visit(const internal::NE* op) override { count(op); }
    void visit(const internal::LT* op) override { count(op); }
    void visit(const internal::LE* op) override { count(op); }
    void visit(const internal::GT* op) override { count(op); }
    void visit(const internal::GE* op) override { count(op); }
    void visit(const internal::And* op) override { count(op); }
    void visit(const internal::Or* op) override { count(op); }
    void visit(const internal::Not* op) override { count(op); }
    void visit(const internal::Select* op) override { count(op); }
    void visit(const internal::Call* op) override {
        const bool loads =
            op->call_type == internal::Call::Halide || op->call_type == internal::Call::Image;
        if (loads) {
            // Where it is read from is address arithmetic.
            if (read_.emplace(op->name, op->value_index).second) bytes_read += op->type.bytes();
            return;
        }
        // Others mark expressions, or name what the other nodes are: strict_float, reinterpret.
        using internal::Call;
        static const std::set<std::string> functions = {"sqrt_f32", "floor_f32", "ceil_f32",
                                                        "trunc_f32", "round_f32"};
        const bool computes =
            op->is_intrinsic({Call::abs, Call::absd, Call::bitwise_and, Call::bitwise_not,
                              Call::bitwise_or, Call::bitwise_xor, Call::shift_left,
                              Call::shift_right}) ||
            functions.contains(op->name);
        if (computes) ++operations;
        IRGraphVisitor::visit(op);
    }

    std::set<std::pair<std::string, int>> read_;
};

}  // namespace

std::vector<FuncCost> func_costs(const KernelRequest& request) {
    const Kernel kernel = make_kernel(*request.stage, request.inside, request.isa);
    std::vector<FuncCost> out;
    for (const NamedFunc& named : kernel.funcs) {
        const internal::Function function = named.func.function();
        if (function.has_extern_definition()) continue;
        std::vector<internal::Stmt> values;
        const auto add = [&](const std::vector<Halide::Expr>& exprs) {
            for (const Halide::Expr& value : exprs)
                values.push_back(internal::Evaluate::make(value));
        };
        add(function.values());
        for (const internal::Definition& update : function.updates())
            add(update.values());
        Counter counter;
        const std::unique_ptr<internal::IRMutator> expander(make_expander(kernel.deferred));
        expander->mutate(internal::Block::make(values)).accept(&counter);
        FuncCost& cost = out.emplace_back();
        cost.func = named.name;
        cost.operations = counter.operations;
        cost.bytes_read = counter.bytes_read;
        for (const Halide::Type& type : function.output_types())
            cost.bytes_written += type.bytes();
    }
    return out;
}

}  // namespace openfab::lower
