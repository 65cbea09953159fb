// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "compiler/check/statement_checker.h"

namespace openfab::check {

/// Checks modules, fablets and their declarations: the top of the checker, private to
/// compiler/check.
class Checker : private StatementChecker {
  public:
    explicit Checker(diag::Sink* sink) : StatementChecker(sink) {}
    Program run(const std::vector<Unit>& units, const CheckOptions& options);

  private:
    /// The names that a module exports.
    struct Exports {
        Scope names;
        std::vector<const Function*> functions;
    };

    // check_module.cpp
    void check_unit(const Unit& unit, std::vector<Exports>* done, Program* program);
    void import_names(const Unit& unit, const std::vector<Exports>& done);
    void check_file_fablets(const ast::File& file, Program* program);
    void find_rule(const Unit& unit, const Exports& exports, const std::string& name);

    // check.cpp
    void check_fablet(const ast::Fablet& from, Fablet* to);
    void find_point_members(const ast::Fablet& from, Fablet* to);
    void check_annotations(const ast::Variable& from, Symbol* symbol, ir::Uniform* uniform);
    void check_uniform(const ast::Variable& from, Fablet* to);
    bool assign_uniform_index(const ast::Variable& v, const Type& type, ir::Uniform* uniform,
                              Fablet* to);
    void check_stages(const ast::Fablet& from, Fablet* to);
    void call_rule(const ast::Fablet& from, Fablet* to);
    void check_stage_body(const ast::Stage& from, Stage* to, StageContext context,
                          const Type& result);
    void check_varying(const ast::Variable& v, const ast::Stage& stage, Fablet* to);
    void check_surface_varying(const ast::Variable& v, const Type& type, Fablet* to);
    void check_nearest(const ast::Variable& v, const Type& type, Fablet* to);
    ir::Varying varying(const ast::Variable& v, const Type& type) const;
    void add_stage_symbol(Stage* stage, SymbolKind kind, const ast::Variable& v, const Type& type,
                          size_t index);

    // check_shape.cpp
    void check_claims(const ast::Stage& stage, Fablet* to);
    void check_shape(const ast::Stage& from, Fablet* to);
    void leave_empty(const ast::Fablet& from, Fablet* to);
    void check_shape_varying(const ast::Variable& v, const Type& type, Fablet* to);
    void check_against_shape(const ast::Variable& v, const Type& type, const Fablet& to);

    // check_grow.cpp
    void check_grow(const ast::Stage& from, const ast::Stage* shape, Fablet* to);
    void check_parent(const ast::Variable& v, const Type& type, Fablet* to);
    void check_node(const ast::Stage& from, const Fablet& to);

    // check_declare.cpp
    void check_scope(const ast::Scope& from, const ast::Fablet* fablet, Fablet* to,
                     std::vector<std::unique_ptr<Symbol>>* constants,
                     std::vector<std::unique_ptr<Function>>* functions);
    // check_enum.cpp
    void declare_enum(const ast::Enum& from, std::vector<std::unique_ptr<Symbol>>* constants);
    void add_choices(const ast::Variable& v, const Type& element, ir::Uniform* uniform) const;

    void check_constant(const ast::Variable& v, std::vector<std::unique_ptr<Symbol>>* to);
    void declare_functions(const std::vector<ast::Function>& from,
                           std::vector<std::unique_ptr<Function>>* to);
    void check_functions(const std::vector<ast::Function>& from,
                         const std::vector<std::unique_ptr<Function>>& to);
    std::unique_ptr<Symbol> parameter(const ast::Variable& v);
    void check_recursion(const std::vector<std::unique_ptr<Function>>& functions);

    const Function* rule_ = nullptr;  ///< of fablets without `@Dither`; may be null
};

}  // namespace openfab::check
