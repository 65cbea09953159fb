// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace openfab {

/// A place in a text file, one-based; without a line it is the file as a whole, or whatever else
/// `file` names, such as an option of the command line.
struct SourceLocation {
    std::string file;
    int32_t line = 0;
    int32_t column = 0;

    /// `file:line:column`, or `file` alone where there is no line.
    std::string str() const;
    bool operator==(const SourceLocation&) const = default;
};

}  // namespace openfab
