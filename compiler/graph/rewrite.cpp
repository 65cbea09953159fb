// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/graph/rewrite.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "compiler/check/builtins.h"
#include "compiler/format/format.h"

namespace openfab::graph {

namespace {

std::vector<syntax::Token> lexed(source::SourceManager* sources, const std::string& text,
                                 bool* fine) {
    diag::Sink sink;
    std::vector<syntax::Token> tokens = syntax::lex(*sources, sources->add("text", text), &sink);
    *fine = sink.errors() == 0;
    return tokens;
}

bool opens(const syntax::Token& t) {
    return t.is("(") || t.is("[") || t.is("{");
}
bool closes(const syntax::Token& t) {
    return t.is(")") || t.is("]") || t.is("}");
}

/// Whether the first token's bracket ends with the last token.
bool is_bracketed(const std::vector<syntax::Token>& tokens) {
    if (tokens.size() < 3 || !tokens[0].is("(")) return false;
    int depth = 0;
    for (size_t i = 0; i + 1 < tokens.size(); ++i) {
        depth += opens(tokens[i]) ? 1 : closes(tokens[i]) ? -1 : 0;
        if (depth == 0) return i + 2 == tokens.size();
    }
    return false;
}

struct Comment {
    uint32_t begin = 0;
    std::string text;
};

std::vector<Comment> comments_of(std::string_view text) {
    std::vector<Comment> found;
    for (size_t i = 0; i + 1 < text.size(); ++i) {
        if (text[i] == '"') {
            for (++i; i < text.size() && text[i] != '"' && text[i] != '\n'; ++i)
                i += text[i] == '\\' ? 1 : 0;
            continue;
        }
        const bool line = text.substr(i, 2) == "//", block = text.substr(i, 2) == "/*";
        if (!line && !block) continue;
        const size_t end = line ? text.find('\n', i) : text.find("*/", i + 2);
        const size_t past = end == std::string_view::npos ? text.size() : line ? end : end + 2;
        found.push_back({static_cast<uint32_t>(i), std::string(text.substr(i, past - i))});
        i = past - 1;
    }
    return found;
}

/// A comment that can stand within a line.
std::string as_block(const std::string& comment) {
    if (comment.starts_with("/*")) return comment;
    if (comment.find("*/") != std::string::npos) return "\n" + comment + "\n";
    const size_t last = comment.find_last_not_of(" \t\r");
    return "/*" + comment.substr(2, last - 1) + " */";
}

}  // namespace

bool is_operand(const std::string& text) {
    source::SourceManager sources;
    bool fine = false;
    const std::vector<syntax::Token> tokens = lexed(&sources, text, &fine);
    int depth = 0;
    for (size_t i = 0; i + 1 < tokens.size(); ++i) {
        const syntax::Token& t = tokens[i];
        if (closes(t)) --depth;
        const bool operates = t.kind == syntax::TokenKind::kPunct && !opens(t) && !closes(t) &&
                              !t.is(".") && !t.is(",");
        if (depth == 0 && operates) return false;
        if (opens(t)) ++depth;
    }
    return fine;
}

namespace {

/// Returns what is wrong with brackets, or an empty text.
std::string why_no_brackets(const std::vector<syntax::Token>& tokens) {
    std::vector<char> open;
    for (const syntax::Token& t : tokens) {
        if (opens(t)) open.push_back(t.text[0]);
        if (!closes(t)) continue;
        const char wanted = t.is(")") ? '(' : t.is("]") ? '[' : '{';
        if (open.empty() || open.back() != wanted) return "the brackets do not match";
        open.pop_back();
    }
    return open.empty() ? "" : "the brackets do not match";
}

}  // namespace

std::string why_no_expression(const std::string& text) {
    source::SourceManager sources;
    bool fine = false;
    const std::vector<syntax::Token> tokens = lexed(&sources, text, &fine);
    if (!fine) return "this has characters that OpenFL has not";
    if (tokens.size() < 2) return "a value is missing";
    if (text.find("//") != std::string::npos || text.find("/*") != std::string::npos)
        return "a comment belongs in the text";
    const bool ends =
        std::any_of(tokens.begin(), tokens.end(), [](const syntax::Token& t) { return t.is(";"); });
    return ends ? "an expression has no `;`" : why_no_brackets(tokens);
}

bool is_name(const std::string& text) {
    source::SourceManager sources;
    bool fine = false;
    const std::vector<syntax::Token> tokens = lexed(&sources, text, &fine);
    return fine && tokens.size() == 2 && tokens[0].kind == syntax::TokenKind::kIdentifier &&
           tokens[0].text == text && check::find_type(text).is_error();
}

Rewrite::Rewrite(const server::Analysis& analysis) : analysis_(analysis) {
    for (const syntax::Token& token : analysis.tokens())
        taken_.insert(std::string(token.text));
    for (const check::Function* f : analysis.functions(""))
        taken_.insert(f->name);
    for (const std::string& name : check::function_names())
        taken_.insert(name);
}

void Rewrite::replace(const source::Span& span, const std::string& text) {
    std::erase_if(changes_, [&](const Change& one) {
        return one.begin >= span.begin && one.end <= span.end &&
               (one.begin < one.end || (one.begin > span.begin && one.begin < span.end));
    });
    changes_.push_back({span.begin, span.end, text});
}

void Rewrite::remove_line(uint32_t begin, uint32_t end) {
    const std::string_view all = analysis_.sources().text(server::Analysis::kDocument);
    const size_t next = all.find_first_not_of(" \t\r", end);
    const bool whole = next != std::string_view::npos && all[next] == '\n';
    remove({server::Analysis::kDocument, begin, whole ? static_cast<uint32_t>(next + 1) : end});
}

void Rewrite::insert(uint32_t at, const std::string& text) {
    changes_.push_back({at, at, text});
}

std::string Rewrite::text(const source::Span& span) const {
    std::vector<const Change*> inside;
    for (const Change& one : changes_) {
        if (one.begin >= span.begin && one.end <= span.end) inside.push_back(&one);
    }
    // What is inserted at a place comes before what is replaced from there on.
    std::stable_sort(inside.begin(), inside.end(), [](const Change* a, const Change* b) {
        return a->begin != b->begin ? a->begin < b->begin
                                    : (a->begin == a->end) > (b->begin == b->end);
    });
    const std::string_view all = analysis_.sources().text(server::Analysis::kDocument);
    std::string out;
    uint32_t at = span.begin;
    for (const Change* one : inside) {
        if (one->begin < at) continue;  // inside of what was replaced before
        out += all.substr(at, one->begin - at);
        out += one->text;
        at = one->end;
    }
    return out + std::string(all.substr(at, span.end - at));
}

std::string Rewrite::expression(const source::Span& span) const {
    std::string out = text(span);
    while (true) {
        source::SourceManager sources;
        bool fine = false;
        const std::vector<syntax::Token> tokens = lexed(&sources, out, &fine);
        if (!fine || !is_bracketed(tokens)) return out;
        const uint32_t begin = tokens[0].span.end;
        const uint32_t end = tokens[tokens.size() - 2].span.begin;
        // A comment inside is no reason for the brackets, but it stays.
        out = out.substr(0, tokens[0].span.begin) + out.substr(begin, end - begin) +
              out.substr(end + 1);
    }
}

std::string Rewrite::fresh_name(std::string base) {
    if (!is_name(base)) base = "value";
    std::string name = base;
    for (int n = 2; taken_.contains(name) || !is_name(name); ++n)
        name = fmt::format("{}{}", base, n);
    taken_.insert(name);
    return name;
}

Result<std::string> Rewrite::with_fresh_names(const std::string& statements) {
    source::SourceManager sources;
    bool fine = false;
    const std::vector<syntax::Token> tokens = lexed(&sources, statements, &fine);
    if (!fine) return user_error("this has characters that OpenFL has not");
    if (tokens.size() < 2) return user_error("there is nothing to paste");
    if (const std::string wrong = why_no_brackets(tokens); !wrong.empty()) return user_error(wrong);
    std::map<std::string, std::string> names;
    for (size_t i = 0; i + 2 < tokens.size(); ++i) {
        const bool declares = !check::find_type(tokens[i].text).is_error() &&
                              tokens[i + 1].kind == syntax::TokenKind::kIdentifier &&
                              (tokens[i + 2].is("=") || tokens[i + 2].is(";") ||
                               tokens[i + 2].is("[") || tokens[i + 2].is(","));
        const std::string name(tokens[i + 1].text);
        if (declares && !names.contains(name)) names[name] = fresh_name(name);
    }
    std::string out;
    uint32_t at = 0;
    for (size_t i = 0; i + 1 < tokens.size(); ++i) {
        const syntax::Token& t = tokens[i];
        const auto other = names.find(std::string(t.text));
        // A member has the name of nothing here.
        const bool member = i > 0 && tokens[i - 1].is(".");
        if (t.kind != syntax::TokenKind::kIdentifier || other == names.end() || member) continue;
        out += statements.substr(at, t.span.begin - at) + other->second;
        at = t.span.end;
    }
    return out + statements.substr(at);
}

void Rewrite::import(const std::string& module) {
    const ast::File& file = analysis_.tree();
    const bool known = std::any_of(file.imports.begin(), file.imports.end(),
                                   [&](const ast::Import& one) { return one.name == module; });
    if (known) return;
    const std::string line = "import " + module + ";\n";
    if (file.imports.empty()) {
        insert(analysis_.tokens().front().span.begin, line + "\n");
        return;
    }
    // Behind the `;` of the last that comes before it by name, else before the first.
    const ast::Import* before = nullptr;
    for (const ast::Import& one : file.imports) {
        if (one.name < module) before = &one;
    }
    const std::vector<syntax::Token>& tokens = analysis_.tokens();
    if (before == nullptr) {
        const size_t name = analysis_.token_at(file.imports.front().span.begin);
        insert(tokens[name - 1].span.begin, line);
        return;
    }
    size_t end = analysis_.token_at(before->span.begin);
    while (end + 1 < tokens.size() && !tokens[end].is(";"))
        ++end;
    insert(tokens[end].span.end, "\n" + line);
}

/// What an expression is replaced by keeps the comments that stood inside of it; those of statements that are removed go.
void Rewrite::keep_comments() {
    const std::string_view all = analysis_.sources().text(server::Analysis::kDocument);
    const auto size = static_cast<uint32_t>(all.size());
    std::multiset<std::string> there;
    for (Comment& comment : comments_of(text({server::Analysis::kDocument, 0, size})))
        there.insert(std::move(comment.text));
    for (const Comment& comment : comments_of(all)) {
        const auto still = there.find(comment.text);
        if (still != there.end()) {
            there.erase(still);
            continue;
        }
        Change* of = nullptr;  // the outermost
        for (Change& one : changes_) {
            if (one.begin <= comment.begin && comment.begin < one.end &&
                (of == nullptr || one.end - one.begin > of->end - of->begin))
                of = &one;
        }
        if (of == nullptr || of->text.empty()) continue;
        const std::string kept = as_block(comment.text);
        of->text = of->text.find("//") == std::string::npos && of->text.back() != '\n'
                       ? of->text + " " + kept
                       : kept + " " + of->text;
    }
}

Result<std::string> Rewrite::made() {
    keep_comments();
    const auto size =
        static_cast<uint32_t>(analysis_.sources().text(server::Analysis::kDocument).size());
    const std::string changed = text({server::Analysis::kDocument, 0, size});
    source::SourceManager sources;
    diag::Sink sink;
    const Result<std::string> formatted =
        format::format(sources, sources.add("document", changed), &sink);
    if (formatted) return formatted;
    if (formatted.error().code == ErrorCode::kInternal) return formatted.error();
    const std::vector<diag::Diagnostic> found = sink.sorted();
    return user_error(found.empty() ? formatted.error().text() : found.front().message);
}

}  // namespace openfab::graph
