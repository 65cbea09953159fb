// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Changes members in the text of a world, and leaves all else of it as somebody has written it.

#include <string>
#include <string_view>

#include "base/result.h"

namespace openfab::viewer {

/// Returns the text with `"uniform": value` in the uniforms of an object; `value` is JSON. `name` is
/// for errors: text that is not a world, or has no such object.
Result<std::string> with_uniform(const std::string& text, const std::string& name,
                                 std::string_view object, std::string_view uniform,
                                 std::string_view value);

/// Returns the text with `"key": value` in an object of the world such as `meshes`, which is made if it is not there.
Result<std::string> with_entry(const std::string& text, const std::string& name,
                               std::string_view section, std::string_view key,
                               std::string_view value);

/// Returns the text with another name of a uniform that an entry of `objects` or `fablets` binds; unchanged where it binds
/// none of this name.
Result<std::string> with_renamed_uniform(const std::string& text, const std::string& name,
                                         std::string_view section, std::string_view entry,
                                         std::string_view from, std::string_view to);

/// Returns the text with another mesh of an object.
Result<std::string> with_mesh(const std::string& text, const std::string& name,
                              std::string_view object, std::string_view mesh);

}  // namespace openfab::viewer
