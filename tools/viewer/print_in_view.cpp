// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/print_in_view.h"

#include <utility>

#include "tools/viewer/messages.h"

namespace openfab::viewer {

namespace fs = std::filesystem;

/// The caller holds the lock.
Result<void> PrintInView::show(const PrintOfValues& print, const std::string& name, bool full) {
    if (print.file.empty()) return user_error(messages::kNoPrintYet);
    if (Result<void> shown = session_->show(print.file.string(), name); !shown) return shown;
    settings_ = print.settings;
    shows_full_ = full;
    return {};
}

std::optional<Vec3i> PrintInView::show_draft(PrintOfValues draft) {
    const std::lock_guard lock(mutex_);
    if (!show(draft, world_, false)) return {};
    // The session has it open as long as it needs it.
    std::error_code ignored;
    if (!draft_.file.empty()) fs::remove(draft_.file, ignored);
    draft_ = std::move(draft);
    const Session::Prints prints = session_->prints();
    return prints.list.empty() ? Vec3i{} : prints.list[0]->file().info().size;
}

bool PrintInView::was_shown(const fs::path& draft) const {
    const std::lock_guard lock(mutex_);
    return draft_.file == draft;
}

Result<void> PrintInView::show_draft_again() {
    const std::lock_guard lock(mutex_);
    return show(draft_, world_, false);
}

Result<void> PrintInView::show_full(const PrintOfValues& full) {
    const std::lock_guard lock(mutex_);
    return show(full, full.file.filename().string(), true);
}

bool PrintInView::shows_full() const {
    const std::lock_guard lock(mutex_);
    return shows_full_;
}

std::vector<std::string> PrintInView::settings() const {
    const std::lock_guard lock(mutex_);
    return settings_;
}

}  // namespace openfab::viewer
