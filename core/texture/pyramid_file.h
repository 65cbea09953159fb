// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The `.oftx` file, little-endian:
//
//   offset  bytes  field
//   0       8      magic "OFTX\r\n\x1a\n"
//   8       4      version (kFileVersion)
//   12      4      channels
//   16      4      width of level 0
//   20      4      height of level 0
//   24      4      levels
//   28      4      depth of level 0 of a volume, 0 of a picture, -1 of a picture whose last channel
//                  is alpha
//   32      8      content key: hash of the image file and of the options it was made with
//   40      8      byte offset of the texels, a multiple of 64
//   48      8      byte offset of the min-max values, a multiple of 64
//   56      8      bytes of the whole file
//   64      8      checksum of the whole file except these bytes
//   72      16 n   level table: texel offset, width, height, min-max offset (as in the info block
//   of pyramid.h)
//
// The table of a volume is 28 + 20 n bytes long: its origin and extent, six floats, and 1 where it
// is a look-up table (else 0), then the level table with its 5 values. All else follows from sizes
// and channels; a reader computes it and refuses a file that differs.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "base/clean_exit.h"
#include "base/input_file.h"
#include "base/result.h"
#include "texture/pyramid_layout.h"

namespace openfab::texture {

constexpr int32_t kFileVersion = 3;

/// Returns the file size of a pyramid.
int64_t pyramid_file_bytes(const PyramidLayout& layout);

/// A file that is being written, mapped at its full size. Written pages are released now and then,
/// so that memory does not grow with the picture. Nothing appears under the final name until
/// `finish`; without it the temporary file is removed.
class PyramidWriter {
  public:
    /// Creates `file`.tmp-… beside the final name. Errors: kOutside with the system's reason.
    static Result<std::unique_ptr<PyramidWriter>> create(const std::filesystem::path& file,
                                                         const PyramidLayout& layout,
                                                         uint64_t content_key);
    ~PyramidWriter();
    PyramidWriter(const PyramidWriter&) = delete;
    PyramidWriter& operator=(const PyramidWriter&) = delete;

    /// Returns level 0, bottom row first, interleaved, for the caller to fill.
    float* level0() { return texels_; }
    /// Must be called after bytes were written or read again.
    void wrote(int64_t bytes);
    /// Makes the other levels and the min-max values, and renames the file into place.
    Result<void> finish();

  private:
    PyramidWriter() = default;

    std::filesystem::path file_;
    std::filesystem::path temporary_;
    std::optional<RemovedAtEnd> at_end_;  ///< of temporary_
    PyramidLayout layout_;
    int descriptor_ = -1;  ///< locked as long as the writer lives
    void* mapping_ = nullptr;
    size_t bytes_ = 0;
    int64_t held_bytes_ = 0;  ///< upper bound of resident bytes of the mapping
    float* texels_ = nullptr;
    float* minmax_ = nullptr;
};

/// The contents of a mapped file, its header checked against its size.
struct PyramidView {
    PyramidLayout layout;
    uint64_t content_key = 0;
    const float* texels = nullptr;
    const float* minmax = nullptr;
};

/// Verifies the checksum of the whole file; errors do not name the file.
Result<void> check_pyramid_file(const InputFile& file);

/// Reads the header at `data`; errors do not name the file.
Result<PyramidView> parse_pyramid_file(const void* data, size_t bytes);

}  // namespace openfab::texture
