// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/check/tree.h"
#include "compiler/check/uses.h"
#include "compiler/diag/sink.h"
#include "compiler/syntax/ast.h"

namespace openfab::check {

/// Returns what stands for a query of a surface in a shape stage.
const char* shape_query_help(std::string_view query);
constexpr const char* kNoQueriesInGrow =
    "a rule makes nodes of functions, uniforms, textures and the node before";
constexpr const char* kNoPrintsInShape =
    "a shape is asked at points that no voxel has: print from `@Volume`, which may call the same "
    "function";

/// A file and its imports.
struct Unit {
    const ast::File* file = nullptr;
    std::string name;             ///< the module's name; empty for the program
    std::vector<size_t> imports;  ///< per import of the file: the unit's index in the list
};

struct CheckOptions {
    bool need_fablet = true;  ///< false: a file of functions is enough
    Uses* uses = nullptr;     ///< filled in if given
    /// Returns the module of the standard library that has a function, constant or struct of a name; empty if none does.
    std::function<std::string(std::string_view)> module_of;
    /// The dither rule of fablets without one: a function of the unit of this index.
    struct Rule {
        size_t unit = 0;
        std::string name;  ///< empty: none
    } rule;
};

/// Resolves names, types and stages of the last unit, the program, and of the modules before it,
/// each of which comes after its imports. The result may be translated only if the sink holds no
/// errors.
Program check(const std::vector<Unit>& units, const CheckOptions& options, diag::Sink* sink);

}  // namespace openfab::check
