// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the nodes of a graph are at voxels: `openflc lsp` adds a `printf` for each to the text (compiler/graph/look.h),
// and `openflc run` evaluates it, compiled, on the world: over a slice, over the surface, or in one voxel.

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/result.h"
#include "base/vec.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::viewer {

/// The world of a graph, and what of it is looked at.
struct Look {
    std::string world;
    std::vector<std::filesystem::path> sources;  ///< of all of its fablets
    std::filesystem::path source;                ///< the one that the text is of
    std::vector<std::string> allow, settings;    ///< as of `openfab print`
    pipeline::PrintInfo print;                   ///< of the world, at any pitch
    bool is_surface = false;                     ///< of nodes of @Surface
    int32_t slice = 0;
    std::optional<Vec3d> point_mm;  ///< this voxel alone
};

/// Thread-safe: one after the other.
class NodeLooker {
  public:
    /// `programs`: the folder of openflc; `scratch`: one that exists, for its files.
    NodeLooker(std::filesystem::path programs, std::filesystem::path scratch)
        : programs_(std::move(programs)), scratch_(std::move(scratch)) {}

    /// Runs a text with prints, as `openfl/look` answers it. Returns, of a slice or surface,
    ///   {"width", "height", "pixel_mm", "inside": [0 or 1 …], "materials": […],
    ///    "nodes": [{"node", "type", "numbers", "low", "high", "values": [0 to 255, or -1 for no number …]}]},
    /// rows from the top, of a pixel all numbers; of a voxel {"nodes": [{"node", "type", "numbers", "values": […]}]}.
    Result<std::string> look(const Look& of, const JsonValue& printed);

  private:
    std::filesystem::path programs_, scratch_;
    std::mutex mutex_;
};

}  // namespace openfab::viewer
