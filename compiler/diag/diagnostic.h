// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One message to the user, and the table of all messages. Each row of diagnostics.def becomes a
// constant (diag::kNarrowing) typed by its arguments, so a wrong argument does not compile.

#include <fmt/format.h>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/source/span.h"

namespace openfab::diag {

enum class Severity : uint8_t { kWarning, kError };

enum class Id : uint16_t {
#define OPENFAB_DIAGNOSTIC(name, id, severity, ...) k##name,
#include "compiler/diag/diagnostics.def"
#undef OPENFAB_DIAGNOSTIC
    kCount
};

template <typename... Args>
struct Descriptor {
    Id id;
    Severity severity;
    fmt::format_string<Args...> format;
};

namespace detail {
// Collects the argument types of a row.
template <typename... Args>
struct Types {};
template <typename... Args>
Descriptor<Args...> describe(Types<Args...>);
}  // namespace detail

#define OPENFAB_DIAGNOSTIC(name, id_text, severity_name, text, ...)                    \
    inline constexpr decltype(detail::describe(detail::Types<__VA_ARGS__>{})) k##name{ \
        Id::k##name, Severity::k##severity_name, text};
#include "compiler/diag/diagnostics.def"
#undef OPENFAB_DIAGNOSTIC

/// Returns the text in brackets after a message, such as `narrowing`.
const char* id_text(Id id);

struct Note {
    source::Span span;
    std::string message;
};

/// Replaces a span by text; an empty span makes it an insertion.
struct Edit {
    source::Span span;
    std::string text;
};

struct Diagnostic {
    Id id{};
    Severity severity = Severity::kError;
    source::Span span;
    std::string message;
    std::vector<Note> notes;
    std::vector<std::string> helps;
    std::vector<Edit> fix;  ///< applied together they fix the error; empty if unsure

    Diagnostic& note(const source::Span& at, std::string text) {
        notes.push_back({at, std::move(text)});
        return *this;
    }
    Diagnostic& help(std::string text) {
        helps.push_back(std::move(text));
        return *this;
    }
    Diagnostic& replace(const source::Span& at, std::string text) {
        fix.push_back({at, std::move(text)});
        return *this;
    }
    Diagnostic& insert_before(const source::Span& at, std::string text) {
        return replace({at.file, at.begin, at.begin}, std::move(text));
    }
    Diagnostic& insert_after(const source::Span& at, std::string text) {
        return replace({at.file, at.end, at.end}, std::move(text));
    }
    /// Suggests the one of `names` that the word at `at` is close to; if there is none, adds the
    /// help `otherwise`, unless that is empty.
    Diagnostic& suggest(const source::Span& at, std::string_view word,
                        std::span<const std::string> names, std::string otherwise);
};

}  // namespace openfab::diag
