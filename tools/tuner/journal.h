// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `openfab tune` has found so far, so that it can go on after an end: a file of JSON, one object
// a line. The first line says what was tuned; each other one what is known of a schedule by then, the
// last one of a schedule counts. A line that was cut off at the end is left out.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/result.h"

namespace openfab::tuner {

/// What is known of one schedule.
struct Trial {
    std::vector<std::string> changes;  ///< to the first schedule
    std::string refused;               ///< why it is not one; empty: it is
    std::vector<double> ratios;        ///< its seconds to those of the first schedule
    bool won = false;                  ///< by the last verdict on it (verdict.h)
};

class Journal {
  public:
    /// Opens a journal, and reads it where it exists; fails where it is of something else than `key`
    /// describes.
    static Result<Journal> open(const std::filesystem::path& file, const std::string& key);

    /// Returns what is known of the schedule of a text; null: nothing.
    const Trial* find(const std::string& text) const;
    size_t size() const { return trials_.size(); }
    /// Notes it.
    Result<void> add(const std::string& text, const Trial& trial);

  private:
    Result<void> append(const std::string& line) const;

    std::filesystem::path file_;
    std::map<uint64_t, Trial> trials_;  ///< by the text's hash
};

}  // namespace openfab::tuner
