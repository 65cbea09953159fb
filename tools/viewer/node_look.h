// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the nodes of a graph are at voxels: `openflc lsp` adds a `printf` for each to the text (compiler/graph/look.h),
// and `openflc run` evaluates it, compiled, on the world: over a slice, over the surface, along a line, or in one voxel.

#include <array>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/json.h"
#include "base/result.h"
#include "base/vec.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::viewer {

/// Where nodes are looked at.
enum class LookOver : uint8_t {
    kSlice,    ///< the plane of voxels across an axis through a point
    kLine,     ///< the row of voxels along an axis through it
    kVoxel,    ///< that voxel
    kSurface,  ///< of @Surface its points, of @Volume the voxels at the surface
};

/// The world of a graph, and what of it is looked at.
struct Look {
    std::string world;
    std::vector<std::filesystem::path> sources;  ///< of all of its fablets
    std::filesystem::path source;                ///< the one that the text is of
    std::vector<std::string> allow, settings;    ///< as of `openfab print`
    pipeline::PrintInfo print;                   ///< of the world, at any pitch
    LookOver over = LookOver::kSlice;
    int axis = 2;
    Vec3d point_mm;
};

/// The voxels that are evaluated for that.
struct LookGrid {
    Vec3d pitch_mm;
    double pixel_mm = 0;     ///< of the picture, or between the places of a line
    bool one_slice = false;  ///< that of the point alone
    double shell_mm = 0;     ///< only those so near the surface print; 0: all
    /// And those whose centres are from the first on and below the second.
    std::array<std::optional<std::pair<double, double>>, 3> within_mm;
};
LookGrid grid_of(const Look& of);

/// Thread-safe: one after the other.
class NodeLooker {
  public:
    /// `programs`: the folder of openflc; `scratch`: one that exists, for its files.
    NodeLooker(std::filesystem::path programs, std::filesystem::path scratch)
        : programs_(std::move(programs)), scratch_(std::move(scratch)) {}

    /// Runs a text with prints, as `openfl/look` answers it. Returns, over a slice or surface,
    ///   {"width", "height", "pixel_mm", "inside": [0 or 1 …], "materials": […],
    ///    "nodes": [{"node", "type", "numbers", "low", "high", "values": [0 to 255, or -1 for no number …]}]},
    /// rows from the top, of a pixel all numbers; along a line {"axis", "from_mm", "step_mm", "materials", "nodes"} with the
    /// values themselves, null where there is none; of a voxel {"nodes": [{"node", "type", "numbers", "values": […]}]}.
    Result<std::string> look(const Look& of, const JsonValue& printed);

  private:
    std::filesystem::path programs_, scratch_;
    std::mutex mutex_;
};

}  // namespace openfab::viewer
