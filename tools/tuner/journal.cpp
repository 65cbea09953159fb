// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/tuner/journal.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "base/hash.h"
#include "base/json.h"
#include "base/json_text.h"
#include "base/text.h"
#include "tools/tuner/messages.h"

namespace openfab::tuner {

namespace {

constexpr size_t kMostBytes = size_t{64} << 20;

std::string name_of(uint64_t hash) {
    return fmt::format("{:016x}", hash);
}

std::string first_line(const std::string& key) {
    return JsonText().begin_object().member("tunes", key).end_object().take();
}

std::string line_of(uint64_t hash, const Trial& trial) {
    JsonText out;
    out.begin_object().member("schedule", name_of(hash)).key("changes").begin_array();
    for (const std::string& change : trial.changes)
        out.value(change);
    out.end_array();
    if (!trial.refused.empty()) out.member("refused", trial.refused);
    out.key("ratios").begin_array();
    for (const double ratio : trial.ratios)
        out.value(ratio);
    out.end_array();
    if (trial.won) out.member("won", true);
    return out.end_object().take();
}

std::string text_of(const JsonValue& object, const char* key) {
    const JsonMember* member = object.find(key);
    return member != nullptr && member->value.is(JsonValue::Kind::kString) ? member->value.text
                                                                           : "";
}

const std::vector<JsonValue>& items_of(const JsonValue& object, const char* key) {
    static const std::vector<JsonValue> none;
    const JsonMember* member = object.find(key);
    return member != nullptr ? member->value.items : none;
}

}  // namespace

Result<Journal> Journal::open(const std::filesystem::path& file, const std::string& key) {
    Journal journal;
    journal.file_ = file;
    std::error_code status;
    if (!std::filesystem::exists(file, status)) {
        if (const Result<void> begun = journal.append(first_line(key)); !begun)
            return begun.error();
        return journal;
    }
    const Result<std::string> text = read_text_file(file, kMostBytes);
    if (!text) return text.error();
    const auto other = [&] {
        return user_error(fmt::format(messages::kNoJournalOfThis, file.string()),
                          messages::kNoJournalOfThisHelp);
    };
    size_t lines = 0, whole = 0;
    for (size_t at = 0; at < text->size();) {
        const size_t end = text->find('\n', at);
        if (end == std::string::npos) break;  // cut off
        const Result<JsonValue> line = parse_json(text->substr(at, end - at), file.string());
        at = whole = end + 1;
        if (!line || !line->is(JsonValue::Kind::kObject)) return other();
        if (lines++ == 0) {
            if (text_of(*line, "tunes") != valid_utf8(key)) return other();
            continue;
        }
        Trial trial;
        for (const JsonValue& change : items_of(*line, "changes"))
            trial.changes.push_back(change.text);
        trial.refused = text_of(*line, "refused");
        for (const JsonValue& ratio : items_of(*line, "ratios"))
            trial.ratios.push_back(ratio.number);
        const JsonMember* won = line->find("won");
        trial.won = won != nullptr && won->value.boolean;
        const std::string name = text_of(*line, "schedule");
        const uint64_t hash = std::strtoull(name.c_str(), nullptr, 16);
        if (name != name_of(hash)) return other();
        journal.trials_[hash] = std::move(trial);
    }
    if (lines == 0) return other();
    if (whole < text->size()) std::filesystem::resize_file(file, whole, status);
    return journal;
}

const Trial* Journal::find(const std::string& text) const {
    const auto found = trials_.find(xxh3(text));
    return found != trials_.end() ? &found->second : nullptr;
}

Result<void> Journal::add(const std::string& text, const Trial& trial) {
    const uint64_t hash = xxh3(text);
    trials_[hash] = trial;
    return append(line_of(hash, trial));
}

Result<void> Journal::append(const std::string& line) const {
    std::ofstream out(file_, std::ios::binary | std::ios::app);
    out << line << '\n';
    out.close();
    if (out) return {};
    return outside_error(
        fmt::format(messages::kCannotBeWritten, file_.string(), std::strerror(errno)));
}

}  // namespace openfab::tuner
