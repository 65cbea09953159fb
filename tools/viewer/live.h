// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The live loop on a world: a thread prints it, at a draft's pitch, by `openfab print`, and again
// whenever the world, a fablet or a value that the page has set changes.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/own_folder.h"
#include "base/result.h"
#include "client/fablet_compiler.h"
#include "tools/viewer/change_signal.h"
#include "tools/viewer/draft_print.h"
#include "tools/viewer/full_print.h"
#include "tools/viewer/graph_compiler.h"
#include "tools/viewer/node_look.h"
#include "tools/viewer/print_in_view.h"
#include "tools/viewer/prober.h"
#include "tools/viewer/session.h"
#include "tools/viewer/set_values.h"
#include "tools/viewer/tried_text.h"
#include "tools/viewer/view.h"
#include "tools/viewer/watched_world.h"
#include "tools/viewer/world_files.h"

namespace openfab::viewer {

/// What the page asks of a world, answered by the parts that each have some of it. All functions are thread-safe.
class Live {
  public:
    /// Starts the loop; the session must outlive it.
    static Result<std::unique_ptr<Live>> start(const ViewOptions& options, Session* session);
    ~Live();
    Live(const Live&) = delete;
    Live& operator=(const Live&) = delete;

    bool watches() const { return options_.watch; }
    /// Writes the state of the loop as an object.
    void describe(JsonText* out) const;
    /// Waits until the state has changed since `known`, the "change" of describe(), though not long; returns at once where
    /// several wait already.
    void wait_for_change(int64_t known) const;
    /// Writes the world's objects with their uniforms, the fablets and what is wrong with them.
    std::string details() const;
    /// Returns the part at a point of the preview, where parts are known.
    std::optional<std::string> part_at(const Vec3d& point_mm) const;
    /// Returns the fractions of materials at a point of the preview, before the dither.
    Result<std::vector<double>> fractions_at(const pipeline::PrintInfo& info,
                                             const Vec3d& point_mm);

    // What the page asks for. Errors are the user's where a name or number is unknown.

    /// Returns `{"text", "stamp"}` of a fablet's source by its number.
    Result<std::string> source(int32_t fablet) const;
    /// Returns `{"diagnostics"}` of a text that is not saved.
    Result<std::string> check(int32_t fablet, const std::string& text);
    /// Returns the graph of a text that is not saved, what an action makes of it, or what can be added to it: `method` is
    /// `graph`, `edit` or `palette` (compiler/graph/service.h).
    Result<std::string> graph(const std::string& method, int32_t fablet, const std::string& text,
                              const JsonValue* action);
    /// Where a hand has put the nodes of a fablet's graph (graph_places.h).
    Result<std::string> places(int32_t fablet) const;
    Result<void> keep_places(int32_t fablet, const JsonValue& places) const;
    /// Returns what nodes of a text are at voxels of the print in view (node_look.h). `action`: {"tab", "nodes", "over":
    /// "slice", "line", "voxel" or "surface", "point_mm", "axis"}.
    Result<std::string> look(int32_t fablet, const std::string& text, const JsonValue& action);
    /// Returns a small PNG of a texture of the world (texture_look.h).
    Result<std::vector<uint8_t>> texture(const std::string& name, bool is_volume) const;
    /// Saves a source that still is the one of this stamp; returns `{"stamp", "notes"}`.
    Result<std::string> save(int32_t fablet, const std::string& text, const std::string& stamp);
    /// Returns {"change"}: from which state on (describe()) the print in view has the value, once it is done.
    Result<std::string> set(const std::string& object, const std::string& uniform,
                            const JsonValue& value);
    /// Shows the world as it would be with another text of a fablet (tried_text.h), until the next try, save, or
    /// end_try(). Returns as set().
    Result<std::string> try_value(int32_t fablet, const std::string& text, const std::string& name,
                                  const std::string& uniform, const JsonValue& value);
    void end_try();
    /// Makes a file that was dropped part of the world, as the mesh of an object or a texture; returns {"name", "mesh",
    /// "notes"}. `repair`: one that is not closed is made so.
    Result<std::string> use_file(const std::string& name, const std::string& object, bool repair);
    /// Prints the world with the values that were set, at its printer's own pitch.
    Result<void> begin_full_print();
    void stop_full_print();
    /// Shows the last whole print in place of the draft, or the draft again.
    Result<void> show_full_print(bool full);
    /// Puts a template in place of the world and its fablet; where `openfab view --new` made them.
    Result<void> use_template(const std::string& name);
    /// 0: as fine as the part needs, coarse first.
    void set_draft(int32_t draft);
    /// Forgets the values that were set.
    void revert();
    /// Writes the values that were set to the world; not before a print has taken them.
    Result<void> write();
    WorldFiles& files() { return files_; }

  private:
    Live(ViewOptions options, Session* session, std::unique_ptr<TemporaryFolder> folder);

    void run();
    void print_again();
    /// Returns {"change"}, of an ask for a print.
    std::string asked() const;
    static bool has_taken(const DraftPrint::State& draft, const SetValues::List& values,
                          const ChangeSignal::Counts& counts);

    ViewOptions options_;
    Session* session_;
    std::unique_ptr<TemporaryFolder> folder_;
    mutable ChangeSignal signal_;
    WatchedWorld world_;
    SetValues values_;
    TriedText tried_;
    PrintInView view_;
    DraftPrint draft_;
    mutable FullPrint full_print_;
    GraphCompiler graphs_;
    WorldFiles files_;
    Prober prober_;
    NodeLooker looker_;
    std::mutex check_mutex_;
    client::FabletCompiler page_compiler_;  ///< of check(), with an output of its own
    std::thread thread_;
};

}  // namespace openfab::viewer
