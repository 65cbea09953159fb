// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The files that a world names. Worlds come from strangers, so a world reads below its own folder
// only, unless the person who runs it allows more.

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "base/json.h"
#include "world/json_reader.h"
#include "world/world.h"

namespace openfab::scene {

class WorldFiles {
  public:
    WorldFiles(const std::filesystem::path& world, const FileRules& rules, JsonReader* json);

    /// A path, which counts from the world's folder, and may be read.
    std::filesystem::path path(const JsonValue& value, const std::string& what);
    /// A path that must name a file.
    std::filesystem::path existing(const JsonValue& value, const std::string& what);
    /// One file, or the slices of a volume: a folder, or a pattern that names some.
    std::filesystem::path images(const JsonValue& value, const std::string& what);
    /// A file that a file of the world names in turn, at `value`.
    void also(const JsonValue& value, const std::filesystem::path& file);

    /// The folders below which files may be read: the world's own, or its project's, first.
    const std::vector<std::filesystem::path>& roots() const { return roots_; }
    /// All that were named, the world first.
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

}  // namespace openfab::scene
