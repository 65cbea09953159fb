// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backends/common/format.h"

namespace openfab::gcvf {

extern const backends::Format kGcvfFormat;

}  // namespace openfab::gcvf
