// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>

#include "base/caret.h"
#include "base/clean_exit.h"
#include "base/json_text.h"
#include "base/text.h"
#include "base/units.h"
#include "program/messages.h"

namespace openfab::program {

namespace {

// Often enough to show progress, seldom enough to cost nothing and to keep logs short.
constexpr double kBarSeconds = 0.1;
constexpr double kPlainSeconds = 5;
constexpr double kJsonSeconds = 0.25;

/// Returns voxels per second since the first event, or since the start of the process for the
/// first.
double rate(const pipeline::ProgressEvent& event, const pipeline::ProgressEvent& start) {
    const bool later = event.voxels_done > start.voxels_done && event.seconds > start.seconds;
    const double seconds = later ? event.seconds - start.seconds : event.seconds;
    const int64_t voxels = later ? event.voxels_done - start.voxels_done : event.voxels_done;
    return seconds > 0 ? static_cast<double>(voxels) / seconds : 0;
}

double seconds_left(const pipeline::ProgressEvent& event, const pipeline::ProgressEvent& start) {
    const double per_second = rate(event, start);
    return per_second > 0 ? static_cast<double>(event.voxels_total - event.voxels_done) / per_second
                          : 0;
}

double share_done(const pipeline::ProgressEvent& event) {
    return event.slices_total > 0 ? static_cast<double>(event.slices_done) / event.slices_total : 1;
}

/// Writes text that is safe for a terminal, or the bar's own control codes. Failures are ignored: a
/// print does not end with its viewer.
void put(std::FILE* stream, const std::string& text) {
    if (is_ending()) return;  // the handler has said why
    (void)std::fwrite(text.data(), 1, text.size(), stream);
}

std::string json_event(const char* event, const char* key, const std::string& text) {
    return fmt::format("{{\"event\": \"{}\", \"{}\": {}}}\n", event, key, json_string(text));
}

constexpr const char* kClearLine = "\r\x1b[K";

std::string error_event(const Error& error, std::string_view setting) {
    JsonText json;
    json.begin_object().member("event", "error").member("text", error.message);
    json.member("help", error.help);
    if (!setting.empty()) {
        json.member("setting", setting);
    } else if (!error.location.file.empty()) {
        json.member("file", error.location.file).member("line", error.location.line);
        json.member("column", error.location.column);
    }
    return json.end_object().take() + '\n';
}

int terminal_columns(std::FILE* stream) {
    winsize size{};
    return ::ioctl(::fileno(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace

Progress::Progress(ProgressMode mode, std::FILE* stream)
    : style_(mode == ProgressMode::kPlain      ? Style::kPlain
             : mode == ProgressMode::kJson     ? Style::kJson
             : mode == ProgressMode::kNone     ? Style::kNone
             : ::isatty(::fileno(stream)) != 0 ? Style::kBar
                                               : Style::kPlain),
      stream_(stream) {}

std::string Progress::describe(const pipeline::ProgressEvent& event,
                               const pipeline::ProgressEvent& start) {
    std::string text = fmt::format(messages::kProgress, event.slices_done, event.slices_total,
                                   share_done(event) * 100);
    // The duration of the first slice is unknown: compiling and set-up came before.
    if (event.slices_done == start.slices_done && event.slices_done < event.slices_total)
        return text;
    text += fmt::format(messages::kProgressRate, rate(event, start) * 1e-6);
    if (event.slices_done < event.slices_total)
        text += "  " + format_seconds(seconds_left(event, start)) + " left";
    return text;
}

void Progress::update(const pipeline::ProgressEvent& event) {
    const std::lock_guard lock(mutex_);
    if (start_.slices_done == 0) start_ = event;
    const bool last = event.slices_done >= event.slices_total;
    if (style_ == Style::kNone || (event.seconds < due_seconds_ && !last)) return;
    switch (style_) {
        case Style::kBar:
            due_seconds_ = event.seconds + kBarSeconds;
            show_bar(event);
            break;
        case Style::kPlain:
            due_seconds_ = event.seconds + kPlainSeconds;
            put(stream_, describe(event, start_) + "\n");
            break;
        case Style::kJson:
            due_seconds_ = event.seconds + kJsonSeconds;
            show_json(event);
            break;
        case Style::kNone:
            break;
    }
    std::fflush(stream_);
}

void Progress::show_bar(const pipeline::ProgressEvent& event) {
    const std::string text = describe(event, start_);
    const int room = terminal_columns(stream_) - static_cast<int>(text.size()) - 5;
    const int width = std::clamp(room, 0, 40);
    const int full = static_cast<int>(share_done(event) * width);
    std::string bar;
    if (width > 3) bar = fmt::format("[{:=<{}}{:<{}}] ", "", full, "", width - full);
    put(stream_, fmt::format("\r{}{}\x1b[K", bar, text));
    bar_shown_ = true;
}

void Progress::show_json(const pipeline::ProgressEvent& event) {
    put(stream_,
        fmt::format("{{\"event\": \"progress\", \"slices_done\": {}, \"slices_total\": {}, "
                    "\"voxels_done\": {}, "
                    "\"voxels_total\": {}, \"seconds\": {:.3f}, \"mvoxels_per_second\": {:.3f}, "
                    "\"seconds_left\": {:.1f}}}\n",
                    event.slices_done, event.slices_total, event.voxels_done, event.voxels_total,
                    event.seconds, rate(event, start_) * 1e-6, seconds_left(event, start_)));
}

void Progress::print_line(const std::string& line) {
    const std::lock_guard lock(mutex_);
    end();
    put(stream_,
        style_ == Style::kJson ? json_event("print", "line", line) : printable(line) + '\n');
    std::fflush(stream_);
}

void Progress::warn(const std::string& message) {
    const std::lock_guard lock(mutex_);
    end();
    put(stream_, style_ == Style::kJson ? json_event("warning", "text", message)
                                        : "warning: " + printable(message) + '\n');
    std::fflush(stream_);
}

void Progress::note(const std::string& message) {
    if (style_ == Style::kNone) return;
    const std::lock_guard lock(mutex_);
    end();
    put(stream_, style_ == Style::kJson ? json_event("note", "text", message)
                                        : "note: " + printable(message) + '\n');
    std::fflush(stream_);
}

void Progress::slow(int32_t first, int32_t last, double seconds) {
    if (style_ != Style::kJson)
        return note(fmt::format(messages::kSlowSlab, first, last, format_seconds(seconds)));
    const std::lock_guard lock(mutex_);
    put(stream_,
        fmt::format("{{\"event\": \"slow\", \"first\": {}, \"last\": {}, \"seconds\": {:.0f}}}\n",
                    first, last, seconds));
    std::fflush(stream_);
}

void Progress::fail(const Error& error, std::string_view setting) {
    const std::lock_guard lock(mutex_);
    end();
    put(stream_, style_ == Style::kJson ? error_event(error, setting) : render_error(error));
    std::fflush(stream_);
}

std::string Progress::error_text(const Error& error, std::string_view setting) const {
    if (style_ == Style::kJson) return error_event(error, setting);
    return (style_ == Style::kBar ? kClearLine : "") + render_error(error);
}

void Progress::end() {
    const std::lock_guard lock(mutex_);
    if (!bar_shown_) return;
    put(stream_, kClearLine);
    std::fflush(stream_);
    bar_shown_ = false;
}

}  // namespace openfab::program
