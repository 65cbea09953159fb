// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The prints of the live loop, and how pages hear of them.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "backends/read/print_file.h"
#include "base/input_file.h"
#include "base/json.h"
#include "base/talking_program.h"
#include "tools/viewer/live.h"
#include "tools/viewer/messages.h"

namespace openfab::viewer {

namespace {

namespace fs = std::filesystem;

constexpr int64_t kTailBytes = 16 << 10;
/// Each that waits holds a thread of the server, and a connection of its browser.
constexpr int32_t kMostWaiting = 4;
constexpr auto kLongestWait = std::chrono::milliseconds(10'000);
constexpr auto kShortWait = std::chrono::milliseconds(400);
/// Of a draft that is as fine as the part needs: the first one of a world, and the voxels of the grid of the others.
constexpr int32_t kFirstDraft = 8;
constexpr double kCoarseVoxels = 4e5, kFineVoxels = 6e6;

/// Of the statistics of a print, the million voxels that a second of work on voxels makes: set-up and files, which a
/// fablet does not change, are most of a small draft. 0: not known.
double speed_of(const std::string& statistics) {
    const Result<JsonValue> json = parse_json(statistics, "statistics");
    const JsonValue* voxels = json ? member_of(*json, "voxels_solid") : nullptr;
    const JsonValue* phases = json ? member_of(*json, "seconds_by_phase") : nullptr;
    if (voxels == nullptr || phases == nullptr) return 0;
    double seconds = 0;
    for (const JsonMember& phase : phases->members) {
        const bool is_work = phase.key != "set_up" && phase.key != "encode" &&
                             phase.key != "commit" && phase.key != "finish";
        if (is_work) seconds += phase.value.number;
    }
    return seconds > 0 ? voxels->number * 1e-6 / seconds : 0;
}

}  // namespace

void Live::begin_print() {
    // Compiles into its own process, without a linker, and prints before what it culls by is compiled.
    std::vector<std::string> argv{(options_.programs / "openflc").string(), "run"};
    {
        const std::lock_guard lock(mutex_);
        is_over_ = false;
        slices_done_ = slices_total_ = 0;
        printed_draft_ = next_draft();
        if (!read_.message.empty() || client::has_errors(read_.diagnostics)) {
            phase_ = Phase::kFailed;
            message_ = remaining_message_ = read_.message;
            ++version_;
            tell_of_change();
            return;
        }
        // The world's own errors are told by who finds nothing to compile.
        if (read_.sources.empty()) argv = {(options_.programs / "openfab").string(), "print"};
        printed_trial_ = trial_;
        for (const fs::path& source : read_.sources) {
            const bool tried = trial_ != nullptr && trial_->source == source;
            argv.push_back(as_argument(tried ? trial_->file : source));
        }
        argv.push_back(as_argument(fs::absolute(options_.file)));
        preview_ = folder_->path() / fmt::format("preview-{}.ofr", ++number_);
        for (const std::string& word :
             {"--output=" + preview_.string(), std::string("--progress=json"),
              fmt::format("--draft={}", printed_draft_), "--stats=" + statistics_file().string()})
            argv.push_back(word);
        for (const std::string& word : client::memory_words())
            argv.push_back(word);
        for (const std::string& folder : options_.allow)
            argv.push_back(allow_argument(folder));
        settings_ = options_.settings;
        for (const Override& one : overrides_)
            settings_.push_back(one.setting());
        for (const std::string& setting : settings_)
            argv.push_back("--set=" + setting);
        for (const std::string& setting : trial_settings_)
            argv.push_back("--set=" + setting);
    }
    std::error_code ignored;
    fs::remove(statistics_file(), ignored);
    set_phase(Phase::kPrinting, {});
    Result<std::unique_ptr<client::Child>> child =
        client::Child::start(argv, folder_->path() / "print.out", folder_->path() / "print.err");
    if (child) {
        child_ = std::move(*child);
    } else {
        set_phase(Phase::kFailed, {child.error().text(), {}});
    }
}

fs::path Live::statistics_file() const {
    return folder_->path() / "print.stats";
}

bool Live::print_is_whole() const {
    // They are written last, of a print that failed, too.
    std::error_code ignored;
    if (!fs::exists(statistics_file(), ignored)) return false;
    const Result<std::unique_ptr<prints::PrintFile>> file =
        prints::PrintFile::open(preview_.string(), options_.memory_bytes);
    return file && (*file)->totals().has_value();
}

void Live::show_preview() {
    const std::string name = fs::path(options_.file).filename().string();
    if (!session_->show(preview_.string(), name)) return;
    const Session::Prints prints = session_->prints();
    const std::lock_guard lock(mutex_);
    std::error_code ignored;
    // The session has it open as long as it needs it.
    if (!shown_.empty()) fs::remove(shown_, ignored);
    shown_ = preview_;
    if (!prints.list.empty()) {
        const Vec3i size = prints.list[0]->file().info().size;
        full_voxels_ = std::pow(printed_draft_, 3) * size.x * size.y * size.z;
    }
    shown_settings_ = settings_;
    shows_full_ = false;
    tell_of_change();
}

int32_t Live::next_draft() const {
    if (draft_ > 0) return draft_;
    if (full_voxels_ <= 0) return kFirstDraft;
    const double most = refines_ ? kFineVoxels : kCoarseVoxels;
    return std::max(1, static_cast<int32_t>(std::ceil(std::cbrt(full_voxels_ / most) - 1e-9)));
}

bool Live::refine() {
    // What it culls by is compiled first, for the finer print as well.
    if (child_ != nullptr) return false;
    {
        const std::lock_guard lock(mutex_);
        if (draft_ > 0 || refines_ || asked_ || phase_ != Phase::kDone || trial_ != nullptr)
            return false;
        refines_ = true;
        if (next_draft() >= printed_draft_) return false;
    }
    begin_print();
    return true;
}

void Live::show_done_print() {
    if (full_print_.done_now()) (void)show_full_print(true);
}

Result<void> Live::show_full_print(bool full) {
    fs::path file = full_print_.output();
    if (!full) {
        const std::lock_guard lock(mutex_);
        file = shown_;
    }
    if (file.empty()) return user_error(messages::kNoPrintYet);
    const std::string name = (full ? file : fs::path(options_.file)).filename().string();
    if (Result<void> shown = session_->show(file.string(), name); !shown) return shown;
    const std::lock_guard lock(mutex_);
    shown_settings_ = full ? full_settings_ : settings_;
    shows_full_ = full;
    tell_of_change();
    return {};
}

void Live::follow_print() {
    if (child_ == nullptr) return;
    const std::optional<int> code = child_->exit_code();
    const std::string err = client::end_of_file(folder_->path() / "print.err", kTailBytes);
    if (const std::optional<JsonValue> progress = client::last_progress(err)) {
        const JsonValue* done = member_of(*progress, "slices_done");
        const JsonValue* total = member_of(*progress, "slices_total");
        const int32_t slices = done != nullptr ? static_cast<int32_t>(done->number) : 0;
        const std::lock_guard lock(mutex_);
        if (slices != slices_done_) tell_of_change();
        slices_done_ = slices;
        slices_total_ = total != nullptr ? static_cast<int32_t>(total->number) : 0;
    }
    const bool fine = code ? *code == 0 : is_over_ || print_is_whole();
    // The very first is shown while it grows; another when it is whole.
    const bool first = session_->prints().list.empty() && slices_done_ > 0;
    if ((fine || first) && shown_ != preview_) show_preview();
    if (fine && !is_over_) {
        const double speed = speed_of(client::end_of_file(statistics_file(), kTailBytes));
        {
            const std::lock_guard lock(mutex_);
            // What a change costs is told of texts that stay.
            if (printed_trial_ == nullptr) {
                mvoxels_per_second_ = speed;
                print_done_ = number_;
            }
        }
        is_over_ = true;
        set_phase(Phase::kDone, client::words_of(err, true));
    }
    if (!code) return;
    child_.reset();
    if (!fine && shown_ != preview_) {
        std::error_code ignored;
        fs::remove(preview_, ignored);
    }
    // What came last, as well.
    const client::PrintWords words = client::words_of(err, fine);
    if (!fine || words.all() != message_) set_phase(fine ? Phase::kDone : Phase::kFailed, words);
}

void Live::wait_for_change(int64_t known) const {
    std::unique_lock lock(mutex_);
    if (change_ != known || waiting_ >= kMostWaiting) return;
    ++waiting_;
    // The whole print has its own process, of which nobody tells.
    told_.wait_for(lock, full_print_.runs() ? kShortWait : kLongestWait,
                   [&] { return change_ != known || stop_; });
    --waiting_;
}

void Live::tell_of_change() {
    ++change_;
    told_.notify_all();
}

void Live::set_phase(Phase phase, const client::PrintWords& words) {
    const std::lock_guard lock(mutex_);
    if (phase != Phase::kChecking) ++version_;
    phase_ = phase;
    message_ = words.all();
    client::PrintWords remaining{words.text, {}};
    for (Override& one : overrides_)
        one.trouble.clear();
    for (const client::SettingError& error : words.settings) {
        const auto of =
            std::find_if(overrides_.begin(), overrides_.end(),
                         [&](const Override& one) { return one.setting() == error.setting; });
        if (of == overrides_.end()) {
            remaining.settings.push_back(error);
        } else {
            of->trouble = error.text;
        }
    }
    remaining_message_ = remaining.all();
    tell_of_change();
}

}  // namespace openfab::viewer
