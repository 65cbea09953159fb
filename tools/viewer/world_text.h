// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Changes uniforms in the text of a world, and leaves all else of it as somebody has written it.

#include <string>
#include <string_view>

#include "base/result.h"

namespace openfab::viewer {

/// Returns the text with `"uniform": value` in the uniforms of an object; `value` is JSON. `name` is
/// for errors: text that is not a world, or has no such object.
Result<std::string> with_uniform(const std::string& text, const std::string& name,
                                 std::string_view object, std::string_view uniform,
                                 std::string_view value);

}  // namespace openfab::viewer
