// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What of a result is shown in colours, and by which scale.

#include <filesystem>
#include <string>
#include <vector>

#include "mechanics/model/picture.h"
#include "mechanics/part/part_results.h"

namespace openfab::mechanics {

/// What `--show` takes.
inline constexpr const char* kShown[] = {"von-mises", "displacement", "tension", "compression",
                                         "safety"};

struct Shown {
    std::string name, unit;     ///< "von-mises", "MPa"
    std::vector<float> values;  ///< of elements
    double least = 0, most = 1;
    bool low_is_bad = false;  ///< of safety factors, and of compression, which is below 0

    Colour colour(double value) const;
};

/// `what` is one of kShown. A few elements in a thousand are beyond the scale, so that a corner's peak does
/// not make all else dark; that of safety is the same for all parts, so that two can be compared.
Shown shown_of(const PartProblem& problem, const PartFields& fields,
               const Field<double, kElastic>& moved_mm, const std::string& what);

/// FILE.ofr, as `openfab view` opens: a voxel an element, a material of its colour for each band of values.
Result<void> write_bands(const std::filesystem::path& file, const Grid& grid, const Vec3& origin_mm,
                         const std::vector<uint8_t>& kind, const Shown& shown);

/// A number as short as it may be on a scale.
std::string short_number(double value);

}  // namespace openfab::mechanics
