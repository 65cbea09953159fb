// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The live loop on a world: a thread prints it, at a draft's pitch, by `openfab print`, and again
// whenever the world, a fablet or a value that the page has set changes. While a print runs, the one
// before it stays in view.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/own_folder.h"
#include "base/result.h"
#include "client/child.h"
#include "client/fablet_compiler.h"
#include "client/print_words.h"
#include "tools/viewer/dropped.h"
#include "tools/viewer/full_print.h"
#include "tools/viewer/graph_compiler.h"
#include "tools/viewer/node_look.h"
#include "tools/viewer/part_edit.h"
#include "tools/viewer/part_finder.h"
#include "tools/viewer/prober.h"
#include "tools/viewer/session.h"
#include "tools/viewer/source_text.h"
#include "tools/viewer/view.h"
#include "world/world.h"

namespace openfab::viewer {

/// All functions are thread-safe.
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
    /// Saves a source that still is the one of this stamp; returns `{"stamp", "notes"}`. Where it gives a uniform another
    /// name, so does the world.
    Result<std::string> save(int32_t fablet, const std::string& text, const std::string& stamp);
    /// Returns {"change"}: from which state on (describe()) the print in view has the value, once it is done.
    Result<std::string> set(const std::string& object, const std::string& uniform,
                            const JsonValue& value);
    /// Shows the world as it would be with another text of a fablet, whose `uniform` has a value in all objects: what a hand
    /// that drags a number sees, without a new kernel for each. Until the next try, save, or end_try(). Returns as set().
    Result<std::string> try_value(int32_t fablet, const std::string& text, const std::string& name,
                                  const std::string& uniform, const JsonValue& value);
    void end_try();
    /// Takes a part of a file that is dropped on the page (dropped.h).
    Result<void> upload(const std::string& name, int64_t at, const std::string& bytes);
    /// Makes it part of the world, as the mesh of an object or a texture; returns {"name", "mesh", "notes"}.
    /// `repair`: one that is not closed is made so.
    Result<std::string> use_file(const std::string& name, const std::string& object, bool repair);
    /// Changes the world as the panel "Part" does (part_edit.h), goes back, or forward again.
    Result<void> edit_part(const JsonValue& edits);
    Result<void> step_part(bool forward);
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

  private:
    enum class Phase { kChecking, kPrinting, kDone, kFailed };
    struct Override {
        std::string object, uniform, value;  ///< value is JSON
        std::string trouble;                 ///< why the last print refused it
        std::string setting() const { return object + '.' + uniform + '=' + value; }
    };
    /// A text that is tried (try_value).
    struct Trial {
        std::filesystem::path source;  ///< in place of this
        std::string text;
        std::filesystem::path file;
        std::unique_ptr<TemporaryFolder> folder;  ///< of the file
    };
    /// What was read last.
    struct Read {
        std::shared_ptr<const world::World> world;
        std::vector<std::filesystem::path> sources;
        std::vector<std::filesystem::path> roots;    ///< below which they must stay
        std::map<std::string, JsonValue> described;  ///< by the world's name of the fablet
        std::vector<client::Diagnostic> diagnostics;
        std::string message;
        std::map<std::filesystem::path, std::filesystem::file_time_type> times;
    };

    Live(ViewOptions options, Session* session, std::unique_ptr<TemporaryFolder> folder);

    void run();
    Read read() const;
    static void keep_known(const Read& before, Read* now);
    bool must_read() const;
    bool files_changed() const;
    void begin_print();
    void follow_print();
    void show_preview();
    void show_done_print();
    /// How coarse the next print is; the caller holds the lock.
    int32_t next_draft() const;
    /// Prints once more where a finer print shows more. Returns whether it does.
    bool refine();
    std::filesystem::path statistics_file() const;
    /// Whether the print has made its slices; its process may still compile what the next one culls by.
    bool print_is_whole() const;
    void set_phase(Phase phase, const client::PrintWords& words);
    /// Replaces the world's text by what `change` makes of it.
    Result<void> change_world(const std::function<Result<std::string>(const std::string&)>& change);
    /// The caller holds the lock.
    void describe_part_of_world(JsonText* out) const;
    void describe_object(const world::Object& object, JsonText* out) const;
    struct Source {
        std::filesystem::path path;
        std::vector<std::filesystem::path> roots;
    };
    Result<Source> source_of(int32_t fablet) const;
    /// Finds a uniform that two texts of a source call differently, and gives it its new name in the world. Returns what
    /// was done, for people.
    Result<std::string> rename_bindings(const Source& source, const std::string& before,
                                        const std::string& after);
    void touch();
    /// Wakes who waits for a change. The caller holds the lock.
    void tell_of_change();
    /// Whether the print with the values that were set has begun to make slices, or is done.
    bool values_are_taken() const;

    ViewOptions options_;
    Session* session_;
    std::unique_ptr<TemporaryFolder> folder_;
    client::FabletCompiler compiler_;       ///< of the loop
    client::FabletCompiler page_compiler_;  ///< of check(), with an output of its own
    std::mutex check_mutex_;
    GraphCompiler graphs_;
    Prober prober_;
    NodeLooker looker_;
    Dropped dropped_;
    mutable FullPrint full_print_;
    std::atomic<bool> stop_{false};
    std::mutex uses_mutex_;     ///< of use_file; taken before files_mutex_
    PartHistory part_history_;  ///< guarded by files_mutex_
    std::mutex
        files_mutex_;  ///< of what is in the world's folder (world_lock.h); taken before mutex_

    mutable std::mutex mutex_;              ///< of all below
    std::condition_variable changed_;       ///< of what the loop waits for
    mutable std::condition_variable told_;  ///< of what pages wait for
    int64_t change_ = 0;                    ///< counts what describe() tells of
    mutable int32_t waiting_ = 0;
    bool asked_ = false;  ///< for another print
    Phase phase_ = Phase::kChecking;
    std::string message_;
    std::string remaining_message_;  ///< without what is wrong with a value that was set
    int64_t version_ = 0;            ///< of details()
    int32_t draft_ = 1;              ///< 0: as the part needs
    int32_t printed_draft_ = 0;      ///< of the print that runs, or ran last
    double full_voxels_ = 0;         ///< of the world's grid at its printer's pitch; 0: not known
    bool refines_ = false;           ///< the print that runs is the finer one
    bool shows_full_ = false;        ///< the whole print is in view
    std::vector<std::string> full_settings_;  ///< of the whole print
    int32_t slices_done_ = 0, slices_total_ = 0;
    double mvoxels_per_second_ = 0;  ///< of the last print that was done; 0: not known
    int64_t print_done_ = 0;         ///< its number
    std::vector<Override> overrides_;
    Read read_;
    std::shared_ptr<const PartFinder> finder_;
    std::shared_ptr<const Trial> trial_;
    std::vector<std::string> trial_settings_;
    std::vector<std::string> settings_;        ///< of the print that runs, or ran last
    std::vector<std::string> shown_settings_;  ///< of the print in view
    std::filesystem::path shown_;              ///< the draft that was shown last

    // Of the loop's thread alone.
    std::unique_ptr<client::Child> child_;
    bool is_over_ = false;  ///< the print, while its process compiles on
    int64_t number_ = 0;
    std::shared_ptr<const Trial> printed_trial_;
    std::filesystem::path preview_;
    std::thread thread_;
};

}  // namespace openfab::viewer
