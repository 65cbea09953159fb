// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The printer that slices from elsewhere were made for.

#include "runtime/pipeline/slice_sink.h"
#include "world/printer.h"

namespace openfab::tools {

/// Returns the printer that a print names, for support and hand-off notes; one that is not known
/// here has none.
world::Printer printer_of(const pipeline::PrintInfo& info);

}  // namespace openfab::tools
