// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The audit log of a receiver: who came, what was taken and what was refused, a JSON object a line. It is only ever
// appended to.

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

    /// Appends `{"time", "event", "from", "print", "slice", "text"}`, at once and to the disk. A line that cannot be
    /// written is told once.
    void add(const char* event, const std::string& from, const std::string& print, int32_t slice,
             const std::string& text);

  private:
    AuditLog(int descriptor, std::string name) : descriptor_(descriptor), name_(std::move(name)) {}

    int descriptor_;
    std::string name_;
    bool failed_ = false;
};

}  // namespace openfab::tools
