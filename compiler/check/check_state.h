// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The checker, private to compiler/check: declarations and stages in check.cpp, statements in
// check_stmt.cpp, expressions in check_expr.cpp, calls and methods in check_call.cpp. A node with
// an error becomes an Error node of error type, which reports nothing more.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/check/check.h"

namespace openfab::check {

enum class StageContext : uint8_t { kGlobal, kFunction, kSurface, kVolume };

/// Returns the bits of a scalar if they are known at this point: without functions and uniforms.
std::optional<uint32_t> known_bits(const Expr& expr);

/// Returns `(float2, int)`, for messages.
std::string type_list(const std::vector<ExprPtr>& args);
/// Returns the first part of an expression that has a side effect, or null.
const Expr* side_effect(const Expr& expr);
/// True if an error was reported for one of them.
bool any_error(const std::vector<ExprPtr>& args);

class Checker {
  public:
    explicit Checker(diag::Sink* sink) : sink_(sink) {}
    Program run(const std::vector<Unit>& units, const CheckOptions& options);

  private:
    using Scope = std::map<std::string, const Symbol*, std::less<>>;

    /// The names that a module exports.
    struct Exports {
        Scope names;
        std::vector<const Function*> functions;
    };

    // check_module.cpp
    void check_unit(const Unit& unit, std::vector<Exports>* done, Program* program);
    void import_names(const Unit& unit, const std::vector<Exports>& done);
    void check_file_fablets(const ast::File& file, Program* program);

    // check.cpp
    void check_recursion(const std::vector<std::unique_ptr<Function>>& functions);
    void check_fablet(const ast::Fablet& from, Fablet* to);
    void find_point_members(const ast::Fablet& from, Fablet* to);
    void check_uniform(const ast::Variable& from, Fablet* to);
    bool assign_uniform_index(const ast::Variable& v, const Type& type, ir::Uniform* uniform,
                              Fablet* to);
    void check_stages(const ast::Fablet& from, Fablet* to);
    void check_stage_body(const ast::Stage& from, Stage* to, StageContext context,
                          const Type& result);
    void check_varying(const ast::Variable& v, const ast::Stage& stage, Fablet* to);
    void check_surface_varying(const ast::Variable& v, const Type& type, Fablet* to);
    void check_nearest(const ast::Variable& v, const Type& type, Fablet* to);
    ir::Varying varying(const ast::Variable& v, const Type& type) const;
    void add_stage_symbol(Stage* stage, SymbolKind kind, const ast::Variable& v, const Type& type,
                          size_t index);

    // check_declare.cpp
    void check_scope(const ast::Scope& from, const ast::Fablet* fablet, Fablet* to,
                     std::vector<std::unique_ptr<Symbol>>* constants,
                     std::vector<std::unique_ptr<Function>>* functions);
    Type declared_type(const ast::TypeRef& ref);
    /// Returns the type of a variable with its array extents; an error type after a message.
    Type declared_type(const ast::Variable& v);
    std::optional<int> extent(const ast::Variable& v, size_t dimension);
    std::optional<int32_t> constant_int(const ast::Expr& expr, const char* what);
    void declare_struct(const ast::Struct& from);
    void check_constant(const ast::Variable& v, std::vector<std::unique_ptr<Symbol>>* to);
    void declare_functions(const std::vector<ast::Function>& from,
                           std::vector<std::unique_ptr<Function>>* to);
    void check_functions(const std::vector<ast::Function>& from,
                         const std::vector<std::unique_ptr<Function>>& to);
    std::unique_ptr<Symbol> parameter(const ast::Variable& v);
    bool declare(const Symbol* symbol);
    const Symbol* find(std::string_view name) const;

    // check_stmt.cpp
    StmtPtr statement(const ast::Stmt& stmt);
    StmtPtr block(const ast::Stmt& stmt);
    void declaration(const ast::Stmt& stmt, std::vector<StmtPtr>* out);
    StmtPtr local(const ast::Variable& v);
    StmtPtr if_statement(const ast::Stmt& stmt);
    StmtPtr loop(const ast::Stmt& stmt);
    StmtPtr return_statement(const ast::Stmt& stmt);
    StmtPtr switch_statement(const ast::Stmt& stmt);
    bool labels(const ast::Stmt& stmt, size_t* at, const Type& type, Stmt* out);
    int32_t loop_bound(const ast::Stmt& stmt);
    ExprPtr condition(const ast::Expr& expr);
    static bool is_bare_assignment(const ast::Expr& expr);
    void check_used(const ast::Expr& from, const Expr& expr);

    // check_expr.cpp
    ExprPtr expression(const ast::Expr& expr);
    ExprPtr name(const ast::Expr& expr);
    ExprPtr unary(const ast::Expr& expr);
    ExprPtr binary(const ast::Expr& expr);
    ExprPtr matrix_binary(const ast::Expr& expr, ExprPtr left, ExprPtr right);
    ExprPtr logical(const ast::Expr& expr);
    ExprPtr composition_binary(const ast::Expr& expr, ExprPtr left, ExprPtr right);
    ExprPtr conditional(const ast::Expr& expr);
    ExprPtr assign(const ast::Expr& expr);
    ExprPtr increment(const ast::Expr& expr);
    ExprPtr index(const ast::Expr& expr);
    ExprPtr member(const ast::Expr& expr);
    ExprPtr struct_member(const ast::Expr& expr, ExprPtr object,
                          const std::vector<StructMember>& members);
    ExprPtr matrix_swizzle(const ast::Expr& expr, ExprPtr object);
    ExprPtr attribute_member(const ast::Expr& expr, ExprPtr object);
    ExprPtr swizzle(const ast::Expr& expr, ExprPtr object);
    ExprPtr cast(const ast::Expr& expr);
    std::string help_for_name(std::string_view name) const;
    ExprPtr comma(const ast::Expr& expr);
    void check_division(const Expr& value, const Type& to);
    void check_foreign_operators(const ast::Expr& expr, const Expr& left, const Expr& right);
    bool is_type_name(std::string_view name) const;
    const Symbol* attributes() const;
    void help_with_conversion(const Type& from, const Type& to, diag::Diagnostic* d) const;
    ExprPtr bad_operand(const ast::Expr& expr, const std::string& types);
    bool assignable(const Expr& target);
    /// Returns the common type of an operator's operands; the shorter vector wins, with a warning.
    Type common_type(const Type& a, const Type& b) const;
    ExprPtr convert(ExprPtr value, const Type& to);

    // check_list.cpp
    /// Checks an initializer of type `to`: a value, or a list in `{ }`.
    ExprPtr initializer(const ast::Expr& expr, const Type& to);
    ExprPtr list(const ast::Expr& expr, const Type& to);
    ExprPtr list_of(const ast::Expr& expr, const Type& to, const std::vector<Type>& parts);
    bool flatten(const ast::Expr& expr, const Type& to, std::vector<ExprPtr>* out);
    ExprPtr convert_explicitly(ExprPtr value, const Type& to);

    // check_call.cpp
    ExprPtr call(const ast::Expr& expr);
    std::vector<ExprPtr> arguments(const ast::Expr& expr);
    ExprPtr construct(const ast::Expr& expr, const Type& type, std::vector<ExprPtr> args);
    ExprPtr intrinsic(const ast::Expr& expr, const IntrinsicInfo& info, std::vector<ExprPtr> args);
    ExprPtr user_call(const ast::Expr& expr, const std::vector<const Function*>& candidates,
                      std::vector<ExprPtr> args);
    ExprPtr method(const ast::Expr& expr);
    ExprPtr composition_method(const ast::Expr& expr, ExprPtr object, std::vector<ExprPtr> args);
    ExprPtr unknown_function(const ast::Expr& expr);

    ExprPtr construct_struct(const ast::Expr& expr, const Type& type);

    // check_functions.cpp
    ExprPtr own_function_call(const ast::Expr& expr, const IntrinsicInfo& info,
                              std::vector<ExprPtr> args);
    ExprPtr convert_own_arguments(const ast::Expr& expr, const IntrinsicInfo& info,
                                  const char* parameters, char result, int size,
                                  std::vector<ExprPtr> args);
    ExprPtr bits_call(const ast::Expr& expr, const IntrinsicInfo& info, std::vector<ExprPtr> args);

    // check_query.cpp
    static bool is_query(std::string_view name);
    bool query_is_in_volume(const ast::Expr& callee, const char* help);
    ExprPtr distance_query(const ast::Expr& expr, std::vector<ExprPtr> args);
    ExprPtr surface_query(const ast::Expr& expr, std::vector<ExprPtr> args);
    ExprPtr look_up(const ast::Expr& expr, ExprPtr texture, std::vector<ExprPtr> args);
    ExprPtr unknown_look_up(const ast::Expr& expr, const Type& texture);

    // check_matrix.cpp
    ExprPtr matrix_call(const ast::Expr& expr, MatrixOp op, std::vector<ExprPtr> args);
    ExprPtr mul(const ast::Expr& expr, std::vector<ExprPtr> args);
    ExprPtr over(const ast::Expr& expr, std::vector<ExprPtr> args);

    // check_printf.cpp
    ExprPtr printf_call(const ast::Expr& expr);
    bool match_format(const ast::Expr& literal, std::vector<ExprPtr>* values, size_t first,
                      std::string* out);

    std::vector<const Function*> overloads(std::string_view name) const;
    bool wrong_count(const ast::Expr& call, std::string_view name, const std::string& right,
                     size_t count);

    ExprPtr make(ExprKind kind, const Type& type, const source::Span& span) const;
    ExprPtr poison(const source::Span& span) const { return make(ExprKind::kError, {}, span); }

    diag::Sink* sink_;
    std::vector<Scope> scopes_;
    std::vector<std::unique_ptr<Symbol>> types_;  ///< the names of structs
    std::vector<const Function*> visible_functions_;
    std::vector<const Function*> imported_functions_;
    StageContext context_ = StageContext::kGlobal;
    source::Span stage_span_;
    Type return_type_;
    Function* function_ = nullptr;
    Fablet* fablet_ = nullptr;
    Program* program_ = nullptr;
    int loops_ = 0;
    int switches_ = 0;
};

}  // namespace openfab::check
