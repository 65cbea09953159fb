// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backends/common/format.h"

namespace openfab::zarr {

extern const backends::Format kZarrFormat;

}  // namespace openfab::zarr
