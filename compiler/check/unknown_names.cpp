// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Help with names, calls and methods as other languages have them, and with those of the library that are not imported.
#include "compiler/check/unknown_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compiler/check/attributes.h"
#include "compiler/check/foreign_names.h"
#include "compiler/check/nodes.h"

namespace openfab::check {

namespace {

constexpr std::string_view kStages[] = {"Surface", "Volume", "Dither", "Shape"};
constexpr std::string_view kLengths[] = {"length", "size",  "len",   "count",
                                         "Length", "Count", "sizeof"};
constexpr std::string_view kCasts[] = {"static_cast", "reinterpret_cast", "const_cast",
                                       "dynamic_cast"};

template <size_t N>
bool is_one_of(const std::string_view (&names)[N], std::string_view name) {
    return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

source::Span between(const source::Span& left, const source::Span& right) {
    return {left.file, left.end, right.begin};
}

}  // namespace

/// Adds a help line if an imported module keeps a name to itself; returns whether one does.
bool UnknownNames::help_with_private(std::string_view name, diag::Diagnostic* d) const {
    const std::string* module = names_.private_module(name);
    if (module == nullptr) return false;
    d->help(
        fmt::format("`{}` is private to module `{}`: names that begin with `_` stay inside "
                    "their module",
                    name, *module));
    return true;
}

/// Returns help for a name of another language, or one that exists only in the surface stage.
std::string UnknownNames::help_for_name(std::string_view name) const {
    std::string foreign_help = foreign_name_help(name);
    if (!foreign_help.empty()) return foreign_help;
    Type type;
    const Symbol* symbol = names_.attributes();
    if (symbol != nullptr && find_attribute(name, symbol->type, &type))
        return fmt::format("write `{}.{}`", symbol->name, name);
    if (name == "attr") {
        switch (place_.context) {
            case StageContext::kVolume:
                return "declare it: `@Volume(@varying { VolumeAttributes attr })`";
            case StageContext::kSurface:
                return "declare it: `@Surface(@varying { SurfaceAttributes attr })`";
            case StageContext::kDither:
                return "declare it: `@Dither(@varying { DitherAttributes attr })`";
            case StageContext::kShape:
                return "declare it: `@Shape(@varying { ShapeAttributes attr })`";
            case StageContext::kGrow:
                return "declare it: `@Grow(@varying { GrowAttributes attr, Node parent })`";
            case StageContext::kGlobal:
            case StageContext::kFunction:
                break;
        }
    }
    if (place_.context != StageContext::kVolume) return "";
    for (const auto* list : {&place_.fablet->ir.surface_outputs, &place_.fablet->ir.surface_inputs,
                             &place_.fablet->ir.shape_outputs}) {
        for (const ir::Varying& v : *list) {
            if (v.name != name) continue;
            return fmt::format(
                "the {} stage has it: add `@nearest {} {}` to the varyings of this one",
                list != &place_.fablet->ir.shape_outputs ? "surface"
                : !place_.fablet->node.is_error()        ? "grow"
                                                         : "shape",
                v.type_name, v.name);
        }
    }
    if (name == "uv")
        return "texture coordinates come from the mesh: add `@nearest float2 uv` to the varyings";
    return "";
}

/// Adds the import that a name of the standard library needs; returns whether it is one.
bool UnknownNames::help_with_library(std::string_view name, diag::Diagnostic* d) const {
    const std::string module = module_of_ ? module_of_(name) : std::string();
    if (module.empty()) return false;
    d->help(fmt::format("it is in the module `{0}`: write `import {0};` at the top of the file",
                        module))
        .insert_before(file_begin_, fmt::format("import {};\n", module));
    return true;
}

/// Adds the help for a function that the library has under another name; returns whether there is one.
bool UnknownNames::help_with_library_name(const ast::Expr& callee, diag::Diagnostic* d) const {
    const LibraryName library = library_name(callee.text);
    const std::string module =
        module_of_ && !library.name.empty() ? module_of_(library.name) : std::string();
    if (module.empty()) return false;
    d->help(fmt::format("the library's is `{}`: write `import {};` at the top of the file",
                        library.form, module));
    if (!library.same_arguments) return true;
    d->replace(callee.span, std::string(library.name));
    const bool imported = std::any_of(names_.imported().begin(), names_.imported().end(),
                                      [&](const Function* f) { return f->name == library.name; });
    if (!imported) d->insert_before(file_begin_, fmt::format("import {};\n", module));
    return true;
}

/// The arguments are not checked: one cause, one message.
ExprPtr UnknownNames::function(const ast::Expr& callee, const source::Span& span,
                               const ast::Expr* call) const {
    const std::string_view name = callee.text;
    diag::Diagnostic& d = sink_->report(callee.span, diag::kUnknownFunction, name);
    if (help_with_private(name, &d) || help_with_library(name, &d) ||
        help_with_library_name(callee, &d))
        return poison(span);
    if (is_one_of(kStages, name)) {
        d.help("a stage cannot be called: put what two of them need into a function");
        return poison(span);
    }
    if (name == "not" && call != nullptr && call->args.size() == 2) {
        d.help("write `!`").replace(callee.span, "!");
        return poison(span);
    }
    if (is_one_of(kLengths, name) && call != nullptr && call->args.size() == 2 &&
        help_with_length(*call, &d))
        return poison(span);
    if (const std::string foreign_help = foreign_function_help(name); !foreign_help.empty()) {
        d.help(foreign_help);
        const std::string ours = renamed_function(name);
        if (is_foreign_lookup(name)) {
            if (call != nullptr) fix_lookup(*call, 1, &d);
        } else if (!ours.empty()) {
            d.replace(callee.span, ours);
        }
        return poison(span);
    }
    std::vector<std::string> names = function_names();
    for (const auto* list : {&names_.functions(), &names_.imported()}) {
        for (const Function* f : *list)
            names.push_back(f->name);
    }
    for (const std::string& type : type_names())
        names.push_back(type);
    d.suggest(callee.span, name, names,
              "library functions need an `import`; OPENFL.md lists the built-in functions in "
              "section 8");
    return poison(span);
}

/// `texture2D(picture, uv)` as `picture.Sample4(uv, 0)`; the texture is argument `at`.
void UnknownNames::fix_lookup(const ast::Expr& expr, size_t at, diag::Diagnostic* d) {
    if (expr.args.size() != at + 2 || expr.args[at]->kind != ast::ExprKind::kName) return;
    const ast::Expr& texture = *expr.args[at];
    const ast::Expr& point = *expr.args[at + 1];
    const source::Span& call = expr.args[0]->span;
    d->replace({call.file, call.begin, texture.span.begin}, "")
        .replace(between(texture.span, point.span), ".Sample4(")
        .insert_after(point.span, ", 0");
}

/// `len(list)`: what an array's length is, if the argument is an array that has a name.
bool UnknownNames::help_with_length(const ast::Expr& call, diag::Diagnostic* d) const {
    const ast::Expr& of = *call.args[1];
    const Symbol* symbol = of.kind == ast::ExprKind::kName ? names_.find(of.text) : nullptr;
    if (symbol == nullptr || !symbol->type.is_array()) return false;
    d->help(fmt::format("`{}` has the {} elements that it is declared with", of.text,
                        symbol->type.length()))
        .replace(call.span, std::to_string(symbol->type.length()));
    return true;
}

/// Reports a member or method that a value does not have, where a function does what is meant.
/// `whole` is the call, or the member alone.
ExprPtr UnknownNames::method(const ast::Expr& whole, const ast::Expr& member,
                             const Type& type) const {
    diag::Diagnostic& d =
        sink_->report(member.text_span, diag::kUnknownMember, type_name(type), member.text);
    const ast::Expr& object = *member.args[0];
    const bool call = &whole != &member;
    if (type.is_array() && is_one_of(kLengths, member.text)) {
        d.help(fmt::format("it has the {} elements that it is declared with", type.length()))
            .replace(whole.span, std::to_string(type.length()));
        return poison(whole.span);
    }
    if (type.is(Base::kMaterial)) {
        d.help("amounts are set in a composition: `mc.Set(material, amount)`");
        return poison(whole.span);
    }
    const std::string renamed = renamed_function(member.text);
    const std::string name = renamed.empty() ? std::string(member.text) : renamed;
    const bool known = find_intrinsic(name) != nullptr || !names_.overloads(name).empty() ||
                       name == "transpose" || name == "determinant" || name == "inverse";
    if (!type.is_arithmetic() || (!known && !call)) return poison(whole.span);
    if (known) {
        d.help(fmt::format("functions are no methods: `{}(v)`", name))
            .insert_before(object.span, name + "(");
        const bool more = call && whole.args.size() > 1;
        if (more) {
            d.replace(between(object.span, whole.args[1]->span), ", ");
        } else {
            d.replace({object.span.file, object.span.end, whole.span.end}, ")");
        }
    } else if (member.text.size() <= 4 &&
               member.text.find_first_not_of("xyzwrgba") == std::string_view::npos) {
        d.help("components are not called: leave out `()`")
            .replace({member.text_span.file, member.text_span.end, whole.span.end}, "");
    }
    return poison(whole.span);
}

/// `float[3](1, 2, 3)`, an array as GLSL makes it.
bool UnknownNames::array_constructor(const ast::Expr& expr) const {
    const ast::Expr& callee = *expr.args[0];
    const bool of_type = callee.kind == ast::ExprKind::kIndex &&
                         callee.args[0]->kind == ast::ExprKind::kName &&
                         names_.is_type(callee.args[0]->text);
    if (!of_type) return false;
    diag::Diagnostic& d =
        sink_->report(callee.args[0]->span, diag::kNotAValue, callee.args[0]->text, "type")
            .help("write a list in braces: `{1, 2, 3}`");
    if (expr.args.size() > 1) {
        d.replace({callee.span.file, callee.span.begin, expr.args[1]->span.begin}, "{")
            .replace({expr.span.file, expr.args.back()->span.end, expr.span.end}, "}");
    }
    return true;
}

/// `static_cast<int>(x)`
bool UnknownNames::cast_template(const ast::Expr& expr) const {
    const ast::Expr* name = &expr;
    while (name->kind == ast::ExprKind::kBinary)
        name = name->args[0].get();
    if (name->kind != ast::ExprKind::kName || !is_one_of(kCasts, name->text)) return false;
    sink_->report(name->span, diag::kUnknownFunction, name->text)
        .help("a conversion is written `int(x)`");
    return true;
}

/// Reports a name once in a function or stage. `value` is the type of what is assigned to it, if something is.
ExprPtr UnknownNames::name(const ast::Expr& expr, const Type& value) {
    if (place_.context != StageContext::kGlobal && !reported_.emplace(expr.text).second)
        return poison(expr.span);
    diag::Diagnostic& d = sink_->report(expr.span, diag::kUnknownName, expr.text);
    if (help_with_private(expr.text, &d)) return poison(expr.span);
    if (const std::string help = help_for_name(expr.text); !help.empty()) {
        d.help(help);
        if (const std::string constant = constant_of(expr.text); !constant.empty())
            d.insert_before(file_begin_, constant + "\n");
        return poison(expr.span);
    }
    if (help_with_uniform(expr.text, &d) || help_with_library(expr.text, &d))
        return poison(expr.span);
    std::vector<std::string> names;
    for (const Names::Scope& scope : names_.scopes()) {
        for (const auto& [text, symbol] : scope)
            names.push_back(text);
    }
    names.insert(names.end(), {"true", "false"});
    const bool declares = !value.is_error() && !value.is_array();
    const std::string type = declares ? type_name(value) : "";
    d.suggest(
        expr.span, expr.text, names,
        declares ? fmt::format("declare it with its type: `{} {} = …`", type, expr.text) : "");
    if (declares && d.fix.empty()) d.insert_before(expr.span, type + " ");
    return poison(expr.span);
}

/// Adds that a uniform is declared in a fablet, and seen there alone; returns whether one of this name is.
bool UnknownNames::help_with_uniform(std::string_view name, diag::Diagnostic* d) const {
    const auto uniform = uniforms_.find(name);
    if (place_.fablet != nullptr || uniform == uniforms_.end()) return false;
    d->note(uniform->second, fmt::format("the uniform `{}` is declared here", name))
        .help(
            "functions of the fablet see its uniforms: move this one into the fablet, or give it "
            "the value as a parameter");
    return true;
}

void UnknownNames::begin_file(const ast::File& file) {
    file_begin_ = file.begin;
    uniforms_.clear();
    for (const ast::Fablet& fablet : file.fablets) {
        for (const ast::Variable& v : fablet.uniforms)
            uniforms_.emplace(v.name, v.span);
    }
}

}  // namespace openfab::check
