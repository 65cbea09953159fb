// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/vec.h"
#include "runtime/dither/band.h"
#include "runtime/pipeline/fraction_sink.h"
#include "runtime/volume/evaluate.h"

namespace openfab::pipeline {

/// Passes the fractions of a row of blocks to a sink: of slices 8 slab .. 8 slab + 7 those whose bit
/// is in `slices`. `size`: the grid's, in voxels.
void write_fractions(const dither::RowBand& band, int32_t slab, uint8_t slices, const Vec3i& size,
                     int32_t materials, FractionSink* sink);

/// Passes the derivatives of a row of blocks on.
void write_rates(const volume::RowRates& rates, int32_t slab, int32_t row, uint8_t slices,
                 const Vec3i& size, FractionSink* sink);

}  // namespace openfab::pipeline
