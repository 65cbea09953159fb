// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/cut/cut.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "pieces/extent.h"

namespace openfab::solid {

namespace {

__extension__ typedef __int128 Wide;

constexpr double kScale = 1ull << 40;  // of the largest coefficient

Wide ceil_div(Wide a, Wide b) {
    const Wide quotient = a / b;
    return quotient + (a % b > 0 ? 1 : 0);
}

int32_t clamped(Wide x, int32_t lo, int32_t hi) {
    return x < lo ? lo : x > hi ? hi : static_cast<int32_t>(x);
}

/// Coverage in a rectangle of columns, all of it void.
void reset(const Box3i& box, voxel::SlabMask* mask) {
    mask->x0 = box.lo.x & ~7;
    mask->y0 = box.lo.y & ~7;
    mask->width = std::max(((box.hi.x + 7) & ~7) - mask->x0, 0);
    mask->height = std::max(((box.hi.y + 7) & ~7) - mask->y0, 0);
    if (box.lo.x >= box.hi.x || box.lo.y >= box.hi.y) mask->width = mask->height = 0;
    mask->mask.assign(static_cast<size_t>(mask->width) * static_cast<size_t>(mask->height), 0);
}

uint8_t* row_of(voxel::SlabMask* mask, int32_t y) {
    return mask->mask.data() +
           static_cast<size_t>(y - mask->y0) * static_cast<size_t>(mask->width) - mask->x0;
}

Box3i common(const Box3i& a, const Box3i& b) {
    Box3i out;
    for (int axis = 0; axis < 3; ++axis) {
        out.lo[axis] = std::max(a.lo[axis], b.lo[axis]);
        out.hi[axis] = std::max(std::min(a.hi[axis], b.hi[axis]), out.lo[axis]);
    }
    return out;
}

/// Returns a box of voxels that holds a box, with one to spare.
Box3i voxels_of(const Box3d& box) {
    Box3i out;
    constexpr double kMost = 1 << 29;
    for (int axis = 0; axis < 3; ++axis) {
        out.lo[axis] =
            static_cast<int32_t>(std::clamp(std::floor(box.lo[axis]) - 1, 0 - kMost, kMost));
        out.hi[axis] =
            static_cast<int32_t>(std::clamp(std::ceil(box.hi[axis]) + 1, 0 - kMost, kMost));
    }
    return out;
}

Box3d of_doubles(const Box3f& box) {
    return {vec_cast<double>(box.lo), vec_cast<double>(box.hi)};
}

}  // namespace

VoxelSide::VoxelSide(const pieces::Side& side, const part::Part& part, const part::Grid& grid)
    : front_(side.front) {
    const Vec3d turned = part.local_to_build.apply_vector(side.normal);
    const double at = dot(turned, grid.origin_mm - part.local_to_build.t) - side.offset;
    const Vec3d n{turned.x * grid.pitch_mm.x, turned.y * grid.pitch_mm.y,
                  turned.z * grid.pitch_mm.z};
    const double scale = kScale / std::max({std::fabs(n.x), std::fabs(n.y), std::fabs(n.z)});
    a_ = std::llround(n.x * scale);
    b_ = std::llround(n.y * scale);
    c_ = std::llround(n.z * scale);
    // Far beyond any grid: the whole of it is on one side.
    constexpr double kFarthest = 1e30;
    d_ = static_cast<Wide>(std::floor(std::clamp(-2 * at * scale, 0 - kFarthest, kFarthest) + 0.5));
}

void VoxelSide::narrow(int32_t y, int32_t z, int32_t* lo, int32_t* hi) const {
    const Wide rest = d_ - Wide{b_} * (2 * int64_t{y} + 1) - Wide{c_} * (2 * int64_t{z} + 1);
    if (a_ == 0) {
        const bool front = rest < 0 || (rest == 0 && (b_ != 0 ? b_ > 0 : c_ > 0));
        if (front != front_) *hi = *lo;
        return;
    }
    const Wide size = a_ > 0 ? a_ : 0 - a_;
    const int32_t from = clamped(ceil_div((a_ > 0 ? rest : 0 - rest) - size, 2 * size), *lo, *hi);
    // Where a is positive, voxels in front are those from here on, else those before it.
    if ((a_ > 0) == front_) {
        *lo = from;
    } else {
        *hi = from;
    }
}

Cut::Cut(const part::Part& part, const part::Grid& grid, const Solid& solid, const Box3i& whole)
    : piece_(part.piece), to_voxel_(part::local_to_voxel(part, grid)) {
    if (!piece_->region.shapes_only) {
        for (const pieces::Side& side : piece_->region.sides)
            sides_.emplace_back(side, part, grid);
    }
    const std::array<double, 9>& r = part.local_to_build.m;
    for (size_t row = 0; row < 3; ++row) {
        for (size_t column = 0; column < 3; ++column)
            to_local_.m[row * 3 + column] =
                r[column * 3 + row] * grid.pitch_mm[static_cast<int>(column)];
    }
    const Vec3d from = grid.origin_mm - part.local_to_build.t;
    to_local_.t = {r[0] * from.x + r[3] * from.y + r[6] * from.z,
                   r[1] * from.x + r[4] * from.y + r[7] * from.z,
                   r[2] * from.x + r[5] * from.y + r[8] * from.z};
    Box3d box = box_in_build(part, solid);
    box.add(voxels_beyond(part, solid, grid.pitch_mm, box));
    box_ = {{0, 0, 0}, {0, 0, 0}};
    if (box.empty()) return;
    for (int axis = 0; axis < 3; ++axis) {
        box.lo[axis] = (box.lo[axis] - grid.origin_mm[axis]) / grid.pitch_mm[axis];
        box.hi[axis] = (box.hi[axis] - grid.origin_mm[axis]) / grid.pitch_mm[axis];
    }
    box_ = common(voxels_of(box), whole);
}

Vec3d Cut::center_of(int32_t x, int32_t y, int32_t z) const {
    return to_local_.apply({x + 0.5, y + 0.5, z + 0.5});
}

Box3i Cut::box_of(const pieces::Shape& shape) const {
    const Box3d local = shape.box();
    Box3d box;
    for (uint32_t i = 0; i < 8; ++i) {
        box.add(to_voxel_.apply({(i & 1) != 0 ? local.hi.x : local.lo.x,
                                 (i & 2) != 0 ? local.hi.y : local.lo.y,
                                 (i & 4) != 0 ? local.hi.z : local.lo.z}));
    }
    return common(voxels_of(box), box_);
}

/// Calls visit(x, y, bit) for the voxels of a shape within a mask.
template <typename Visit>
void Cut::visit_voxels(const pieces::Shape& shape, int32_t slab, const voxel::SlabMask& mask,
                       const Visit& visit) const {
    Box3i box = box_of(shape);
    box = common(box, {{mask.x0, mask.y0, 8 * slab},
                       {mask.x0 + mask.width, mask.y0 + mask.height, 8 * slab + 8}});
    if (box.lo.z >= box.hi.z || box.lo.x >= box.hi.x) return;
    tbb::parallel_for(box.lo.y, box.hi.y, [&](int32_t y) {
        for (int32_t x = box.lo.x; x < box.hi.x; ++x) {
            for (int32_t z = box.lo.z; z < box.hi.z; ++z) {
                if (shape.contains(center_of(x, y, z)))
                    visit(x, y, static_cast<uint8_t>(1u << (z & 7)));
            }
        }
    });
}

void Cut::fill_sides(int32_t slab, voxel::SlabMask* allowed) const {
    const int32_t x0 = allowed->x0, x1 = x0 + allowed->width;
    tbb::parallel_for(allowed->y0, allowed->y0 + allowed->height, [&](int32_t y) {
        uint8_t* row = row_of(allowed, y);
        for (int32_t k = 0; k < 8; ++k) {
            int32_t lo = x0, hi = x1;
            for (const VoxelSide& side : sides_)
                side.narrow(y, 8 * slab + k, &lo, &hi);
            if (lo >= hi) continue;
            row[lo] ^= static_cast<uint8_t>(1u << k);
            if (hi < x1) row[hi] ^= static_cast<uint8_t>(1u << k);
        }
        uint8_t inside = 0;
        for (int32_t x = x0; x < x1; ++x)
            row[x] = inside ^= row[x];
    });
}

void Cut::apply(int32_t slab, voxel::SlabMask* mask, std::vector<FilledMask>* filled) const {
    filled->clear();
    const Box3i covered{{mask->x0, mask->y0, 8 * slab},
                        {mask->x0 + mask->width, mask->y0 + mask->height, 8 * slab + 8}};
    Box3i box = common(box_, covered);
    if (box.lo.z >= box.hi.z) box.hi = box.lo;
    voxel::SlabMask allowed;
    reset(box, &allowed);
    const pieces::Region& region = piece_->region;
    if (!region.shapes_only) fill_sides(slab, &allowed);
    for (const pieces::Shape& shape : region.added) {
        visit_voxels(shape, slab, allowed,
                     [&](int32_t x, int32_t y, uint8_t bit) { row_of(&allowed, y)[x] |= bit; });
    }
    for (const pieces::Shape& shape : region.removed) {
        visit_voxels(shape, slab, allowed, [&](int32_t x, int32_t y, uint8_t bit) {
            row_of(&allowed, y)[x] &= static_cast<uint8_t>(~bit);
        });
    }
    tbb::parallel_for(allowed.y0, allowed.y0 + allowed.height, [&](int32_t y) {
        uint8_t* to = row_of(&allowed, y);
        const uint8_t* from = row_of(mask, y);
        for (int32_t x = allowed.x0; x < allowed.x0 + allowed.width; ++x)
            to[x] &= from[x];
    });
    *mask = std::move(allowed);
    for (size_t i = 0; i < region.filled.size(); ++i) {
        const pieces::Shape& shape = region.filled[i].shape;
        const Box3i of = common(box_of(shape), box);
        if (of.lo.x >= of.hi.x || of.lo.y >= of.hi.y) continue;
        FilledMask one;
        one.code = piece_->filled_codes[i];
        reset(of, &one.mask);
        visit_voxels(shape, slab, one.mask, [&](int32_t x, int32_t y, uint8_t bit) {
            row_of(&one.mask, y)[x] |= static_cast<uint8_t>(bit & row_of(mask, y)[x]);
        });
        filled->push_back(std::move(one));
    }
}

Box3d box_in_build(const part::Part& part, const Solid& solid) {
    if (part.piece == nullptr) return solid.exact_box(part.local_to_build);
    const pieces::Region& region = part.piece->region;
    const bool mesh = part::is_mesh(part) && part.mesh != nullptr && !part.mesh->triangles.empty();
    if (mesh && solid.dicing() == nullptr) {
        return pieces::piece_box(pieces::Body{part.mesh->positions, part.mesh->triangles}, region,
                                 part.local_to_build);
    }
    const Box3f bounds = solid.bounds();
    if (bounds.empty()) return {};
    if (region.shapes_only || region.sides.empty())
        return pieces::piece_box(of_doubles(bounds), region, part.local_to_build);
    Box3d box = solid.box_on_sides(part.local_to_build, region.sides);
    // Where cuts meet within what is displaced, none of its micropolygons need be.
    if (mesh) box.add(pieces::corner_box(of_doubles(bounds), region, part.local_to_build));
    if (box.empty()) return box;
    box.add(pieces::added_box(of_doubles(bounds), region, part.local_to_build));
    // Pegs reach no farther than the part, and what is not known before a print is within this.
    const Box3d whole = solid.exact_box(part.local_to_build),
                most = pieces::piece_box(of_doubles(bounds), region, part.local_to_build);
    for (int axis = 0; axis < 3; ++axis) {
        box.lo[axis] = std::max({box.lo[axis], whole.lo[axis], most.lo[axis]});
        box.hi[axis] = std::min({box.hi[axis], whole.hi[axis], most.hi[axis]});
    }
    return box.empty() ? Box3d{} : box;
}

Box3d voxels_beyond(const part::Part& part, const Solid& solid, const Vec3d& pitch_mm,
                    const Box3d& known) {
    std::span<const pieces::Side> sides;
    if (part.piece != nullptr && !part.piece->region.shapes_only) sides = part.piece->region.sides;
    return solid.voxels_beyond(part.local_to_build, sides, pitch_mm, known);
}

std::vector<int32_t> tops_of_piece(const Placed& placed, const Cut& cut, const Box3i& box) {
    const Vec3i size = box.size();
    std::vector<int32_t> tops(
        static_cast<size_t>(std::max(size.x, 0)) * static_cast<size_t>(std::max(size.y, 0)), 0);
    voxel::SlabMask mask;
    std::vector<FilledMask> filled;
    for (int32_t slab = box.lo.z >> 3; 8 * slab < box.hi.z; ++slab) {
        placed.coverage(slab, &mask, nullptr, nullptr);
        cut.apply(slab, &mask, &filled);
        const int32_t y0 = std::max(mask.y0, box.lo.y), x0 = std::max(mask.x0, box.lo.x);
        for (int32_t y = y0; y < std::min(mask.y0 + mask.height, box.hi.y); ++y) {
            const uint8_t* row = row_of(&mask, y);
            int32_t* out = &tops[static_cast<size_t>(y - box.lo.y) * static_cast<size_t>(size.x)];
            for (int32_t x = x0; x < std::min(mask.x0 + mask.width, box.hi.x); ++x) {
                if (row[x] == 0) continue;
                int32_t top = 7;
                while ((row[x] >> top & 1) == 0)
                    --top;
                out[x - box.lo.x] = 8 * slab + top;
            }
        }
    }
    placed.forget_slabs();
    return tops;
}

}  // namespace openfab::solid
