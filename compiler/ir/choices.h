// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The names of a uniform's values: of an enum's, or of a bool's that has labels. They are an annotation that no source
// can write: a line for each, name, tab, value, tab, label.

#include <algorithm>
#include <string>

#include "compiler/ir/ir.h"

namespace openfab::ir {

inline constexpr const char* kChoices = "@choices";

/// Returns the lines; empty for a uniform whose values have no names.
inline std::string choices(const Uniform& uniform) {
    const auto found = std::find_if(uniform.annotations.begin(), uniform.annotations.end(),
                                    [](const auto& one) { return one.first == kChoices; });
    return found == uniform.annotations.end() ? std::string() : found->second;
}

}  // namespace openfab::ir
