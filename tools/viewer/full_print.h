// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The print that the page asks for: the world at its printer's own pitch, by `openfab print`, to a file beside it that
// nothing else has.

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "base/result.h"
#include "client/child.h"
#include "tools/viewer/print_in_view.h"

namespace openfab::viewer {

/// Thread-safe.
class FullPrint {
  public:
    /// `programs`: the folder of openfab; `scratch`: one that exists, for its messages.
    FullPrint(std::filesystem::path programs, std::filesystem::path scratch)
        : programs_(std::move(programs)), scratch_(std::move(scratch)) {}

    /// Begins; a user error while one runs.
    Result<void> begin(const std::filesystem::path& world, const std::vector<std::string>& allow,
                       const std::vector<std::string>& settings);
    /// Ends one that runs, early: the slices that are whole stay.
    void stop();
    bool runs();
    /// One that is done, once for each.
    std::optional<PrintOfValues> done_now();
    /// The last one; without a file where there was none.
    PrintOfValues last();
    /// Writes null, or {"phase": "printing", "done", "failed" or "stopped", "file", "path", "slices_done", "slices_total",
    /// "seconds_left", "message"}.
    void describe(JsonText* out);

  private:
    std::filesystem::path programs_, scratch_;
    std::mutex mutex_;
    std::unique_ptr<client::Child> child_;
    PrintOfValues print_;  ///< the last one
    bool begun_ = false, stopped_ = false, told_ = false;
};

}  // namespace openfab::viewer
