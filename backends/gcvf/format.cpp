// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/gcvf/format.h"

#include "backends/gcvf/gcvf_sink.h"

namespace openfab::gcvf {

const backends::Format kGcvfFormat{
    .name = "gcvf",
    .extension = ".gcvf",
    .flips_x = true,
    .not_resumed =
        "a package is closed after its last slice, so nothing is left of one that was "
        "cut short; print an .ofr file, and make a gcvf of it with `openfab export`",
    .bytes_per_column = [](size_t) { return kBytesPerColumn; },
    .files = backends::one_renamed_file,
    .open = [](const backends::OutputSettings& settings)
        -> Result<std::unique_ptr<pipeline::SliceSink>> {
        return std::unique_ptr<pipeline::SliceSink>(
            std::make_unique<GcvfSink>(settings.path, settings.flip_x));
    },
};

}  // namespace openfab::gcvf
