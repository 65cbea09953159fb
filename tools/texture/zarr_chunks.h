// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The bytes of the chunks of an array of Zarr: in files of their own or in shards, as codecs have packed them.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"
#include "texture/zarr_array.h"

namespace openfab::tools {

/// A file of an array, and what chunks it has.
class ZarrFile {
  public:
    /// Reads the index of a shard. Errors do not name the file; all sizes are checked against what the file has.
    static Result<ZarrFile> open(InputFile file, const texture::ZarrArray& array);

    /// Fills `out` with the chunk's bytes as numbers lie in memory but for their order of bytes. `number`: of the chunk in its
    /// shard, the last axis fastest. False where there is none.
    Result<bool> read(int64_t number, std::vector<char>* out) const;

  private:
    struct Place {
        uint64_t begin = 0, bytes = 0;
    };
    ZarrFile(InputFile file, const texture::ZarrArray& array)
        : file_(std::move(file)), array_(&array) {}
    Result<void> read_index();

    InputFile file_;
    const texture::ZarrArray* array_;
    std::vector<Place> places_;
};

/// Undoes the codecs of a chunk, which then has `bytes` bytes.
Result<void> decode_chunk(std::span<const texture::ZarrCodec> codecs, size_t bytes,
                          std::vector<char>* chunk);

}  // namespace openfab::tools
