// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/zarr/format.h"

#include "backends/zarr/zarr_sink.h"

namespace openfab::zarr {

const backends::Format kZarrFormat{
    .name = "zarr",
    .extension = ".zarr",
    // Slices that wait for their slab, its shards, and a quarter of a slab that is half as fine.
    .bytes_per_column = [](size_t) { return int64_t{2 * kSlab + kSlab}; },
    .open = [](const backends::OutputSettings& settings)
        -> Result<std::unique_ptr<pipeline::SliceSink>> {
        return std::unique_ptr<pipeline::SliceSink>(
            std::make_unique<ZarrSink>(settings.path, settings.resume));
    },
};

}  // namespace openfab::zarr
