// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes ZIP packages, by minizip.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "backends/common/deflate_spool.h"
#include "backends/common/output_file.h"

namespace openfab::backends {

/// A package in a file. Entries are written one after another; they have no timestamps, so the same
/// entries give the same bytes.
class Package {
  public:
    /// `file` must be empty, allow writes at any offset, and outlive this.
    static Result<std::unique_ptr<Package>> create(OutputFile* file);
    ~Package();
    Package(const Package&) = delete;

    Result<void> add(const std::string& name, std::string_view text);
    /// Begins an entry of so many bytes, which `write` adds and `end` ends: deflated, unless it is large.
    Result<void> begin(const std::string& name, int64_t bytes);
    Result<void> write(std::span<const uint8_t> bytes) { return write_packed(bytes); }
    Result<void> end();
    /// Begins an entry that is already deflated, of at most `most_bytes` before and after.
    Result<void> begin_packed(const std::string& name, int64_t most_bytes);
    Result<void> write_packed(std::span<const uint8_t> bytes);
    Result<void> end_packed(const TextSum& sum);
    /// Writes the directory; without it the file is not a valid package.
    Result<void> close();

  private:
    /// The stream that minizip writes to.
    struct Stream {
        OutputFile* file = nullptr;
        int64_t at = 0;
        std::optional<Error> error;
    };
    struct Callbacks;

    Package() = default;
    Result<void> checked(int status, const char* what);
    Result<void> open(const std::string& name, bool packed, bool large, bool deflated = true);

    std::unique_ptr<Stream> stream_ = std::make_unique<Stream>();
    void* zip_ = nullptr;
};

}  // namespace openfab::backends
