// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the system says when it refuses something: people are told what would allow it, where a limit
// of theirs is the reason.

#include <string>

namespace openfab {

/// Returns the system's words for a value of `errno`, and the limit to raise if it is one.
std::string system_reason(int code);

}  // namespace openfab
