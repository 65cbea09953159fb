// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/names.h"

#include <algorithm>

#include "compiler/check/names.h"

namespace openfab::check {

const Symbol* Names::find(std::string_view name) const {
    for (auto scope = scopes_.rbegin(); scope != scopes_.rend(); ++scope) {
        const auto entry = scope->find(name);
        if (entry != scope->end()) return entry->second;
    }
    return nullptr;
}

bool Names::is_type(std::string_view name) const {
    const Symbol* symbol = find(name);
    if (symbol != nullptr) return symbol->kind == SymbolKind::kType;
    return !find_type(name).is_error();
}

/// Returns the attributes of the stage or function, or null.
const Symbol* Names::attributes() const {
    for (const Scope& scope : scopes_) {
        for (const auto& [text, symbol] : scope) {
            if (symbol->type.is_attributes()) return symbol;
        }
    }
    return nullptr;
}

std::vector<const Function*> Names::overloads(std::string_view name) const {
    std::vector<const Function*> out;
    for (const Function* f : functions_) {
        if (f->name == name) out.push_back(f);
    }
    const size_t own = out.size();
    for (const Function* f : imported_) {
        if (f->name != name) continue;
        const bool hidden = std::any_of(out.begin(), out.begin() + static_cast<ptrdiff_t>(own),
                                        [&](const Function* o) { return same_parameters(*o, *f); });
        if (!hidden) out.push_back(f);
    }
    return out;
}

/// Returns whether a name is imported and the file has functions of that name, which come first.
bool Names::is_hidden_by_function(const Symbol& symbol) const {
    const auto imported = scopes_.front().find(symbol.name);
    return imported != scopes_.front().end() && imported->second == &symbol &&
           std::any_of(functions_.begin(), functions_.end(),
                       [&](const Function* f) { return f->name == symbol.name; });
}

void Names::record_use(const source::Span& at, const Symbol& symbol) {
    if (uses_ == nullptr || at.file == 0) return;
    uses_->names.push_back({at, symbol.span, UseKind::kSymbol, symbol.kind, symbol.name,
                            symbol.type, symbol.is_const, nullptr});
}

void Names::record_use(const source::Span& at, const Function& function) {
    if (uses_ == nullptr) return;
    uses_->names.push_back({at, function.span, UseKind::kFunction, SymbolKind::kLocal,
                            function.name, function.return_type, true, &function});
}

void Names::record_use(const source::Span& at, const StructMember& member) {
    if (uses_ == nullptr) return;
    uses_->names.push_back({at, member.span, UseKind::kMember, SymbolKind::kLocal, member.name,
                            member.type, false, nullptr});
}

bool Names::declare(const Symbol* symbol) {
    record_use(symbol->span, *symbol);
    const auto [known, fresh] = scopes_.back().emplace(symbol->name, symbol);
    if (!fresh) {
        diag::Diagnostic& d = sink_->report(symbol->span, diag::kRedeclared, symbol->name);
        if (known->second->span.file != 0) d.note(known->second->span, "the first one is here");
    }
    return fresh;
}

void Names::begin_file() {
    scopes_.assign(1, {});
    functions_.clear();
    imported_.clear();
    private_.clear();
}

const std::string* Names::private_module(std::string_view name) const {
    const auto known = private_.find(name);
    return known == private_.end() ? nullptr : &known->second;
}

}  // namespace openfab::check
