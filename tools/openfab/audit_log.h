// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The audit log of a receiver: who came, what was taken and what was refused, a JSON object a line. It is only ever
// appended to.

#include <cstdint>
#include <memory>
#include <string>

#include "base/result.h"

namespace openfab::tools {

class AuditLog {
  public:
    /// Opens a log to append to, which is made for this user alone.
    static Result<std::unique_ptr<AuditLog>> open(const std::string& file);
    ~AuditLog();
    AuditLog(const AuditLog&) = delete;
    AuditLog& operator=(const AuditLog&) = delete;

    /// Appends `{"time", "event", "from", "print", "slice", "text"}`, at once and to the disk. That lines cannot be
    /// written, as on a full disk, is told once; when they can again, a line of the event `lost` says how many were.
    void add(const char* event, const std::string& from, const std::string& print, int32_t slice,
             const std::string& text);

  private:
    AuditLog(int descriptor, std::string name) : descriptor_(descriptor), name_(std::move(name)) {}

    int descriptor_;
    std::string name_;
    int64_t lost_ = 0;   ///< lines since the last one that was written
    bool torn_ = false;  ///< the last one is there in part
};

}  // namespace openfab::tools
