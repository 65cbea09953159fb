// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "compiler/check/tree.h"
#include "compiler/diag/sink.h"
#include "compiler/syntax/ast.h"

namespace openfab::sema {

/// A file and what it imports.
struct Unit {
    const ast::File* file = nullptr;
    std::string name;             ///< the module's name; empty for the program
    std::vector<size_t> imports;  ///< per import of the file: the unit's place in the list
};

struct CheckOptions {
    bool need_fablet = true;  ///< else a file of functions will do
};

/// Resolves names, types and stages of the last unit, the program, and of the modules before it,
/// each of which stands behind what it imports. What it returns may be translated only if the sink
/// holds no errors.
Program check(const std::vector<Unit>& units, const CheckOptions& options, diag::Sink* sink);

}  // namespace openfab::sema
