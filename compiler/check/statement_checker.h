// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "compiler/check/expression_checker.h"

namespace openfab::check {

/// Checks statements, the bodies of functions and stages; private to compiler/check.
class StatementChecker {
  public:
    StatementChecker(diag::Sink* sink, Names* names, const Place& place,
                     ExpressionChecker* expressions)
        : sink_(sink), names_(*names), place_(place), expressions_(*expressions) {}

    /// Checks the body of a stage, which returns a `result`.
    StmtPtr stage(const ast::Stmt& body, const Type& result);
    /// The same of a function, whose parameters share the scope that is open, as in HLSL.
    StmtPtr function(const ast::Stmt& body, const Type& result);

  private:
    void begin(const Type& result);
    void children(const ast::Stmt& stmt, Stmt* out);
    StmtPtr statement(const ast::Stmt& stmt);
    StmtPtr block(const ast::Stmt& stmt);
    void declaration(const ast::Stmt& stmt, std::vector<StmtPtr>* out);
    StmtPtr local(const ast::Variable& v);
    bool infer(const ast::Variable& v, Stmt* out);
    StmtPtr if_statement(const ast::Stmt& stmt);
    StmtPtr loop(const ast::Stmt& stmt);
    StmtPtr return_statement(const ast::Stmt& stmt);
    StmtPtr switch_statement(const ast::Stmt& stmt);
    bool labels(const ast::Stmt& stmt, size_t* at, const Type& type, Stmt* out);
    int32_t loop_bound(const ast::Stmt& stmt);
    bool is_no_shape(const Expr& value) const;

    diag::Sink* sink_;
    Names& names_;
    const Place& place_;
    ExpressionChecker& expressions_;
    Type return_type_;
    int loops_ = 0;
    int switches_ = 0;
};

}  // namespace openfab::check
