// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/part_sizes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "runtime/pipeline/messages.h"
#include "runtime/solid/cut/cut.h"

namespace openfab::pipeline {

namespace {

/// Limit of the lines of one kind; thousands of instances share a fault.
constexpr size_t kMostSizes = 4;

bool is_whole_mesh(const part::Part& part) {
    return part::is_mesh(part) && part.piece == nullptr;
}

/// Computes the sizes of placed parts, visiting each mesh once.
class Ruler {
  public:
    explicit Ruler(const Vec3d& pitch_mm) : pitch_mm_(pitch_mm) {}

    /// Of a part that may reach nowhere, zeros.
    Vec3d voxels(const part::Part& part, const solid::Solid& solid) {
        const Box3d placed =
            is_whole_mesh(part) ? placed_mesh(part) : solid::box_in_build(part, solid);
        if (placed.empty()) return {};
        const Vec3d size = placed.size();
        return {size.x / pitch_mm_.x, size.y / pitch_mm_.y, size.z / pitch_mm_.z};
    }

  private:
    Box3d placed_mesh(const part::Part& part) {
        const Box3d& box = box_of(part);
        Box3d placed;
        for (int corner = 0; corner < 8; ++corner) {
            placed.add(part.local_to_build.apply({(corner & 1) != 0 ? box.hi.x : box.lo.x,
                                                  (corner & 2) != 0 ? box.hi.y : box.lo.y,
                                                  (corner & 4) != 0 ? box.hi.z : box.lo.z}));
        }
        return placed;
    }

    const Box3d& box_of(const part::Part& part) {
        const auto [at, fresh] = boxes_.try_emplace(part.mesh.get());
        for (size_t i = 0; fresh && i < part.mesh->positions.size(); ++i)
            at->second.add(part.mesh->positions[i]);
        return at->second;
    }

    Vec3d pitch_mm_;
    // Only for lookup, never iterated: the order of pointers must not affect results.
    std::map<const part::PartMesh*, Box3d> boxes_;
};

std::string describe(const part::Part& part, const Vec3d& voxels) {
    return fmt::format(messages::kPartSize, part.name, part.instance, voxels.x, voxels.y, voxels.z);
}

}  // namespace

std::string part_sizes(std::span<const part::Part> parts,
                       const std::vector<std::shared_ptr<solid::Solid>>& solids,
                       const Vec3d& pitch_mm) {
    Ruler ruler(pitch_mm);
    std::string text;
    for (size_t i = 0; i < std::min(parts.size(), kMostSizes); ++i) {
        text += fmt::format("{}{}", i == 0 ? "" : "; ",
                            describe(parts[i], ruler.voxels(parts[i], *solids[i])));
    }
    if (parts.size() > kMostSizes)
        text += fmt::format(messages::kAndMoreParts, parts.size() - kMostSizes);
    return text;
}

std::vector<std::string> thin_part_warnings(
    std::span<const part::Part> parts, const std::vector<std::shared_ptr<solid::Solid>>& solids,
    const Vec3d& pitch_mm) {
    // Not for the rounding of what is one thick.
    constexpr double kThin = 1 - 1e-4;
    Ruler ruler(pitch_mm);
    std::vector<std::string> warnings;
    size_t thin = 0;
    for (size_t i = 0; i < parts.size(); ++i) {
        const part::Part& part = parts[i];
        const Vec3d voxels = ruler.voxels(part, *solids[i]);
        // Nothing of it is a warning of its own.
        if (voxels == Vec3d{}) continue;
        // A surface stage may thicken it arbitrarily, unless the world bounds it.
        const double grows = part.fablet->has_surface != 0 && is_whole_mesh(part)
                                 ? 2 * static_cast<double>(part.max_displacement_mm)
                                 : 0;
        bool vanishes = false;
        for (int a = 0; a < 3; ++a)
            vanishes = vanishes || voxels[a] + grows / pitch_mm[a] < kThin;
        if (!vanishes || ++thin > kMostSizes) continue;
        warnings.push_back(describe(part, voxels) + messages::kPartVanishes);
    }
    if (thin > kMostSizes)
        warnings.push_back(fmt::format(messages::kMorePartsThin, thin - kMostSizes));
    return warnings;
}

std::vector<std::string> lost_part_warnings(std::span<const part::Part> parts,
                                            const std::vector<bool>& covered) {
    std::vector<std::string> warnings;
    size_t lost = 0;
    for (size_t i = 0; i < parts.size() && parts.size() > 1; ++i) {
        if (covered[i] || parts[i].piece != nullptr || ++lost > kMostSizes) continue;
        warnings.push_back(fmt::format(messages::kPartLost, parts[i].name, parts[i].instance));
    }
    if (lost > kMostSizes)
        warnings.push_back(fmt::format(messages::kMorePartsLost, lost - kMostSizes));
    return warnings;
}

std::vector<std::string> empty_part_notes(std::span<const part::Part> parts,
                                          const std::vector<volume::PartVoxels>& voxels) {
    constexpr double kMuch = 0.01;
    // By object: its instances share its fablet, if not its uniforms.
    std::map<std::string, volume::PartVoxels> sums;
    std::vector<const std::string*> names;
    for (size_t i = 0; i < parts.size(); ++i) {
        if (std::ranges::count(parts[i].slot_material, 0) > 0) continue;
        const auto [at, fresh] = sums.try_emplace(parts[i].name);
        if (fresh) names.push_back(&at->first);
        at->second.own += voxels[i].own;
        at->second.empty += voxels[i].empty;
        at->second.unusable += voxels[i].unusable;
    }
    const auto share = [&](const volume::PartVoxels& sum) {
        return static_cast<double>(sum.empty) / static_cast<double>(std::max<int64_t>(sum.own, 1));
    };
    const auto list = [&](bool negative) {
        std::string text;
        size_t count = 0;
        for (const std::string* name : names) {
            const volume::PartVoxels& sum = sums[*name];
            if (share(sum) <= kMuch || (sum.unusable > 0) != negative || ++count > kMostSizes)
                continue;
            text +=
                fmt::format(messages::kEmptyShare, count == 1 ? "" : ", ", 100 * share(sum), *name);
        }
        if (count > kMostSizes) text += fmt::format(messages::kMoreEmpty, count - kMostSizes);
        return text;
    };
    std::vector<std::string> notes;
    if (const std::string zero = list(false); !zero.empty())
        notes.push_back(fmt::format(messages::kPartsEmpty, zero));
    if (const std::string negative = list(true); !negative.empty())
        notes.push_back(fmt::format(messages::kPartsEmptyNegative, negative));
    return notes;
}

}  // namespace openfab::pipeline
