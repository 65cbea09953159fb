// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/server/text_document.h"

#include <algorithm>
#include <utility>

#include "compiler/source/source_manager.h"

namespace openfab::server {

namespace {

/// Code points beyond the 16-bit plane are two code units in UTF-16, and four bytes in UTF-8.
int64_t units_of(size_t bytes, Encoding encoding) {
    if (encoding == Encoding::kUtf8) return static_cast<int64_t>(bytes);
    return bytes == 4 ? 2 : 1;
}

}  // namespace

int64_t code_units(std::string_view text, Encoding encoding) {
    int64_t units = 0;
    for (size_t at = 0; at < text.size();) {
        const size_t bytes = source::code_point_bytes(text, at);
        units += units_of(bytes, encoding);
        at += bytes;
    }
    return units;
}

void TextDocument::set(std::string text) {
    text_ = std::move(text);
    starts_.assign(1, 0);
    for (size_t i = 0; i < text_.size(); ++i) {
        const bool alone = text_[i] == '\r' && (i + 1 == text_.size() || text_[i + 1] != '\n');
        if (text_[i] == '\n' || alone) starts_.push_back(static_cast<uint32_t>(i + 1));
    }
}

uint32_t TextDocument::offset(const Position& position, Encoding encoding) const {
    if (position.line < 0) return 0;
    if (position.line >= lines()) return static_cast<uint32_t>(text_.size());
    const auto line = static_cast<size_t>(position.line);
    size_t end = line + 1 < starts_.size() ? starts_[line + 1] : text_.size();
    while (end > starts_[line] && (text_[end - 1] == '\n' || text_[end - 1] == '\r'))
        --end;
    size_t at = starts_[line];
    for (int64_t left = position.character; left > 0 && at < end;) {
        const size_t bytes = source::code_point_bytes(text_, at);
        left -= units_of(bytes, encoding);
        if (left >= 0) at += bytes;  // within a code point is before it
    }
    return static_cast<uint32_t>(std::min(at, end));
}

Position TextDocument::position(uint32_t offset, Encoding encoding) const {
    offset = std::min(offset, static_cast<uint32_t>(text_.size()));
    const auto next = std::upper_bound(starts_.begin(), starts_.end(), offset);
    const auto line = static_cast<size_t>(next - starts_.begin()) - 1;
    const std::string_view before =
        std::string_view(text_).substr(starts_[line], offset - starts_[line]);
    return {static_cast<int64_t>(line), code_units(before, encoding)};
}

void TextDocument::replace(const Range& range, std::string_view with, Encoding encoding) {
    const uint32_t begin = offset(range.start, encoding);
    const uint32_t end = std::max(begin, offset(range.end, encoding));
    std::string text = text_;
    text.replace(begin, end - begin, with);
    set(std::move(text));
}

}  // namespace openfab::server
