// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a hand that drags a number in a fablet's text sees: the world with another text of that fablet, in which the number
// is a uniform, and the uniform's value in all objects of it. One text serves all values of a drag: its kernel is kept.

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/own_folder.h"
#include "base/result.h"
#include "tools/viewer/watched_world.h"

namespace openfab::viewer {

/// Thread-safe.
class TriedText {
  public:
    /// `scratch`: a folder that exists, for texts.
    explicit TriedText(std::filesystem::path scratch) : scratch_(std::move(scratch)) {}

    struct Text {
        std::filesystem::path source;  ///< in place of this
        std::string text;
        std::filesystem::path file;
        std::unique_ptr<TemporaryFolder> folder;  ///< of the file
    };
    struct Trial {
        std::shared_ptr<const Text> text;   ///< nullptr: nothing is tried
        std::vector<std::string> settings;  ///< as `openfab print --set` takes them
    };
    Trial now() const;
    /// Tries a text of a source, whose fablet `name` has a `uniform` of this value. User errors where it has none.
    Result<void> put(const WorldReading& reading, const FabletSource& source,
                     const std::string& text, const std::string& name, const std::string& uniform,
                     const JsonValue& value);
    /// Returns whether anything was tried.
    bool end();

  private:
    std::filesystem::path scratch_;
    mutable std::mutex mutex_;
    Trial trial_;
};

}  // namespace openfab::viewer
