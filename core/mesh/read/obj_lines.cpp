// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/obj_lines.h"

#include <algorithm>

#include "base/own_threads.h"

namespace openfab::mesh {
namespace {

bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

/// Whether the line that ends at `end` may go on behind it.
bool ends_in_backslash(std::string_view text, size_t end) {
    while (end > 0 && text[end - 1] == '\r')
        --end;
    return end > 0 && text[end - 1] == '\\';
}

/// Returns the first byte at or behind `at` that certainly begins a logical line.
size_t next_line(std::string_view text, size_t at) {
    for (;;) {
        const size_t end = text.find('\n', at);
        if (end == std::string_view::npos) return text.size();
        if (!ends_in_backslash(text, end)) return end + 1;
        at = end + 1;
    }
}

void count_statement(std::string_view word, ObjCounts* counts) {
    counts->vertices += word == "v";
    counts->uv += word == "vt";
    counts->normals += word == "vn";
    counts->faces += word == "f" || word == "fo";
}

ObjCounts count_statements(std::string_view text) {
    ObjCounts counts;
    for (size_t at = 0; at < text.size();) {
        const size_t end = std::min(text.find('\n', at), text.size());
        if (ends_in_backslash(text, end)) {
            ObjLines lines(text, at, text.size(), 0);
            if (lines.next()) count_statement(lines.tokens()[0], &counts);
            counts.newlines += static_cast<size_t>(lines.next_number());
            at = lines.end();
            continue;
        }
        while (at < end && is_blank(text[at]))
            ++at;
        // The longest of the words that count has two letters.
        size_t length = 0;
        while (length < 3 && at + length < end && !is_blank(text[at + length]))
            ++length;
        count_statement(text.substr(at, length), &counts);
        counts.newlines += end < text.size();
        at = end + 1;
    }
    return counts;
}

}  // namespace

void ObjCounts::add(const ObjCounts& other) {
    newlines += other.newlines;
    vertices += other.vertices;
    uv += other.uv;
    normals += other.normals;
    faces += other.faces;
}

std::vector<ObjPart> divide_obj(std::string_view text, size_t bytes) {
    std::vector<ObjPart> parts;
    for (size_t begin = 0; begin < text.size(); begin = parts.back().end) {
        const size_t least = text.size() - begin > bytes ? begin + bytes : text.size();
        parts.push_back({begin, next_line(text, least), {}, {}});
    }
    on_own_threads(parts.size(), [&](size_t i) {
        ObjPart& part = parts[i];
        part.inside = count_statements(text.substr(part.begin, part.end - part.begin));
    });
    for (size_t i = 1; i < parts.size(); ++i) {
        parts[i].before = parts[i - 1].before;
        parts[i].before.add(parts[i - 1].inside);
    }
    return parts;
}

bool ObjLines::next() {
    while (next_or_comment()) {
        if (!tokens_.empty()) return true;
    }
    return false;
}

bool ObjLines::next_or_comment() {
    while (at_ < text_.size()) {
        read_line();
        if (!tokens_.empty() || !comment_.empty()) return true;
    }
    return false;
}

void ObjLines::read_line() {
    start_ = at_;
    first_line_ = line_;
    tokens_.clear();
    comment_ = {};
    while (at_ < text_.size()) {
        const char c = text_[at_];
        if (c == '\n') {
            ++at_;
            ++line_;
            return;
        }
        if (is_blank(c)) {
            ++at_;
        } else if (c == '#') {
            const size_t end = std::min(text_.find('\n', at_), text_.size());
            if (tokens_.empty()) comment_ = text_.substr(at_ + 1, end - at_ - 1);
            at_ = end;
        } else if (c == '\\' && continues(at_ + 1)) {
            at_ = text_.find('\n', at_) + 1;
            ++line_;
        } else {
            const size_t start = at_;
            while (at_ < text_.size() && !is_blank(text_[at_]) && text_[at_] != '\n')
                ++at_;
            if (tokens_.size() < kMaxObjCorners + 2)
                tokens_.push_back(text_.substr(start, at_ - start));
        }
    }
}

bool ObjLines::continues(size_t behind) const {
    while (behind < text_.size() && text_[behind] == '\r')
        ++behind;
    return behind < text_.size() && text_[behind] == '\n';
}

std::string_view ObjLines::rest_of_line(std::string_view token) const {
    const auto start = static_cast<size_t>(token.data() - text_.data());
    size_t end = std::min(text_.find('\n', start), text_.size());
    while (end > start && is_blank(text_[end - 1]))
        --end;
    return text_.substr(start, end - start);
}

SourceLocation ObjLines::location(std::string_view token, const std::string& file) const {
    const std::string_view before =
        text_.substr(start_, static_cast<size_t>(token.data() - text_.data()) - start_);
    const size_t newline = before.rfind('\n');
    const std::string_view left =
        newline == std::string_view::npos ? before : before.substr(newline + 1);
    const auto lines = std::count(before.begin(), before.end(), '\n');
    const auto letters = std::count_if(
        left.begin(), left.end(), [](char c) { return (static_cast<uint8_t>(c) & 0xC0) != 0x80; });
    return {file, first_line_ + static_cast<int32_t>(lines), static_cast<int32_t>(letters) + 1};
}

}  // namespace openfab::mesh
