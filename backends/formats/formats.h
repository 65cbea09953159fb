// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The table of output formats.

#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "backends/common/format.h"

namespace openfab::backends {

/// All formats, in the order in which help and messages list them.
std::span<const Format* const> formats();

/// Returns the format that `--format` calls so, or null.
const Format* find_format(std::string_view name);

/// Returns the names of the formats for which `holds` is true, as a text: `ofr, png or bmp`;
/// with a comma as the last joint `ofr, png, bmp`.
std::string format_names(
    std::string_view last_joint = "or",
    const std::function<bool(const Format&)>& holds = [](const Format&) { return true; });

/// Returns the extensions of the outputs that are files: `.ofr, .gcvf, .npy`.
std::string file_extensions();

}  // namespace openfab::backends
