// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Prints of a world at a draft's pitch, one after the other. While one runs, the one before it stays in view.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "client/child.h"
#include "client/print_words.h"
#include "tools/viewer/change_signal.h"
#include "tools/viewer/print_in_view.h"
#include "tools/viewer/set_values.h"
#include "tools/viewer/tried_text.h"
#include "tools/viewer/view.h"
#include "tools/viewer/watched_world.h"

namespace openfab::viewer {

/// The state is for all threads, the prints for one: that of the loop.
class DraftPrint {
  public:
    enum class Phase { kChecking, kPrinting, kDone, kFailed };
    struct State {
        Phase phase = Phase::kChecking;
        std::string message;
        std::string other_message;  ///< without what is wrong with a value that was set
        int32_t draft = 1;          ///< that the page asks for; 0: as the part needs
        int32_t printed_draft = 0;  ///< of the print that runs, or ran last
        int32_t slices_done = 0, slices_total = 0;
        int64_t values_edition = 0;     ///< of the values of that print (SetValues)
        double mvoxels_per_second = 0;  ///< of the last print that was done; 0: not known
        int64_t done_number = 0;        ///< its number
    };

    /// All but `options` must outlive it. `scratch`: a folder that exists, for prints.
    DraftPrint(ViewOptions options, std::filesystem::path scratch, ChangeSignal* signal,
               SetValues* values, PrintInView* view);

    State state() const;
    /// Of the prints that begin from now on.
    void set_draft(int32_t draft);

    // For the loop's thread.

    /// Ends the print that runs: another follows.
    void end();
    /// The size of the world's grid is not known any more.
    void forget_size() { full_voxels_ = 0; }
    void begin(const WorldReading& reading, const TriedText::Trial& trial);
    void follow();
    /// Whether a finer print would show more now; it is the next one.
    bool refines();
    /// Whether slices are waited for.
    bool makes_slices() const { return child_ != nullptr && !is_over_; }

  private:
    int32_t next_draft() const;
    std::filesystem::path statistics_file() const;
    bool is_whole() const;
    void show();
    void set_phase(Phase phase, const client::PrintWords& words);

    ViewOptions options_;
    std::filesystem::path scratch_;
    ChangeSignal* signal_;
    SetValues* values_;
    PrintInView* view_;
    mutable std::mutex mutex_;
    State state_;  ///< guarded by mutex_

    // Of the loop's thread alone.
    std::unique_ptr<client::Child> child_;
    PrintOfValues print_;                          ///< that runs, or ran last
    std::shared_ptr<const TriedText::Text> text_;  ///< that is tried in it
    double full_voxels_ = 0;  ///< of the world's grid at its printer's pitch; 0: not known
    bool is_finer_ = false;   ///< the second print, of a draft that is as the part needs
    bool is_over_ = false;    ///< the print, while its process compiles on
    int64_t number_ = 0;
};

}  // namespace openfab::viewer
