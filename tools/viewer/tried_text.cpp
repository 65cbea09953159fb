// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/tried_text.h"

#include <fmt/format.h>

#include <utility>

#include "client/fablet_compiler.h"
#include "tools/viewer/messages.h"
#include "tools/viewer/uniform_value.h"

namespace openfab::viewer {

TriedText::Trial TriedText::now() const {
    const std::lock_guard lock(mutex_);
    return trial_;
}

Result<void> TriedText::put(const WorldReading& reading, const FabletSource& source,
                            const std::string& text, const std::string& name,
                            const std::string& uniform, const JsonValue& value) {
    constexpr const char* kLetters =
        "_0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
    if (uniform.find_first_not_of(kLetters) != std::string::npos || !is_uniform_value(value))
        return user_error(messages::kNoUniformValue);
    if (reading.world == nullptr) return user_error(messages::kNoWorldYet);
    Trial trial{now().text, {}};
    if (trial.text == nullptr || trial.text->source != source.path || trial.text->text != text) {
        Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create(scratch_);
        if (!folder) return folder.error();
        Result<std::filesystem::path> file =
            client::put_source((*folder)->path(), source.path, text);
        if (!file) return file.error();
        trial.text = std::make_shared<const Text>(
            Text{source.path, text, std::move(*file), std::move(*folder)});
    }
    JsonText json;
    json.value(value);
    const std::string text_of_value = json.take();
    for (const world::Object& object : reading.world->objects) {
        const auto ref = reading.world->fablets.find(object.fablet);
        if (ref != reading.world->fablets.end() && ref->second.source == source.path &&
            ref->second.fablet == name)
            trial.settings.push_back(fmt::format("{}.{}={}", object.name, uniform, text_of_value));
    }
    const std::lock_guard lock(mutex_);
    trial_ = std::move(trial);
    return {};
}

bool TriedText::end() {
    const std::lock_guard lock(mutex_);
    return std::exchange(trial_, {}).text != nullptr;
}

}  // namespace openfab::viewer
