// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `export` and `merge` share: slices of .ofr files are read and written as something else.

#include <memory>
#include <string>
#include <vector>

#include "backends/ofr/ofr_reader.h"
#include "backends/read/print_file.h"
#include "base/result.h"
#include "tools/openfab/commands.h"

namespace openfab::tools {

/// Completes `options` (previews, colours, format) and checks what can be checked before a file is
/// read. Returns the bytes that `--memory` allows.
Result<int64_t> prepare_copy(ExportOptions* options);

/// Chooses the format and checks, before any output is opened, that writing slices of `info` fits
/// into `memory_bytes` and that no output is one of `inputs`.
Result<void> check_copy(ExportOptions* options, const std::vector<std::string>& inputs,
                        const pipeline::PrintInfo& info, int64_t memory_bytes);

/// Passes all slices that the reader has left to the sink.
Result<void> copy_slices(ofr::OfrReader* reader, pipeline::SliceSink* sink);

/// Same for a print of any kind, all of whose slices must be there; returns its totals.
Result<pipeline::PrintTotals> copy_slices(const prints::PrintFile& print,
                                          pipeline::SliceSink* sink);

/// Adds what `reader` has read so far to `totals`, whose codes are as many; not the tight box.
void add_slices_read(const ofr::OfrReader& reader, pipeline::PrintTotals* totals);

}  // namespace openfab::tools
