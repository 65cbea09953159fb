// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/words.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "base/caret.h"
#include "base/json_text.h"
#include "base/result.h"

namespace openfab::viewer {

namespace {

const std::string& text_of(const JsonValue& event, std::string_view key) {
    static const std::string kNone;
    const JsonValue* member = member_of(event, key);
    return member != nullptr ? member->text : kNone;
}

int32_t number_of(const JsonValue& event, std::string_view key) {
    const JsonValue* member = member_of(event, key);
    return member != nullptr ? static_cast<int32_t>(member->number) : 0;
}

void add_error(const JsonValue& event, PrintWords* words) {
    const std::string& setting = text_of(event, "setting");
    const SourceLocation location{text_of(event, "file"), number_of(event, "line"),
                                  number_of(event, "column")};
    const Error error = error_at(location, text_of(event, "text"), text_of(event, "help"));
    if (setting.empty()) {
        words->text += render_error(error);
    } else {
        words->settings.push_back({setting, error.text()});
    }
}

}  // namespace

std::string PrintWords::all() const {
    std::string all = text;
    for (const SettingError& one : settings)
        all += render_error(user_error("--set " + one.setting + ": " + one.text));
    return all;
}

PrintWords words_of(const std::string& err, bool went_well) {
    PrintWords words;
    for (size_t from = 0; from < err.size();) {
        const size_t to = std::min(err.find('\n', from), err.size());
        const std::string_view line = std::string_view(err).substr(from, to - from);
        from = to + 1;
        if (!line.starts_with('{')) {
            if (!went_well || line.starts_with("warning: ")) words.text += std::string(line) + '\n';
            continue;
        }
        const Result<JsonValue> event = parse_json(line, "event");
        if (!event) continue;
        const std::string& kind = text_of(*event, "event");
        if (kind == "warning") words.text += "warning: " + text_of(*event, "text") + '\n';
        if (kind == "error" && !went_well) add_error(*event, &words);
    }
    return words;
}

std::optional<JsonValue> last_progress(const std::string& err) {
    const size_t end = err.rfind('\n');
    if (end == std::string::npos) return {};
    const size_t from = err.rfind("{\"event\": \"progress\"", end);
    if (from == std::string::npos) return {};
    Result<JsonValue> read =
        parse_json(std::string_view(err).substr(from, err.find('\n', from) - from), "progress");
    return read ? std::optional(std::move(*read)) : std::nullopt;
}

}  // namespace openfab::viewer
