// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/syntax/ast.h"
#include "compiler/syntax/token.h"

namespace openfab::syntax {

/// Limit of the nesting of a program; deeper is an error, so that no input overflows the stack.
constexpr int kMaxDepth = 200;

/// Parses the tokens of one file, from `lex`. Always returns a tree; after errors parts of it are
/// missing.
ast::File parse(const source::SourceManager& sources, const std::vector<Token>& tokens,
                diag::Sink* sink);

}  // namespace openfab::syntax
