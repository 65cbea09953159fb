// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Changes the structure of XML and JSON and keeps them well-formed: elements that stand where none of their kind
// belongs reach code that damaged bytes, which the parser refuses, never do.

#include <random>
#include <string>

namespace openfab::testing {

/// Moves, copies or nests an element of XML, or a member or item of JSON; false where the text has none.
bool move_element(std::string* text, std::mt19937_64* random);

}  // namespace openfab::testing
