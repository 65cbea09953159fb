// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Scopes and functions: what a name means at a place. Each use is recorded for editors.

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/check/tree.h"
#include "compiler/check/uses.h"
#include "compiler/diag/sink.h"

namespace openfab::check {

class Names {
  public:
    using Scope = std::map<std::string, const Symbol*, std::less<>>;

    /// `uses` may be null.
    Names(diag::Sink* sink, Uses* uses) : sink_(sink), uses_(uses) {}

    /// Begins a file with one scope, that of its imports.
    void begin_file();
    void open() { scopes_.emplace_back(); }
    void close() { scopes_.pop_back(); }
    /// From the outermost, that of the imports.
    const std::vector<Scope>& scopes() const { return scopes_; }
    Scope& imports() { return scopes_.front(); }

    /// Declares a name in the innermost scope; false after a message.
    bool declare(const Symbol* symbol);
    const Symbol* find(std::string_view name) const;
    bool is_type(std::string_view name) const;
    /// Returns the attributes of the stage or function, or null.
    const Symbol* attributes() const;

    /// The functions of the file, and of the fablet where one is checked.
    const std::vector<const Function*>& functions() const { return functions_; }
    const std::vector<const Function*>& imported() const { return imported_; }
    void add(const Function* function) { functions_.push_back(function); }
    void import(const Function* function) { imported_.push_back(function); }
    /// Forgets the functions from number `size` on.
    void keep_functions(size_t size) { functions_.resize(size); }
    std::vector<const Function*> overloads(std::string_view name) const;
    bool is_hidden_by_function(const Symbol& symbol) const;

    /// Says that a module keeps a name to itself.
    void add_private(std::string name, std::string module) {
        private_.emplace(std::move(name), std::move(module));
    }
    /// Returns the imported module that keeps a name to itself, or null.
    const std::string* private_module(std::string_view name) const;

    void record_use(const source::Span& at, const Symbol& symbol);
    void record_use(const source::Span& at, const Function& function);
    void record_use(const source::Span& at, const StructMember& member);
    void record_type(const source::Span& at, const Type& type) {
        if (uses_ != nullptr) uses_->expressions.push_back({at, type});
    }

  private:
    diag::Sink* sink_;
    Uses* uses_;
    std::vector<Scope> scopes_;
    std::vector<const Function*> functions_;
    std::vector<const Function*> imported_;
    std::map<std::string, std::string, std::less<>> private_;
};

}  // namespace openfab::check
