// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "compiler/check/expression_checker.h"

namespace openfab::check {

namespace {

struct OpName {
    std::string_view text;
    ir::Op op;
};
constexpr OpName kBinaryOps[] = {
    {"+", ir::Op::kAdd},  {"-", ir::Op::kSub},    {"*", ir::Op::kMul},   {"/", ir::Op::kDiv},
    {"%", ir::Op::kMod},  {"&", ir::Op::kBitAnd}, {"|", ir::Op::kBitOr}, {"^", ir::Op::kBitXor},
    {"<<", ir::Op::kShl}, {">>", ir::Op::kShr},   {"==", ir::Op::kEq},   {"!=", ir::Op::kNe},
    {"<", ir::Op::kLt},   {"<=", ir::Op::kLe},    {">", ir::Op::kGt},    {">=", ir::Op::kGe},
};

ir::Op binary_op(std::string_view text) {
    for (const OpName& candidate : kBinaryOps) {
        if (candidate.text == text) return candidate.op;
    }
    return ir::Op::kAdd;
}

std::string both(const Type& a, const Type& b) {
    return fmt::format("`{}` and `{}`", type_name(a), type_name(b));
}

/// Returns whether a swizzle names a component twice.
bool names_twice(const Expr& swizzle) {
    const auto end = swizzle.lanes.begin() + swizzle.type.size;
    for (auto lane = swizzle.lanes.begin(); lane != end; ++lane) {
        if (std::find(swizzle.lanes.begin(), lane, *lane) != lane) return true;
    }
    return false;
}

}  // namespace

ExprPtr ExpressionChecker::make(ExprKind kind, const Type& type, const source::Span& span) const {
    auto out = std::make_unique<Expr>();
    out->kind = kind;
    out->type = type;
    out->span = span;
    return out;
}

ExprPtr ExpressionChecker::expression(const ast::Expr& expr) {
    ExprPtr out = expression_of_kind(expr);
    if (uses_ != nullptr) uses_->expressions.push_back({expr.span, out->type});
    return out;
}

ExprPtr ExpressionChecker::expression_of_kind(const ast::Expr& expr) {
    switch (expr.kind) {
        case ast::ExprKind::kBad:
            return poison(expr.span);
        case ast::ExprKind::kBoolLiteral:
        case ast::ExprKind::kIntLiteral:
        case ast::ExprKind::kUintLiteral:
        case ast::ExprKind::kFloatLiteral: {
            const Type type = expr.kind == ast::ExprKind::kBoolLiteral   ? kBoolType
                              : expr.kind == ast::ExprKind::kIntLiteral  ? kIntType
                              : expr.kind == ast::ExprKind::kUintLiteral ? kUintType
                                                                         : kFloatType;
            ExprPtr out = make(ExprKind::kConstant, type, expr.span);
            out->bits = expr.bits;
            return out;
        }
        case ast::ExprKind::kStringLiteral:
            sink_->report(expr.span, diag::kNotAValue, expr.text, "string")
                .help("strings are allowed only in `printf`, `assert` and annotations");
            return poison(expr.span);
        case ast::ExprKind::kInitList:
            sink_->report(expr.span, diag::kNotAValue, "{ }", "list")
                .help(
                    "a list initializes or assigns a variable; elsewhere name the type: `float3(1, "
                    "2, 3)`");
            return poison(expr.span);
        case ast::ExprKind::kName:
            return name(expr);
        case ast::ExprKind::kUnary:
            return unary(expr);
        case ast::ExprKind::kPrefix:
        case ast::ExprKind::kPostfix:
            return increment(expr);
        case ast::ExprKind::kBinary:
            return binary(expr);
        case ast::ExprKind::kConditional:
            return conditional(expr);
        case ast::ExprKind::kAssign:
            return assign(expr);
        case ast::ExprKind::kComma:
            return comma(expr);
        case ast::ExprKind::kIndex:
            return index(expr);
        case ast::ExprKind::kMember:
            return member(expr);
        case ast::ExprKind::kCall:
            return call(expr);
        case ast::ExprKind::kCast:
            return cast(expr);
    }
    return poison(expr.span);
}

ExprPtr ExpressionChecker::name(const ast::Expr& expr) {
    const Symbol* symbol = find(expr.text);
    if (symbol != nullptr) {
        record_use(expr.span, *symbol);
        if (symbol->type.is_error()) return poison(expr.span);
        if (symbol->kind == SymbolKind::kType) {
            sink_->report(expr.span, diag::kNotAValue, expr.text, "type");
            return poison(expr.span);
        }
        if (symbol->kind == SymbolKind::kVoid && fablet_->ir.void_slot < 0) {
            fablet_->ir.void_slot = fablet_->ir.slot_count++;
        }
        ExprPtr out = make(ExprKind::kVariable, symbol->type, expr.span);
        out->symbol = symbol;
        return out;
    }
    if (!find_type(expr.text).is_error()) {
        sink_->report(expr.span, diag::kNotAValue, expr.text, "type");
        return poison(expr.span);
    }
    if (!overloads(expr.text).empty() || find_intrinsic(expr.text) != nullptr) {
        sink_->report(expr.span, diag::kNotAValue, expr.text, "function");
        return poison(expr.span);
    }
    return unknown_name(expr, {});
}

bool ExpressionChecker::is_type_name(std::string_view name) const {
    const Symbol* symbol = find(name);
    if (symbol != nullptr) return symbol->kind == SymbolKind::kType;
    return !find_type(name).is_error();
}

ExprPtr ExpressionChecker::bad_operand(const ast::Expr& expr, const std::string& types) {
    diag::Diagnostic& d = sink_->report(expr.text_span, diag::kBadOperand, expr.text, types);
    if (types.find("`Material`") != std::string::npos) {
        d.help(
            "a material is not a number: `mc.Set(m, 0.5)` sets how much of it a composition holds, "
            "`mc.Add(m, 0.5)` adds more");
    } else if (types.find("`MaterialComposition`") != std::string::npos) {
        d.help("compositions support `a + b`, `a * s`, `lerp(a, b, t)` and `over(a, b)`");
    } else if (expr.text == "^" && types.find("float") != std::string::npos) {
        d.help("a power is written `pow(x, y)`");
    } else if (expr.text == "==" || expr.text == "!=") {
        d.help("arrays, structs and matrices are compared element by element");
    }
    return poison(expr.span);
}

ExprPtr ExpressionChecker::unary(const ast::Expr& expr) {
    ExprPtr operand = expression(*expr.args[0]);
    if (operand->type.is_error()) return poison(expr.span);
    const Type given = operand->type;
    Type type = given;
    ir::Op op = ir::Op::kNeg;
    if (expr.text == "!") {
        type.base = Base::kBool;
        op = ir::Op::kNot;
    } else if (given.base == Base::kBool) {
        type.base = Base::kInt;
    }
    if (expr.text == "~") op = ir::Op::kBitNot;
    const bool matrix = given.is_matrix() && (expr.text == "-" || expr.text == "+");
    if (!(given.is_numeric() || matrix) || (expr.text == "~" && !type.is_integer())) {
        return bad_operand(expr, fmt::format("`{}`", type_name(given)));
    }
    operand = convert(std::move(operand), type);
    if (expr.text == "+") return operand;
    ExprPtr out = make(ExprKind::kUnary, type, expr.span);
    out->op = op;
    out->args.push_back(std::move(operand));
    return out;
}

Type ExpressionChecker::common_type(const Type& a, const Type& b) const {
    Type out;
    out.base = std::max(a.base, b.base);  // bool < int < uint < float
    if (a.is_matrix() || b.is_matrix()) {
        out.rows = a.is_matrix() ? a.rows : b.rows;
        out.size = a.is_matrix() ? a.size : b.size;
        return out;
    }
    out.size = a.size == 1 || b.size == 1 ? std::max(a.size, b.size) : std::min(a.size, b.size);
    return out;
}

ExprPtr ExpressionChecker::binary(const ast::Expr& expr) {
    if (expr.text == "&&" || expr.text == "||") return logical(expr);
    const bool pointer = (expr.text == "*" || expr.text == "&") &&
                         expr.args[0]->kind == ast::ExprKind::kName &&
                         is_type_name(expr.args[0]->text);
    if (pointer) {
        sink_->report(expr.args[0]->span, diag::kNotAValue, expr.args[0]->text, "type")
            .help("there are no pointers or references; an `out` parameter gives a value back");
        return poison(expr.span);
    }
    if (report_cast_template(expr)) return poison(expr.span);
    ExprPtr left = expression(*expr.args[0]);
    ExprPtr right = expression(*expr.args[1]);
    if (left->type.is_error() || right->type.is_error()) return poison(expr.span);
    const Type a = left->type;
    const Type b = right->type;
    if (a.is(Base::kComposition) || b.is(Base::kComposition)) {
        return composition_binary(expr, std::move(left), std::move(right));
    }
    ir::Op op = binary_op(expr.text);
    const bool equality = op == ir::Op::kEq || op == ir::Op::kNe;
    const bool materials = a.is(Base::kMaterial) && b.is(Base::kMaterial) && equality;
    if (a.is_matrix() || b.is_matrix())
        return matrix_binary(expr, std::move(left), std::move(right));
    if (!materials && !(a.is_numeric() && b.is_numeric())) return bad_operand(expr, both(a, b));
    Type type = materials ? a : common_type(a, b);
    if (type.base == Base::kBool && !equality) type.base = Base::kInt;
    if (ir::is_bitwise(op) && !type.is_integer()) return bad_operand(expr, both(a, b));
    check_foreign_operators(expr, *left, *right);
    ExprPtr out = make(ExprKind::kBinary,
                       ir::is_comparison(op) ? Type{Base::kBool, type.size} : type, expr.span);
    out->op = op;
    out->args.push_back(convert(std::move(left), type));
    out->args.push_back(convert(std::move(right), type));
    return out;
}

/// Component-wise, as in HLSL; a scalar is broadcast.
ExprPtr ExpressionChecker::matrix_binary(const ast::Expr& expr, ExprPtr left, ExprPtr right) {
    const Type a = left->type;
    const Type b = right->type;
    const bool fits = (a.is_matrix() && b.is_scalar()) || (b.is_matrix() && a.is_scalar()) ||
                      (a.is_matrix() && b.is_matrix() && a.rows == b.rows && a.size == b.size);
    const ir::Op op = binary_op(expr.text);
    if (!fits || ir::is_bitwise(op) || ir::is_comparison(op)) {
        diag::Diagnostic& d =
            sink_->report(expr.text_span, diag::kBadOperand, expr.text, both(a, b));
        if (expr.text == "*") {
            d.help("the product of linear algebra is `mul(a, b)`");
            const bool product = a.is_matrix() ? b.is_vector() && a.size == b.size
                                               : a.is_vector() && a.size == b.rows;
            if (product)
                d.insert_before(expr.args[0]->span, "mul(")
                    .replace(expr.text_span, ",")
                    .insert_after(expr.args[1]->span, ")");
        }
        return poison(expr.span);
    }
    const Type type = common_type(a, b);
    ExprPtr out = make(ExprKind::kBinary, type, expr.span);
    out->op = op;
    out->args.push_back(convert(std::move(left), type));
    out->args.push_back(convert(std::move(right), type));
    return out;
}

/// a + b, a * s, s * a: on the amounts of each material.
ExprPtr ExpressionChecker::composition_binary(const ast::Expr& expr, ExprPtr left, ExprPtr right) {
    const std::string types = both(left->type, right->type);
    if (expr.text == "*" && right->type.is(Base::kComposition)) std::swap(left, right);
    const bool sum =
        expr.text == "+" && right->type.is(Base::kComposition) && left->type.is(Base::kComposition);
    const bool product = expr.text == "*" && right->type.is_scalar();
    if (!sum && !product) return bad_operand(expr, types);
    if (product) right = convert(std::move(right), kFloatType);
    ExprPtr out = make(ExprKind::kBinary, left->type, expr.span);
    out->op = sum ? ir::Op::kAdd : ir::Op::kMul;
    out->args.push_back(std::move(left));
    out->args.push_back(std::move(right));
    return out;
}

/// Says that nothing can be assigned to an expression, and what to write instead.
void ExpressionChecker::refuse_target(const Expr& target) {
    if (target.kind == ExprKind::kGet) {
        sink_->report(target.span, diag::kNotAssignable, "the result of `Get`")
            .help("write `mc.Set(m, amount)`");
        return;
    }
    if (target.kind != ExprKind::kAttribute) {
        sink_->report(target.span, diag::kNotAssignable, "this expression");
        return;
    }
    const bool surface = context_ == StageContext::kSurface;
    const bool dither = context_ == StageContext::kDither;
    sink_->report(target.span, diag::kNotAssignable, "a stage attribute")
        .help(context_ == StageContext::kGrow
                  ? "attributes are read-only; work on a copy: `uint path = attr.path;`"
              : context_ == StageContext::kShape
                  ? "attributes are read-only; work on a copy: `float3 p = attr.p;`"
              : surface ? "attributes are read-only; the displacement that the stage "
                          "returns moves the surface"
              : dither  ? "attributes are read-only; work on a copy: `int3 at = attr.voxel;`"
                        : "attributes are read-only; work on a copy: `float3 p = "
                          "attr.voxelCenter;`");
}

bool ExpressionChecker::assignable(const Expr& target) {
    switch (traits(target.kind).target) {
        case Target::kError:
            return false;
        case Target::kNone:
            refuse_target(target);
            return false;
        case Target::kPart:
            if (target.kind == ExprKind::kSwizzle && names_twice(target)) {
                sink_->report(target.span, diag::kNotAssignable,
                              "a swizzle that names a component twice");
                return false;
            }
            return assignable(*target.args[0]);
        case Target::kSymbol:
            break;
    }
    const Symbol& symbol = *target.symbol;
    const char* what = nullptr;
    if (symbol.kind == SymbolKind::kUniform) what = "uniform";
    if (symbol.kind == SymbolKind::kVoid) what = "built-in material";
    if (symbol.kind == SymbolKind::kAttributes) what = "stage's attributes";
    if (symbol.kind == SymbolKind::kConstant || symbol.is_const) what = "constant";
    if (what == nullptr) return true;
    diag::Diagnostic& d = sink_->report(target.span, diag::kNotAssignable,
                                        fmt::format("`{}`, a {},", symbol.name, what));
    if (symbol.span.file != 0)
        d.note(symbol.span, fmt::format("`{}` is declared here", symbol.name));
    if (symbol.kind == SymbolKind::kUniform && symbol.type.is_arithmetic()) {
        d.help(fmt::format("the world sets a uniform; work on a copy: `{0} copy = {1};`",
                           type_name(symbol.type), symbol.name));
    }
    return false;
}

ExprPtr ExpressionChecker::assign(const ast::Expr& expr) {
    if (report_undeclared_target(expr)) return poison(expr.span);
    ExprPtr target = expression(*expr.args[0]);
    const Type type = target->type;
    const bool plain = expr.text == "=";
    const bool list = plain && expr.args[1]->kind == ast::ExprKind::kInitList;
    ExprPtr value = list ? initializer(*expr.args[1], type) : expression(*expr.args[1]);
    if (type.is_error() || value->type.is_error()) return poison(expr.span);
    if (!assignable(*target)) return poison(expr.span);
    ExprPtr out = make(ExprKind::kAssign, type, expr.span);
    if (plain) {
        value = convert(std::move(value), type);
        out->operand_type = type;
    } else {
        out->compound = true;
        out->op = binary_op(expr.text.substr(0, expr.text.size() - 1));
        const bool mixture = type.is(Base::kComposition);
        if (type.is_matrix() && !ir::is_bitwise(out->op) && value->type.is_arithmetic() &&
            (value->type.is_scalar() ||
             (value->type.rows == type.rows && value->type.size == type.size))) {
            out->operand_type = type;
            out->args.push_back(std::move(target));
            out->args.push_back(convert(std::move(value), type));
            return out;
        }
        const bool sum = mixture && out->op == ir::Op::kAdd && value->type == type;
        const bool product = mixture && out->op == ir::Op::kMul && value->type.is_scalar();
        if (!sum && !product && !(type.is_numeric() && value->type.is_numeric())) {
            return bad_operand(expr, both(type, value->type));
        }
        Type common = mixture ? type : common_type(type, value->type);
        if (common.base == Base::kBool) common.base = Base::kInt;
        if (ir::is_bitwise(out->op) && !common.is_integer()) {
            return bad_operand(expr, both(type, value->type));
        }
        // The operation may be wider than the target; converting its result back is then a
        // narrowing.
        if (!mixture && value->type.base == Base::kFloat && type.base != Base::kFloat) {
            sink_->report(expr.span, diag::kNarrowing, "float", type_name(type))
                .help(fmt::format("write the conversion: `a = {}(a {} b)`", type_name(type),
                                  expr.text.substr(0, expr.text.size() - 1)));
        }
        common.size = type.size;
        out->operand_type = common;
        value = convert(std::move(value), product ? kFloatType : common);
    }
    if (value->type.is_error()) return poison(expr.span);
    out->args.push_back(std::move(target));
    out->args.push_back(std::move(value));
    return out;
}

ExprPtr ExpressionChecker::increment(const ast::Expr& expr) {
    ExprPtr target = expression(*expr.args[0]);
    if (target->type.is_error()) return poison(expr.span);
    if (!target->type.is_numeric() || target->type.base == Base::kBool) {
        return bad_operand(expr, fmt::format("`{}`", type_name(target->type)));
    }
    if (!assignable(*target)) return poison(expr.span);
    ExprPtr out = make(ExprKind::kIncrement, target->type, expr.span);
    out->op = expr.text == "++" ? ir::Op::kAdd : ir::Op::kSub;
    out->postfix = expr.kind == ast::ExprKind::kPostfix;
    out->args.push_back(std::move(target));
    return out;
}

ExprPtr ExpressionChecker::index(const ast::Expr& expr) {
    ExprPtr object = expression(*expr.args[0]);
    ExprPtr at = expression(*expr.args[1]);
    if (object->type.is_error() || at->type.is_error()) return poison(expr.span);
    const Type type = object->type;
    if (!type.is_array() && !type.is_matrix() && !type.is_vector()) {
        diag::Diagnostic& d = sink_->report(expr.text_span, diag::kBadOperand, "[ ]",
                                            fmt::format("`{}`", type_name(type)));
        if (type.is(Base::kComposition)) {
            d.help("`mc.Get(m)` is the amount of a material, `mc.Set(m, x)` sets it");
        } else if (type.is(Base::kTexture2D) || type.is(Base::kTexture3D)) {
            d.help("a texture is read with `Sample1` to `Sample4`");
        }
        return poison(expr.span);
    }
    if (at->type != kUintType) at = convert(std::move(at), kIntType);
    if (at->type.is_error()) return poison(expr.span);
    if (const std::optional<uint32_t> bits = known_bits(*at)) {
        const auto index = static_cast<int32_t>(*bits);
        if (index < 0 || index >= type.length()) {
            sink_->report(expr.args[1]->span, diag::kOutOfRange, "index", index, 0,
                          type.length() - 1);
            return poison(expr.span);
        }
    }
    ExprPtr out = make(ExprKind::kIndex, type.element(), expr.span);
    out->args.push_back(std::move(object));
    out->args.push_back(std::move(at));
    return out;
}

ExprPtr ExpressionChecker::member(const ast::Expr& expr) {
    ExprPtr object = expression(*expr.args[0]);
    if (object->type.is_error()) return poison(expr.span);
    if (object->type.is_numeric()) return swizzle(expr, std::move(object));
    if (object->type.is_matrix()) return matrix_swizzle(expr, std::move(object));
    if (object->type.is_attributes()) return attribute_member(expr, std::move(object));
    if (object->type.is(Base::kStruct)) {
        const StructType& record = *object->type.record;
        return struct_member(expr, std::move(object), record.members);
    }
    if (object->type.is(Base::kSurfacePoint)) {
        return struct_member(expr, std::move(object),
                             fablet_ != nullptr ? fablet_->point_members : common_point_members());
    }
    if (object->type.is_array()) return unknown_method(expr, expr, object->type);
    diag::Diagnostic& d =
        sink_->report(expr.text_span, diag::kUnknownMember, type_name(object->type), expr.text);
    if (object->type.is(Base::kComposition)) {
        d.help("`mc.Get(m)` is the amount of a material, `mc.Set(m, x)` sets it");
    }
    return poison(expr.span);
}

ExprPtr ExpressionChecker::struct_member(const ast::Expr& expr, ExprPtr object,
                                         const std::vector<StructMember>& members) {
    std::vector<std::string> names;
    std::string all;
    for (size_t i = 0; i < members.size(); ++i) {
        if (members[i].name == expr.text) {
            record_use(expr.text_span, members[i]);
            if (members[i].type.is_error()) return poison(expr.span);
            ExprPtr out = make(ExprKind::kMember, members[i].type, expr.span);
            out->bits = static_cast<uint32_t>(i);
            out->args.push_back(std::move(object));
            return out;
        }
        names.push_back(members[i].name);
        all += fmt::format("{}`{}`", all.empty() ? "" : ", ", members[i].name);
    }
    diag::Diagnostic& d =
        sink_->report(expr.text_span, diag::kUnknownMember, type_name(object->type), expr.text)
            .suggest(expr.text_span, expr.text, names, "it has " + all);
    if (d.fix.empty() && object->type.is(Base::kSurfacePoint)) {
        d.help(
            "the volume stage's `@nearest` varyings are members too, in functions of the fablet");
    }
    return poison(expr.span);
}

}  // namespace openfab::check
