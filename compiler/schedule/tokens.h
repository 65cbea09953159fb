// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The words of a schedule file.

#include <variant>
#include <vector>

#include "compiler/schedule/schedule.h"

namespace openfab::schedule {

struct Token {
    enum class Kind {
        kWord,    ///< letters, digits, `_` and `*`
        kString,  ///< "…"; the word's text is without the quotes
        kMark,    ///< one of ( ) [ ] { } . , = % < > or <= >= == !=
        kNewLine,
        kEnd,
    };
    Kind kind = Kind::kEnd;
    Word word;

    bool is(std::string_view text) const {
        return (kind == Kind::kWord || kind == Kind::kMark) && word.text == text;
    }
};

/// Returns the tokens of a file, kEnd last, without comments; a line that begins with `.` belongs
/// to the one before it.
std::variant<std::vector<Token>, Fault> tokens_of(const Source& source);

}  // namespace openfab::schedule
