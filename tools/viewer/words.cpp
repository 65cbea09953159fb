// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/words.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "base/json_text.h"

namespace openfab::viewer {

namespace {

/// How a print with `--progress json` begins a line that warns.
constexpr std::string_view kWarning = "{\"event\": \"warning\"";

}  // namespace

std::string words_of(const std::string& err, bool went_well) {
    std::string words;
    for (size_t from = 0; from < err.size();) {
        const size_t to = std::min(err.find('\n', from), err.size());
        const std::string_view line = std::string_view(err).substr(from, to - from);
        if (line.starts_with(kWarning)) {
            const Result<JsonValue> event = parse_json(line, "event");
            const JsonValue* text = event ? member_of(*event, "text") : nullptr;
            if (text != nullptr) words += "warning: " + text->text + '\n';
        } else if (went_well ? line.starts_with("warning: ") : !line.starts_with('{')) {
            words += std::string(line) + '\n';
        }
        from = to + 1;
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
