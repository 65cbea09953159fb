// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A range of bytes in a source file. Files are numbered by the SourceManager; 0 is "nowhere".

#include <cstdint>

namespace openfab::source {

struct Span {
    uint32_t file = 0;   ///< SourceManager's number, 0 for none
    uint32_t begin = 0;  ///< byte offsets
    uint32_t end = 0;
    bool operator==(const Span&) const = default;
};

}  // namespace openfab::source
