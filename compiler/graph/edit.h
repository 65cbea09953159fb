// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What can be done to a graph. Each action is an edit of the text, through the formatter: what it does not name stays,
// comments too. An action that would make an error of a program without errors is refused, with the compiler's reason.

#include <cstdint>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/result.h"
#include "compiler/graph/graph.h"
#include "compiler/graph/palette.h"

namespace openfab::graph {

/// By `what`, the other members mean:
///   set          tab, node, port, text: the expression in a port
///   default      uniform, text: the value that a uniform has where the world gives none
///   connect      tab, from, output, node, port
///   disconnect   tab, node, port: what was there becomes a node of its own, the port a value
///   insert       tab, node, port, signature: a function on a wire
///   add          tab, signature, before (a statement; -1: before the result)
///   paste        tab, text: statements before the result; what they declare gets other names where it must
///   delete       tab, node
///   name         tab, node, text: gives a node a name, or another one
///   group        tab, nodes, text: makes a function of them
///   expose       tab, node, port, text: makes a uniform of a value
///   add_uniform  fablet, type, text
///   delete_uniform, rename_uniform   uniform, text
struct Action {
    std::string what;
    int tab = -1, node = -1, port = -1, from = -1, output = 0, before = -1;
    int uniform = -1, fablet = -1;
    std::string text, signature, module, type;
    std::vector<int> nodes;
};

Result<Action> action_of(const JsonValue& json);

/// Returns the text of a document after an action. `open` are texts of other files that are open.
Result<std::string> edited(const server::Analysis& analysis, const Graph& graph,
                           const Action& action);

/// Returns the first error that a text has and a document has not, as a user error.
Result<void> still_fine(const server::Analysis& before, const server::Analysis& after);

}  // namespace openfab::graph
