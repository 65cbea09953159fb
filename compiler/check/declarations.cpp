// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/declarations.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <string_view>
#include <utility>

namespace openfab::check {

namespace {

/// A struct, an enum or a constant of a scope, in source order.
struct Item {
    const ast::Struct* record = nullptr;
    const ast::Variable* constant = nullptr;
    const ast::Enum* names = nullptr;
    uint32_t offset() const {
        return record != nullptr  ? record->span.begin
               : names != nullptr ? names->span.begin
                                  : constant->span.begin;
    }
};

std::vector<Item> items_of(const ast::Scope& scope) {
    std::vector<Item> out;
    for (const ast::Struct& record : scope.structs)
        out.push_back({&record, nullptr, nullptr});
    for (const ast::Variable& v : scope.constants)
        out.push_back({nullptr, &v, nullptr});
    for (const ast::Enum& names : scope.enums)
        out.push_back({nullptr, nullptr, &names});
    std::stable_sort(out.begin(), out.end(),
                     [](const Item& a, const Item& b) { return a.offset() < b.offset(); });
    return out;
}

using Mentioned = std::set<std::string_view>;

bool mentions(const ast::Expr* expr, const Mentioned& names) {
    if (expr == nullptr) return false;
    if (expr->kind == ast::ExprKind::kName && names.count(expr->text) != 0) return true;
    return std::any_of(expr->args.begin(), expr->args.end(),
                       [&](const ast::ExprPtr& arg) { return mentions(arg.get(), names); });
}

void check_defaults_order(const Function& f, diag::Sink* sink) {
    bool seen = false;
    for (const auto& p : f.parameters) {
        if (seen && p->fallback == nullptr && !p->type.is_error()) {
            sink->report(p->span, diag::kBadDeclaration,
                         fmt::format("`{}` needs a default: one before it has one", p->name));
        }
        seen = seen || p->fallback != nullptr;
    }
}

constexpr size_t kMaxNames = 256;

/// Returns the text of a `string label = "…"`; empty without one.
std::string label_of(const ast::Variable& item) {
    for (const ast::Annotation& a : item.annotations) {
        if (a.name == "label" && a.value != nullptr &&
            a.value->kind == ast::ExprKind::kStringLiteral)
            return one_line(a.value->text);
    }
    return "";
}

/// Returns the one of `choices` that has this name or label, or null.
const Choice* find_choice(const std::vector<Choice>& choices, std::string_view name) {
    const auto choice = std::find_if(choices.begin(), choices.end(), [&](const Choice& one) {
        return one.name == name || one.label == name;
    });
    return choice == choices.end() ? nullptr : &*choice;
}

enum class Visit : uint8_t { kOpen, kDone };

/// Reports the call that closes a cycle, for every cycle that a depth-first search from `f` finds.
void visit_calls(const Function* f, std::map<const Function*, Visit>* visits, diag::Sink* sink) {
    (*visits)[f] = Visit::kOpen;
    for (const Function::CallSite& call : f->calls) {
        const auto known = visits->find(call.function);
        if (known == visits->end()) {
            visit_calls(call.function, visits, sink);
        } else if (known->second == Visit::kOpen) {
            sink->report(call.span, diag::kRecursion, call.function->name)
                .note(call.function->span,
                      fmt::format("`{}` is declared here", call.function->name))
                .help("OpenFL has no recursion: write a loop");
        }
    }
    (*visits)[f] = Visit::kDone;
}

}  // namespace

/// Returns a text without what separates names and labels.
std::string one_line(std::string_view text) {
    std::string out(text);
    std::replace_if(
        out.begin(), out.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
    return out;
}

/// Structs and constants may depend on each other and are checked in source order; functions may be
/// declared anywhere. Whatever may use a uniform or a function is therefore checked later.
void Declarations::scope(const ast::Scope& from, const std::vector<ast::Variable>& uniforms,
                         const std::function<void(const ast::Variable&)>& check_uniform,
                         std::vector<std::unique_ptr<Symbol>>* constants,
                         std::vector<std::unique_ptr<Function>>* functions) {
    Mentioned later;
    for (const ast::Function& f : from.functions)
        later.insert(f.name);
    for (const ast::Variable& v : uniforms)
        later.insert(v.name);
    std::vector<const ast::Variable*> late;
    for (const Item& item : items_of(from)) {
        if (item.record != nullptr) {
            expressions_.types().declare_struct(*item.record);
        } else if (item.names != nullptr) {
            declare_enum(*item.names, constants);
        } else if (mentions(item.constant->init.get(), later)) {
            later.insert(item.constant->name);
            late.push_back(item.constant);
        } else {
            constant(*item.constant, constants);
        }
    }
    for (const ast::Variable& v : uniforms)
        check_uniform(v);
    declare_functions(from.functions, functions);
    for (const ast::Variable* v : late)
        constant(*v, constants);
    check_bodies(from.functions, *functions);
}

void Declarations::constant(const ast::Variable& v, std::vector<std::unique_ptr<Symbol>>* to) {
    place_.context = StageContext::kGlobal;
    auto symbol = std::make_unique<Symbol>();
    symbol->kind = SymbolKind::kConstant;
    symbol->name = v.name;
    symbol->span = v.span;
    symbol->is_const = true;
    symbol->type = expressions_.types().declared_type(v);
    const Type& type = symbol->type;
    const bool computed = type == kVoidType || type.is_attributes() ||
                          contains(type, Base::kSurfacePoint) || contains(type, Base::kComposition);
    if (!type.is_error() && computed) {
        sink_->report(v.type.span, diag::kBadDeclaration,
                      fmt::format("a constant cannot have type `{}`", type_name(type)));
        symbol->type = {};
    } else if (!type.is_error() && !v.is_const) {
        sink_
            ->report(v.span, diag::kBadDeclaration,
                     fmt::format("`{}` is outside a function and not `const`", v.name))
            .help(type.is_handle() || type.is_curve() || contains(type, Base::kMaterial)
                      ? fmt::format("the world binds it: `@uniform {{ {} {}; }}`", v.type.text,
                                    v.name)
                      : "nothing is kept from voxel to voxel: write `const`, or make it a uniform, "
                        "`@uniform { … }`");
    } else if (!type.is_error() && v.init == nullptr) {
        sink_
            ->report(v.span, diag::kBadDeclaration,
                     fmt::format("constant `{}` has no value", v.name))
            .help(fmt::format("write `const {} {} = …;`", v.type.text, v.name));
        symbol->type = {};
    }
    if (v.init != nullptr && !symbol->type.is_error()) {
        symbol->init = expressions_.initializers().of(*v.init, symbol->type);
        if (symbol->init->type.is_error()) {
            symbol->type = {};
        } else {
            symbol->known = known_bits(*symbol->init);
        }
    }
    names_.declare(symbol.get());
    to->push_back(std::move(symbol));
}

std::unique_ptr<Symbol> Declarations::parameter(const ast::Variable& v) {
    auto symbol = std::make_unique<Symbol>();
    symbol->kind = SymbolKind::kParameter;
    symbol->name = v.name;
    symbol->span = v.span;
    symbol->is_const = v.is_const;
    symbol->is_in = v.is_in || !v.is_out;
    symbol->is_out = v.is_out;
    symbol->type = expressions_.types().declared_type(v);
    const Type& type = symbol->type;
    if (type.is(Base::kVoid) || (v.is_out && (type.is_attributes() || type.is_handle()))) {
        sink_->report(v.type.span, diag::kBadDeclaration,
                      fmt::format("{} parameter cannot have type `{}`", v.is_out ? "an `out`" : "a",
                                  v.type.text));
        symbol->type = {};
    } else if (v.init != nullptr && v.is_out) {
        sink_->report(v.init->span, diag::kBadDeclaration, "an `out` parameter has no default");
    } else if (v.init != nullptr && !type.is_error()) {
        place_.context = StageContext::kGlobal;
        auto fallback = std::make_unique<Symbol>();
        fallback->kind = SymbolKind::kConstant;
        fallback->name = v.name;
        fallback->span = v.span;
        fallback->type = type;
        fallback->init = expressions_.initializers().of(*v.init, type);
        symbol->fallback = std::move(fallback);
    }
    return symbol;
}

void Declarations::declare_functions(const std::vector<ast::Function>& from,
                                     std::vector<std::unique_ptr<Function>>* to) {
    for (const ast::Function& f : from) {
        auto function = std::make_unique<Function>();
        function->name = f.name;
        function->span = f.span;
        function->return_type = expressions_.types().declared_type(f.return_type);
        if (function->return_type.is_attributes()) {
            sink_->report(f.return_type.span, diag::kBadDeclaration,
                          fmt::format("a function cannot return `{}`", f.return_type.text));
            function->return_type = {};
        }
        for (const ast::Variable& v : f.parameters)
            function->parameters.push_back(parameter(v));
        check_defaults_order(*function, sink_);
        for (const Function* known : names_.functions()) {
            if (known->name != f.name || !same_parameters(*known, *function)) continue;
            sink_->report(f.span, diag::kRedeclared, f.name)
                .note(known->span, "the first one is here, with the same parameters");
        }
        names_.record_use(function->span, *function);
        names_.add(function.get());
        to->push_back(std::move(function));
    }
}

void Declarations::check_bodies(const std::vector<ast::Function>& from,
                                const std::vector<std::unique_ptr<Function>>& to) {
    const size_t first = to.size() - from.size();  // those of modules come first
    for (size_t i = 0; i < from.size(); ++i) {
        place_.context = StageContext::kFunction;
        unknown_.begin_body();
        Function& function = *to[first + i];
        place_.function = &function;
        names_.open();
        for (const auto& p : function.parameters)
            names_.declare(p.get());
        function.body = statements_.function(*from[i].body, function.return_type);
        names_.close();
        place_.function = nullptr;
    }
}

void Declarations::declare_enum(const ast::Enum& from,
                                std::vector<std::unique_ptr<Symbol>>* constants) {
    place_.context = StageContext::kGlobal;
    auto type = std::make_unique<Symbol>();
    type->kind = SymbolKind::kType;
    type->name = from.name;
    type->span = from.span;
    type->is_const = true;
    type->type = kIntType;
    if (!find_type(from.name).is_error()) {
        sink_
            ->report(from.span, diag::kBadDeclaration,
                     fmt::format("`{}` is a built-in type", from.name))
            .help("give the enum another name");
        return;
    }
    if (from.items.empty()) {
        sink_->report(from.span, diag::kBadDeclaration,
                      fmt::format("enum `{}` has no names", from.name));
    }
    if (from.items.size() > kMaxNames) {
        sink_->report(from.span, diag::kTooComplex,
                      fmt::format("enum `{}` has more than {} names", from.name, kMaxNames));
        return;
    }
    names_.declare(type.get());
    int64_t next = 0;
    for (const ast::Variable& item : from.items) {
        auto symbol = std::make_unique<Symbol>();
        symbol->kind = SymbolKind::kConstant;
        symbol->name = item.name;
        symbol->span = item.span;
        symbol->is_const = true;
        symbol->type = kIntType;
        if (item.init != nullptr)
            next = expressions_.types()
                       .constant_int(*item.init, "the value of an enum's name")
                       .value_or(0);
        if (next > INT32_MAX) {
            sink_->report(item.span, diag::kNarrowing, std::to_string(next), "int");
            next = 0;
        }
        const auto bits = static_cast<uint32_t>(static_cast<int32_t>(next));
        symbol->init = make(ExprKind::kConstant, kIntType, item.span);
        symbol->init->bits = bits;
        symbol->known = bits;
        const std::string label = label_of(item);
        const Choice* known = label.empty() ? nullptr : find_choice(type->choices, label);
        if (known != nullptr)
            sink_->report(item.span, diag::kBadDeclaration,
                          fmt::format("`{}` already stands for `{}`", label, known->name));
        type->choices.push_back({std::string(item.name),
                                 label.empty() ? std::string(item.name) : label,
                                 static_cast<int32_t>(next)});
        ++next;
        names_.declare(symbol.get());
        constants->push_back(std::move(symbol));
    }
    expressions_.types().keep(std::move(type));
}

void check_recursion(const std::vector<std::unique_ptr<Function>>& functions, diag::Sink* sink) {
    std::map<const Function*, Visit> visits;
    for (const auto& f : functions) {
        if (visits.count(f.get()) == 0) visit_calls(f.get(), &visits, sink);
    }
}

}  // namespace openfab::check
