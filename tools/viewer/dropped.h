// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Files that are dropped on the page: meshes and pictures, which become part of the world. They come in pieces, are
// read by `openfab import`, and only what that takes is copied beside the world, under a name that nothing has.

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>

#include "base/result.h"

namespace openfab::viewer {

/// Thread-safe.
class Dropped {
  public:
    /// `programs`: the folder of openfab; `scratch`: one that exists, for what comes.
    Dropped(std::filesystem::path programs, std::filesystem::path scratch)
        : programs_(std::move(programs)), scratch_(std::move(scratch)) {}

    /// Adds bytes to a file; `at` is how many there are: 0 begins it.
    Result<void> add(const std::string& name, int64_t at, const std::string& bytes);

    struct Made {
        std::string world;  ///< its new text
        std::string notes;  ///< what the user should know, a line each
        std::string entry;  ///< its name in the world
        bool is_mesh = false;
    };
    /// Puts a file that has come into the folder of a world, whose text this is: a mesh becomes that of an object, a
    /// picture a texture. `repair`: a mesh that is not closed is made so.
    Result<Made> use(const std::string& name, const std::string& object,
                     const std::filesystem::path& world, const std::string& text, bool repair);

  private:
    Result<Made> use_mesh(const std::filesystem::path& file, const std::string& object,
                          const std::filesystem::path& world, const std::string& text,
                          bool repair) const;

    std::filesystem::path programs_, scratch_;
    std::mutex mutex_;
};

}  // namespace openfab::viewer
