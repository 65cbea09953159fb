// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the page does to the files of a world's folder: the world itself, and its fablets.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>

#include "base/json.h"
#include "base/result.h"
#include "tools/viewer/change_signal.h"
#include "tools/viewer/dropped.h"
#include "tools/viewer/graph_compiler.h"
#include "tools/viewer/part_edit.h"
#include "tools/viewer/set_values.h"
#include "tools/viewer/watched_world.h"

namespace openfab::viewer {

/// Thread-safe, and alone with a folder among the viewers of it (world_lock.h). After each change, a print is asked for.
class WorldFiles {
  public:
    /// What pointers name must outlive it. `scratch`: a folder that exists, for what comes and is made.
    WorldFiles(const std::filesystem::path& world, std::filesystem::path programs,
               std::filesystem::path scratch, GraphCompiler* graphs, SetValues* values,
               ChangeSignal* signal)
        : world_(std::filesystem::absolute(world)),
          programs_(std::move(programs)),
          scratch_(std::move(scratch)),
          graphs_(graphs),
          values_(values),
          signal_(signal),
          dropped_(programs_, scratch_) {}

    struct Saved {
        std::string stamp;
        std::string notes;  ///< for people
    };
    /// Saves a text that still is the one of this stamp. Where it gives a uniform another name, so does the world.
    Result<Saved> save(const WorldReading& reading, const FabletSource& source,
                       const std::string& text, const std::string& stamp);
    /// Changes the world as the panel "Part" does (part_edit.h), goes back, or forward again.
    Result<void> edit_part(const JsonValue& edits);
    Result<void> step_part(bool forward);
    /// Writes the values that are set to the world, and forgets them, if `may_write` has no error for them.
    Result<void> write_values(const std::function<Result<void>(const SetValues::List&)>& may_write);
    /// Takes a part of a file that is dropped on the page.
    Result<void> upload(const std::string& name, int64_t at, const std::string& bytes);
    /// Makes it part of the world (dropped.h).
    Result<Dropped::Made> use_file(const std::string& name, const std::string& object, bool repair);
    /// Puts a template of `openfab new` in place of the world and its fablet.
    Result<void> use_template(const std::string& name);

  private:
    using Change = std::function<Result<std::string>(const std::string&)>;

    /// Replaces the world's text by what `change` makes of it. Returns whether that is another.
    Result<bool> change_world(const Change& change);
    Result<void> print_changed(const Result<bool>& changed);
    /// Finds a uniform that two texts of a source call differently, and gives it its new name in the world. Returns what
    /// was done, for people. The caller holds the folder.
    Result<std::string> rename_bindings(const WorldReading& reading, const FabletSource& source,
                                        const std::string& before, const std::string& after);

    std::filesystem::path world_, programs_, scratch_;
    GraphCompiler* graphs_;
    SetValues* values_;
    ChangeSignal* signal_;
    Dropped dropped_;
    std::mutex uses_mutex_;     ///< of use_file(); taken before files_mutex_
    std::mutex files_mutex_;    ///< of what is in the world's folder
    PartHistory part_history_;  ///< guarded by files_mutex_
};

}  // namespace openfab::viewer
