// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The list of the shards that a writer has finished: text, a line a slab behind one that says of which print and of
// which slices it is, and at the end the totals of these. Each line ends with its own checksum; what follows a damaged
// line does not count.
//
//   openfab-zarr 1 of IDENTITY slices A:B xxh3 SUM
//   slab 7 BYTES:DIGEST BYTES:DIGEST … xxh3 SUM          levels 0, 1, …; `0:0` for a shard that is void
//   end solid N hash HASH tight X0 Y0 Z0 X1 Y1 Z1 codes N N … xxh3 SUM

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "backends/zarr/shard.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::zarr {

struct ShardList {
    int32_t begin = 0, end = 0;  ///< slices
    /// Of the slabs from `begin` on, each with its levels.
    std::vector<std::vector<ShardDigest>> slabs;
    std::optional<pipeline::PrintTotals> totals;  ///< once all are there
    size_t bytes = 0;                             ///< of its good lines, `end` not among them
};

/// Returns `openfab/000000-000064.list`.
std::string list_name(int32_t begin, int32_t end);

std::string list_head(std::string_view identity, int32_t begin, int32_t end);
std::string slab_line(int32_t slab, const std::vector<ShardDigest>& shards);
std::string end_line(const pipeline::PrintTotals& totals);

/// Reads a list of the print; none where it is of another one. `levels`: digests of each slab.
std::optional<ShardList> parse_list(std::string_view text, std::string_view identity,
                                    size_t levels);

}  // namespace openfab::zarr
