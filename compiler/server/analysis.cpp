// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/server/analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compiler/frontend/frontend.h"
#include "compiler/translate/translate.h"

namespace openfab::server {

namespace {

bool is_open(const syntax::Token& t) {
    return t.is("(") || t.is("{") || t.is("[");
}
bool is_close(const syntax::Token& t) {
    return t.is(")") || t.is("}") || t.is("]");
}

uint32_t add_document(source::SourceManager* sources, const std::filesystem::path& path,
                      const std::string& text, const OpenFiles& open) {
    for (const auto& [file, content] : open)
        sources->replace(file, content);
    return sources->add(path.empty() ? "document" : path.string(), text, path.parent_path());
}

/// Returns a line of a comment without its slashes; nothing if it is none.
std::optional<std::string> comment_line(std::string_view line) {
    const size_t first = line.find_first_not_of(" \t");
    if (first == std::string_view::npos || line.substr(first, 2) != "//") return std::nullopt;
    line.remove_prefix(first + 2);
    if (line.starts_with(' ')) line.remove_prefix(1);
    return std::string(line);
}

}  // namespace

Analysis::Analysis(const std::filesystem::path& path, const std::string& text,
                   const OpenFiles& open) {
    const uint32_t file = add_document(&sources_, path, text, open);
    tokens_ = syntax::lex(sources_, file, &lexer_);
    units_ = &modules_.load(file);
    program_ = check::check(*units_, {false, &uses_, {}, {}}, &found_);
    if (found_.errors() == 0) {
        translate::translate(program_, {}, &found_);
    } else {
        // The compiler stops at the first step that fails; what the later ones say may follow from that.
        found_ = {};
        stopped_ = true;
        const uint32_t again = add_document(&sources_in_error_, path, text, open);
        frontend::compile_to_ir(sources_in_error_, again, found_, {false});
    }
    match_brackets();
}

const source::SourceManager& Analysis::reported_sources() const {
    return stopped_ ? sources_in_error_ : sources_;
}

void Analysis::match_brackets() {
    matching_.assign(tokens_.size(), tokens_.size() - 1);
    std::vector<size_t> open;
    for (size_t i = 0; i < tokens_.size(); ++i) {
        if (is_open(tokens_[i])) open.push_back(i);
        if (!is_close(tokens_[i])) continue;
        // A closing bracket also ends what was left open inside.
        const char wanted = tokens_[i].text == ")" ? '(' : tokens_[i].text == "]" ? '[' : '{';
        const auto found = std::find_if(open.rbegin(), open.rend(),
                                        [&](size_t at) { return tokens_[at].text[0] == wanted; });
        if (found == open.rend()) continue;
        matching_[*found] = i;
        matching_[i] = *found;
        open.erase(found.base() - 1, open.end());
    }
}

const check::Use* Analysis::name_at(uint32_t offset) const {
    const check::Use* best = nullptr;
    for (const check::Use& use : uses_.names) {
        if (use.span.file != kDocument || offset < use.span.begin || offset > use.span.end)
            continue;
        // Between two names the one that begins here counts.
        if (best == nullptr || use.span.begin > best->span.begin) best = &use;
    }
    return best;
}

size_t Analysis::token_at(uint32_t offset) const {
    size_t at = 0;
    while (at + 1 < tokens_.size() && tokens_[at].span.end < offset)
        ++at;
    // Of two that touch, a word counts.
    const bool next = at + 1 < tokens_.size() && tokens_[at].span.end == offset &&
                      tokens_[at + 1].span.begin == offset;
    return next && tokens_[at].kind == syntax::TokenKind::kPunct ? at + 1 : at;
}

size_t Analysis::token_before(uint32_t offset) const {
    const auto next =
        std::partition_point(tokens_.begin(), tokens_.end() - 1,
                             [&](const syntax::Token& t) { return t.span.end <= offset; });
    return next == tokens_.begin() ? tokens_.size()
                                   : static_cast<size_t>(next - tokens_.begin()) - 1;
}

bool Analysis::in_comment_or_string(uint32_t offset) const {
    const size_t before = token_before(offset);
    const size_t next = before == tokens_.size() ? 0 : before + 1;
    const syntax::Token& token = tokens_[next];
    if (token.kind == syntax::TokenKind::kString && token.span.begin < offset) return true;
    const uint32_t begin = before == tokens_.size() ? 0 : tokens_[before].span.end;
    const std::string_view text = sources_.text(kDocument).substr(0, offset);
    for (size_t at = begin; at + 1 < text.size(); ++at) {
        if (text[at] != '/' || (text[at + 1] != '/' && text[at + 1] != '*')) continue;
        const bool line = text[at + 1] == '/';
        const size_t end = line ? text.find('\n', at) : text.find("*/", at + 2);
        if (end == std::string_view::npos) return true;
        at = end;
    }
    return false;
}

std::optional<check::Type> Analysis::type_ending_at(uint32_t offset) const {
    const check::Uses::Typed* best = nullptr;
    for (const check::Uses::Typed& e : uses_.expressions) {
        if (e.span.file != kDocument || e.span.end != offset) continue;
        if (best == nullptr || e.span.begin <= best->span.begin) best = &e;
    }
    if (best == nullptr || best->type.is_error()) return std::nullopt;
    return best->type;
}

source::Span Analysis::scope_of(uint32_t offset) const {
    const auto size = static_cast<uint32_t>(sources_.text(kDocument).size());
    size_t brace = tokens_.size();
    size_t paren = tokens_.size();
    for (size_t i = 0; i < tokens_.size() && tokens_[i].span.begin <= offset; ++i) {
        if (!is_open(tokens_[i]) || tokens_[matching_[i]].span.begin < offset) continue;
        if (tokens_[i].is("(")) paren = i;
        if (tokens_[i].is("{") && paren == tokens_.size()) brace = i;
    }
    if (paren != tokens_.size()) {
        // Parameters, varyings and the start of a `for`: to the end of the body, or of the statement.
        size_t last = std::min(matching_[paren] + 1, tokens_.size() - 1);
        if (tokens_[last].is("{")) {
            last = matching_[last];
        } else {
            while (last + 1 < tokens_.size() && !tokens_[last].is(";"))
                last = tokens_[last].is("{") ? matching_[last] : last + 1;
        }
        return {kDocument, offset, tokens_[last].span.end};
    }
    if (brace == tokens_.size()) return {kDocument, 0, size};
    // `@uniform { … }` declares for the fablet around it.
    const bool uniforms = brace > 0 && tokens_[brace - 1].text == "uniform";
    if (uniforms && tokens_[brace].span.begin > 0) return scope_of(tokens_[brace - 1].span.begin);
    const size_t close = matching_[brace];
    return {kDocument, tokens_[brace].span.end,
            close == tokens_.size() - 1 ? size : tokens_[close].span.begin};
}

const ast::Variable* Analysis::uniform_at(const source::Span& declared) const {
    for (const check::Unit& unit : units()) {
        for (const ast::Fablet& fablet : unit.file->fablets) {
            for (const ast::Variable& v : fablet.uniforms) {
                if (v.span == declared) return &v;
            }
        }
    }
    return nullptr;
}

std::optional<uint32_t> Analysis::file_of_import(const ast::Import& import) const {
    for (size_t at : units().back().imports) {
        const check::Unit& unit = units()[at];
        if (unit.name == import.name) return unit.file->end.file;
    }
    return std::nullopt;
}

bool Analysis::is_imported(const source::Span& declared, std::string_view name) const {
    if (name.starts_with('_')) return false;
    const std::vector<ast::Import>& imports = tree().imports;
    return std::any_of(imports.begin(), imports.end(), [&](const ast::Import& import) {
        return file_of_import(import) == declared.file;
    });
}

std::vector<const check::Function*> Analysis::functions(std::string_view name) const {
    std::vector<const check::Function*> out;
    const auto take = [&](const std::vector<std::unique_ptr<check::Function>>& from) {
        for (const auto& f : from) {
            const bool here = f->span.file == kDocument;
            if ((name.empty() || f->name == name) && (here || is_imported(f->span, f->name)))
                out.push_back(f.get());
        }
    };
    for (const check::Fablet& fablet : program_.fablets)
        take(fablet.functions);
    take(program_.functions);
    return out;
}

std::string Analysis::comment_above(const source::Span& declared) const {
    std::string out;
    uint32_t line = sources_.locate(declared.file, declared.begin).line;
    while (line > 1) {
        const auto comment = comment_line(sources_.line_text(declared.file, --line));
        if (!comment || comment->starts_with("----") || comment->starts_with("SPDX-")) break;
        out.insert(0, *comment + (out.empty() ? "" : "\n"));
    }
    return out;
}

std::string Analysis::head_comment(uint32_t file) const {
    std::string out;
    for (uint32_t line = 1;; ++line) {
        const auto comment = comment_line(sources_.line_text(file, line));
        if (!comment) return out;
        if (comment->starts_with("Copyright") || comment->starts_with("SPDX-") || comment->empty())
            continue;
        out += (out.empty() ? "" : "\n") + *comment;
    }
}

std::filesystem::path Analysis::path_of(uint32_t file) const {
    const std::filesystem::path folder = sources_.folder(file);
    if (folder.empty()) return {};
    return folder / std::filesystem::path(std::string(sources_.name(file))).filename();
}

std::vector<std::string> parameters(const check::Function& function) {
    std::vector<std::string> out;
    for (const auto& p : function.parameters) {
        const char* way = p->is_out ? (p->is_in ? "inout " : "out ") : "";
        out.push_back(fmt::format("{}{} {}", way, check::type_name(p->type), p->name));
    }
    return out;
}

std::string signature(const check::Function& function) {
    return fmt::format("{} {}({})", check::type_name(function.return_type), function.name,
                       fmt::join(parameters(function), ", "));
}

}  // namespace openfab::server
