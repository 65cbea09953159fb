// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The prints that are being looked at.

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "backends/read/print_file.h"
#include "base/result.h"
#include "tools/viewer/cuts.h"
#include "tools/viewer/slice_store.h"
#include "tools/viewer/volume.h"

namespace openfab::viewer {

/// A print with all that was read of it. All functions are thread-safe.
class ViewedPrint {
  public:
    static Result<std::shared_ptr<ViewedPrint>> open(const std::string& path, std::string name,
                                                     int64_t memory_bytes);

    prints::PrintFile& file() { return *file_; }
    SliceStore& slices() { return slices_; }
    Cuts& cuts() { return cuts_; }
    /// Returns the volume, which is begun by the first call.
    Volume& volume();
    const std::string& name() const { return name_; }

  private:
    ViewedPrint(std::unique_ptr<prints::PrintFile> file, std::string name);

    std::unique_ptr<prints::PrintFile> file_;
    std::string name_;
    SliceStore slices_;
    Cuts cuts_;
    std::mutex volume_mutex_;
    std::unique_ptr<Volume> volume_;  ///< last, since it reads from the others
};

/// Two prints of one size, for the volume of their difference. All functions are thread-safe.
class Compared {
  public:
    Compared(std::shared_ptr<ViewedPrint> first, std::shared_ptr<ViewedPrint> second)
        : first_(std::move(first)), second_(std::move(second)) {}
    /// Returns the volume, which is begun by the first call.
    Volume& volume();

  private:
    std::shared_ptr<ViewedPrint> first_, second_;
    std::mutex volume_mutex_;
    std::unique_ptr<Volume> volume_;  ///< last, since it reads from the others
};

/// One print, or two to compare. The generation is another whenever one of them is another print,
/// so that answers on the old one are not taken for ones on the new. All functions are thread-safe.
class Session {
  public:
    explicit Session(int64_t memory_bytes) : memory_bytes_(memory_bytes) {}

    struct Prints {
        int64_t generation = 0;
        std::vector<std::shared_ptr<ViewedPrint>> list;
        std::shared_ptr<Compared> compared;  ///< where both can be compared
    };

    /// Adds a print.
    Result<void> open(const std::string& path);
    /// Shows this one in place of the first; `name` is what it is called.
    Result<void> show(const std::string& path, const std::string& name);
    Prints prints() const;
    /// Finds what was written to the prints since; opens anew what was replaced.
    void look_again();

  private:
    /// Makes what follows from the list. The caller holds the lock; what it returns ends, with its
    /// thread, after that.
    [[nodiscard]] std::shared_ptr<Compared> begin_generation();

    int64_t memory_bytes_;
    mutable std::mutex mutex_;
    Prints prints_;
};

/// Returns why two prints cannot be compared voxel by voxel, or an empty text.
std::string why_not_compared(const pipeline::PrintInfo& a, const pipeline::PrintInfo& b);

}  // namespace openfab::viewer
