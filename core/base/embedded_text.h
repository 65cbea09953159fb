// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A text file that the build embeds in the program (cmake/embed.cmake).

#include <string_view>

namespace openfab {

struct EmbeddedText {
    std::string_view name;  ///< of the file
    std::string_view text;
};

}  // namespace openfab
