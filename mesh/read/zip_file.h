// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// ZIP archives in memory, as 3MF needs them: stored and deflated entries, ZIP64, checksums.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "base/result.h"

namespace openfab::scene {

class ZipFile {
  public:
    /// `bytes` must outlive this. Errors: no archive, cut short, or damaged.
    static Result<ZipFile> open(std::string_view bytes, const std::string& file);

    /// Names are compared without case, and without a slash before them.
    bool has(const std::string& name) const;

    /// The content of an entry of at most `limit` bytes, its checksum compared. Errors: none of
    /// this name, encrypted, of another method, damaged, larger, or packed tighter than text ever
    /// is.
    Result<std::string> read(const std::string& name, int64_t limit = 1'000'000'000) const;

    /// The name by which an entry is found, the same for all spellings of it.
    static std::string key(std::string_view name);

  private:
    struct Entry {
        uint64_t offset = 0;  ///< of its local header
        uint64_t compressed = 0;
        uint64_t size = 0;
        uint32_t checksum = 0;
        uint16_t method = 0;
        bool encrypted = false;
    };

    std::string_view bytes_;
    std::string file_;
    std::map<std::string, Entry> entries_;
};

}  // namespace openfab::scene
