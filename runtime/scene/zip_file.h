// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// ZIP archives in memory, as 3MF needs them: stored and deflated entries, ZIP64, checksums.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "runtime/base/result.h"

namespace openfab::scene {

class ZipFile {
  public:
    /// `bytes` must outlive this. Errors: no archive, cut short, or damaged.
    static Result<ZipFile> open(std::string_view bytes, const std::string& file);

    /// Names are compared without case, and without a slash before them.
    bool has(const std::string& name) const;

    /// The content of an entry, its checksum compared. Errors: none of this name, encrypted, of
    /// another method, damaged, or larger than 1 GB.
    Result<std::string> read(const std::string& name) const;

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
