// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The lines of an OBJ text, and its division into pieces that can be read apart. What a line means
// depends on the text before it only by the number of its line and by how many elements there are so
// far, which are counted beforehand; groups and materials are kept for whoever joins the pieces.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/source_location.h"

namespace openfab::mesh {

/// Corners that a face may have, and groups that it may be in.
constexpr size_t kMaxObjCorners = 4096;

/// How many there are of each in a part of a text, in valid statements.
struct ObjCounts {
    size_t newlines = 0, vertices = 0, uv = 0, normals = 0, faces = 0;

    void add(const ObjCounts& other);
};

/// A part of a text that begins and ends between lines.
struct ObjPart {
    size_t begin = 0, end = 0;  ///< in the text
    ObjCounts before, inside;   ///< what comes before it, and what is in it
};

/// Divides a text into parts of about `bytes`, and counts what is in them, in parallel. The parts
/// depend on the text alone.
std::vector<ObjPart> divide_obj(std::string_view text, size_t bytes);

/// Splits a part of a text into logical lines of tokens: a backslash that stands alone at the end of
/// a line continues it. Keeps a reference to the text.
class ObjLines {
  public:
    /// Starts at a byte of the text that begins the line of the number `line`.
    ObjLines(std::string_view text, size_t begin, size_t end, int32_t line)
        : text_(text.substr(0, end)), at_(begin), line_(line) {}

    /// Goes to the next logical line that has tokens; false at the end.
    bool next();
    /// Goes to the next line of which a comment is all, tokens() being empty, or that has tokens.
    bool next_or_comment();

    /// The tokens of the line without its comment; one more than any statement may have, at most.
    const std::vector<std::string_view>& tokens() const { return tokens_; }
    /// The text behind the sign of a comment that is all of its line; else empty.
    std::string_view comment() const { return comment_; }
    /// The number of the line on which the logical one begins, and the byte of the text.
    int32_t line() const { return first_line_; }
    size_t start() const { return start_; }
    /// The byte behind the logical line, and the number of the line that begins there.
    size_t end() const { return at_; }
    int32_t next_number() const { return line_; }

    /// The rest of a token's line from that token on, without blanks at its end.
    std::string_view rest_of_line(std::string_view token) const;
    /// The place of a token of this line.
    SourceLocation location(std::string_view token, const std::string& file) const;

  private:
    void read_line();
    bool continues(size_t behind) const;

    std::string_view text_;  ///< up to the part's end
    size_t at_;
    int32_t line_;
    size_t start_ = 0;
    int32_t first_line_ = 1;
    std::vector<std::string_view> tokens_;
    std::string_view comment_;
};

}  // namespace openfab::mesh
