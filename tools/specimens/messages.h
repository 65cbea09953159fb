// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The texts of messages.def as constants; `fmt::format(messages::kName, …)` checks what they take.

namespace openfab::specimens::messages {

#define OPENFAB_MESSAGE(name, text) inline constexpr char name[] = text;
#include "tools/specimens/messages.def"
#undef OPENFAB_MESSAGE

}  // namespace openfab::specimens::messages
