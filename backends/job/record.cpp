// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/job/record.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <ctime>
#include <fstream>
#include <string_view>

#include "backends/common/output_file.h"
#include "backends/job/inputs.h"
#include "backends/job/messages.h"
#include "backends/job/processes.h"
#include "base/json_text.h"

namespace openfab::job {

namespace {

namespace fs = std::filesystem;

/// Of a print that is stopped and resumed again and again, the last ones tell enough.
constexpr size_t kMostEvents = 1000;

std::string time_text() {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    std::array<char, 32> text{};
    if (::gmtime_r(&now, &utc) == nullptr ||
        std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc) == 0)
        return {};
    return text.data();
}

std::string words_json(const std::vector<OptionWords>& options) {
    JsonText out;
    out.begin_array();
    for (const OptionWords& option : options) {
        out.begin_array().value(option.name);
        for (const std::string& value : option.values)
            out.value(value);
        out.end_array();
    }
    return out.end_array().take();
}

std::string programs_json(const std::vector<std::vector<std::string>>& programs) {
    JsonText out;
    out.begin_array();
    for (const std::vector<std::string>& command : programs) {
        out.begin_array();
        for (const std::string& word : command)
            out.value(word);
        out.end_array();
    }
    return out.end_array().take();
}

std::string provenance_json(const pipeline::PrintInfo& info) {
    JsonText out;
    out.begin_array();
    for (const auto& [name, value] : info.provenance)
        out.begin_array().value(name).value(value).end_array();
    return out.end_array().take();
}

/// A line for each, so that people can read and compare them.
template <typename List, typename Text>
std::string lines(const List& list, const Text& text) {
    std::string out = "[";
    for (const auto& one : list)
        out += (out.size() == 1 ? "\n    " : ",\n    ") + text(one);
    return out + (out.size() == 1 ? "]" : "\n  ]");
}

/// Whether a file is a record, also a damaged one: nothing else of that name is replaced.
bool may_replace(const fs::path& file) {
    std::error_code status;
    const fs::file_status there = fs::symlink_status(file, status);
    if (there.type() == fs::file_type::not_found) return true;
    // A pipe would be waited for, a link leads elsewhere.
    if (there.type() != fs::file_type::regular) return false;
    std::ifstream in(file, std::ios::binary);
    std::array<char, 26> first{};
    in.read(first.data(), first.size());
    // A power failure leaves nothing, or zeros.
    if (in.gcount() == 0 || first[0] == 0) return true;
    return std::string_view(first.data(), static_cast<size_t>(in.gcount())) ==
           "{\n  \"format\": \"openfab.job";
}

}  // namespace

fs::path record_file(const std::string& output) {
    struct stat there {};
    const bool exists = ::stat(output.c_str(), &there) == 0;
    // A device or a pipe has no place beside it.
    if (exists && !S_ISREG(there.st_mode) && !S_ISDIR(there.st_mode)) return {};
    fs::path path(output);
    if (path.filename() == "." || path.filename() == "..") {
        std::error_code ignored;
        path = fs::canonical(path, ignored);
    }
    if (!path.has_filename()) path = path.parent_path();
    return path.string() + ".job.json";
}

Record::Record(fs::path file, Facts facts, bool resumed)
    : file_(std::move(file)), facts_(std::move(facts)), resumed_(resumed) {}

std::string Record::event(const char* what, const std::string& more) const {
    return fmt::format(R"({{"event":"{}","time":"{}","host":{},"process":{},"slices":{}{}}})", what,
                       time_text(), json_string(host_name()), ::getpid(), written_, more);
}

void Record::start(const pipeline::PrintInfo& info, int32_t kept, const std::string& from) {
    const std::lock_guard lock(mutex_);
    info_ = info;
    written_ = kept;
    events_.clear();
    std::string changed;
    const bool has_before = resumed_ && may_replace(file_);
    if (const Result<JsonValue> before = has_before ? read_record(file_) : JsonValue();
        has_before && before) {
        const JsonValue* events = member_of(*before, "events");
        if (events != nullptr) {
            for (const JsonValue& one : events->items)
                events_.push_back(JsonText().value(one).take());
        }
        if (const JsonValue* forgotten = member_of(*before, "events_forgotten"))
            forgotten_ = static_cast<int64_t>(forgotten->number);
        for (const std::string& name : changed_inputs(*before, facts_.inputs))
            changed += (changed.empty() ? "" : ",") + json_string(name);
    }
    std::string more = fmt::format(R"(,"process_start":{})", start_of_process(::getpid()));
    if (!from.empty()) more += R"(,"from":)" + json_string(from);
    if (!changed.empty()) more += R"(,"changed_inputs":[)" + changed + "]";
    events_.push_back(event(events_.empty() ? "start" : "resume", more));
    started_ = true;
    stopped_ = false;
    write("running");
}

void Record::stop(const StopReason& reason) {
    const std::lock_guard lock(mutex_);
    if (!started_ || ended_) return;
    if (stopped_) events_.pop_back();
    stopped_ = true;
    std::string more = fmt::format(R"(,"by":{})", json_string(reason.by));
    if (!reason.signal.empty()) more += R"(,"signal":)" + json_string(reason.signal);
    if (reason.sender > 0) more += fmt::format(R"(,"sender":{})", reason.sender);
    if (!reason.error.empty()) more += R"(,"error":)" + json_string(reason.error);
    if (info_.slice_begin + written_ < info_.slice_end)
        more += fmt::format(R"(,"slice":{})", info_.slice_begin + written_);
    events_.push_back(event("stop", more));
    write("stopped");
}

void Record::complete(uint64_t hash) {
    const std::lock_guard lock(mutex_);
    if (!started_ || ended_) return;
    if (stopped_) events_.pop_back();
    hash_ = fmt::format("{:016x}", hash);
    std::string changed;
    for (const std::string& name : changed_since(facts_.inputs))
        changed += (changed.empty() ? "" : ",") + json_string(name);
    std::string more = fmt::format(R"(,"hash":"{}")", hash_);
    if (!changed.empty()) more += R"(,"changed_inputs":[)" + changed + "]";
    events_.push_back(event("complete", more));
    ended_ = true;
    write("complete");
}

bool Record::has_stopped() const {
    const std::lock_guard lock(mutex_);
    return stopped_;
}

std::string Record::trouble() const {
    const std::lock_guard lock(mutex_);
    return trouble_;
}

void Record::write(const std::string& state) {
    if (!may_replace(file_)) {
        trouble_ = fmt::format(messages::kNoRecord, file_.string());
        return;
    }
    while (events_.size() > kMostEvents) {
        events_.erase(events_.begin());
        ++forgotten_;
    }
    const auto input = [](const Input& each) {
        return fmt::format(R"({{"path":{},"bytes":{},"sha256":"{}"}})",
                           json_string(each.path.string()), each.bytes, each.sha256);
    };
    const auto same = [](const std::string& each) { return each; };
    std::string text = fmt::format(
        "{{\n  \"format\": \"openfab.job\",\n  \"version\": 1,\n  \"title\": {},\n  \"state\": "
        "\"{}\",\n"
        "  \"hash\": {},\n  \"slices\": {{\"first\": {}, \"end\": {}, \"of\": {}, \"written\": "
        "{}}},\n"
        "  \"events\": {},\n  \"events_forgotten\": {},\n",
        json_string(info_.title), state, hash_.empty() ? "null" : json_string(hash_),
        info_.slice_begin, info_.slice_end, info_.size.z, written_, lines(events_, same),
        forgotten_);
    text += fmt::format(
        "  \"output_format\": {},\n  \"printer\": {{\"name\": {}, \"sha256\": {}}},\n  "
        "\"provenance\": {},\n"
        "  \"folder\": {},\n  \"options\": {},\n  \"compilation\": {},\n  \"programs\": {},\n"
        "  \"inputs\": {}\n}}\n",
        json_string(facts_.format), json_string(facts_.printer), json_string(facts_.printer_sha256),
        provenance_json(info_), json_string(facts_.folder.string()), words_json(facts_.options),
        facts_.compilation ? words_json(*facts_.compilation) : "null",
        programs_json(facts_.programs), lines(facts_.inputs, input));
    const Result<void> written = backends::write_whole_file(file_, text);
    if (!written) trouble_ = written.error().text();
}

}  // namespace openfab::job
