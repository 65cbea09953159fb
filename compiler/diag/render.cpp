// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/diag/render.h"

#include <algorithm>
#include <iterator>

#include "base/caret.h"
#include "base/json_text.h"

namespace openfab::diag {

namespace {

const char* severity_text(Severity severity) {
    return severity == Severity::kError ? "error" : "warning";
}

/// Formats a source line for a terminal: each code point takes one column.
std::string printable(std::string_view line) {
    std::string out;
    for (size_t i = 0; i < line.size();) {
        const size_t bytes = source::code_point_bytes(line, i);
        const auto lead = static_cast<unsigned char>(line[i]);
        if (bytes == 1 && lead >= 0x80) {
            out += "\xEF\xBF\xBD";  // U+FFFD
        } else if (lead < 0x20 || lead == 0x7f) {
            out += ' ';
        } else {
            out += line.substr(i, bytes);
        }
        i += bytes;
    }
    return out;
}

/// Longer lines are shown in part: a file without line ends must not flood the terminal.
constexpr uint32_t kMaxLineColumns = 200;
constexpr uint32_t kColumnsBefore = 80;

/// Returns `count` code points of `line` from code point `first` on.
std::string columns(std::string_view line, uint32_t first, uint32_t count) {
    size_t begin = 0;
    while (first-- > 0 && begin < line.size())
        begin += source::code_point_bytes(line, begin);
    size_t end = begin;
    while (count-- > 0 && end < line.size())
        end += source::code_point_bytes(line, end);
    return std::string(line.substr(begin, end - begin));
}

void print_caret(const source::Span& span, const source::SourceManager& sources, std::string* out) {
    const source::Location at = sources.locate(span.file, span.begin);
    const source::Location end = sources.locate(span.file, span.end);
    std::string line = printable(sources.line_text(span.file, at.line));
    uint32_t shown = source::count_code_points(line);
    uint32_t column = at.column;
    uint32_t last = end.line == at.line ? end.column : shown + 1;  // one past the caret
    if (shown > kMaxLineColumns) {
        const uint32_t cut = column > kColumnsBefore ? column - kColumnsBefore : 0;
        line = "…" + columns(line, cut, kMaxLineColumns) + "…";
        shown = source::count_code_points(line);
        column = column - cut + 1;
        last = last - cut + 1;
    }
    last = std::max(std::min(last, shown + 1), column + 1);
    *out += caret_lines(line, at.line, column, last - column);
}

std::string location_text(const source::Span& span, const source::SourceManager& sources) {
    const source::Location at = sources.locate(span.file, span.begin);
    return fmt::format("{}:{}:{}", sources.name(span.file), at.line, at.column);
}

void print_one(const Diagnostic& d, const source::SourceManager& sources, std::string* out) {
    fmt::format_to(std::back_inserter(*out), "{}: {}: {} [{}]\n", location_text(d.span, sources),
                   severity_text(d.severity), d.message, id_text(d.id));
    print_caret(d.span, sources, out);
    for (const Note& note : d.notes) {
        fmt::format_to(std::back_inserter(*out), "{}: note: {}\n",
                       location_text(note.span, sources), note.message);
    }
    for (const std::string& help : d.helps)
        *out += "help: " + help + '\n';
}

std::string json_location(const source::Span& span, const source::SourceManager& sources) {
    const source::Location at = sources.locate(span.file, span.begin);
    return fmt::format(R"("file":{},"line":{},"column":{})", json_string(sources.name(span.file)),
                       at.line, at.column);
}

std::string json_one(const Diagnostic& d, const source::SourceManager& sources) {
    const source::Location end = sources.locate(d.span.file, d.span.end);
    std::string notes;
    for (const Note& note : d.notes) {
        notes += fmt::format(R"({}{{"message":{},{}}})", notes.empty() ? "" : ",",
                             json_string(note.message), json_location(note.span, sources));
    }
    std::string helps;
    for (const std::string& help : d.helps)
        helps += (helps.empty() ? "" : ",") + json_string(help);
    std::string fix;
    for (const Edit& edit : d.fix) {
        const source::Location after = sources.locate(edit.span.file, edit.span.end);
        fix += fmt::format(R"({}{{{},"end_line":{},"end_column":{},"text":{}}})",
                           fix.empty() ? "" : ",", json_location(edit.span, sources), after.line,
                           after.column, json_string(edit.text));
    }
    return fmt::format(
        R"({{"id":"{}","severity":"{}","message":{},{},"end_line":{},"end_column":{},"notes":[{}],"help":[{}],"fix":[{}]}})",
        id_text(d.id), severity_text(d.severity), json_string(d.message),
        json_location(d.span, sources), end.line, end.column, notes, helps, fix);
}

}  // namespace

std::string render_text(const Sink& sink, const source::SourceManager& sources) {
    std::string out;
    size_t errors = 0;
    size_t warnings = 0;
    for (const Diagnostic& d : sink.sorted()) {
        // Errors must not be hidden by many warnings.
        size_t& shown = d.severity == Severity::kError ? errors : warnings;
        if (++shown <= kMaxShown) print_one(d, sources, &out);
    }
    if (sink.warnings() > kMaxShown) {
        out += fmt::format("left out {} of {} warnings\n", sink.warnings() - kMaxShown,
                           sink.warnings());
    }
    if (sink.errors() > kMaxShown) {
        out += fmt::format("stopped after {} of {} errors\n", kMaxShown, sink.errors());
    }
    return out;
}

std::string render_json(const Sink& sink, const source::SourceManager& sources) {
    std::string items;
    for (const Diagnostic& d : sink.sorted()) {
        if (!items.empty()) items += ',';
        items += json_one(d, sources);
    }
    return fmt::format("{{\"diagnostics\":[{}],\"errors\":{},\"warnings\":{}}}\n", items,
                       sink.errors(), sink.warnings());
}

}  // namespace openfab::diag
