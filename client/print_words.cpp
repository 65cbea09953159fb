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

/// The last whole line that is an event of this kind, whatever its spaces.
std::optional<JsonValue> last_event(std::string_view err, std::string_view kind) {
    for (size_t end = err.rfind('\n'); end != std::string_view::npos && end > 0;) {
        const size_t before = err.rfind('\n', end - 1);
        const size_t from = before == std::string_view::npos ? 0 : before + 1;
        const std::string_view line = err.substr(from, end - from);
        if (line.starts_with('{')) {
            Result<JsonValue> event = parse_json(line, "event");
            if (event && text_member(*event, "event") == kind) return std::move(*event);
        }
        end = before;
    }
    return std::nullopt;
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
            if (!went_well || line.starts_with("warning: ") || line.starts_with("note: "))
                words.text += std::string(line) + '\n';
            continue;
        }
        const Result<JsonValue> event = parse_json(line, "event");
        if (!event) continue;
        const std::string kind = text_member(*event, "event");
        if (kind == "warning" || kind == "note")
            words.text += kind + ": " + text_member(*event, "text") + '\n';
        if (kind == "error" && !went_well) add_error(*event, &words);
    }
    return words;
}

Error print_error(const std::string& err, int code) {
    const std::optional<JsonValue> event = last_event(err, "error");
    if (!event) return relayed_error(err, code);
    Error error = error_of(*event);
    const ErrorCode kind = kind_of_exit(code);
    error.code = kind == ErrorCode::kUsage ? ErrorCode::kUserInput : kind;
    return error;
}

std::optional<JsonValue> last_progress(const std::string& err) {
    return last_event(err, "progress");
}

}  // namespace openfab::client
