// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The syntax tree: the source as written, before any semantic analysis. Texts are views into the
// SourceManager's buffers, which must outlive the tree.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/source/span.h"

namespace openfab::ast {

enum class ExprKind : uint8_t {
#define OPENFAB_AST_EXPR(name) k##name,
#include "compiler/syntax/nodes.def"
};

enum class StmtKind : uint8_t {
#define OPENFAB_AST_STMT(name) k##name,
#include "compiler/syntax/nodes.def"
};

struct Expr;
struct Stmt;
using ExprPtr = std::unique_ptr<Expr>;
using StmtPtr = std::unique_ptr<Stmt>;

/// By kind, `text` and `args`:
///   literals        as written; `bits` is the value
///   Name            the name
///   Unary           + - ! ~        {operand}
///   Prefix/Postfix  ++ --          {operand}
///   Binary          the operator   {left, right}; && and || too
///   Conditional     ?              {condition, if true, if false}
///   Assign          = += …         {target, value}
///   Comma           ,              {first, second}
///   Index           [              {object, index}
///   Member          member's name  {object}
///   Call            (              {callee: Name or Member, arguments…}
///   Cast            type's name    {operand, extents of an array, outermost first…}
///   InitList        {              items
struct Expr {
    ExprKind kind = ExprKind::kBad;
    source::Span span;       ///< all of it
    source::Span text_span;  ///< of `text`
    std::string_view text;
    uint32_t bits = 0;
    std::vector<ExprPtr> args;
    int depth = 1;  ///< levels of nodes; limited by the parser, so that later steps may recurse
};

struct TypeRef {
    std::string_view text;
    source::Span span;
};

/// `float min = 0` in `[[ ]]`.
struct Annotation {
    TypeRef type;
    std::string_view name;
    source::Span span;
    ExprPtr value;
};

/// One declared name: uniform, constant, local, parameter or varying.
struct Variable {
    TypeRef type;
    std::string_view name;
    source::Span span;             ///< of the name
    std::vector<ExprPtr> extents;  ///< of an array, outermost first; null where `[]` was written
    source::Span array_span;       ///< all brackets
    ExprPtr init;
    std::vector<Annotation> annotations;
    bool is_const = false;
    bool is_in = false;   ///< `in` or `inout` was written
    bool is_out = false;  ///< `out` or `inout` was written
    bool nearest = false;
};

/// `struct Name { … };`
struct Struct {
    std::string_view name;
    source::Span span;  ///< of the name
    std::vector<Variable> members;
};

/// `enum Name { A, B = 4 };`
struct Enum {
    std::string_view name;
    source::Span span;            ///< of the name
    std::vector<Variable> items;  ///< without types; `init` is the value, if one is written
};

/// By kind:
///   Block        body
///   Declaration  record? (declared first), variables
///   Expression   expr
///   If           expr, body {then, else?}
///   For          init?, expr?, step?, body {one}, bound?
///   While, Do    expr, body {one}, bound?
///   Return       expr?
///   Switch       expr, body: Case labels and statements
///   Case         expr? (none: `default`)
struct Stmt {
    StmtKind kind = StmtKind::kBad;
    source::Span span;  ///< of its keyword or first token; of a Block, its closing brace
    std::string_view text;
    ExprPtr expr;
    ExprPtr step;
    StmtPtr init;
    std::vector<StmtPtr> body;
    std::vector<Variable> variables;
    std::unique_ptr<Struct> record;
    ExprPtr bound;            ///< n of `@bound(n)`
    source::Span bound_span;  ///< of `@bound`
};

struct Function {
    TypeRef return_type;
    std::string_view name;
    source::Span span;  ///< of the name
    std::vector<Variable> parameters;
    StmtPtr body;
};

enum class StageKind : uint8_t { kSurface, kVolume, kDither, kShape, kGrow };

struct Stage {
    StageKind kind = StageKind::kVolume;
    source::Span span;  ///< of `@Surface`, `@Volume`, `@Dither`, `@Shape` or `@Grow`
    std::vector<Variable> varyings;
    std::vector<TypeRef> claims;  ///< `distance` of `[[ distance ]]`
    StmtPtr body;
};

/// `import name;`
struct Import {
    std::string_view name;
    source::Span span;  ///< of the name
};

/// The declarations at file level or in a fablet.
struct Scope {
    std::vector<Struct> structs;
    std::vector<Enum> enums;
    std::vector<Variable> constants;
    std::vector<Function> functions;
};

struct Fablet {
    std::string_view name;
    source::Span span;  ///< of the name
    std::vector<Variable> uniforms;
    Scope scope;
    std::vector<Stage> stages;
};

struct File {
    source::Span begin;  ///< of the first token
    source::Span end;    ///< just past the last character
    std::vector<source::Span>
        damaged;  ///< what could not be parsed, and names in it may be declared there
    std::vector<Import> imports;
    Scope scope;
    std::vector<Fablet> fablets;
};

/// Returns the marker of a stage without its `@`: "Surface".
const char* stage_name(StageKind kind);

/// Returns the tree as indented text, one node a line.
std::string dump(const File& file);

}  // namespace openfab::ast
