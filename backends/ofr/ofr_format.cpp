// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/ofr/ofr_format.h"

#include "backends/ofr/ofr_sink.h"
#include "backends/ofr/slice_codec.h"

namespace openfab::ofr {

const backends::Format kOfrFormat{
    .name = "ofr",
    .extension = ".ofr",
    .streams = true,
    .open =
        [](const backends::OutputSettings& settings) {
            return settings.resume ? OfrSink::reopen(settings.path)
                                   : OfrSink::create(settings.path);
        },
    .encode = [](const pipeline::SliceView& slice, const pipeline::PrintInfo&,
                 const backends::OutputSettings&) { return encode_slice(slice); },
};

}  // namespace openfab::ofr
