// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The answers to an editor's questions about a document. Each writes the result of one request of the Language Server
// Protocol as JSON; none reads or writes anything else.

#include <optional>
#include <string>
#include <string_view>

#include "base/json_text.h"
#include "base/result.h"
#include "compiler/server/workspace.h"

namespace openfab::server {

/// A question: a document, and a byte of it where there is one.
struct Query {
    Workspace* workspace = nullptr;
    Document* document = nullptr;
    const Analysis* analysis = nullptr;
    uint32_t offset = 0;

    Range range(uint32_t begin, uint32_t end) const {
        return document->text.range(begin, end, workspace->encoding);
    }
    void write_range(JsonText* out, uint32_t begin, uint32_t end) const {
        workspace->write(out, range(begin, end));
    }
};

// hover.cpp
void hover(const Query& query, JsonText* out);
/// Returns what is known of a name, as Markdown.
std::string describe(const Analysis& analysis, const check::Use& use);

// completion.cpp
void complete(const Query& query, JsonText* out);
void signature_help(const Query& query, JsonText* out);

// structure.cpp
void document_symbols(const Query& query, JsonText* out);
void semantic_tokens(const Query& query, JsonText* out);
/// Writes the names that the numbers in semantic tokens stand for.
void semantic_legend(JsonText* out);

// edits.cpp
void diagnostics(const Query& query, JsonText* out);
void definition(const Query& query, JsonText* out);
void references(const Query& query, bool with_declaration, JsonText* out);
/// Writes the range of the name that can be renamed, or the reason why it cannot.
Result<void> prepare_rename(const Query& query, JsonText* out);
/// Writes the edits of a renaming that keeps the meaning of every other name.
Result<void> rename(const Query& query, const std::string& name, JsonText* out);
/// Writes the fixes of messages that touch a range of bytes.
void code_actions(const Query& query, uint32_t begin, uint32_t end, JsonText* out);
/// Writes the edit that formats the document, none if it has syntax errors.
void formatting(const Query& query, JsonText* out);

// colors.cpp
void colors(const Query& query, JsonText* out);
void color_presentations(const Query& query, double red, double green, double blue, uint32_t begin,
                         uint32_t end, JsonText* out);

}  // namespace openfab::server
