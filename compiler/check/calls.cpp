// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "compiler/check/expression_checker.h"
#include "compiler/check/signatures.h"

namespace openfab::check {

namespace {

constexpr int kNoMatch = 1 << 20;

/// The cost of converting an argument to a parameter: 0 the same, 1 widened, 4 broadcast, 16
/// narrowed.
int conversion_cost(const Type& from, const Type& to) {
    if (from == to) return 0;
    if (from.is_matrix() && to.is_matrix()) {
        return from.rows >= to.rows && from.size >= to.size ? 16 : kNoMatch;
    }
    if (from.is_scalar() && to.is_matrix()) return from.base == to.base ? 4 : 5;
    if (!from.is_numeric() || !to.is_numeric()) return kNoMatch;
    int cost = 0;
    if (from.size < to.size) {
        if (from.size != 1) return kNoMatch;
        cost += 4;
    }
    if (from.size > to.size) cost += 16;
    if (from.base < to.base) cost += 1;
    if (from.base > to.base) cost += 16;
    return cost;
}

int call_cost(const Function& f, const std::vector<ExprPtr>& args) {
    if (f.parameters.size() < args.size()) return kNoMatch;
    int cost = 0;
    for (size_t i = args.size(); i < f.parameters.size(); ++i) {
        if (f.parameters[i]->fallback == nullptr) return kNoMatch;
        cost = 1;  // a function of exactly these arguments is preferred
    }
    for (size_t i = 0; i < args.size(); ++i) {
        const Type& type = f.parameters[i]->type;
        if (type.is_error()) continue;
        // An `out` argument must have the parameter's type: there is no conversion on the way out.
        if (f.parameters[i]->is_out && args[i]->type != type) return kNoMatch;
        cost += conversion_cost(args[i]->type, type);
    }
    return std::min(cost, kNoMatch);
}

bool any_match(const std::vector<const Function*>& candidates, const std::vector<ExprPtr>& args) {
    return std::any_of(candidates.begin(), candidates.end(),
                       [&](const Function* f) { return call_cost(*f, args) < kNoMatch; });
}

std::string signature(const Function& f) {
    std::string out = f.name + "(";
    for (size_t i = 0; i < f.parameters.size(); ++i) {
        const Symbol& p = *f.parameters[i];
        const char* way = p.is_out ? (p.is_in ? "inout " : "out ") : "";
        out += fmt::format("{}{}{} {}", i == 0 ? "" : ", ", way, type_name(p.type), p.name);
    }
    return out + ")";
}

std::optional<MatrixOp> matrix_function(std::string_view name) {
    if (name == "mul") return MatrixOp::kMul;
    if (name == "transpose") return MatrixOp::kTranspose;
    if (name == "determinant") return MatrixOp::kDeterminant;
    if (name == "inverse") return MatrixOp::kInverse;
    return std::nullopt;
}

bool is_printf(std::string_view name) {
    return name == "printf" || name == "assert";
}

std::string plural(int count, const char* word) {
    return fmt::format("{} {}{}", count, word, count == 1 ? "" : "s");
}

}  // namespace

std::string type_list(const std::vector<ExprPtr>& args) {
    std::string out;
    for (const ExprPtr& arg : args)
        out += (out.empty() ? "" : ", ") + type_name(arg->type);
    return out;
}

bool any_error(const std::vector<ExprPtr>& args) {
    return std::any_of(args.begin(), args.end(),
                       [](const ExprPtr& arg) { return arg->type.is_error(); });
}

std::vector<ExprPtr> ExpressionChecker::arguments(const ast::Expr& expr) {
    std::vector<ExprPtr> args;
    for (size_t i = 1; i < expr.args.size(); ++i)
        args.push_back(expression(*expr.args[i]));
    return args;
}

std::vector<const Function*> ExpressionChecker::overloads(std::string_view name) const {
    std::vector<const Function*> out;
    for (const Function* f : visible_functions_) {
        if (f->name == name) out.push_back(f);
    }
    const size_t own = out.size();
    for (const Function* f : imported_functions_) {
        if (f->name != name) continue;
        const bool hidden = std::any_of(out.begin(), out.begin() + static_cast<ptrdiff_t>(own),
                                        [&](const Function* o) { return same_parameters(*o, *f); });
        if (!hidden) out.push_back(f);
    }
    return out;
}

/// Returns whether a name is imported and the file has functions of that name, which come first.
bool ExpressionChecker::is_hidden_by_function(const Symbol& symbol) const {
    const auto imported = scopes_.front().find(symbol.name);
    return imported != scopes_.front().end() && imported->second == &symbol &&
           std::any_of(visible_functions_.begin(), visible_functions_.end(),
                       [&](const Function* f) { return f->name == symbol.name; });
}

/// Adds a help line if an imported module keeps a name to itself; returns whether one does.
bool ExpressionChecker::help_with_private(std::string_view name, diag::Diagnostic* d) const {
    const auto found = private_names_.find(name);
    if (found == private_names_.end()) return false;
    d->help(
        fmt::format("`{}` is private to module `{}`: names that begin with `_` stay inside "
                    "their module",
                    name, found->second));
    return true;
}

bool ExpressionChecker::wrong_count(const ast::Expr& call, std::string_view name,
                                    const std::string& right, size_t count) {
    diag::Diagnostic& d = sink_->report(call.args[0]->text_span, diag::kArgumentCount, name, right,
                                        static_cast<int>(count));
    const std::vector<Signature> forms = signatures_of(name);
    std::string list;
    for (const Signature& one : forms)
        list += fmt::format("{}`{}`", list.empty() ? "" : ", ", one.form);
    if (!forms.empty()) d.help((forms.size() == 1 ? "it is " : "there are ") + list);
    return false;
}

ExprPtr ExpressionChecker::call(const ast::Expr& expr) {
    const ast::Expr& callee = *expr.args[0];
    if (callee.kind == ast::ExprKind::kMember) return method(expr);
    if (report_array_constructor(expr)) return poison(expr.span);
    if (callee.kind != ast::ExprKind::kName) {
        ExprPtr value = expression(callee);
        if (!value->type.is_error()) {
            sink_->report(callee.span, diag::kNotAFunction, type_name(value->type));
        }
        return poison(expr.span);
    }
    if (const Symbol* symbol = find(callee.text);
        symbol != nullptr && !is_hidden_by_function(*symbol)) {
        record_use(callee.span, *symbol);
        if (symbol->kind == SymbolKind::kType && symbol->type.is(Base::kStruct)) {
            return construct_struct(expr, symbol->type);
        }
        if (symbol->kind == SymbolKind::kType && symbol->type == kIntType)
            return construct(expr, symbol->type, arguments(expr));
        if (!symbol->type.is_error()) {
            sink_->report(callee.span, diag::kNotAFunction, callee.text)
                .note(symbol->span, fmt::format("`{}` is declared here", callee.text));
        }
        return poison(expr.span);
    }
    const Type type = find_type(callee.text);
    const IntrinsicInfo* info = find_intrinsic(callee.text);
    const std::vector<const Function*> candidates = overloads(callee.text);
    const std::optional<MatrixOp> matrix = matrix_function(callee.text);
    const bool is_over = callee.text == "over";
    const bool asks = is_query(callee.text);
    const bool known = info != nullptr || matrix || is_over || asks;
    if (candidates.empty() && is_printf(callee.text)) return printf_call(expr);
    if (candidates.empty() && is_of_field(callee.text)) return field_call(expr);
    if (candidates.empty() && type.is_error() && !known) {
        return unknown_function(callee, expr.span, &expr);
    }
    std::vector<ExprPtr> args = arguments(expr);
    if (any_error(args)) return poison(expr.span);
    // Falls back to a built-in function if none of the program fits.
    if (!candidates.empty() && (!known || any_match(candidates, args))) {
        return user_call(callee, expr.span, candidates, std::move(args));
    }
    if (!type.is_error()) return construct(expr, type, std::move(args));
    if (matrix) return matrix_call(expr, *matrix, std::move(args));
    if (is_over) return over(expr, std::move(args));
    if (asks) return surface_query(expr, std::move(args));
    if (info->id == Intrinsic::kDistance && args.size() == 1) {
        return distance_query(expr, std::move(args));
    }
    return intrinsic(expr, *info, std::move(args));
}

ExprPtr ExpressionChecker::construct(const ast::Expr& expr, const Type& type,
                                     std::vector<ExprPtr> args) {
    const ast::Expr& callee = *expr.args[0];
    if (any_error(args)) return poison(expr.span);
    if (!type.is_arithmetic()) {
        sink_->report(callee.span, diag::kNotAFunction, callee.text);
        return poison(expr.span);
    }
    const bool four = type.is_matrix() && args.size() == 1 && args[0]->type.is_vector();
    if (args.size() == 1 && !four) {
        check_matrix_of(expr, type, *args[0]);
        ExprPtr out = convert_explicitly(std::move(args[0]), type);
        out->span = expr.span;
        return out;
    }
    int components = 0;
    const int wanted = static_cast<int>(min_components(type));
    for (ExprPtr& arg : args) {
        if (!arg->type.is_numeric()) {
            sink_->report(arg->span, diag::kNoConversion, type_name(arg->type), type_name(type));
            return poison(expr.span);
        }
        const int size = arg->type.size;
        components += size;
        check_division(*arg, type);
        arg = convert_explicitly(std::move(arg), {type.base, size});
    }
    if (components != wanted) {
        wrong_count(expr, callee.text, plural(wanted, "component"),
                    static_cast<size_t>(components));
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kConstruct, type, expr.span);
    out->args = std::move(args);
    return out;
}

/// `Pair(1, 2)` is equivalent to a list of the members.
ExprPtr ExpressionChecker::construct_struct(const ast::Expr& expr, const Type& type) {
    const std::vector<StructMember>& members = type.record->members;
    if (expr.args.size() - 1 != members.size()) {
        wrong_count(expr, expr.args[0]->text, plural(static_cast<int>(members.size()), "argument"),
                    expr.args.size() - 1);
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kConstruct, type, expr.span);
    for (size_t i = 0; i < members.size(); ++i) {
        out->args.push_back(initializer(*expr.args[i + 1], members[i].type));
    }
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

ExprPtr ExpressionChecker::intrinsic(const ast::Expr& expr, const IntrinsicInfo& info,
                                     std::vector<ExprPtr> args) {
    if (info.shape == Shape::kOwn) return own_function_call(expr, info, std::move(args));
    if (info.shape == Shape::kBits) return bits_call(expr, info, std::move(args));
    if (static_cast<int>(args.size()) != info.arity) {
        const std::string right = info.id == Intrinsic::kAtan && args.size() == 2
                                      ? "1 argument (`atan2` takes y and x)"
                                      : plural(info.arity, "argument");
        wrong_count(expr, info.name, right, args.size());
        return poison(expr.span);
    }
    if (info.shape == Shape::kBool) return bools_call(expr, info, std::move(args));
    if (info.shape == Shape::kSelect)
        return choose(expr, expr.args[0]->span, info.name, std::move(args));
    const bool mixture = info.id == Intrinsic::kLerp && args[0]->type.is(Base::kComposition) &&
                         args[1]->type == args[0]->type && args[2]->type.is_scalar();
    const bool numbers = std::all_of(args.begin(), args.end(),
                                     [](const ExprPtr& arg) { return arg->type.is_numeric(); });
    if (!numbers && !mixture) {
        diag::Diagnostic& d =
            sink_->report(expr.args[0]->span, diag::kNoOverload, info.name, type_list(args));
        if (args[0]->type.is(Base::kMaterial)) {
            d.help("mix materials in a composition: `mc.Set(a, 1 - t); mc.Set(b, t);`");
        }
        return poison(expr.span);
    }
    ExprPtr out = make(ExprKind::kIntrinsic, args[0]->type, expr.span);
    out->intrinsic = info.id;
    if (mixture) {
        args[2] = convert(std::move(args[2]), kFloatType);
        out->args = std::move(args);
        return out;
    }
    Type type = args[0]->type;
    for (const ExprPtr& arg : args)
        type = common_type(type, arg->type);
    const bool makes_float =
        info.shape == Shape::kFloat || info.shape == Shape::kToBool || info.shape == Shape::kReduce;
    if (makes_float) type.base = Base::kFloat;
    if (info.shape == Shape::kFloat3) type = kFloat3Type;
    if (type.base == Base::kBool && info.shape != Shape::kReduceBool) type.base = Base::kInt;
    for (ExprPtr& arg : args)
        arg = convert(std::move(arg), type);
    if (any_error(args)) return poison(expr.span);
    out->type = type;
    if (info.shape == Shape::kToInt) out->type.base = Base::kInt;
    if (info.shape == Shape::kToBool) out->type.base = Base::kBool;
    if (info.shape == Shape::kReduceBool) out->type = kBoolType;
    if (info.shape == Shape::kDot || info.shape == Shape::kReduce) out->type.size = 1;
    out->args = std::move(args);
    return out;
}

ExprPtr ExpressionChecker::user_call(const ast::Expr& callee, const source::Span& span,
                                     const std::vector<const Function*>& candidates,
                                     std::vector<ExprPtr> args) {
    const Function* best = nullptr;
    const Function* rival = nullptr;
    int best_cost = kNoMatch;
    for (const Function* f : candidates) {
        const int cost = call_cost(*f, args);
        if (cost >= kNoMatch || cost > best_cost) continue;
        rival = cost == best_cost ? best : nullptr;
        best = f;
        best_cost = cost;
    }
    if (best == nullptr) {
        diag::Diagnostic& d =
            sink_->report(callee.span, diag::kNoOverload, callee.text, type_list(args));
        for (const Function* f : candidates) {
            d.note(f->span, fmt::format("`{}` is here", signature(*f)));
            for (size_t i = 0; i < std::min(args.size(), f->parameters.size()); ++i) {
                const Symbol& p = *f->parameters[i];
                if (!p.is_out || args[i]->type == p.type || candidates.size() > 1) continue;
                d.help(fmt::format("an argument for `{}` is a variable of type `{}`", p.name,
                                   type_name(p.type)));
            }
        }
        return poison(span);
    }
    if (rival != nullptr) {
        sink_->report(callee.span, diag::kAmbiguousCall, callee.text)
            .note(rival->span, fmt::format("candidate `{}`", signature(*rival)))
            .note(best->span, fmt::format("candidate `{}`", signature(*best)));
        return poison(span);
    }
    ExprPtr out = make(ExprKind::kCall, best->return_type, span);
    out->function = best;
    record_use(callee.span, *best);
    if (function_ != nullptr) function_->calls.push_back({best, callee.span});
    for (size_t i = args.size(); i < best->parameters.size(); ++i) {
        const Symbol& fallback = *best->parameters[i]->fallback;
        args.push_back(make(ExprKind::kVariable, fallback.type, span));
        args.back()->symbol = &fallback;
    }
    for (size_t i = 0; i < args.size(); ++i) {
        const Symbol& p = *best->parameters[i];
        if (p.is_out) {
            if (!assignable(*args[i])) return poison(span);
        } else {
            args[i] = convert(std::move(args[i]), p.type);
        }
    }
    out->args = std::move(args);
    return out;
}

ExprPtr ExpressionChecker::method(const ast::Expr& expr) {
    const ast::Expr& callee = *expr.args[0];
    ExprPtr object = expression(*callee.args[0]);
    if (object->type.is_error()) return poison(expr.span);
    const Type& type = object->type;
    if (!type.is(Base::kTexture2D) && !type.is(Base::kTexture3D) && !type.is(Base::kComposition) &&
        !type.is(Base::kDitherAttributes) && !type.is_curve()) {
        return unknown_method(expr, callee, type);
    }
    const bool texture = type.is(Base::kTexture2D) || type.is(Base::kTexture3D);
    if (texture && !is_lookup(callee.text)) return unknown_lookup(expr, type);
    std::vector<ExprPtr> args = arguments(expr);
    if (any_error(args)) return poison(expr.span);
    if (type.is_curve()) return curve_method(expr, std::move(object), std::move(args));
    if (type.is(Base::kDitherAttributes)) return dither_method(expr, std::move(args));
    return type.is(Base::kComposition)
               ? composition_method(expr, std::move(object), std::move(args))
               : lookup(expr, std::move(object), std::move(args));
}

/// `attr.Fraction(i)` and `attr.BlueNoise(face)`.
ExprPtr ExpressionChecker::dither_method(const ast::Expr& expr, std::vector<ExprPtr> args) {
    struct Method {
        std::string_view name;
        ExprKind kind;
        const char* takes;
    };
    constexpr Method kMethods[] = {
        {"Fraction", ExprKind::kFraction, "1 argument, a number from 0 to `count` - 1"},
        {"BlueNoise", ExprKind::kBlueNoise, "1 argument, a face from 0 to 4"}};
    const ast::Expr& callee = *expr.args[0];
    const auto* method = std::ranges::find(kMethods, callee.text, &Method::name);
    if (method == std::end(kMethods)) {
        sink_->report(callee.text_span, diag::kUnknownMember, "DitherAttributes", callee.text)
            .suggest(callee.text_span, callee.text,
                     std::vector<std::string>{"Fraction", "BlueNoise"},
                     "it has `Fraction(i)`, of 0 to `count` - 1, and `BlueNoise(face)`, of 0 to 4");
        return poison(expr.span);
    }
    if (args.size() != 1) {
        wrong_count(expr, callee.text, method->takes, args.size());
        return poison(expr.span);
    }
    if (!args[0]->type.is_scalar()) {
        sink_->report(args[0]->span, diag::kNoConversion, type_name(args[0]->type), "int");
        return poison(expr.span);
    }
    ExprPtr out = make(method->kind, kIntType, expr.span);
    out->args.push_back(convert(std::move(args[0]), kIntType));
    return any_error(out->args) ? poison(expr.span) : std::move(out);
}

ExprPtr ExpressionChecker::composition_method(const ast::Expr& expr, ExprPtr object,
                                              std::vector<ExprPtr> args) {
    struct Method {
        std::string_view name;
        ExprKind kind;
        size_t count;
        Type type;
    };
    const Method methods[] = {
        {"Set", ExprKind::kSet, 2, kVoidType},      {"Add", ExprKind::kAdd, 2, kVoidType},
        {"Get", ExprKind::kGet, 1, kFloatType},     {"Clear", ExprKind::kClear, 0, kVoidType},
        {"Total", ExprKind::kTotal, 0, kFloatType},
    };
    const ast::Expr& callee = *expr.args[0];
    const Method* method = nullptr;
    std::vector<std::string> names;
    for (const Method& m : methods) {
        names.emplace_back(m.name);
        if (m.name == callee.text) method = &m;
    }
    if (method == nullptr) {
        diag::Diagnostic& d = sink_->report(callee.text_span, diag::kUnknownMember,
                                            "MaterialComposition", callee.text);
        if (callee.text == "Normalize" || callee.text == "normalize") {
            d.help("the result of the stage is scaled to a sum of 1 automatically");
        } else {
            d.suggest(callee.text_span, callee.text, names,
                      "it has `Set`, `Add`, `Get`, `Clear` and `Total`");
        }
        return poison(expr.span);
    }
    if (args.size() != method->count) {
        diag::Diagnostic& d = sink_->report(callee.text_span, diag::kArgumentCount, callee.text,
                                            plural(static_cast<int>(method->count), "argument"),
                                            static_cast<int>(args.size()));
        if (method->count == 2) {
            d.help(fmt::format("it takes a material and its amount: `{}(material, 0.5)`",
                               method->name));
        }
        return poison(expr.span);
    }
    if (!args.empty() && !args[0]->type.is(Base::kMaterial)) {
        diag::Diagnostic& d =
            sink_->report(args[0]->span, diag::kNoConversion, type_name(args[0]->type), "Material");
        if (args.size() == 2 && args[1]->type.is(Base::kMaterial)) {
            const auto simple = [](const ast::Expr& part) {
                return part.args.empty() && part.kind != ast::ExprKind::kStringLiteral;
            };
            const ast::Expr& amount = *expr.args[1];
            const ast::Expr& material = *expr.args[2];
            d.help(fmt::format("the material comes first, then its amount: `{}({}, {})`",
                               method->name, simple(material) ? material.text : "material",
                               simple(amount) ? amount.text : "amount"));
            if (simple(material) && simple(amount)) {
                d.replace(amount.span, std::string(material.text))
                    .replace(material.span, std::string(amount.text));
            }
        }
        return poison(expr.span);
    }
    if (args.size() == 2) args[1] = convert(std::move(args[1]), kFloatType);
    const bool writes = method->type == kVoidType;
    if (any_error(args) || (writes && !assignable(*object))) return poison(expr.span);
    ExprPtr out = make(method->kind, method->type, expr.span);
    out->args.push_back(std::move(object));
    for (ExprPtr& arg : args)
        out->args.push_back(std::move(arg));
    return out;
}

}  // namespace openfab::check
