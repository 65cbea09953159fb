// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace openfab::process {

/// A change while a print ran: manifests list it under `EFFECT_changes`, with `text` as KEY.
struct EffectChange {
    std::string effect, key;
    int32_t slice = 0;  ///< the first that was printed so
    std::string text;
};

}  // namespace openfab::process
