// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The texts of messages.def as constants; `fmt::format(messages::kName, …)` checks what they take.

namespace openfab::zarr::messages {

#define OPENFAB_MESSAGE(name, text) inline constexpr char name[] = text;
#include "backends/zarr/messages.def"
#undef OPENFAB_MESSAGE

}  // namespace openfab::zarr::messages
