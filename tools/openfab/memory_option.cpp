// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/memory_option.h"

#include "base/units.h"
#include "program/options.h"

namespace openfab::tools {

Result<int64_t> memory_of(const std::string& text) {
    if (text.empty()) return program::Options().memory_bytes;
    Result<int64_t> bytes = parse_bytes(text);
    if (!bytes) return usage_error("`--memory`: " + bytes.error().text());
    return bytes;
}

}  // namespace openfab::tools
