// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/declared_types.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compiler/check/foreign_names.h"
#include "compiler/check/limits.h"

namespace openfab::check {

Type DeclaredTypes::declared_type(const ast::TypeRef& ref) {
    const Symbol* symbol = names_.find(ref.text);
    if (symbol != nullptr && symbol->kind == SymbolKind::kType) {
        names_.record_use(ref.span, *symbol);
        return symbol->type;
    }
    const Type type = find_type(ref.text);
    if (!type.is_error()) return type;
    diag::Diagnostic& d = sink_->report(ref.span, diag::kUnknownType, ref.text);
    if (const std::string help = foreign_type_help(ref.text); !help.empty()) {
        d.help(help);
        const std::string ours = renamed_type(ref.text);
        if (!ours.empty()) d.replace(ref.span, ours);
        return {};
    }
    std::vector<std::string> names = type_names();
    for (const auto& name : declared_)
        names.push_back(name->name);
    d.suggest(ref.span, ref.text, names,
              "OPENFL.md lists the types in section 3: `bool`, `int`, `uint`, `float`, `float3`, "
              "`Material`, `MaterialComposition` and others");
    return {};
}

std::optional<int32_t> DeclaredTypes::constant_int(const ast::Expr& expr, const char* what) {
    const ExprPtr value = conversions_.implicit(expressions_.expression(expr), kIntType);
    if (value->type.is_error()) return std::nullopt;
    const std::optional<uint32_t> bits = known_bits(*value);
    if (!bits) {
        sink_->report(expr.span, diag::kNotConstant, what);
        return std::nullopt;
    }
    return static_cast<int32_t>(*bits);
}

/// Returns an array's extent: `written`, or as many as the list `counted` has, if it is one.
std::optional<int> DeclaredTypes::extent(const ast::Expr* written, std::string_view name,
                                         const source::Span& brackets, const ast::Expr* counted) {
    std::optional<int32_t> count;
    if (written != nullptr) {
        count = constant_int(*written, "the size of an array");
        if (!count) return std::nullopt;
    } else if (counted != nullptr && counted->kind == ast::ExprKind::kInitList) {
        count = static_cast<int32_t>(counted->args.size());
    } else {
        sink_->report(brackets, diag::kBadDeclaration, fmt::format("array `{}` has no size", name))
            .help("only the outermost size can be left out, and only with an initializer list");
        return std::nullopt;
    }
    if (*count < 1 || *count > kMaxComponents) {
        sink_->report(written != nullptr ? written->span : brackets, diag::kOutOfRange,
                      "array size", *count, 1, kMaxComponents);
        return std::nullopt;
    }
    return *count;
}

Type DeclaredTypes::declared_type(const ast::Variable& v) {
    return v.extents.empty() ? declared_type(v.type)
                             : array_type(v.type, v.name, v.extents, v.array_span, v.init.get());
}

Type DeclaredTypes::array_type(const ast::TypeRef& of, std::string_view name,
                               std::span<const ast::ExprPtr> extents, const source::Span& brackets,
                               const ast::Expr* init) {
    Type type = declared_type(of);
    if (type.is_error()) return type;
    if (type == kVoidType || type.is_attributes()) {
        sink_->report(of.span, diag::kBadDeclaration,
                      fmt::format("an array cannot have elements of type `{}`", of.text));
        return {};
    }
    if (extents.size() > static_cast<size_t>(kMaxDimensions)) {
        sink_->report(brackets, diag::kTooComplex,
                      fmt::format("an array has at most {} dimensions", kMaxDimensions));
        return {};
    }
    for (size_t i = extents.size(); i-- > 0;) {
        const std::optional<int> count =
            extent(extents[i].get(), name, brackets, i == 0 ? init : nullptr);
        if (!count) return {};
        type = array_of(type, *count);
        if (min_components(type) > kMaxComponents) {
            sink_->report(brackets, diag::kTooComplex,
                          fmt::format("`{}` has more than {} components", name, kMaxComponents));
            return {};
        }
    }
    return type;
}

/// An invalid struct is declared all the same, as an error type.
void DeclaredTypes::declare_struct(const ast::Struct& from) {
    auto record = std::make_unique<StructType>();
    record->name = from.name;
    record->span = from.span;
    bool ok = true;
    for (const ast::Variable& v : from.members) {
        const Type type = declared_type(v);
        const auto known = std::find_if(record->members.begin(), record->members.end(),
                                        [&](const StructMember& m) { return m.name == v.name; });
        if (known != record->members.end()) {
            sink_->report(v.span, diag::kRedeclared, v.name)
                .note(known->span, "the first one is here");
        } else if (type == kVoidType || type.is_attributes()) {
            sink_->report(v.type.span, diag::kBadDeclaration,
                          fmt::format("a member cannot have type `{}`", v.type.text));
            ok = false;
        } else if (v.init != nullptr) {
            sink_
                ->report(v.init->span, diag::kBadDeclaration, "a member cannot have an initializer")
                .help("initialize the variable: `{ … }` with a value for each member");
        } else {
            record->members.push_back({std::string(v.name), type, v.span});
            names_.record_use(v.span, record->members.back());
        }
    }
    if (!find_type(from.name).is_error()) {
        sink_
            ->report(from.span, diag::kBadDeclaration,
                     fmt::format("`{}` is a built-in type", from.name))
            .help("give the struct another name");
        return;
    }
    if (from.members.empty()) {
        sink_->report(from.span, diag::kBadDeclaration,
                      fmt::format("struct `{}` has no members", from.name));
        ok = false;
    }
    Type type{Base::kStruct, 1};
    type.record = record.get();
    if (ok && min_components(type) > kMaxComponents) {
        sink_->report(from.span, diag::kTooComplex,
                      fmt::format("`{}` has more than {} components", from.name, kMaxComponents));
        ok = false;
    }
    auto symbol = std::make_unique<Symbol>();
    symbol->kind = SymbolKind::kType;
    symbol->name = from.name;
    symbol->span = from.span;
    symbol->is_const = true;
    if (ok) symbol->type = type;
    names_.declare(symbol.get());
    declared_.push_back(std::move(symbol));
    structs_.push_back(std::move(record));
}

}  // namespace openfab::check
