// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "runtime/process/kind.h"

namespace openfab::process {

extern const Kind kBleedKind;

}  // namespace openfab::process
