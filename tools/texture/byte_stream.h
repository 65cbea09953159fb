// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The bytes of a file from some place on, as they are or decompressed on the way.

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"

namespace openfab::tools {

/// Streams the bytes of a file.
class ByteStream {
  public:
    ByteStream(InputFile file, int64_t begin) : file_(std::move(file)), at_(begin) {}
    virtual ~ByteStream() = default;
    /// Reads up to `bytes` bytes; fewer only at the end.
    virtual Result<size_t> next(char* out, size_t bytes);
    /// Skips that many bytes.
    virtual Result<void> skip(int64_t bytes);
    /// Returns an upper bound of the number of bytes.
    virtual int64_t left() const { return file_.bytes() - at_; }

  private:
    InputFile file_;
    int64_t at_ = 0;
};

/// Opens the bytes from `begin` on.
std::unique_ptr<ByteStream> open_bytes(InputFile file, int64_t begin);
/// The same, decompressed: of gzip, of any number of members, or zlib.
std::unique_ptr<ByteStream> open_packed_bytes(InputFile file, int64_t begin);

/// Opens one file of several that hold data together.
using OpenPart = std::function<Result<std::unique_ptr<ByteStream>>()>;
/// Opens the first `share` bytes of each part, one behind the other; each is open only while it is read.
/// `first` is any file that is open.
Result<std::unique_ptr<ByteStream>> chain_bytes(InputFile first, std::vector<OpenPart> parts,
                                                int64_t share);

}  // namespace openfab::tools
