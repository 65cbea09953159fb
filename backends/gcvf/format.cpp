// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/gcvf/format.h"

#include "backends/gcvf/gcvf_sink.h"
#include "backends/gcvf/messages.h"

namespace openfab::gcvf {

const backends::Format kGcvfFormat{
    .name = "gcvf",
    .extension = ".gcvf",
    .flips_x = true,
    .not_resumed = messages::kNotResumed,
    .ended_early = messages::kEndedEarly,
    .bytes_per_column = [](size_t) { return kBytesPerColumn; },
    .files = backends::one_renamed_file,
    .open = [](const backends::OutputSettings& settings)
        -> Result<std::unique_ptr<pipeline::SliceSink>> {
        return std::unique_ptr<pipeline::SliceSink>(
            std::make_unique<GcvfSink>(settings.path, settings.flip_x));
    },
};

}  // namespace openfab::gcvf
