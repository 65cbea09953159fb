// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads ZIP archives in memory, as far as 3MF needs: stored and deflated entries, ZIP64, checksums.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace openfab::mesh {

/// An open archive.
class ZipFile {
  public:
    /// Opens an archive; `bytes` must outlive it. Errors: not an archive, cut short, or damaged.
    static Result<ZipFile> open(std::string_view bytes, const std::string& file);

    /// Returns whether there is an entry of this name, ignoring case and a leading slash. Names may
    /// be percent-encoded, here and in the archive.
    bool has(const std::string& name) const;

    /// Returns the names of all entries as they are written, in the order of their keys.
    std::vector<std::string> names() const;

    /// Reads an entry of at most `limit` bytes and verifies its checksum. Errors: no such entry,
    /// encrypted, of another method, damaged, larger, or of a compression ratio that text never
    /// reaches.
    Result<std::string> read(const std::string& name, int64_t limit = 1'000'000'000) const;

    /// Returns the key of an entry, the same for all spellings of its name.
    static std::string key(std::string_view name);

    /// Returns the last name of a path, without percent-encoding, for people.
    static std::string file_name(const std::string& path);

    /// Returns the name of what part `from` calls `name`: from the root of the archive if it begins
    /// with a slash or there is such an entry, else beside `from`; without `.` and `..`.
    std::string resolve(const std::string& from, const std::string& name) const;

  private:
    struct Entry {
        std::string name;     ///< as it is written
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

}  // namespace openfab::mesh
