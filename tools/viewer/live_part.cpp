// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The panel "Part" of the page: changes of the world, and their history.

#include <filesystem>

#include "base/replace_file.h"
#include "tools/viewer/live.h"
#include "tools/viewer/messages.h"
#include "tools/viewer/world_lock.h"

namespace openfab::viewer {

Result<void> Live::edit_part(const JsonValue& edits) {
    return change_world([&](const std::string& text) -> Result<std::string> {
        Result<std::string> made =
            part_edited(text, std::filesystem::path(options_.file).filename().string(), edits);
        if (made && *made != text) part_history_.record(text, *made);
        return made;
    });
}

Result<void> Live::step_part(bool forward) {
    return change_world([&](const std::string& text) -> Result<std::string> {
        std::optional<std::string> made = part_history_.step(text, forward);
        if (!made) return user_error(messages::kNothingToUndo);
        return std::move(*made);
    });
}

Result<void> Live::change_world(
    const std::function<Result<std::string>(const std::string&)>& change) {
    const Result<WorldLock> alone = WorldLock::take(&files_mutex_, options_.file);
    if (!alone) return alone.error();
    const Result<std::string> text = read_source(options_.file);
    if (!text) return text.error();
    const Result<std::string> made = change(*text);
    if (!made) return made.error();
    if (*made == *text) return {};
    if (Result<void> written = replace_file(options_.file, *made); !written) return written;
    const std::lock_guard lock(mutex_);
    touch();
    return {};
}

void Live::describe_part_of_world(JsonText* out) const {
    const Result<std::string> text = read_source(options_.file);
    describe_part(text ? *text : "{}", read_.world.get(), out);
}

}  // namespace openfab::viewer
