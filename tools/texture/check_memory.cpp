// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/check_memory.h"

#include <fmt/format.h>

#include "base/units.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

Result<void> check_memory(int64_t needed_bytes, int64_t memory_bytes) {
    if (needed_bytes <= memory_bytes) return {};
    constexpr int64_t kStep = 100'000'000;
    return user_error(fmt::format(messages::kTakesTooMuchMemory, format_bytes(needed_bytes),
                                  format_bytes(memory_bytes),
                                  (needed_bytes + kStep - 1) / kStep * (kStep / 1'000'000)));
}

}  // namespace openfab::tools
