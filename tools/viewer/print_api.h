// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Answers what the page asks about prints. Everything is read only.
//
//   api/tile    a part of a slice or cut as a PNG: generation, print (0, 1 or diff), axis (x, y or
//               z), at, lu, lv (levels), u, v, coarse, colors
//   api/pick    a voxel: generation, print, x, y, z; with `reach` the nearest solid one in its slice
//   api/amounts fractions of the materials in a voxel before the dither: generation, print, x, y, z
//   api/slice   voxels of a slice by code, and of a difference those that differ by both codes:
//               generation, print, z
//   api/volume  RGBA of cells, once more steps were read than `known`; else 204: generation, print,
//               colors, known
//   api/opening the slice that shows most: generation, print

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "base/vec.h"
#include "tools/viewer/http_server.h"
#include "tools/viewer/session.h"

namespace openfab::viewer {

/// Returns the name of the part at a point in build space, empty for none; where parts are unknown,
/// there is no such function.
using PartAt = std::function<std::optional<std::string>(const Vec3d& point_mm)>;

/// Returns the fraction of each material of the first print at a point in build space; where its
/// world is unknown, there is no such function.
using AmountsAt = std::function<Result<std::vector<double>>(const pipeline::PrintInfo& info,
                                                            const Vec3d& point_mm)>;

/// What is known of the world that the first print was made from.
struct OfWorld {
    PartAt part_at;
    AmountsAt amounts_at;
};

/// Answers a request, or nothing where the path is none of these.
std::optional<Answer> answer_on_prints(const Session& session, const OfWorld& world,
                                       const Request& request);

/// Writes `"generation": …, "prints": […], "difference": …` into an object.
void describe_prints(const Session::Prints& prints, JsonText* out);

/// An answer that something is wrong with the request, or with what it wants to read.
Answer refusal(int status, const std::string& why);

}  // namespace openfab::viewer
