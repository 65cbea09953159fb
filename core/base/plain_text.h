// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Text files as other programs save them: with a byte order mark, in UTF-16, with the line ends of an
// old Macintosh. Readers of lines take them through here and see line feeds and UTF-8 alone.

#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"

namespace openfab {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// Returns `UTF-16` or `UTF-32` if that is what the bytes are, by their mark or their zeros; else an
/// empty text.
std::string_view wide_encoding(std::string_view bytes);

/// Returns what is wrong with text that readers cannot take: that it is UTF-16.
Complaint not_utf8(std::string_view bytes);

/// The text of a file without its byte order mark, each line ended by `\n`, maybe after `\r`.
class PlainText {
  public:
    /// Keeps a reference to the bytes, or a copy where a carriage return alone ends a line.
    explicit PlainText(std::string_view bytes);
    PlainText(const PlainText&) = delete;
    PlainText& operator=(const PlainText&) = delete;

    /// Returns the text with carriage returns that end lines alone made line feeds.
    static std::string with_line_feeds(std::string text);

    std::string_view text() const { return copied_.empty() ? bytes_ : copied_; }
    /// Returns the bytes of the copy.
    int64_t copied_bytes() const { return static_cast<int64_t>(copied_.size()); }

  private:
    std::string_view bytes_;
    std::string copied_;
};

}  // namespace openfab
