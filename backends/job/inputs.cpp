// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/job/inputs.h"

#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <string_view>

#include "base/input_file.h"
#include "base/json_text.h"
#include "base/sha256.h"

namespace openfab::job {

namespace {

namespace fs = std::filesystem;

constexpr int64_t kLargestSource = 16 << 20;

/// Without links resolved: files name each other by these paths.
fs::path absolute_of(const fs::path& file) {
    std::error_code ignored;
    return fs::absolute(file, ignored).lexically_normal();
}

int64_t time_of(const struct stat& file) {
    return int64_t{file.st_mtim.tv_sec} * 1'000'000'000 + file.st_mtim.tv_nsec;
}

bool is_word(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

/// Skips blanks and comments of OpenFL.
size_t skip_blanks(std::string_view text, size_t at) {
    for (;;) {
        while (at < text.size() && std::isspace(static_cast<unsigned char>(text[at])) != 0)
            ++at;
        if (text.substr(at, 2) == "//") {
            at = std::min(text.find('\n', at), text.size());
        } else if (text.substr(at, 2) == "/*") {
            const size_t end = text.find("*/", at + 2);
            at = end == std::string_view::npos ? text.size() : end + 2;
        } else {
            return at;
        }
    }
}

/// Finds what may be names behind the word: in a comment or a text, too, where a file of that name does no harm.
std::vector<std::string> names_behind(std::string_view text, std::string_view word) {
    std::vector<std::string> names;
    for (size_t at = text.find(word); at != std::string_view::npos;
         at = text.find(word, at + word.size())) {
        if (at > 0 && is_word(text[at - 1])) continue;
        size_t from = at + word.size();
        if (from < text.size() && is_word(text[from])) continue;
        from = skip_blanks(text, from);
        const bool in_quotes = from < text.size() && text[from] == '"';
        from += in_quotes ? 1 : 0;
        size_t end = from;
        while (end < text.size() &&
               (in_quotes ? text[end] != '"' && text[end] != '\n' : is_word(text[end])))
            ++end;
        if (end > from) names.emplace_back(text.substr(from, end - from));
    }
    return names;
}

}  // namespace

std::vector<fs::path> imported_files(const fs::path& source) {
    std::vector<fs::path> found{source};
    const bool schedule = source.extension() == ".sched";
    for (size_t next = 0; next < found.size(); ++next) {
        const Result<InputFile> file = InputFile::open(found[next]);
        if (!file) continue;
        const Result<std::string> text = file->read_all(kLargestSource);
        if (!text) continue;
        for (const std::string& name : names_behind(*text, schedule ? "include" : "import")) {
            const fs::path path = found[next].parent_path() / (schedule ? name : name + ".fl");
            std::error_code ignored;
            if (fs::is_regular_file(path, ignored) &&
                std::find(found.begin(), found.end(), path) == found.end())
                found.push_back(path);
        }
    }
    found.erase(found.begin());
    return found;
}

Input read_input(const fs::path& file) {
    Input input{absolute_of(file), 0, {}, 0};
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return input;
    struct stat status {};
    if (::fstat(opened->descriptor(), &status) == 0) input.time = time_of(status);
    Sha256 sum;
    std::vector<uint8_t> buffer(256 << 10);
    for (;;) {
        const Result<size_t> got = opened->read(input.bytes, buffer.data(), buffer.size());
        if (!got) return input;
        if (*got == 0) break;
        sum.add(std::span(buffer).first(*got));
        input.bytes += static_cast<int64_t>(*got);
    }
    input.sha256 = hex_text(sum.digest());
    return input;
}

std::vector<Input> read_inputs(const std::vector<fs::path>& files) {
    std::vector<Input> inputs;
    std::set<fs::path> known;
    const auto add = [&](const fs::path& file) {
        std::error_code ignored;
        if (fs::is_directory(file, ignored) || !known.insert(absolute_of(file)).second) return;
        inputs.push_back(read_input(file));
    };
    for (const fs::path& file : files) {
        add(file);
        const fs::path extension = file.extension();
        if (extension != ".fl" && extension != ".sched") continue;
        for (const fs::path& imported : imported_files(file))
            add(imported);
    }
    return inputs;
}

std::vector<Input> inputs_of(const JsonValue& record) {
    std::vector<Input> inputs;
    const JsonValue* list = member_of(record, "inputs");
    if (list == nullptr) return inputs;
    for (const JsonValue& each : list->items) {
        const auto text = [&](const char* name) {
            const JsonValue* value =
                each.is(JsonValue::Kind::kObject) ? member_of(each, name) : nullptr;
            return value == nullptr ? std::string() : value->text;
        };
        const JsonValue* bytes =
            each.is(JsonValue::Kind::kObject) ? member_of(each, "bytes") : nullptr;
        constexpr double kMost = 9e15;
        const double number = bytes == nullptr ? 0 : bytes->number;
        inputs.push_back({text("path"),
                          number >= 0 && number < kMost ? static_cast<int64_t>(number) : 0,
                          text("sha256"), 0});
    }
    return inputs;
}

std::vector<std::string> changed_inputs(const JsonValue& record, const std::vector<Input>& now) {
    std::map<fs::path, std::string> digests;
    for (const Input& input : now)
        digests[input.path] = input.sha256;
    std::vector<std::string> changed;
    for (const Input& before : inputs_of(record)) {
        const auto found = digests.find(before.path);
        if (found == digests.end() || found->second != before.sha256)
            changed.push_back(before.path.filename().string());
    }
    return changed;
}

std::vector<std::string> changed_since(const std::vector<Input>& inputs) {
    std::vector<std::string> changed;
    for (const Input& input : inputs) {
        struct stat status {};
        if (input.time == 0 || (::stat(input.path.c_str(), &status) == 0 &&
                                status.st_size == input.bytes && time_of(status) == input.time))
            continue;
        if (read_input(input.path).sha256 != input.sha256)
            changed.push_back(input.path.filename().string());
    }
    return changed;
}

}  // namespace openfab::job
