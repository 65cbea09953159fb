// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A world whose files may change: what was read of it last, with its fablets as the compiler describes them.

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/json_text.h"
#include "base/result.h"
#include "client/fablet_compiler.h"
#include "tools/viewer/part_finder.h"
#include "world/world.h"

namespace openfab::viewer {

/// A fablet's file.
struct FabletSource {
    std::filesystem::path path;
    std::vector<std::filesystem::path> roots;  ///< below which it must stay
};

/// What was read at one time. What could not be read is as it was before: a mistake while typing takes no control away.
struct WorldReading {
    std::shared_ptr<const world::World> world;    ///< nullptr: none could ever be read
    std::shared_ptr<const PartFinder> finder;     ///< of this world
    std::vector<std::filesystem::path> sources;   ///< of fablets; pages know them by number
    std::vector<std::filesystem::path> roots;     ///< below which they must stay
    std::map<std::string, JsonValue> described;   ///< by the world's name of the fablet
    std::vector<client::Diagnostic> diagnostics;  ///< of the fablets
    std::string message;  ///< why the world could not be read; empty: it could
    std::map<std::filesystem::path, std::filesystem::file_time_type> times;

    /// A user error where there is no fablet of this number.
    Result<FabletSource> source_of(int32_t fablet) const;
    /// The object of a name, or nullptr.
    const world::Object* object(const std::string& name) const;
    /// The uniforms of a fablet by the world's name of it, or nullptr.
    const JsonValue* uniforms_of(const std::string& fablet) const;
    bool can_print() const { return message.empty() && !client::has_errors(diagnostics); }
};

/// Thread-safe; one thread at a time reads anew.
class WatchedWorld {
  public:
    /// `scratch`: a folder that exists, for the compiler's output.
    WatchedWorld(std::filesystem::path file, world::FileRules rules,
                 const std::filesystem::path& programs, const std::filesystem::path& scratch)
        : file_(std::move(file)), rules_(std::move(rules)), compiler_(programs, scratch) {}

    /// What was read last; never nullptr.
    std::shared_ptr<const WorldReading> now() const;
    bool files_changed() const;
    /// Reads the files where that may tell something new. Returns whether the world's own file has changed.
    bool read_again();

  private:
    WorldReading read(const WorldReading& before) const;

    std::filesystem::path file_;
    world::FileRules rules_;
    client::FabletCompiler compiler_;
    mutable std::mutex mutex_;
    std::shared_ptr<const WorldReading> now_ = std::make_shared<WorldReading>();
};

}  // namespace openfab::viewer
