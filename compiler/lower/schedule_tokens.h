// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The words of a schedule file.

#include <variant>
#include <vector>

#include "compiler/lower/schedule.h"

namespace openfab::lower {

struct ScheduleToken {
    enum class Kind {
        kWord,    ///< letters, digits, `_` and `*`
        kString,  ///< "…"; the word's text is without the quotes
        kMark,    ///< one of ( ) [ ] { } . , = % < > or <= >= == !=
        kNewLine,
        kEnd,
    };
    Kind kind = Kind::kEnd;
    ScheduleWord word;

    bool is(std::string_view text) const {
        return (kind == Kind::kWord || kind == Kind::kMark) && word.text == text;
    }
};

/// Returns the tokens of a file, kEnd last, without comments; a line that begins with `.` belongs
/// to the one before it.
std::variant<std::vector<ScheduleToken>, ScheduleFault> schedule_tokens(
    const ScheduleSource& source);

}  // namespace openfab::lower
