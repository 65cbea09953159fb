// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The checked tree: names resolved, types known, every implicit conversion written out. Made by
// `check`, read by `translate`.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compiler/check/builtins.h"
#include "compiler/check/type.h"
#include "compiler/ir/ir.h"
#include "compiler/source/span.h"

namespace openfab::check {

struct Expr;
struct Stmt;
struct Function;
using ExprPtr = std::unique_ptr<Expr>;
using StmtPtr = std::unique_ptr<Stmt>;

enum class SymbolKind : uint8_t {
    kUniform,   ///< index: in Fablet::uniforms
    kConstant,  ///< init
    kLocal,
    kParameter,
    kSurfaceInput,   ///< index: among the inputs; the fablet may change its own copy
    kSurfaceOutput,  ///< index: among the outputs
    kShapeOutput,    ///< likewise, of the shape stage
    kGrowParent,     ///< the node whose child a grow stage makes; type: the struct
    kNearest,        ///< index: among the nearest inputs
    kAttributes,     ///< `attr`
    kVoid,           ///< the built-in material VOID
    kType,           ///< a struct's name, or an enum's; type
};

/// A name of an enum, or of a bool that has labels.
struct Choice {
    std::string name;
    std::string label;  ///< for people; the name where there is none
    int32_t value = 0;
};

struct Symbol {
    SymbolKind kind = SymbolKind::kLocal;
    std::string name;
    Type type;
    source::Span span;
    bool is_const = false;
    bool is_in = true;    ///< parameter: the argument's value is copied in
    bool is_out = false;  ///< parameter: the value is copied back
    int32_t index = 0;
    ExprPtr init;
    std::unique_ptr<Symbol> fallback;  ///< of a parameter: its default, as a constant
    std::optional<uint32_t> known;     ///< a scalar constant's bits, if known
    struct Annotation {
        source::Span span;  ///< of the name
        ExprPtr value;      ///< null unless it is an expression to compute
    };
    std::vector<Annotation> annotations;  ///< of a uniform, as ir::Uniform::annotations
    std::vector<Choice> choices;          ///< of an enum's name
};

enum class ExprKind : uint8_t {
#define OPENFAB_TREE_EXPR(name, ...) k##name,
#include "compiler/check/nodes.def"
};

/// Whether a value can be assigned to an expression.
enum class Target : uint8_t {
    kNone,
    kSymbol,  ///< yes, if its symbol is no constant
    kPart,    ///< if one can to the first argument
    kError,   ///< no, and this was reported before
};

/// What evaluating an expression changes, arguments apart.
enum class Effect : uint8_t {
    kNone,
    kOwn,
    kCallee,  ///< those arguments that the function writes
};

/// From what the bits of a scalar are known before anything runs.
enum class Folding : uint8_t {
    kNever,
    kOwn,       ///< from what the node holds, each in its own way
    kOperands,  ///< from those of its operands
};

struct ExprTraits {
    Target target;
    Effect effect;
    Folding folding;
};

constexpr ExprTraits traits(ExprKind kind) {
    switch (kind) {
#define OPENFAB_TREE_EXPR(name, target, effect, folding) \
    case ExprKind::k##name:                              \
        return {Target::target, Effect::effect, Folding::folding};
#include "compiler/check/nodes.def"
    }
    return {};
}

/// Members of SurfaceAttributes, VolumeAttributes, DitherAttributes, ShapeAttributes and GrowAttributes.
enum class Attribute : uint8_t {
    kP,
    kN,
    kNg,
    kUv,
    kDpdu,
    kDpdv,
    kInstance,
    kVoxelCenter,
    kVoxelSize,
    kBuildPosition,
    kVoxel,
    kSeed,
    kCount,
    kChild,
    kLevel,
    kPath,
};

/// Functions of matrices.
enum class MatrixOp : uint8_t { kMul, kTranspose, kDeterminant, kInverse };

/// By kind:
///   Constant     bits, one component
///   Variable     symbol
///   Attribute    attribute
///   Convert      args {value} to `type`: components, a scalar broadcast (to all of a struct or an
///                array too), or the first components; of a matrix the upper left ones
///   Unary        op kNeg, kNot, kBitNot; args {operand}
///   Binary       op; args {left, right}, of one type
///   AndThen      args {left, right}, scalar bools; OrElse the same
///   Conditional  args {condition, if true, if false}
///   Swizzle      lanes[0 .. type.size), components in order; args {vector or matrix}
///   Member       bits: index of the member; args {struct or SurfacePoint}
///   Index        args {array, matrix or vector; index}. A varying index is clamped to the range
///   Construct    args, whose components in order are the value's; without args all are 0
///   Assign       args {target, value}; with `compound` op is applied in `operand_type`, the type
///                that the value already has
///   Increment    args {target}, op kAdd or kSub; `postfix`: the value is the old one
///   Comma        args {first, second}
///   Intrinsic    intrinsic, args
///   Matrix       matrix_op, args
///   Call         function; args, one per parameter and of its type, targets for `out`
///   Gradient     function, of a float of a point; args, one per parameter; MeanCurvature the same
///   Sample       args {texture, channel, width, coordinates: a float2 or two floats, of an
///                ImageTexture3D a float3}; type.size channels
///   Curve        args {Spline or ColorRamp, x}
///   Distance     args {point}; NearestPoint the same; DistanceTo args {object, point}
///   WalkEnd      args {point, stop, seed}, before them an object or not
///   Set, Add     args {composition, material, weight}
///   Get          args {composition, material}
///   Clear        args {composition}; Total the same
///   Over         args {above, below}
///   Fraction     args {number}, of a dither rule; BlueNoise: args {face}
///   Printf       text: the format, one conversion per component; args {values}; with `is_assert`
///                args {condition, values}
struct Expr {
    ExprKind kind = ExprKind::kError;
    Type type;
    source::Span span;
    std::vector<ExprPtr> args;
    uint32_t bits = 0;
    ir::Op op = ir::Op::kAdd;
    std::array<uint8_t, 4> lanes{};
    bool compound = false;
    bool postfix = false;
    Type operand_type;
    Attribute attribute = Attribute::kP;
    Intrinsic intrinsic = Intrinsic::kAbs;
    MatrixOp matrix_op = MatrixOp::kMul;
    bool is_assert = false;
    std::string text;
    const Symbol* symbol = nullptr;
    const Function* function = nullptr;
};

enum class StmtKind : uint8_t {
#define OPENFAB_TREE_STMT(name) k##name,
#include "compiler/check/nodes.def"
};

/// By kind:
///   Block       body
///   Declare     symbol, expr? (its first value)
///   Expression  expr
///   If          expr, body {then, else?}
///   Loop        init?, expr? (condition), step?, body {one}; `test_last` for do … while; `bound`
///   Return      expr?
///   Switch      expr, body {one per section}, labels
struct Stmt {
    StmtKind kind = StmtKind::kBlock;
    source::Span span;
    ExprPtr expr;
    ExprPtr step;
    StmtPtr init;
    std::vector<StmtPtr> body;
    std::unique_ptr<Symbol> symbol;
    bool test_last = false;
    int32_t bound = 0;  ///< iteration limit of `@bound`; 0: none
    struct Labels {
        std::vector<uint32_t> values;
        bool is_default = false;
    };
    std::vector<Labels> labels;  ///< of each section of a Switch; values are distinct
};

struct Function {
    std::string name;
    source::Span span;
    Type return_type;
    std::vector<std::unique_ptr<Symbol>> parameters;
    StmtPtr body;
    struct CallSite {
        const Function* function;
        source::Span span;
    };
    std::vector<CallSite> calls;
};

/// Returns whether the parameter types are equal, so that calls would be ambiguous.
bool same_parameters(const Function& a, const Function& b);

struct Stage {
    source::Span span;
    std::vector<std::unique_ptr<Symbol>> symbols;  ///< varyings and attributes
    StmtPtr body;
};

struct Fablet {
    ir::Fablet
        ir;  ///< all but the stages' instructions and the defaults, which `translate` fills in
    std::vector<std::unique_ptr<Symbol>> uniforms;  ///< one per ir.uniforms; init is the default
    std::vector<std::unique_ptr<Symbol>>
        surface_inputs;  ///< defaults only, one per ir.surface_inputs
    std::vector<std::unique_ptr<Symbol>> constants;
    std::vector<std::unique_ptr<Function>> functions;
    std::unique_ptr<Symbol> void_material;
    std::vector<StructMember> point_members;  ///< of a SurfacePoint
    Stage surface;
    Stage volume;
    Stage dither;
    Stage shape;  ///< or the grow stage
    Type node;    ///< of a grow stage its struct; else an error
};

struct Program {  ///< declarations outside fablets are those of the program and its modules
    std::vector<std::unique_ptr<Symbol>> constants;
    std::vector<std::unique_ptr<Function>> functions;
    std::vector<std::unique_ptr<StructType>> structs;  ///< all, of fablets and blocks too
    std::vector<Fablet> fablets;
};

/// Indices of the members that every SurfacePoint has; the fablet's nearest inputs follow.
enum PointMember : uint32_t { kPointPosition = 0, kPointNormal = 1, kPointDistance = 2 };

/// Returns these three.
std::vector<StructMember> common_point_members();

}  // namespace openfab::check
