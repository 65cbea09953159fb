// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which print of a world is in view: the draft that was shown last, or the last whole print.

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "tools/viewer/session.h"

namespace openfab::viewer {

/// A print's file, with what was set of the world (`--set`).
struct PrintOfValues {
    std::filesystem::path file;
    std::vector<std::string> settings;
};

/// Thread-safe.
class PrintInView {
  public:
    /// `world`: what a draft is called. The session must outlive it.
    PrintInView(std::string world, Session* session)
        : world_(std::move(world)), session_(session) {}

    /// Shows a draft, and removes the one before. Returns its size in voxels, or nothing where it cannot be read yet.
    std::optional<Vec3i> show_draft(PrintOfValues draft);
    bool was_shown(const std::filesystem::path& draft) const;
    /// Whether there is no print yet.
    bool is_empty() const { return session_->prints().list.empty(); }
    /// Shows the last draft again; a user error where there is none.
    Result<void> show_draft_again();
    /// Shows a whole print; a user error where it has no file.
    Result<void> show_full(const PrintOfValues& full);
    bool shows_full() const;
    /// What was set of the print in view.
    std::vector<std::string> settings() const;

  private:
    Result<void> show(const PrintOfValues& print, const std::string& name, bool full);

    std::string world_;
    Session* session_;
    mutable std::mutex mutex_;
    PrintOfValues draft_;                ///< that was shown last
    std::vector<std::string> settings_;  ///< of the one in view
    bool shows_full_ = false;
};

}  // namespace openfab::viewer
