// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// JSON for people to edit: what fits a line stands on one; and trees of cuts in it.

#include <string>

#include "base/json.h"
#include "pieces/tree.h"

namespace openfab::tools {

JsonValue json_of(double number);
JsonValue json_of(const std::string& text);
JsonValue json_of(const Vec3d& v);
/// Sets a member of an object, in its place or behind the others.
void set_member(JsonValue* object, const std::string& key, JsonValue value);

/// Returns the cut of `pieces`, with what is on both sides.
JsonValue json_of(const pieces::Tree& tree);

/// Returns the text of a file, with a line end.
std::string text_of(const JsonValue& value);
/// Returns the text of a value that stands in the lines of a world, behind a key of that many letters.
std::string text_in_world(const JsonValue& value, size_t key, size_t indent = 4);

}  // namespace openfab::tools
