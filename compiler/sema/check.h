// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/diag/sink.h"
#include "compiler/sema/tree.h"
#include "compiler/syntax/ast.h"

namespace openfab::sema {

/// Resolves names, types and stages. What it returns may be translated only if the sink holds no
/// errors.
Program check(const ast::File& file, diag::Sink* sink);

}  // namespace openfab::sema
