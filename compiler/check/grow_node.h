// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/check/tree.h"
#include "compiler/diag/sink.h"
#include "compiler/syntax/ast.h"

namespace openfab::check {

/// Checks the members that mean something, of the node that the grow stage `from` returns.
void check_node(const ast::Stage& from, const Fablet& to, diag::Sink* sink);

}  // namespace openfab::check
