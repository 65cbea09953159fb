// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "runtime/pipeline/messages.h"
#include "runtime/solid/cut/cut.h"
#include "runtime/surface/transform_box.h"

namespace openfab::pipeline {

namespace {

// Limits: strides of a packed slice fit 32 bits in kernels, and voxel indices are exact in float.
constexpr double kLargestSide = 1 << 24;
constexpr double kFarthest = 1e9;  // of the origin, in voxels
constexpr int64_t kLargestSliceBytes = std::numeric_limits<int32_t>::max();

double snapped(double position_vox) {
    return std::floor(256.0 * position_vox + 0.5) / 256.0;
}

std::string size_of(const Box3d& box) {
    const Vec3d size = box.size();
    return fmt::format("{:.6g} x {:.6g} x {:.6g} mm", size.x, size.y, size.z);
}

/// The part that extends farthest, and its displacement's share of that.
std::string largest_part(std::span<const part::Part> parts,
                         const std::vector<std::shared_ptr<solid::Solid>>& solids) {
    Box3d all;
    std::vector<Box3d> boxes;
    for (size_t i = 0; i < parts.size(); ++i) {
        boxes.push_back(solid::box_in_build(parts[i], *solids[i]));
        all.add(boxes.back());
    }
    const auto reach = [&](const Box3d& box) {
        const Vec3d from = box.lo - all.center(), to = box.hi - all.center();
        return std::max({-from.x, -from.y, to.x, to.y, -from.z, to.z});
    };
    size_t worst = 0;
    for (size_t i = 1; i < boxes.size(); ++i) {
        if (reach(boxes[i]) > reach(boxes[worst])) worst = i;
    }
    Box3d plain;
    if (!part::is_mesh(parts[worst])) {
        plain = boxes[worst];
    } else {
        for (const Vec3d& p : parts[worst].mesh->positions)
            plain.add(parts[worst].local_to_build.apply(p));
    }
    const Vec3d more = boxes[worst].size() - plain.size();
    std::string text = fmt::format(messages::kReachesFarthest, parts[worst].name, size_of(plain));
    constexpr double kSmall_mm = 1e-3;  // rounding
    const double most = std::max({more.x, more.y, more.z});
    if (most > kSmall_mm) {
        text += fmt::format(messages::kBeforeDisplacement, size_of(boxes[worst]));
    }
    return text;
}

/// Whether a part is of no material: it only cuts others, and may reach beyond all of them.
bool only_cuts(const part::Part& part) {
    return !part.slot_material.empty() &&
           std::all_of(part.slot_material.begin(), part.slot_material.end(),
                       [](uint8_t code) { return code == 0; });
}

bool contains(const Box3d& outer, const Box3d& inner) {
    for (int a = 0; a < 3; ++a) {
        if (inner.lo[a] < outer.lo[a] || inner.hi[a] > outer.hi[a]) return false;
    }
    return true;
}

}  // namespace

Result<part::Grid> make_grid(std::span<const part::Part> parts,
                             const std::vector<std::shared_ptr<solid::Solid>>& solids,
                             const Vec3d& pitch_mm, int32_t bits, const Vec3i& margin_vox,
                             const std::optional<Box3d>& crop_mm,
                             const std::optional<Box3d>& window_mm,
                             const std::optional<Vec3d>& lattice_mm) {
    Box3d box = window_mm.value_or(crop_mm.value_or(Box3d{}));
    bool any = window_mm.has_value();
    std::map<const solid::Solid*, Box3f> bounds;
    const bool all_cut = std::all_of(parts.begin(), parts.end(), only_cuts);
    for (size_t i = 0; i < parts.size() && !window_mm; ++i) {
        if (only_cuts(parts[i]) && !all_cut) continue;
        const auto [known, fresh] = bounds.try_emplace(solids[i].get());
        if (fresh) known->second = solids[i]->bounds();
        // Few of many parts are at the border; the others need no exact box.
        if (known->second.empty()) continue;
        any = true;
        if (contains(box, surface::transform_box(parts[i].local_to_build, known->second))) continue;
        box.add(solid::box_in_build(parts[i], *solids[i]));
        box.add(solid::voxels_beyond(parts[i], *solids[i], pitch_mm, box));
    }
    // A piece of a shape that is empty is known by its surface alone.
    if (!any || box.empty()) return user_error(messages::kNothingToPrint);
    part::Grid grid;
    grid.pitch_mm = pitch_mm;
    for (int a = 0; a < 3; ++a) {
        const int32_t margin = window_mm ? 0 : margin_vox[a];
        const double step = lattice_mm ? (*lattice_mm)[a] / pitch_mm[a] : 1;
        const double lo =
            std::floor(snapped(box.lo[a] / (step * pitch_mm[a]))) * step - (a == 2 ? 0 : margin);
        const double hi = lattice_mm
                              ? lo + std::ceil(snapped(box.hi[a] / pitch_mm[a] - lo)) + margin
                              : std::ceil(snapped(box.hi[a] / pitch_mm[a])) + margin;
        const double size = std::max(hi - lo, 1.0);
        if (!(std::fabs(lo) <= kFarthest)) {
            return user_error(
                fmt::format(messages::kBeginsTooFar,
                            window_mm ? messages::kWindowBegins : messages::kPartsBegin, box.lo[a],
                            "xyz"[a], kFarthest, pitch_mm[a]));
        }
        if (!(size <= kLargestSide)) {
            return user_error(fmt::format(messages::kSpansTooFar,
                                          window_mm ? messages::kWindowSpans : messages::kPartsSpan,
                                          box.hi[a] - box.lo[a], "xyz"[a], size, pitch_mm[a],
                                          kLargestSide, largest_part(parts, solids)));
        }
        grid.origin_mm[a] = lo * pitch_mm[a];
        grid.size[a] = static_cast<int32_t>(size);
    }
    const int64_t slice_bytes = (int64_t{grid.size.x} * bits + 7) / 8 * grid.size.y;
    if (slice_bytes > kLargestSliceBytes) {
        return user_error(fmt::format(messages::kSliceTooLarge, grid.size.x, grid.size.y,
                                      8 / bits * kLargestSliceBytes, largest_part(parts, solids)));
    }
    return grid;
}

Result<Vec2<int32_t>> slice_range(const part::Grid& grid, const PrintOptions& options) {
    Vec2<int32_t> range{0, grid.size.z};
    if (options.slices) {
        range = *options.slices;
        // The last of equal ranges, as job arrays make them, may reach past the end.
        if (range.x < std::min(range.y, grid.size.z)) range.y = std::min(range.y, grid.size.z);
        if (range.x < 0 || range.x >= grid.size.z || range.x >= range.y) {
            return user_error(fmt::format(messages::kSlicesOutside, range.x,
                                          range.y == kToTheEnd ? "" : std::to_string(range.y),
                                          grid.size.z));
        }
    } else if (options.part) {
        // On borders of slabs, so that no work is done twice.
        constexpr int64_t kSlab = 8;
        const int64_t slabs = (grid.size.z + kSlab - 1) / kSlab;
        const auto [part, parts] = *options.part;
        if (parts > slabs)
            return user_error(fmt::format(messages::kMorePartsThanSlabs, part, parts, slabs));
        const int64_t count = parts;
        const auto begin_of = [&](int32_t one) {
            return static_cast<int32_t>(
                std::min<int64_t>(one * slabs / count * kSlab, grid.size.z));
        };
        range = {begin_of(part - 1), begin_of(part)};
    } else if (options.z_range_mm) {
        const Vec2<double> z = *options.z_range_mm;
        const double top = grid.size.z * grid.pitch_mm.z;
        if (!(z.x < z.y) || !(z.y > 0) || !(z.x < top)) {
            return user_error(fmt::format(messages::kNoSliceInRange, z.x, z.y, top));
        }
        range.x = static_cast<int32_t>(std::floor(std::max(z.x, 0.0) / grid.pitch_mm.z));
        range.y =
            static_cast<int32_t>(std::min<double>(std::ceil(z.y / grid.pitch_mm.z), grid.size.z));
    }
    return range;
}

}  // namespace openfab::pipeline
