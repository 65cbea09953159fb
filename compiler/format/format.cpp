// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/format/format.h"

#include <vector>

#include "compiler/format/formatter.h"
#include "compiler/syntax/parser.h"

namespace openfab::format {

Result<std::string> format(const source::SourceManager& sources, uint32_t file, diag::Sink* sink) {
    const size_t errors = sink->errors();
    const std::vector<syntax::Token> tokens = syntax::lex(sources, file, sink);
    if (sink->errors() == errors) syntax::parse(sources, tokens, sink);
    if (sink->errors() != errors) return user_error("the file has syntax errors");
    const std::vector<Word> words = words_of(sources, file, tokens);
    std::string out = Formatter(words).file();
    // Nobody should have to find out from a print that layout changed a program.
    source::SourceManager again;
    diag::Sink quiet;
    const uint32_t made = again.add("formatted", out);
    if (!same_words(words, words_of(again, made, syntax::lex(again, made, &quiet))))
        return internal_error("the layout differs in more than white space");
    return out;
}

}  // namespace openfab::format
