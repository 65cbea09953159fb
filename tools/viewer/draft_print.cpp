// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/draft_print.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "backends/read/print_file.h"
#include "base/input_file.h"
#include "base/json.h"
#include "base/json_text.h"
#include "base/talking_program.h"

namespace openfab::viewer {

namespace {

namespace fs = std::filesystem;

constexpr int64_t kTailBytes = 16 << 10;
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

int32_t slices(const JsonValue& progress, const char* name) {
    const JsonValue* count = member_of(progress, name);
    return count == nullptr ? 0 : static_cast<int32_t>(count->number);
}

}  // namespace

DraftPrint::DraftPrint(ViewOptions options, fs::path scratch, ChangeSignal* signal,
                       SetValues* values, PrintInView* view)
    : options_(std::move(options)),
      scratch_(std::move(scratch)),
      signal_(signal),
      values_(values),
      view_(view) {
    state_.draft = options_.draft;
}

DraftPrint::State DraftPrint::state() const {
    const std::lock_guard lock(mutex_);
    return state_;
}

void DraftPrint::set_draft(int32_t draft) {
    const std::lock_guard lock(mutex_);
    state_.draft = draft;
}

void DraftPrint::end() {
    set_phase(Phase::kChecking, {});
    child_.reset();
    is_finer_ = false;
}

void DraftPrint::begin(const WorldReading& reading, const TriedText::Trial& trial) {
    is_over_ = false;
    const SetValues::List values = values_->list();
    const int32_t draft = next_draft();
    {
        // At once: no state says that this print is done.
        const std::lock_guard lock(mutex_);
        state_.phase = Phase::kPrinting;
        state_.slices_done = state_.slices_total = 0;
        state_.printed_draft = draft;
        state_.values_edition = values.edition;
    }
    if (!reading.can_print()) {
        set_phase(Phase::kFailed, {reading.message, {}});
        return;
    }
    // Compiles into its own process, without a linker, and prints before what it culls by is compiled.
    std::vector<std::string> argv{(options_.programs / "openflc").string(), "run"};
    // The world's own errors are told by who finds nothing to compile.
    if (reading.sources.empty()) argv = {(options_.programs / "openfab").string(), "print"};
    text_ = trial.text;
    for (const fs::path& source : reading.sources) {
        const bool tried = text_ != nullptr && text_->source == source;
        argv.push_back(as_argument(tried ? text_->file : source));
    }
    argv.push_back(as_argument(fs::absolute(options_.file)));
    print_.file = scratch_ / fmt::format("preview-{}.ofr", ++number_);
    for (const std::string& word :
         {"--output=" + print_.file.string(), std::string("--progress=json"),
          std::string("--any-pitch"), fmt::format("--draft={}", draft),
          "--stats=" + statistics_file().string()})
        argv.push_back(word);
    for (const std::string& word : client::memory_words())
        argv.push_back(word);
    for (const std::string& folder : options_.allow)
        argv.push_back(allow_argument(folder));
    print_.settings = options_.settings;
    for (const std::string& setting : values.settings())
        print_.settings.push_back(setting);
    for (const std::vector<std::string>& settings : {print_.settings, trial.settings}) {
        for (const std::string& setting : settings)
            argv.push_back("--set=" + setting);
    }
    std::error_code ignored;
    fs::remove(statistics_file(), ignored);
    set_phase(Phase::kPrinting, {});
    Result<std::unique_ptr<client::Child>> child =
        client::Child::start(argv, scratch_ / "print.out", scratch_ / "print.err");
    if (child) {
        child_ = std::move(*child);
    } else {
        set_phase(Phase::kFailed, {child.error().text(), {}});
    }
}

fs::path DraftPrint::statistics_file() const {
    return scratch_ / "print.stats";
}

/// Whether the print has made its slices; its process may still compile what the next one culls by.
bool DraftPrint::is_whole() const {
    // They are written last, of a print that failed, too.
    std::error_code ignored;
    if (!fs::exists(statistics_file(), ignored)) return false;
    const Result<std::unique_ptr<prints::PrintFile>> file =
        prints::PrintFile::open(print_.file.string(), options_.memory_bytes);
    return file && (*file)->totals().has_value();
}

void DraftPrint::show() {
    const std::optional<Vec3i> size = view_->show_draft(print_);
    if (!size) return;
    if (size->x > 0)
        full_voxels_ = std::pow(state().printed_draft, 3) * size->x * size->y * size->z;
    signal_->tell();
}

int32_t DraftPrint::next_draft() const {
    const int32_t draft = state().draft;
    if (draft > 0) return draft;
    if (full_voxels_ <= 0) return kFirstDraft;
    const double most = is_finer_ ? kFineVoxels : kCoarseVoxels;
    return std::max(1, static_cast<int32_t>(std::ceil(std::cbrt(full_voxels_ / most) - 1e-9)));
}

bool DraftPrint::refines() {
    // What it culls by is compiled first, for the finer print as well.
    if (child_ != nullptr || is_finer_ || text_ != nullptr) return false;
    const State now = state();
    if (now.draft > 0 || now.phase != Phase::kDone) return false;
    is_finer_ = true;
    return next_draft() < now.printed_draft;
}

void DraftPrint::follow() {
    if (child_ == nullptr) return;
    const std::optional<int> code = child_->exit_code();
    const std::string err = client::end_of_file(scratch_ / "print.err", kTailBytes);
    State now = state();
    if (const std::optional<JsonValue> progress = client::last_progress(err)) {
        const int32_t done_before =
            std::exchange(now.slices_done, slices(*progress, "slices_done"));
        now.slices_total = slices(*progress, "slices_total");
        {
            const std::lock_guard lock(mutex_);
            state_.slices_done = now.slices_done;
            state_.slices_total = now.slices_total;
        }
        if (now.slices_done != done_before) signal_->tell();
    }
    const bool fine = code ? *code == 0 : is_over_ || is_whole();
    const bool was_shown = view_->was_shown(print_.file);
    // The very first is shown while it grows; another when it is whole.
    const bool first = view_->is_empty() && now.slices_done > 0;
    if ((fine || first) && !was_shown) show();
    if (fine && !is_over_) {
        const double speed = speed_of(client::end_of_file(statistics_file(), kTailBytes));
        // What a change costs is told of texts that stay.
        if (text_ == nullptr) {
            const std::lock_guard lock(mutex_);
            state_.mvoxels_per_second = speed;
            state_.done_number = number_;
        }
        is_over_ = true;
        set_phase(Phase::kDone, client::words_of(err, true));
    }
    if (!code) return;
    child_.reset();
    if (!fine && !view_->was_shown(print_.file)) {
        std::error_code ignored;
        fs::remove(print_.file, ignored);
    }
    // What came last, as well.
    const client::PrintWords words = client::words_of(err, fine);
    if (!fine || words.all() != state().message)
        set_phase(fine ? Phase::kDone : Phase::kFailed, words);
}

void DraftPrint::set_phase(Phase phase, const client::PrintWords& words) {
    const client::PrintWords others = values_->note_troubles(words);
    {
        const std::lock_guard lock(mutex_);
        state_.phase = phase;
        state_.message = words.all();
        state_.other_message = others.all();
    }
    if (phase == Phase::kChecking) {
        signal_->tell();
    } else {
        signal_->tell_of_details();
    }
}

}  // namespace openfab::viewer
