// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "client/print_words.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "base/caret.h"
#include "base/exit_kind.h"
#include "base/json_text.h"
#include "client/child.h"
#include "client/members.h"

namespace openfab::client {

namespace {

Error error_of(const JsonValue& event) {
    const SourceLocation location{text_member(event, "file"),
                                  static_cast<int32_t>(number_member(event, "line")),
                                  static_cast<int32_t>(number_member(event, "column"))};
    return error_at(location, text_member(event, "text"), text_member(event, "help"));
}

void add_error(const JsonValue& event, PrintWords* words) {
    const std::string setting = text_member(event, "setting");
    const Error error = error_of(event);
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
        const std::string kind = text_member(*event, "event");
        if (kind == "warning") words.text += "warning: " + text_member(*event, "text") + '\n';
        if (kind == "error" && !went_well) add_error(*event, &words);
    }
    return words;
}

Error print_error(const std::string& err, int code) {
    const size_t from = err.rfind("{\"event\": \"error\"");
    if (from == std::string::npos) return relayed_error(err, code);
    const Result<JsonValue> event =
        parse_json(std::string_view(err).substr(from, err.find('\n', from) - from), "error");
    if (!event) return relayed_error(err, code);
    Error error = error_of(*event);
    const ErrorCode kind = kind_of_exit(code);
    error.code = kind == ErrorCode::kUsage ? ErrorCode::kUserInput : kind;
    return error;
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

}  // namespace openfab::client
