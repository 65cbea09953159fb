// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the compiler knows of one document: its messages, and of all that can be made out, errors or not, which names it
// has, what they refer to, and the types of its expressions.

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/check/check.h"
#include "compiler/diag/sink.h"
#include "compiler/frontend/modules.h"
#include "compiler/source/source_manager.h"
#include "compiler/syntax/token.h"

namespace openfab::server {

/// Texts of files that an editor has open, by absolute path.
using OpenFiles = std::map<std::filesystem::path, std::string>;

class Analysis {
  public:
    /// `path` is the document's file, empty if it has none; modules are looked for beside it.
    Analysis(const std::filesystem::path& path, const std::string& text, const OpenFiles& open);

    /// What the compiler reports, and the sources of these messages, in which the document is file 1.
    std::vector<diag::Diagnostic> diagnostics() const { return found_.sorted(); }
    const source::SourceManager& reported_sources() const;

    /// All names, also of the modules. The document is this file of `sources`.
    static constexpr uint32_t kDocument = 1;
    const source::SourceManager& sources() const { return sources_; }
    const std::vector<check::Use>& names() const { return uses_.names; }
    /// The types of expressions, by place.
    const std::vector<check::Uses::Typed>& typed() const { return uses_.expressions; }
    const check::Program& program() const { return program_; }
    const std::vector<syntax::Token>& tokens() const { return tokens_; }
    const ast::File& tree() const { return *units().back().file; }
    const std::vector<check::Unit>& units() const { return *units_; }

    /// Returns the name at a byte of the document, or just before it.
    const check::Use* name_at(uint32_t offset) const;
    /// Returns the token at a byte, or that ends there; the last if there is none.
    size_t token_at(uint32_t offset) const;
    /// Returns the token before a byte; `tokens().size()` if there is none.
    size_t token_before(uint32_t offset) const;
    /// Returns the bracket that matches one; the last token if there is none.
    size_t matching(size_t token) const { return matching_[token]; }
    /// True inside a comment or a string.
    bool in_comment_or_string(uint32_t offset) const;
    /// Returns the type of the longest expression that ends at a byte, if its type is known.
    std::optional<check::Type> type_ending_at(uint32_t offset) const;
    /// Returns the bytes in which a name that is declared at `offset` can be used.
    source::Span scope_of(uint32_t offset) const;
    /// Returns the uniform that is declared at a span, or null.
    const ast::Variable* uniform_at(const source::Span& declared) const;
    /// Returns the functions of this name, or of any if it is empty, that can be called in the document.
    std::vector<const check::Function*> functions(std::string_view name) const;
    /// Returns the import that declares a module, by its file.
    std::optional<uint32_t> file_of_import(const ast::Import& import) const;
    /// True if an other file's name can be used in the document.
    bool is_imported(const source::Span& declared, std::string_view name) const;
    /// Returns the comment directly above the line of a declaration, without its slashes.
    std::string comment_above(const source::Span& declared) const;
    /// Returns the comment at the head of a file, without the licence.
    std::string head_comment(uint32_t file) const;
    std::filesystem::path path_of(uint32_t file) const;

  private:
    void match_brackets();

    source::SourceManager sources_, sources_in_error_;
    diag::Sink found_, lexer_;
    bool stopped_ = false;  ///< the messages are those of `sources_in_error_`
    frontend::Modules modules_{&sources_, &found_, frontend::OnError::kContinue};
    const std::vector<check::Unit>* units_ = nullptr;
    check::Uses uses_;
    check::Program program_;
    std::vector<syntax::Token> tokens_;
    std::vector<size_t> matching_;
};

/// `float3 name(float x, out int n)`
std::string signature(const check::Function& function);
/// Returns the parameters as written in a signature.
std::vector<std::string> parameters(const check::Function& function);

}  // namespace openfab::server
