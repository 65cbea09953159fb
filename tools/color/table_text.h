// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The words of tables of patches: CGATS text and CSV.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace openfab::color {

/// The most columns of a table.
constexpr int kMostColumns = 1000;

/// Returns whether a table is CGATS text, whatever its head holds: only that has the keyword
/// BEGIN_DATA_FORMAT, first on a line. Any other table begins with the names of its columns.
bool is_cgats(std::string_view text);

struct CgatsWord {
    std::string_view text;
    int line = 0;  ///< from 1
    bool quoted = false;

    /// Returns whether it is this keyword, which quotes make a value.
    bool is(std::string_view keyword) const { return !quoted && text == keyword; }
};

/// The words of CGATS text: what stands between blanks, ends of lines among them, or in quotes, where it may be
/// empty. From `#` on the line is a comment.
class CgatsWords {
  public:
    /// Keeps a reference to the text.
    explicit CgatsWords(std::string_view text) : left_(text) {}

    /// Returns the next word; none at the end.
    std::optional<CgatsWord> next();
    /// Same, of the line of the last one.
    std::optional<CgatsWord> next_of_line();
    /// From here on commas and semicolons are parts of words, not between them.
    void keep_commas() { between_ = " \t\r"; }

  private:
    void skip_between();

    std::string_view left_, between_ = " \t\r,;";
    int line_ = 1;
};

/// The rows of a CSV (RFC 4180): cells may be in quotes, with separators, ends of lines and doubled quotes in them;
/// two separators with nothing between them are an empty cell.
class CsvRows {
  public:
    /// Keeps a reference to the text.
    explicit CsvRows(std::string_view text) : left_(text) {}

    /// Takes the next row; false at the end.
    bool next(std::vector<std::string>* cells);
    /// Returns the rest of the line at which the next row begins.
    std::string_view peek() const { return left_.substr(0, left_.find('\n')); }
    void skip_line();
    bool at_end() const { return left_.empty(); }
    void set_separator(char separator) { separator_ = separator; }
    char separator() const { return separator_; }
    /// The line at which the last row begins, from 1.
    int line() const { return line_; }
    int next_line() const { return next_line_; }

  private:
    std::string take_cell(bool* last);

    std::string_view left_;
    char separator_ = ',';
    int line_ = 0, next_line_ = 1;
};

/// Reads a number as programs of all countries write it: with a point, or with one comma.
bool read_number(std::string_view word, double* out);

/// Returns ASCII letters as capitals.
std::string upper(std::string_view text);

}  // namespace openfab::color
