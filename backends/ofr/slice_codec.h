// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One slice as bytes: its head and the zstd frame of its packed rows (format.h).

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "backends/ofr/format.h"

namespace openfab::ofr {

/// Level of zstd. Measured on a dithered slice of 2362 x 827 voxels, CPU time of one core of a
/// 2-core AVX2 machine: 730 M voxels/s and 231 kB; level 3 takes a quarter longer for 3 % less,
/// level 6 six times as long for 9 % less. A slice of few runs goes at more than 2 G voxels/s, at
/// either level.
constexpr int kZstdLevel = 1;

/// Compresses a slice; empty where memory ran out. Threads keep what zstd works in.
std::vector<uint8_t> encode_slice(const pipeline::SliceView& slice);

/// Decompresses a frame into `rows`, which has the size of the packed rows, and compares their
/// checksum; the error does not name the slice.
Result<void> decode_frame(const SliceHead& head, std::span<const uint8_t> frame,
                          std::span<uint8_t> rows);

/// Counts the voxels of packed rows by their codes, also those that no material has. The unused half
/// of a row's last byte counts as void.
std::array<int64_t, 256> count_codes(std::span<const uint8_t> rows, int32_t bits);

/// Returns the most bytes that the frame of `raw` bytes of packed rows takes.
size_t most_frame_bytes(size_t raw);

}  // namespace openfab::ofr
