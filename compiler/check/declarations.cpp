// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>

#include "compiler/check/checker.h"

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

using Names = std::set<std::string_view>;

bool mentions(const ast::Expr* expr, const Names& names) {
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

}  // namespace

/// Structs and constants may depend on each other and are checked in source order; functions may be
/// declared anywhere. Whatever may use a uniform or a function is therefore checked later.
void Checker::check_scope(const ast::Scope& from, const ast::Fablet* fablet, Fablet* to,
                          std::vector<std::unique_ptr<Symbol>>* constants,
                          std::vector<std::unique_ptr<Function>>* functions) {
    Names later;
    for (const ast::Function& f : from.functions)
        later.insert(f.name);
    if (fablet != nullptr) {
        for (const ast::Variable& v : fablet->uniforms)
            later.insert(v.name);
    }
    std::vector<const ast::Variable*> late;
    for (const Item& item : items_of(from)) {
        if (item.record != nullptr) {
            declare_struct(*item.record);
        } else if (item.names != nullptr) {
            declare_enum(*item.names, constants);
        } else if (mentions(item.constant->init.get(), later)) {
            later.insert(item.constant->name);
            late.push_back(item.constant);
        } else {
            check_constant(*item.constant, constants);
        }
    }
    if (fablet != nullptr) {
        for (const ast::Variable& v : fablet->uniforms)
            check_uniform(v, to);
    }
    declare_functions(from.functions, functions);
    for (const ast::Variable* v : late)
        check_constant(*v, constants);
    check_functions(from.functions, *functions);
}

void Checker::check_constant(const ast::Variable& v, std::vector<std::unique_ptr<Symbol>>* to) {
    context_ = StageContext::kGlobal;
    auto symbol = std::make_unique<Symbol>();
    symbol->kind = SymbolKind::kConstant;
    symbol->name = v.name;
    symbol->span = v.span;
    symbol->is_const = true;
    symbol->type = declared_type(v);
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
        symbol->init = initializer(*v.init, symbol->type);
        if (symbol->init->type.is_error()) {
            symbol->type = {};
        } else {
            symbol->known = known_bits(*symbol->init);
        }
    }
    declare(symbol.get());
    to->push_back(std::move(symbol));
}

std::unique_ptr<Symbol> Checker::parameter(const ast::Variable& v) {
    auto symbol = std::make_unique<Symbol>();
    symbol->kind = SymbolKind::kParameter;
    symbol->name = v.name;
    symbol->span = v.span;
    symbol->is_const = v.is_const;
    symbol->is_in = v.is_in || !v.is_out;
    symbol->is_out = v.is_out;
    symbol->type = declared_type(v);
    const Type& type = symbol->type;
    if (type.is(Base::kVoid) || (v.is_out && (type.is_attributes() || type.is_handle()))) {
        sink_->report(v.type.span, diag::kBadDeclaration,
                      fmt::format("{} parameter cannot have type `{}`", v.is_out ? "an `out`" : "a",
                                  v.type.text));
        symbol->type = {};
    } else if (v.init != nullptr && v.is_out) {
        sink_->report(v.init->span, diag::kBadDeclaration, "an `out` parameter has no default");
    } else if (v.init != nullptr && !type.is_error()) {
        context_ = StageContext::kGlobal;
        auto fallback = std::make_unique<Symbol>();
        fallback->kind = SymbolKind::kConstant;
        fallback->name = v.name;
        fallback->span = v.span;
        fallback->type = type;
        fallback->init = initializer(*v.init, type);
        symbol->fallback = std::move(fallback);
    }
    return symbol;
}

void Checker::declare_functions(const std::vector<ast::Function>& from,
                                std::vector<std::unique_ptr<Function>>* to) {
    for (const ast::Function& f : from) {
        auto function = std::make_unique<Function>();
        function->name = f.name;
        function->span = f.span;
        function->return_type = declared_type(f.return_type);
        if (function->return_type.is_attributes()) {
            sink_->report(f.return_type.span, diag::kBadDeclaration,
                          fmt::format("a function cannot return `{}`", f.return_type.text));
            function->return_type = {};
        }
        for (const ast::Variable& v : f.parameters)
            function->parameters.push_back(parameter(v));
        check_defaults_order(*function, sink_);
        for (const Function* known : visible_functions_) {
            if (known->name != f.name || !same_parameters(*known, *function)) continue;
            sink_->report(f.span, diag::kRedeclared, f.name)
                .note(known->span, "the first one is here, with the same parameters");
        }
        record_use(function->span, *function);
        visible_functions_.push_back(function.get());
        to->push_back(std::move(function));
    }
}

void Checker::check_functions(const std::vector<ast::Function>& from,
                              const std::vector<std::unique_ptr<Function>>& to) {
    const size_t first = to.size() - from.size();  // those of modules come first
    for (size_t i = 0; i < from.size(); ++i) {
        context_ = StageContext::kFunction;
        unknown_names_.clear();
        function_ = to[first + i].get();
        return_type_ = function_->return_type;
        loops_ = switches_ = 0;
        scopes_.emplace_back();
        for (const auto& p : function_->parameters)
            declare(p.get());
        // Parameters and the body share one scope, as in HLSL.
        function_->body = std::make_unique<Stmt>();
        function_->body->span = from[i].body->span;
        for (const ast::StmtPtr& child : from[i].body->body) {
            if (child->kind == ast::StmtKind::kDeclaration) {
                declaration(*child, &function_->body->body);
            } else {
                function_->body->body.push_back(statement(*child));
            }
        }
        scopes_.pop_back();
        function_ = nullptr;
    }
}

namespace {

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

void Checker::check_recursion(const std::vector<std::unique_ptr<Function>>& functions) {
    std::map<const Function*, Visit> visits;
    for (const auto& f : functions) {
        if (visits.count(f.get()) == 0) visit_calls(f.get(), &visits, sink_);
    }
}

}  // namespace openfab::check
