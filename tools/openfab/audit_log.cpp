// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/audit_log.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>

#include "base/json_text.h"
#include "base/say.h"
#include "base/system_reason.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

/// "2026-11-29T17:40:00Z"
std::string utc_now() {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    char text[32] = "";
    if (::gmtime_r(&now, &utc) != nullptr)
        (void)std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
    return text;
}

}  // namespace

Result<std::unique_ptr<AuditLog>> AuditLog::open(const std::string& file) {
    constexpr mode_t kMine = 0600;
    const int descriptor =
        ::open(file.c_str(), O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC | O_NOFOLLOW, kMine);
    if (descriptor < 0)
        return outside_error(fmt::format(messages::kCannotWrite, file, system_reason(errno)));
    // What is added after a line that a power failure tore begins one of its own.
    struct stat status {};
    char last = '\n';
    if (::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0 &&
        ::pread(descriptor, &last, 1, status.st_size - 1) == 1 && last != '\n')
        (void)::write(descriptor, "\n", 1);
    return std::unique_ptr<AuditLog>(new AuditLog(descriptor, file));
}

AuditLog::~AuditLog() {
    ::close(descriptor_);
}

namespace {

std::string line_of(const char* event, const std::string& from, const std::string& print,
                    int32_t slice, const std::string& text) {
    JsonText out;
    out.begin_object().member("time", utc_now()).member("event", event).member("from", from);
    out.member("print", print).member("slice", slice).member("text", text);
    return out.end_object().take() + "\n";
}

}  // namespace

void AuditLog::add(const char* event, const std::string& from, const std::string& print,
                   int32_t slice, const std::string& text) {
    std::string lines = torn_ ? "\n" : "";
    if (lost_ > 0)
        lines += line_of("lost", "", print, slice, fmt::format(messages::kLogLinesLost, lost_));
    lines += line_of(event, from, print, slice, text);
    const ssize_t wrote = ::write(descriptor_, lines.data(), lines.size());
    const bool whole = wrote == static_cast<ssize_t>(lines.size());
    const bool fine = whole && (::fdatasync(descriptor_) == 0 || errno == EINVAL || errno == EROFS);
    // What was written in part is no line, and what fails without a reason found no room.
    if (!whole && wrote > 0) errno = ENOSPC;
    if (!fine && lost_ == 0)
        warn(fmt::format(messages::kLogNotWritten, name_, system_reason(errno)));
    lost_ = fine ? 0 : lost_ + 1;
    torn_ = !whole && (wrote > 0 || torn_);
}

}  // namespace openfab::tools
