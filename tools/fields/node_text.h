// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The nodes of 3MF's implicit functions, each as one OpenFL expression.

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "mesh/read/threemf_fields.h"

namespace openfab::tools {

/// A value in OpenFL: an expression of one word, or the number of a resource.
struct FieldValue {
    std::string text;
    mesh::ThreemfType type = mesh::ThreemfType::kScalar;
};

/// "float3".
std::string_view openfl_type(mesh::ThreemfType type);
/// "a vector", for messages.
std::string_view name_of(mesh::ThreemfType type);

/// Returns a number as OpenFL reads it back as the same float; empty where it has none.
std::string float_text(double value);

/// What a kind of node is, as far as it is a formula of its inputs.
struct NodeKind {
    std::string_view names;   ///< of the element; some are spelt in several ways
    std::string_view inputs;  ///< their names
    std::string_view types;   ///< s, v, m; * is any of these, a value for each of its numbers
    std::string_view text;    ///< {0} is the first input
    char result = '*';        ///< of what type; * as that input which is any
};

/// Returns the row of a kind, or null.
const NodeKind* find_node_kind(std::string_view name);
/// Returns the names of all kinds, for messages.
std::vector<std::string> node_kinds();

/// Returns the expression of a node whose inputs, by the kind's list, are these. The complaint says what
/// is wrong with their types.
Complaint node_text(const NodeKind& kind, const std::vector<FieldValue>& inputs, FieldValue* out);

/// Same, of constants; the node's numbers are as many as its kind has.
Complaint constant_text(const mesh::ThreemfNode& node, FieldValue* out);

}  // namespace openfab::tools
