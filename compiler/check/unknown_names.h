// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Names that mean nothing here: the message says what was probably meant.

#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include "compiler/check/names.h"
#include "compiler/check/stage_rules.h"
#include "compiler/syntax/ast.h"

namespace openfab::check {

class UnknownNames {
  public:
    /// Returns the module of the library that has a name, or nothing: CheckOptions::module_of.
    using ModuleOf = std::function<std::string(std::string_view)>;

    UnknownNames(diag::Sink* sink, const Names& names, const Place& place, ModuleOf module_of)
        : sink_(sink), names_(names), place_(place), module_of_(std::move(module_of)) {}

    void begin_file(const ast::File& file);
    /// Begins a function or a stage, in which each name is reported once.
    void begin_body() { reported_.clear(); }

    /// `callee`: the name of no function; `call` may be null.
    ExprPtr function(const ast::Expr& callee, const source::Span& span,
                     const ast::Expr* call = nullptr) const;
    ExprPtr name(const ast::Expr& expr, const Type& value);
    ExprPtr method(const ast::Expr& whole, const ast::Expr& member, const Type& type) const;
    bool array_constructor(const ast::Expr& expr) const;
    bool cast_template(const ast::Expr& expr) const;

  private:
    std::string help_for_name(std::string_view name) const;
    bool help_with_private(std::string_view name, diag::Diagnostic* d) const;
    bool help_with_library(std::string_view name, diag::Diagnostic* d) const;
    bool help_with_library_name(const ast::Expr& callee, diag::Diagnostic* d) const;
    bool help_with_length(const ast::Expr& call, diag::Diagnostic* d) const;
    bool help_with_uniform(std::string_view name, diag::Diagnostic* d) const;
    static void fix_lookup(const ast::Expr& expr, size_t at, diag::Diagnostic* d);

    diag::Sink* sink_;
    const Names& names_;
    const Place& place_;
    ModuleOf module_of_;
    source::Span file_begin_;                                    ///< where an import can be put
    std::map<std::string, source::Span, std::less<>> uniforms_;  ///< of the file's fablets
    std::set<std::string, std::less<>> reported_;
};

}  // namespace openfab::check
