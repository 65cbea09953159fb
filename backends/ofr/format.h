// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The `.ofr` file: device voxels, slice by slice, from the bottom up. It is written front to back
// and can be read front to back, so a pipe does; a file that was cut short is readable up to its
// last whole slice.
//
// All numbers are little-endian; `string` is a u32 length and that many bytes of UTF-8; `xxh3` is
// XXH3-64, seed 0.
//
//   header           u8[8]  magic "\x89OFR\r\n\x1a\n" (a text-mode copy breaks it visibly)
//                    u32    version, 2
//                    u32    n, bytes of the fields that follow
//     fields (n)     i32[3] size: voxels along x, y, z of the whole grid
//                    i32[2] first slice in the file, one past the last
//                    i32    bits a voxel, 4 or 8
//                    f64[3] pitch in mm
//                    f64[3] origin in mm: the lowest corner of voxel (0, 0, 0) in build space
//                    u64    seed of the dither
//                    string printer
//                    string title
//                    u32    materials; code c is the c-th from 1, code 0 is void
//       a material   string name
//                    u8[4]  slice key colour RGBA
//                    u8[4]  preview colour RGBA
//                    f64    density in g/cm3
//                    string printer channel
//                    u32    settings that decide the voxels besides the above; version 1 has none
//       a setting    string name, such as "dither" or "meshes"
//                    string value, such as "decorrelated" or a hash
//                    u64    xxh3 of all the above, magic included
//   slice, one for   u32    magic "SLCE"
//   each in order    i32    z
//                    u32    m, bytes of the zstd frame
//                    u32    0
//                    u64    xxh3 of the packed rows
//                    u64    xxh3 of the 24 bytes above
//                    u8[m]  zstd frame of the packed rows: height rows of ceil(width * bits / 8)
//                           bytes, lowest y first, at 4 bits voxel 2n in the low half of byte n
//   index            u32    magic "INDX"
//                    u32    k, bytes of the fields that follow
//     fields (k)     u32    slices; for each, i32 z and u64 offset of its magic from the start
//                           of the file
//                    i64    solid voxels
//                    u32    codes; for each, i64 voxels with it
//                    u64    hash of the print (the same for every format)
//                    i32[6] tight box of what is printed: lowest voxel, one past the highest
//                    u64    xxh3 of magic, k and fields
//                    u64    offset of the index from the start of the file
//                    u8[8]  "OFR-END\n"
//
// The file of an interrupted print has no index. A print with an equal header can resume it.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::ofr {

constexpr std::array<uint8_t, 8> kMagic{0x89, 'O', 'F', 'R', '\r', '\n', 0x1a, '\n'};
constexpr std::array<uint8_t, 8> kEndMagic{'O', 'F', 'R', '-', 'E', 'N', 'D', '\n'};
constexpr uint32_t kVersion = 2;
constexpr uint32_t kOldestVersion = 1;        ///< oldest version that is read
constexpr uint32_t kSliceMagic = 0x45434c53;  // "SLCE"
constexpr uint32_t kIndexMagic = 0x58444e49;  // "INDX"
constexpr size_t kPreambleBytes = 16;         ///< magic, version, length
constexpr size_t kSliceHeadBytes = 32;

// Limits of what a reader allocates for sizes that a file claims.
constexpr uint32_t kMaxHeaderBytes = 1U << 20;
constexpr int32_t kMaxSide = 1 << 20;
constexpr uint64_t kMaxSliceBytes =
    1ULL << 30;  ///< of packed rows; a 490 x 390 mm tray at 600 dpi takes 0.05 of it

/// Size limit of an index, for as many slices and 256 codes.
constexpr uint64_t kMaxIndexBytes = 12ULL * kMaxSide + 256 * 8 + 128;
constexpr size_t kIndexHeadBytes = 8;      ///< magic, length
constexpr size_t kIndexTailBytes = 8 + 8;  ///< offset of the index, end of the file

uint64_t checksum(std::span<const uint8_t> bytes);

struct SliceHead {
    int32_t z = 0;
    uint32_t frame_bytes = 0;
    uint64_t rows_checksum = 0;
};

struct IndexEntry {
    int32_t z = 0;
    uint64_t offset = 0;
    bool operator==(const IndexEntry&) const = default;
};

struct Index {
    std::vector<IndexEntry> slices;
    pipeline::PrintTotals totals;
};

std::vector<uint8_t> write_header(const pipeline::PrintInfo& info);
/// Returns how many bytes of a header follow its preamble of kPreambleBytes, the checksum included.
/// Errors do not name the file.
Result<size_t> header_bytes_left(std::span<const uint8_t> preamble);
/// Parses a whole header, from magic to checksum; errors do not name the file.
Result<pipeline::PrintInfo> read_header(std::span<const uint8_t> bytes);

std::array<uint8_t, kSliceHeadBytes> write_slice_head(const SliceHead& head);
/// Parses a slice head; `bytes` has kSliceHeadBytes.
Result<SliceHead> read_slice_head(std::span<const uint8_t> bytes);

/// Serialises the index, from its magic to the end of the file; `offset` is its position there.
std::vector<uint8_t> write_index(const Index& index, uint64_t offset);
/// Parses an index from its magic to its checksum; what follows is not read.
Result<Index> read_index(std::span<const uint8_t> bytes);

}  // namespace openfab::ofr
