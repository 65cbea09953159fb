// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "compiler/diag/sink.h"
#include "compiler/source/source_manager.h"

namespace openfab::syntax {

enum class TokenKind : uint8_t {
    kEnd,
    kIdentifier,
    kKeyword,
    kInt,
    kUint,
    kFloat,
    kString,
    kPunct
};

struct Token {
    TokenKind kind = TokenKind::kEnd;
    source::Span span;
    std::string_view text;  ///< as written; a string without quotes, escapes not resolved
    uint32_t bits = 0;      ///< numbers: the 32-bit pattern

    bool is(std::string_view punct_or_keyword) const {
        return (kind == TokenKind::kPunct || kind == TokenKind::kKeyword) &&
               text == punct_or_keyword;
    }
};

/// Returns the name of a kind, for dumps.
const char* spelling(TokenKind kind);

/// What errors took out of the tokens.
struct Lost {
    bool whole =
        true;  ///< nothing but directives; what else was wrong has a token that stands for it
    std::vector<source::Span> lines;  ///< directives such as `#define`
};

/// Returns the tokens of a file, always with kEnd last. Comments and white space are dropped;
/// invalid characters are reported and dropped, unless it is clear what they mean. `lost` may be null.
std::vector<Token> lex(const source::SourceManager& sources, uint32_t file, diag::Sink* sink,
                       Lost* lost = nullptr);

}  // namespace openfab::syntax
