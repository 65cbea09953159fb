// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Text that waits compressed in a file without a name until its turn in a package has come.
//
// Deflated pieces that end at a byte can be put one after another into one stream, so that nothing
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

namespace openfab::boundary {

/// Size and checksum of text that was deflated.
struct TextSum {
    int64_t bytes = 0;
    uint64_t crc = 0;
    void add(const TextSum& next);
};

/// Raw deflate of one text, ended at a byte; `last` ends the stream.
std::vector<uint8_t> deflate_text(std::string_view text, bool last, TextSum* sum);

class DeflateSpool {
  public:
    /// The file is made in `folder` and has no name from then on: it is gone with the process.
    static Result<std::unique_ptr<DeflateSpool>> create(const std::filesystem::path& folder);
    ~DeflateSpool();
    DeflateSpool(const DeflateSpool&) = delete;

    Result<void> append(std::string_view text);
    /// Ends the piece; nothing is appended after.
    Result<void> end();
    const TextSum& sum() const { return sum_; }
    int64_t packed_bytes() const { return packed_; }
    /// Hands on all that was packed, in pieces.
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

}  // namespace openfab::boundary
