// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <utility>

#include "client/fablet_compiler.h"
#include "tools/viewer/live.h"
#include "tools/viewer/messages.h"
#include "tools/viewer/uniform_value.h"

namespace openfab::viewer {

Result<std::string> Live::try_value(int32_t fablet, const std::string& text,
                                    const std::string& name, const std::string& uniform,
                                    const JsonValue& value) {
    const Result<Source> of = source_of(fablet);
    if (!of) return of.error();
    constexpr const char* kLetters =
        "_0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
    if (uniform.find_first_not_of(kLetters) != std::string::npos || !is_uniform_value(value))
        return user_error(messages::kNoUniformValue);
    std::shared_ptr<const Trial> trial;
    {
        const std::lock_guard lock(mutex_);
        trial = trial_;
    }
    // One text for all values of a drag: its kernel is kept.
    if (trial == nullptr || trial->source != of->path || trial->text != text) {
        Result<std::unique_ptr<TemporaryFolder>> folder =
            TemporaryFolder::create(folder_->path() / "tried");
        if (!folder) return folder.error();
        Result<std::filesystem::path> file = client::put_source((*folder)->path(), of->path, text);
        if (!file) return file.error();
        trial =
            std::make_shared<Trial>(Trial{of->path, text, std::move(*file), std::move(*folder)});
    }
    JsonText json;
    json.value(value);
    const std::string text_of_value = json.take();
    const std::lock_guard lock(mutex_);
    if (read_.world == nullptr) return user_error(messages::kNoWorldYet);
    trial_ = std::move(trial);
    trial_settings_.clear();
    for (const world::Object& object : read_.world->objects) {
        const auto ref = read_.world->fablets.find(object.fablet);
        if (ref != read_.world->fablets.end() && ref->second.source == of->path &&
            ref->second.fablet == name)
            trial_settings_.push_back(fmt::format("{}.{}={}", object.name, uniform, text_of_value));
    }
    touch();
    JsonText out;
    out.begin_object().member("change", change_).end_object();
    return out.take();
}

void Live::end_try() {
    const std::lock_guard lock(mutex_);
    if (trial_ == nullptr) return;
    trial_ = nullptr;
    trial_settings_.clear();
    touch();
}

}  // namespace openfab::viewer
