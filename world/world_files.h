// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Resolves the files that a world names. Worlds are untrusted, so a world reads below its own
// folder only, unless the user allows more.

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "base/json.h"
#include "texture/volume.h"
#include "world/json_reader.h"
#include "world/world.h"

namespace openfab::world {

class WorldFiles {
  public:
    WorldFiles(const std::filesystem::path& world, const FileRules& rules, JsonReader* json);

    /// Reads a path, relative to the world's folder, that the world may read.
    std::filesystem::path path(const JsonValue& value, const std::string& what);
    /// Reads a path of a file that must exist.
    /// `again`: a file that was read already is not read again for this.
    std::filesystem::path existing(const JsonValue& value, const std::string& what,
                                   bool again = true);
    /// Reads the path of one file, or of a volume's slices: a folder or a pattern with matches. Of a file
    /// of several steps, series or levels, the options say which one's data belong to the world.
    std::filesystem::path images(const JsonValue& value, const std::string& what,
                                 const texture::VolumeOptions& options);
    /// Adds the words of a command that are files of the world's folder; they need not be.
    void words(const JsonValue& value, const std::vector<std::string>& command);
    /// Adds a file that a file of the world, at `value`, names in turn.
    void also(const JsonValue& value, const std::filesystem::path& file);

    /// Returns the world's folder.
    const std::filesystem::path& folder() const { return folder_; }
    /// Returns the folders below which files may be read, the world's own or its project's first.
    const std::vector<std::filesystem::path>& roots() const { return roots_; }
    /// Returns all files that were named, the world first.
    std::vector<std::filesystem::path> take() { return std::move(files_); }

  private:
    bool allowed(const std::filesystem::path& path) const;
    void check(const JsonValue& value, const std::string& what, const std::filesystem::path& path);
    void add(const JsonValue& value, const std::filesystem::path& file);

    std::filesystem::path folder_;
    std::vector<std::filesystem::path> roots_;  ///< without links and dots
    JsonReader& json_;
    std::vector<std::filesystem::path> files_;
    std::set<std::filesystem::path> known_;  ///< of files_, without links
    double read_again_bytes_ = 0;
};

}  // namespace openfab::world
