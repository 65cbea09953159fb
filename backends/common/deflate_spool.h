// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Spools compressed text in an unnamed file until it is copied to a package.
//
// Deflated pieces that end at a byte boundary can be concatenated into one stream, so that nothing
// is compressed twice.

#include <zlib.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace openfab::backends {

/// Size and checksum of uncompressed text.
struct TextSum {
    int64_t bytes = 0;
    uint64_t crc = 0;
    void add(const TextSum& next);
};

/// Deflates one text, raw, up to a byte boundary; `last` ends the stream.
std::vector<uint8_t> deflate_text(std::string_view text, bool last, TextSum* sum);

class DeflateSpool {
  public:
    /// Creates an unnamed file in `folder`, which disappears with the process.
    static Result<std::unique_ptr<DeflateSpool>> create(const std::filesystem::path& folder);
    ~DeflateSpool();
    DeflateSpool(const DeflateSpool&) = delete;

    Result<void> append(std::string_view text);
    /// Ends the text; nothing may be appended after.
    Result<void> end();
    const TextSum& sum() const { return sum_; }
    int64_t packed_bytes() const { return packed_; }
    /// Passes all compressed bytes to `take`, in pieces.
    Result<void> read(const std::function<Result<void>(std::span<const uint8_t>)>& take) const;

  private:
    DeflateSpool(int fd, std::string name) : fd_(fd), name_(std::move(name)) {}
    Result<void> pack(std::string_view text, int flush);
    Result<void> write(size_t bytes);

    int fd_;
    std::string name_;  ///< of the folder, for messages
    z_stream stream_{};
    std::vector<uint8_t> buffer_;
    TextSum sum_;
    int64_t packed_ = 0;
};

}  // namespace openfab::backends
