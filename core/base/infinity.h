// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

namespace openfab {

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

}  // namespace openfab
