// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "compiler/format/format.h"
#include "compiler/server/answers.h"

namespace openfab::server {

namespace {

bool same_entity(const check::Use& a, const check::Use& b) {
    return a.declared == b.declared && a.declared.file != 0;
}

/// Returns the places of a name, each once, in order.
std::vector<source::Span> places_of(const Analysis& analysis, const check::Use& use) {
    std::map<std::pair<uint32_t, uint32_t>, source::Span> out;
    for (const check::Use& other : analysis.names()) {
        if (same_entity(use, other)) out[{other.span.file, other.span.begin}] = other.span;
    }
    std::vector<source::Span> list;
    for (const auto& [at, span] : out)
        list.push_back(span);
    return list;
}

bool is_valid_name(const std::string& name) {
    source::SourceManager sources;
    diag::Sink sink;
    const std::vector<syntax::Token> tokens =
        syntax::lex(sources, sources.add("name", name), &sink);
    return tokens.size() == 2 && sink.errors() == 0 &&
           tokens[0].kind == syntax::TokenKind::kIdentifier && tokens[0].text == name &&
           check::find_type(name).is_error();
}

void write_edit(const Query& query, uint32_t begin, uint32_t end, const std::string& text,
                JsonText* out) {
    out->begin_object().key("range");
    query.write_range(out, begin, end);
    out->member("newText", text).end_object();
}

/// Returns why a name cannot be renamed; empty if it can.
std::string fixed_name(const Analysis& analysis, const check::Use* use) {
    if (use == nullptr || use->declared.file == 0)
        return "there is no name here that can be renamed";
    if (use->declared.file != Analysis::kDocument)
        return fmt::format("`{}` is declared in another file: rename it there", use->name);
    const bool varying = use->symbol == check::SymbolKind::kSurfaceInput ||
                         use->symbol == check::SymbolKind::kSurfaceOutput ||
                         use->symbol == check::SymbolKind::kShapeOutput ||
                         use->symbol == check::SymbolKind::kNearest;
    bool is_varying = use->kind == check::UseKind::kSymbol && varying;
    // A member of a SurfacePoint is declared by a varying.
    for (const check::Use& other : analysis.names()) {
        const bool symbol =
            other.kind == check::UseKind::kSymbol && other.symbol == check::SymbolKind::kNearest;
        is_varying = is_varying || (symbol && same_entity(*use, other));
    }
    if (is_varying) return "the name of a varying ties meshes and stages together";
    // What stands in an expression with an error is not known.
    const std::vector<diag::Diagnostic> found = analysis.diagnostics();
    if (std::any_of(found.begin(), found.end(),
                    [](const diag::Diagnostic& d) { return d.severity == diag::Severity::kError; }))
        return "names can be renamed once the document has no errors";
    return {};
}

const char* const kVersionless = "changes";

void write_diagnostic(const Query& query, const diag::Diagnostic& d, JsonText* out) {
    const source::SourceManager& sources = query.analysis->reported_sources();
    std::string message = d.message;
    for (const std::string& help : d.helps)
        message += "\nhelp: " + help;
    out->begin_object().key("range");
    query.write_range(out, d.span.begin, d.span.end);
    out->member("severity", d.severity == diag::Severity::kError ? 1 : 2);
    out->member("code", diag::id_text(d.id)).member("source", "openflc").member("message", message);
    if (!d.notes.empty()) {
        out->key("relatedInformation").begin_array();
        for (const diag::Note& note : d.notes) {
            out->begin_object().key("location");
            query.workspace->write_location(out, *query.document, sources, note.span);
            out->member("message", note.message).end_object();
        }
        out->end_array();
    }
    out->end_object();
}

/// Returns a message about another file as one about the import that leads there.
diag::Diagnostic brought_home(const Query& query, diag::Diagnostic d) {
    if (d.span.file == Analysis::kDocument) return d;
    const auto home = std::find_if(d.notes.rbegin(), d.notes.rend(), [](const diag::Note& n) {
        return n.span.file == Analysis::kDocument;
    });
    d.notes.insert(d.notes.begin(), {d.span, d.message});
    const source::SourceManager& sources = query.analysis->reported_sources();
    d.message = fmt::format("in `{}`: {}", sources.name(d.span.file), d.message);
    d.span = home == d.notes.rend() ? source::Span{Analysis::kDocument, 0, 0} : home->span;
    d.fix.clear();
    return d;
}

}  // namespace

void diagnostics(const Query& query, JsonText* out) {
    out->begin_object()
        .member("uri", query.document->uri)
        .member("version", query.document->version);
    out->key("diagnostics").begin_array();
    for (const diag::Diagnostic& d : query.analysis->diagnostics())
        write_diagnostic(query, brought_home(query, d), out);
    out->end_array().end_object();
}

void definition(const Query& query, JsonText* out) {
    const Analysis& analysis = *query.analysis;
    const check::Use* use = analysis.name_at(query.offset);
    source::Span to = use == nullptr ? source::Span{} : use->declared;
    for (const ast::Import& import : analysis.tree().imports) {
        const bool here = import.span.begin <= query.offset && query.offset <= import.span.end;
        if (const auto file = here ? analysis.file_of_import(import) : std::nullopt)
            to = {*file, 0, 0};
    }
    if (to.file == 0) {
        out->null();
        return;
    }
    query.workspace->write_location(out, *query.document, analysis.sources(), to);
}

void references(const Query& query, bool with_declaration, JsonText* out) {
    out->begin_array();
    const check::Use* use = query.analysis->name_at(query.offset);
    if (use != nullptr && use->declared.file != 0) {
        for (const source::Span& at : places_of(*query.analysis, *use)) {
            if (at != use->declared || with_declaration)
                query.workspace->write_location(out, *query.document, query.analysis->sources(),
                                                at);
        }
    }
    out->end_array();
}

Result<void> prepare_rename(const Query& query, JsonText* out) {
    const check::Use* use = query.analysis->name_at(query.offset);
    if (const std::string why = fixed_name(*query.analysis, use); !why.empty())
        return user_error(why);
    query.write_range(out, use->span.begin, use->span.end);
    return {};
}

Result<void> rename(const Query& query, const std::string& name, JsonText* out) {
    const Analysis& analysis = *query.analysis;
    const check::Use* use = analysis.name_at(query.offset);
    if (const std::string why = fixed_name(analysis, use); !why.empty()) return user_error(why);
    if (!is_valid_name(name)) return user_error(fmt::format("`{}` is not a name", name));
    const std::vector<source::Span> places = places_of(analysis, *use);
    // With the new name the program must have the same messages, and the same names must refer to the same.
    std::string text = query.document->text.text();
    uint32_t declared = use->declared.begin;
    const auto growth = static_cast<int64_t>(name.size()) - static_cast<int64_t>(use->name.size());
    for (auto at = places.rbegin(); at != places.rend(); ++at) {
        text.replace(at->begin, at->end - at->begin, name);
        if (at->begin < use->declared.begin) declared = static_cast<uint32_t>(declared + growth);
    }
    const std::unique_ptr<Analysis> after = query.workspace->analyse(*query.document, text);
    const check::Use* renamed = after->name_at(declared);
    const bool same = renamed != nullptr && renamed->declared.begin == declared &&
                      renamed->name == name &&
                      places_of(*after, *renamed).size() == places.size() &&
                      after->names().size() == analysis.names().size() &&
                      after->diagnostics().size() == analysis.diagnostics().size();
    if (!same) return user_error(fmt::format("`{}` would clash with another name", name));
    out->begin_object().key(kVersionless).begin_object().key(query.document->uri).begin_array();
    for (const source::Span& at : places)
        write_edit(query, at.begin, at.end, name, out);
    out->end_array().end_object().end_object();
    return {};
}

void code_actions(const Query& query, uint32_t begin, uint32_t end, JsonText* out) {
    out->begin_array();
    for (const diag::Diagnostic& d : query.analysis->diagnostics()) {
        const bool here =
            d.span.file == Analysis::kDocument && d.span.begin <= end && begin <= d.span.end;
        const bool own = std::all_of(d.fix.begin(), d.fix.end(), [](const diag::Edit& e) {
            return e.span.file == Analysis::kDocument;
        });
        if (!here || d.fix.empty() || !own) continue;
        const diag::Edit& first = d.fix.front();
        const std::string title =
            d.fix.size() == 1 && first.span.begin < first.span.end && !first.text.empty()
                ? fmt::format("Change to `{}`", first.text)
            : d.fix.size() == 1 && !first.text.empty() ? fmt::format("Insert `{}`", first.text)
            : !d.helps.empty()                         ? "Fix: " + d.helps.front()
                                                       : "Fix: " + d.message;
        out->begin_object()
            .member("title", title)
            .member("kind", "quickfix")
            .member("isPreferred", true);
        out->key("diagnostics").begin_array();
        write_diagnostic(query, d, out);
        out->end_array()
            .key("edit")
            .begin_object()
            .key(kVersionless)
            .begin_object()
            .key(query.document->uri);
        out->begin_array();
        for (const diag::Edit& edit : d.fix)
            write_edit(query, edit.span.begin, edit.span.end, edit.text, out);
        out->end_array().end_object().end_object().end_object();
    }
    out->end_array();
}

void formatting(const Query& query, JsonText* out) {
    const std::string& text = query.document->text.text();
    source::SourceManager sources;
    diag::Sink sink;
    const Result<std::string> made = format::format(sources, sources.add("document", text), &sink);
    out->begin_array();
    if (made && *made != text) {
        // One edit of the lines that differ, so that the cursor stays where it can.
        size_t begin = 0;
        const size_t shorter = std::min(text.size(), made->size());
        while (begin < shorter && text[begin] == (*made)[begin])
            ++begin;
        while (begin > 0 && text[begin - 1] != '\n')
            --begin;
        size_t tail = 0;
        while (tail < shorter - begin &&
               text[text.size() - 1 - tail] == (*made)[made->size() - 1 - tail])
            ++tail;
        while (tail > 0 && text[text.size() - tail - 1] != '\n')
            --tail;
        write_edit(query, static_cast<uint32_t>(begin), static_cast<uint32_t>(text.size() - tail),
                   made->substr(begin, made->size() - tail - begin), out);
    }
    out->end_array();
}

}  // namespace openfab::server
