// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace openfab {

/// A location in a text file, one-based; without a line, the whole file or whatever else `file`
/// names, such as a command-line option.
struct SourceLocation {
    std::string file;
    int32_t line = 0;
    int32_t column = 0;

    /// Formats `file:line:column`, or `file` alone where there is no line.
    std::string str() const;
    bool operator==(const SourceLocation&) const = default;
};

}  // namespace openfab
