// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A document as the Language Server Protocol sees it: positions are lines and code units in them.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace openfab::server {

/// What a position counts within a line: UTF-16 code units unless the client asked for bytes.
enum class Encoding : uint8_t { kUtf16, kUtf8 };

/// Both from 0.
struct Position {
    int64_t line = 0;
    int64_t character = 0;
    bool operator==(const Position&) const = default;
};

struct Range {
    Position start, end;
};

class TextDocument {
  public:
    TextDocument() = default;
    explicit TextDocument(std::string text) { set(std::move(text)); }

    void set(std::string text);
    const std::string& text() const { return text_; }
    int64_t lines() const { return static_cast<int64_t>(starts_.size()); }
    /// Returns the byte of a position; what lies behind the end of a line or of the text is that end.
    uint32_t offset(const Position& position, Encoding encoding) const;
    Position position(uint32_t offset, Encoding encoding) const;
    Range range(uint32_t begin, uint32_t end, Encoding encoding) const {
        return {position(begin, encoding), position(end, encoding)};
    }
    /// Replaces a range; one that ends before it starts is empty.
    void replace(const Range& range, std::string_view with, Encoding encoding);

  private:
    std::string text_;
    std::vector<uint32_t> starts_{0};
};

/// Returns the number of code units of a text.
int64_t code_units(std::string_view text, Encoding encoding);

}  // namespace openfab::server
