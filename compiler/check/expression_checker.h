// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Names, types and expressions; the lowest of three layers, private to compiler/check: statements
// (statement_checker.h) and declarations (checker.h) build on it. A node with an error becomes an
// Error node of error type, which reports nothing more.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/check/check.h"

namespace openfab::check {

enum class StageContext : uint8_t { kGlobal, kFunction, kSurface, kVolume, kDither, kShape, kGrow };

/// Returns the bits of a scalar if they are known at this point: without functions and uniforms.
std::optional<uint32_t> known_bits(const Expr& expr);

/// Returns `(float2, int)`, for messages.
std::string type_list(const std::vector<ExprPtr>& args);
/// Returns whether a built-in function has an `out` parameter.
bool writes_an_argument(Intrinsic id);
/// Returns the first part of an expression that has a side effect, or null.
const Expr* side_effect(const Expr& expr);
/// True if an error was reported for one of them.
bool any_error(const std::vector<ExprPtr>& args);

/// Checks expressions in the current scopes.
class ExpressionChecker {
  protected:
    using Scope = std::map<std::string, const Symbol*, std::less<>>;

    explicit ExpressionChecker(diag::Sink* sink) : sink_(sink) {}

    // check_names.cpp
    void record_use(const source::Span& at, const Symbol& symbol);
    void record_use(const source::Span& at, const Function& function);
    void record_use(const source::Span& at, const StructMember& member);
    bool declare(const Symbol* symbol);
    const Symbol* find(std::string_view name) const;
    Type declared_type(const ast::TypeRef& ref);
    /// Returns the type of a variable with its array extents; an error type after a message.
    Type declared_type(const ast::Variable& v);
    /// The same of a type's name and its extents; `init` counts an outermost one that is left out, if it is a list.
    Type array_type(const ast::TypeRef& of, std::string_view name,
                    std::span<const ast::ExprPtr> extents, const source::Span& brackets,
                    const ast::Expr* init);
    std::optional<int> extent(const ast::Expr* written, std::string_view name,
                              const source::Span& brackets, const ast::Expr* counted);
    std::optional<int32_t> constant_int(const ast::Expr& expr, const char* what);
    void declare_struct(const ast::Struct& from);

    // check_expr.cpp
    ExprPtr expression(const ast::Expr& expr);
    ExprPtr expression_of_kind(const ast::Expr& expr);
    ExprPtr name(const ast::Expr& expr);
    ExprPtr unary(const ast::Expr& expr);
    ExprPtr binary(const ast::Expr& expr);
    ExprPtr matrix_binary(const ast::Expr& expr, ExprPtr left, ExprPtr right);
    ExprPtr composition_binary(const ast::Expr& expr, ExprPtr left, ExprPtr right);
    ExprPtr assign(const ast::Expr& expr);
    ExprPtr increment(const ast::Expr& expr);
    ExprPtr index(const ast::Expr& expr);
    ExprPtr member(const ast::Expr& expr);
    ExprPtr struct_member(const ast::Expr& expr, ExprPtr object,
                          const std::vector<StructMember>& members);
    bool is_type_name(std::string_view name) const;
    ExprPtr bad_operand(const ast::Expr& expr, const std::string& types);
    bool assignable(const Expr& target);
    void refuse_target(const Expr& target);
    /// Returns the common type of an operator's operands; the shorter vector wins, with a warning.
    Type common_type(const Type& a, const Type& b) const;

    // check_attributes.cpp
    const Symbol* attributes() const;
    std::string help_for_name(std::string_view name) const;
    ExprPtr attribute_member(const ast::Expr& expr, ExprPtr object);

    // check_swizzle.cpp
    ExprPtr swizzle(const ast::Expr& expr, ExprPtr object);
    ExprPtr matrix_swizzle(const ast::Expr& expr, ExprPtr object);

    // check_choice.cpp
    ExprPtr tested(const ast::Expr& expr);
    /// Checks a condition of one answer, as a bool.
    ExprPtr condition(const ast::Expr& expr);
    ExprPtr logical(const ast::Expr& expr);
    Type choice_type(int lanes, const Type& yes, const Type& no) const;
    ExprPtr choose(const ast::Expr& expr, const source::Span& at, std::string_view name,
                   std::vector<ExprPtr> args);
    ExprPtr conditional(const ast::Expr& expr);
    ExprPtr bools_call(const ast::Expr& expr, const IntrinsicInfo& info, std::vector<ExprPtr> args);

    // check_convert.cpp
    Type cast_type(const ast::Expr& expr);
    ExprPtr cast(const ast::Expr& expr);
    ExprPtr convert(ExprPtr value, const Type& to);
    ExprPtr convert_explicitly(ExprPtr value, const Type& to);

    // check_meaning.cpp
    static bool is_bare_assignment(const ast::Expr& expr);
    void check_used(const ast::Expr& from, const Expr& expr);
    ExprPtr comma(const ast::Expr& expr);
    void check_division(const Expr& value, const Type& to);
    void check_matrix_of(const ast::Expr& expr, const Type& type, const Expr& value);
    bool is_hidden_by_function(const Symbol& symbol) const;
    bool help_with_private(std::string_view name, diag::Diagnostic* d) const;
    void check_fits(const Expr& value, const Type& to);
    void check_foreign_operators(const ast::Expr& expr, const Expr& left, const Expr& right);
    void help_with_conversion(const Type& from, const Type& to, diag::Diagnostic* d) const;

    // check_list.cpp
    /// Checks an initializer of type `to`: a value, or a list in `{ }`.
    ExprPtr initializer(const ast::Expr& expr, const Type& to);
    ExprPtr list(const ast::Expr& expr, const Type& to);
    ExprPtr list_of(const ast::Expr& expr, const Type& to, const std::vector<Type>& parts);
    bool flatten(const ast::Expr& expr, const Type& to, std::vector<ExprPtr>* out);

    // check_call.cpp
    ExprPtr call(const ast::Expr& expr);
    std::vector<ExprPtr> arguments(const ast::Expr& expr);
    ExprPtr construct(const ast::Expr& expr, const Type& type, std::vector<ExprPtr> args);
    ExprPtr intrinsic(const ast::Expr& expr, const IntrinsicInfo& info, std::vector<ExprPtr> args);
    /// `callee`: the name; `span`: of the call.
    ExprPtr user_call(const ast::Expr& callee, const source::Span& span,
                      const std::vector<const Function*>& candidates, std::vector<ExprPtr> args);
    ExprPtr method(const ast::Expr& expr);
    ExprPtr composition_method(const ast::Expr& expr, ExprPtr object, std::vector<ExprPtr> args);
    ExprPtr dither_method(const ast::Expr& expr, std::vector<ExprPtr> args);

    ExprPtr construct_struct(const ast::Expr& expr, const Type& type);

    // check_functions.cpp
    ExprPtr own_function_call(const ast::Expr& expr, const IntrinsicInfo& info,
                              std::vector<ExprPtr> args);
    ExprPtr convert_own_arguments(const ast::Expr& expr, const IntrinsicInfo& info,
                                  const char* parameters, char result, int size,
                                  std::vector<ExprPtr> args);
    ExprPtr bits_call(const ast::Expr& expr, const IntrinsicInfo& info, std::vector<ExprPtr> args);

    // check_field.cpp
    static bool is_of_field(std::string_view name);
    ExprPtr field_call(const ast::Expr& expr);

    // check_foreign.cpp
    bool help_with_library(std::string_view name, diag::Diagnostic* d) const;
    bool help_with_library_name(const ast::Expr& callee, diag::Diagnostic* d) const;
    bool help_with_length(const ast::Expr& call, diag::Diagnostic* d) const;
    bool help_with_uniform(std::string_view name, diag::Diagnostic* d) const;
    static void fix_lookup(const ast::Expr& expr, size_t at, diag::Diagnostic* d);
    /// `callee`: the name of no function; `call` may be null.
    ExprPtr unknown_function(const ast::Expr& callee, const source::Span& span,
                             const ast::Expr* call = nullptr);
    ExprPtr unknown_name(const ast::Expr& expr, const Type& value);
    ExprPtr unknown_method(const ast::Expr& whole, const ast::Expr& member, const Type& type);
    bool report_array_constructor(const ast::Expr& expr);
    bool report_cast_template(const ast::Expr& expr);
    bool report_undeclared_target(const ast::Expr& expr);

    // check_curve.cpp
    ExprPtr curve_method(const ast::Expr& expr, ExprPtr curve, std::vector<ExprPtr> args);

    // check_query.cpp
    static bool is_query(std::string_view name);
    bool query_is_in_volume(const ast::Expr& callee, const char* help);
    bool refuse_in_dither(const source::Span& span, std::string_view what);
    bool refuse_in_shape(const source::Span& span, std::string_view what, const char* help);
    ExprPtr distance_query(const ast::Expr& expr, std::vector<ExprPtr> args);
    ExprPtr surface_query(const ast::Expr& expr, std::vector<ExprPtr> args);
    ExprPtr lookup(const ast::Expr& expr, ExprPtr texture, std::vector<ExprPtr> args);
    ExprPtr unknown_lookup(const ast::Expr& expr, const Type& texture);
    static bool is_lookup(std::string_view name);

    // check_matrix.cpp
    ExprPtr matrix_call(const ast::Expr& expr, MatrixOp op, std::vector<ExprPtr> args);
    ExprPtr mul(const ast::Expr& expr, std::vector<ExprPtr> args);
    ExprPtr over(const ast::Expr& expr, std::vector<ExprPtr> args);

    // check_printf.cpp
    ExprPtr printf_call(const ast::Expr& expr);
    bool prints(const Type& type, Base wanted, const source::Span& at, std::string_view conversion);
    ExprPtr flattened(ExprPtr value, Base to);
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
    /// The names that imported modules keep to themselves, with the module.
    std::map<std::string, std::string, std::less<>> private_names_;
    std::set<std::string, std::less<>>
        unknown_names_;  ///< those that were reported in this function or stage
    std::map<std::string, source::Span, std::less<>> uniform_names_;  ///< of the file's fablets
    std::function<std::string(std::string_view)> module_of_;          ///< CheckOptions::module_of
    source::Span file_begin_;  ///< where an import can be put
    StageContext context_ = StageContext::kGlobal;
    source::Span stage_span_;
    Function* function_ = nullptr;
    Fablet* fablet_ = nullptr;
    Program* program_ = nullptr;
    Uses* uses_ = nullptr;
};

}  // namespace openfab::check
