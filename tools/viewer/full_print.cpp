// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/full_print.h"

#include <fmt/format.h>

#include <system_error>

#include "base/input_file.h"
#include "base/json.h"
#include "base/talking_program.h"
#include "client/print_words.h"
#include "tools/viewer/messages.h"

namespace openfab::viewer {

namespace {

namespace fs = std::filesystem;

constexpr int64_t kTailBytes = 16 << 10;

/// A file beside a world that is not there.
fs::path free_output(const fs::path& world) {
    std::string stem = world.filename().string();
    stem = stem.substr(0, stem.find('.'));
    for (int i = 1;; ++i) {
        fs::path file =
            world.parent_path() / (i == 1 ? stem + ".ofr" : fmt::format("{}-{}.ofr", stem, i));
        std::error_code status;
        if (fs::symlink_status(file, status).type() == fs::file_type::not_found) return file;
    }
}

double number_of(const JsonValue& json, const char* name) {
    const JsonValue* found = member_of(json, name);
    return found == nullptr ? 0 : found->number;
}

}  // namespace

Result<void> FullPrint::begin(const fs::path& world, const std::vector<std::string>& allow,
                              const std::vector<std::string>& settings) {
    const std::lock_guard lock(mutex_);
    if (child_ != nullptr && !child_->exit_code()) return user_error(messages::kPrintRunsAlready);
    const fs::path output = free_output(world);
    std::vector<std::string> argv{(programs_ / "openfab").string(),
                                  "print",
                                  as_argument(world),
                                  "--output",
                                  as_argument(output),
                                  "--any-pitch",
                                  "--progress",
                                  "json"};
    for (const std::string& word : client::memory_words())
        argv.push_back(word);
    for (const std::string& one : allow)
        argv.push_back(allow_argument(one));
    for (const std::string& setting : settings)
        argv.push_back("--set=" + setting);
    Result<std::unique_ptr<client::Child>> child =
        client::Child::start(argv, scratch_ / "full.out", scratch_ / "full.err");
    if (!child) return child.error();
    child_ = std::move(*child);
    print_ = {output, settings};
    begun_ = true;
    stopped_ = told_ = false;
    return {};
}

void FullPrint::stop() {
    const std::lock_guard lock(mutex_);
    if (child_ == nullptr || child_->exit_code()) return;
    stopped_ = true;
    child_.reset();
}

bool FullPrint::runs() {
    const std::lock_guard lock(mutex_);
    return child_ != nullptr && !child_->exit_code();
}

std::optional<PrintOfValues> FullPrint::done_now() {
    const std::lock_guard lock(mutex_);
    if (child_ == nullptr || told_ || child_->exit_code() != 0) return {};
    told_ = true;
    return print_;
}

PrintOfValues FullPrint::last() {
    const std::lock_guard lock(mutex_);
    return print_;
}

void FullPrint::describe(JsonText* out) {
    const std::lock_guard lock(mutex_);
    if (!begun_) {
        out->null();
        return;
    }
    const std::optional<int> code = child_ == nullptr ? std::optional<int>(1) : child_->exit_code();
    const std::string err = client::end_of_file(scratch_ / "full.err", kTailBytes);
    const char* phase = !code ? "printing" : stopped_ ? "stopped" : *code == 0 ? "done" : "failed";
    out->begin_object().member("phase", phase).member("file", print_.file.filename().string());
    out->member("path", print_.file.string());
    const std::optional<JsonValue> progress = client::last_progress(err);
    for (const char* name : {"slices_done", "slices_total", "seconds_left"})
        out->member(name, progress ? number_of(*progress, name) : 0);
    out->member("message", code ? client::words_of(err, *code == 0).all() : std::string());
    out->end_object();
}

}  // namespace openfab::viewer
