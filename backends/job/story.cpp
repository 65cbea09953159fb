// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "backends/common/output_lock.h"
#include "backends/job/messages.h"
#include "backends/job/processes.h"
#include "backends/job/record.h"
#include "base/json_text.h"

namespace openfab::job {

namespace {

namespace fs = std::filesystem;

constexpr size_t kLargestRecord = 128 << 20;

}  // namespace

Result<JsonValue> read_record(const fs::path& file) {
    const Result<std::string> text = read_text_file(file, kLargestRecord);
    if (!text) return text.error();
    Result<JsonValue> record = parse_json(*text, file.string());
    if (!record) return record;
    const JsonValue* format =
        record->is(JsonValue::Kind::kObject) ? member_of(*record, "format") : nullptr;
    if (format == nullptr || format->text != "openfab.job")
        return user_error(fmt::format(messages::kNoRecord, file.string()));
    return record;
}

namespace {

std::string text_of(const JsonValue& object, const char* name) {
    const JsonValue* value = member_of(object, name);
    return value != nullptr && value->is(JsonValue::Kind::kString) ? value->text : std::string();
}

int64_t number_of(const JsonValue& object, const char* name) {
    const JsonValue* value = member_of(object, name);
    constexpr double kMost = 9e15;
    const bool fits = value != nullptr && value->is(JsonValue::Kind::kNumber) &&
                      value->number >= -kMost && value->number <= kMost;
    return fits ? static_cast<int64_t>(value->number) : 0;
}

const JsonValue* last_event(const JsonValue& record) {
    const JsonValue* events = member_of(record, "events");
    const bool any = events != nullptr && !events->items.empty() &&
                     events->items.back().is(JsonValue::Kind::kObject);
    return any ? &events->items.back() : nullptr;
}

/// "2026-11-29 17:40:00 UTC"
std::string time_of(const JsonValue& event) {
    std::string time = text_of(event, "time");
    if (time.size() != 20 || time[10] != 'T' || time.back() != 'Z') return time;
    time[10] = ' ';
    return time.substr(0, 19) + " UTC";
}

std::string stop_text(const JsonValue& event) {
    const std::string by = text_of(event, "by");
    std::string text = fmt::format(messages::kStopped, time_of(event));
    if (by == "signal") {
        text += fmt::format(messages::kBySignal, text_of(event, "signal"));
        if (number_of(event, "sender") > 0)
            text += fmt::format(messages::kFromProcess, number_of(event, "sender"));
    } else if (!by.empty()) {
        text += by == "error"   ? messages::kByError
                : by == "limit" ? messages::kByLimit
                                : messages::kWithItsLine;
    }
    if (member_of(event, "slice") != nullptr)
        text += fmt::format(messages::kBeforeSlice, number_of(event, "slice"));
    if (const std::string error = text_of(event, "error"); !error.empty()) text += ": " + error;
    return text;
}

/// Returns the names of the inputs that the event says to be others; empty where there are none.
std::string changed_names(const JsonValue& event) {
    const JsonValue* changed = member_of(event, "changed_inputs");
    std::string names;
    if (changed == nullptr) return names;
    for (const JsonValue& name : changed->items)
        names += (names.empty() ? "`" : ", `") + name.text + "`";
    return names;
}

std::string event_text(const JsonValue& event) {
    const std::string what = text_of(event, "event");
    if (what == "stop") return stop_text(event);
    const std::string changed = changed_names(event);
    if (what == "complete") {
        std::string text = fmt::format(messages::kComplete, time_of(event), text_of(event, "hash"));
        if (!changed.empty()) text += fmt::format(messages::kChangedMeanwhile, changed);
        return text;
    }
    const std::string when = time_of(event), host = text_of(event, "host");
    const int64_t process = number_of(event, "process");
    std::string text = what == "resume" ? fmt::format(messages::kResumed, when, process, host)
                                        : fmt::format(messages::kStarted, when, process, host);
    if (number_of(event, "slices") > 0)
        text += fmt::format(messages::kAfterSlices, number_of(event, "slices"));
    if (const std::string from = text_of(event, "from"); !from.empty())
        text += fmt::format(messages::kFrom, from);
    if (!changed.empty()) text += fmt::format(messages::kChangedSince, changed);
    return text;
}

}  // namespace

std::string state_of(const JsonValue& record, const fs::path& output) {
    std::string state = text_of(record, "state");
    if (state != "running") return state;
    const JsonValue* last = last_event(record);
    if (last == nullptr) return "interrupted";
    const int64_t began = number_of(*last, "process_start");
    // Another machine's processes are not seen from here; its lock is, where the file system has them.
    const bool runs = text_of(*last, "host") == host_name() && began != 0 &&
                      start_of_process(number_of(*last, "process")) == began;
    return runs || backends::is_locked(output.string()) ? "running" : "interrupted";
}

std::optional<JsonValue> record_of(const fs::path& output, std::optional<uint64_t> hash) {
    std::error_code status;
    const fs::path file = record_file(output.string());
    if (file.empty() || !fs::exists(file, status)) return {};
    Result<JsonValue> record = read_record(file);
    if (!record) return {};
    // What stands beside a file may be of one that was there before.
    const bool complete = text_of(*record, "state") == "complete";
    if (complete != hash.has_value()) return {};
    if (complete && text_of(*record, "hash") != fmt::format("{:016x}", *hash)) return {};
    return std::move(*record);
}

std::vector<std::string> story_lines(const JsonValue& record, const fs::path& output) {
    constexpr size_t kMostLines = 12;
    std::vector<std::string> out;
    const JsonValue* events = member_of(record, "events");
    if (events == nullptr) return out;
    const size_t count = events->items.size();
    const size_t first = count > kMostLines ? count - kMostLines : 0;
    const int64_t before = number_of(record, "events_forgotten") + static_cast<int64_t>(first);
    if (before > 0) out.push_back(fmt::format(messages::kEventsBefore, before));
    for (size_t i = first; i < count; ++i) {
        if (events->items[i].is(JsonValue::Kind::kObject))
            out.push_back(event_text(events->items[i]));
    }
    if (text_of(record, "state") == "running") {
        out.push_back(state_of(record, output) == "running" ? messages::kRuns
                                                            : messages::kNobodyWrites);
    }
    return out;
}

}  // namespace openfab::job
