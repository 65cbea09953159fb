// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What lowered code tells of its variables before it has ever run: the range of each, with the
// regions that extern stages are asked for. An extern stage is taken to read, along vars that it
// shares with what it reads, no more than it is asked for; vars of its input alone have bounds of
// their own (compiler/lower/sample.cpp).

#include <Halide.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compiler/lower/scheduled_kernel.h"

namespace openfab::lower {

/// Returns the extent of a Func along a var where its bound is a constant.
std::optional<int64_t> constant_extent(const ScheduledFunc& func, const std::string& var);

/// The regions that extern stages are asked for, which lowered code finds by calling them without
/// memory: `answer.o0.bounds_query` holds what is asked of `answer`, and then
/// `asked.o0.bounds_query.answer` what that reads of `asked`.
class RegionQueries : public Halide::Internal::IRMutator {
  public:
    explicit RegionQueries(const ScheduledKernel& kernel) : kernel_(kernel) {}

    /// Takes note of a let; returns whether its value comes from queries.
    bool note(const std::string& name, const Halide::Expr& value);
    /// Puts regions in the place of queries.
    Halide::Expr resolve(const Halide::Expr& e) { return mutate(e); }

  private:
    struct Side {
        Halide::Expr min;
        Halide::Expr extent;
    };

    using Halide::Internal::IRMutator::visit;
    Halide::Expr visit(const Halide::Internal::Variable* op) override;
    Halide::Expr visit(const Halide::Internal::Call* op) override;
    static Side bound_of(const ScheduledFunc& func, const std::string& var);
    std::string current(const std::string& name) const;
    void note_query(const std::string& name, const std::string& func, const std::string& rest,
                    const Halide::Expr& value);
    std::vector<Side> sides_of(const Halide::Expr& value);

    const ScheduledKernel& kernel_;
    std::map<std::string, std::vector<Side>> regions_;
    std::map<std::string, std::string> latest_;  ///< by Func: the last query of it
    std::map<std::string, Halide::Expr> values_;
    std::map<std::string, Halide::Expr> structs_;  ///< shapes with names of their own
};

/// Walks the statements of a kernel's functions with the range of each variable, where buffers have
/// at most `places` columns, vertices, groups or blocks.
class RangeWalk : public Halide::Internal::IRVisitor {
  public:
    RangeWalk(const ScheduledKernel& kernel, int64_t places)
        : kernel_(kernel), places_(places), queries_(kernel) {}

    void walk(const Halide::Module& module);

  protected:
    /// Called before a function's statements; all are walked twice, and only the second time with
    /// the ranges of all variables.
    virtual void begin(bool /*last*/) {}
    virtual void enter(const Halide::Internal::LoweredFunc& function) {
        function.body.accept(this);
    }

    using Halide::Internal::IRVisitor::visit;
    /// Expressions allocate and check nothing.
    void visit(const Halide::Internal::Store*) override {}
    void visit(const Halide::Internal::Evaluate*) override {}
    void visit(const Halide::Internal::AssertStmt*) override {}
    void visit(const Halide::Internal::LetStmt* op) override;
    void visit(const Halide::Internal::For* op) override;
    void visit(const Halide::Internal::IfThenElse* op) override;

    const ScheduledKernel& kernel_;
    const int64_t places_;
    Halide::Internal::Scope<Halide::Internal::Interval> scope_;
    RegionQueries queries_;

  private:
    void push(const std::string& name, int64_t least, int64_t most);
};

}  // namespace openfab::lower
