// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/shape_near.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "base/check.h"
#include "base/infinity.h"

namespace openfab::solid {

namespace {

constexpr int32_t kCube = 4;  // cells along a cube
constexpr int32_t kCubes = kPatchCells / kCube;
static_assert(kCubes == kBlockCubes);
// Shells of blocks around a box that are looked through; what is farther is far.
constexpr int32_t kMostShells = 16;
// Of the distances that voxels are told, and of what is computed here.
constexpr float kRelative = 0x1p-13f, kOfCoordinates = 0x1p-17f;

/// Of two stretches of an axis: the square of the least distance.
float gap2(float lo_a, float hi_a, float lo_b, float hi_b) {
    const float d = std::max(std::max(lo_a - hi_b, lo_b - hi_a), 0.0f);
    return d * d;
}

}  // namespace

ShapeNear::ShapeNear(const ShapeField& field, std::span<const Vec3i> blocks)
    : field_(field),
      blocks_(blocks),
      masks_(std::make_unique<Masks[]>(blocks.size())),
      kernels_(near_kernels()),
      block_mm_(static_cast<float>(field.cell_mm() * kPatchCells)) {
    const Vec3i cells = field.cells();
    for (int a = 0; a < 3; ++a) {
        size_[a] = (cells[a] + kPatchCells - 1) / kPatchCells;
        for (int32_t cube = 0; cube <= kCubes * size_[a]; ++cube) {
            Vec3i vertex{0, 0, 0};
            vertex[a] = std::min(kCube * cube, cells[a]);
            edges_[static_cast<size_t>(a)].push_back(field.position(vertex)[a]);
        }
        largest_ = std::max({largest_, std::fabs(edges_[static_cast<size_t>(a)].front()),
                             std::fabs(edges_[static_cast<size_t>(a)].back())});
    }
    const auto rows = static_cast<size_t>(size_.y) * static_cast<size_t>(size_.z);
    rows_.assign(rows + 1, 0);
    for (const Vec3i& lowest : blocks) {
        const auto row = static_cast<size_t>(lowest.z / kPatchCells * size_.y) +
                         static_cast<size_t>(lowest.y / kPatchCells);
        ++rows_[row + 1];
    }
    for (size_t row = 0; row < rows; ++row)
        rows_[row + 1] += rows_[row];
}

/// An edge of four cells between an inside and an outside vertex has a micro-vertex; micropolygons
/// around it have an area unless the inside vertex is alone, so that one beside it is looked at.
void ShapeNear::find_masks(size_t block, uint64_t* possible, uint64_t* certain) const {
    const Vec3i lowest = blocks_[block], cells = field_.cells();
    ShapePoints points, lo, hi;
    Vec3i end;
    for (int a = 0; a < 3; ++a)
        end[a] = std::min(lowest[a] + kPatchCells, cells[a]);
    const auto vertex = [&](int32_t x, int32_t y, int32_t z) {
        const Vec3i at = lowest + Vec3i{x, y, z} * kCube;
        return Vec3i{std::min(at.x, end.x), std::min(at.y, end.y), std::min(at.z, end.z)};
    };
    std::array<const float*, 3> sides{};
    for (int a = 0; a < 3; ++a) {
        const auto axis = static_cast<size_t>(a);
        sides[axis] = &edges_[axis][static_cast<size_t>(lowest[a] / kCube)];
    }
    points.resize(125);
    lo.resize(kMostBlockCubes);
    hi.resize(kMostBlockCubes);
    for (size_t i = 0; i < points.size(); ++i)
        points.set(i, {sides[0][i % 5], sides[1][i / 5 % 5], sides[2][i / 25]});
    for (size_t i = 0; i < kMostBlockCubes; ++i) {
        const size_t x = i % 4, y = i / 4 % 4, z = i / 16;
        lo.set(i, {sides[0][x], sides[1][y], sides[2][z]});
        hi.set(i, {sides[0][x + 1], sides[1][y + 1], sides[2][z + 1]});
    }
    ShapeCalls* calls = field_.take();
    std::vector<float> values, value_lo, value_hi, beside;
    abi::KernelStatus status = calls->sign_bounds(lo, hi, &value_lo, &value_hi);
    if (status.ok()) status = calls->signs(points, &values);
    const Box3f around = field_.block_box(lowest);
    if (status.ok()) field_.close_border(around, points, &values);
    *possible = *certain = 0;
    for (size_t i = 0; i < 64 && status.ok(); ++i) {
        const bool inside = value_hi[i] < 0 && !field_.at_border({lo.point(i), hi.point(i)});
        if (!(value_lo[i] >= 0) && !inside) *possible |= uint64_t{1} << i;
    }
    struct Edge {
        int32_t axis;
        Vec3i at;
    };
    std::vector<Edge> edges;
    const auto value = [&](const Vec3i& at) {
        return values[static_cast<size_t>((at.z * (kCubes + 1) + at.y) * (kCubes + 1) + at.x)];
    };
    points.clear();
    for (int32_t i = 0; i < 125 && status.ok(); ++i) {
        const Vec3i at{i % 5, i / 5 % 5, i / 25};
        for (int axis = 0; axis < 3; ++axis) {
            if (at[axis] == kCubes) continue;
            Vec3i next = at;
            ++next[axis];
            if ((value(at) < 0) == (value(next) < 0)) continue;
            edges.push_back({axis, at});
            const Vec3i& in = value(at) < 0 ? at : next;
            for (const int32_t step : {-1, 1}) {
                Vec3i to = vertex(in.x, in.y, in.z);
                to[axis] = std::clamp(to[axis] + step, 0, cells[axis]);
                points.push_back(field_.position(to));
            }
        }
    }
    if (status.ok() && !edges.empty()) {
        status = calls->signs(points, &beside);
        // Those beside it may be of the next block.
        if (status.ok()) field_.close_border(field_.bounds(), points, &beside);
    }
    field_.give(calls);
    if (!status.ok()) {
        field_.note(status);
        *possible = ~uint64_t{0};
        return;
    }
    for (size_t e = 0; e < edges.size(); ++e) {
        if (!(beside[2 * e] < 0) && !(beside[2 * e + 1] < 0)) continue;
        const auto& [axis, at] = edges[e];
        const int b = (axis + 1) % 3, c = (axis + 2) % 3;
        for (int32_t k = 0; k < 4; ++k) {
            Vec3i cube = at;
            cube[b] -= k & 1, cube[c] -= k >> 1;
            if (cube[b] < 0 || cube[c] < 0 || cube[b] == kCubes || cube[c] == kCubes) continue;
            *certain |= uint64_t{1} << ((cube.z * kCubes + cube.y) * kCubes + cube.x);
        }
    }
    *possible |= *certain;
    // Each block has a micropolygon.
    if (*possible == 0) *possible = ~uint64_t{0};
}

void ShapeNear::add_block(size_t number, const Box3f& whole, Tools* tools, float* nearest2) const {
    const Vec3i& lowest = blocks_[number];
    NearBlock block;
    float block2 = 0;  // no cube is nearer than the block is
    for (int a = 0; a < 3; ++a) {
        const auto axis = static_cast<size_t>(a);
        block.first[axis] = lowest[a] / kCube;
        const float* const sides = &edges_[axis][static_cast<size_t>(block.first[axis])];
        block.sides[axis] = sides;
        block2 += gap2(whole.lo[a], whole.hi[a], sides[0], sides[kCubes]);
    }
    if (block2 > *nearest2) return;
    Masks& masks = masks_[number];
    block.possible = masks.possible.load(std::memory_order_acquire);
    if (block.possible != 0) {
        block.certain = masks.certain.load(std::memory_order_relaxed);
    } else {
        find_masks(number, &block.possible, &block.certain);
        masks.certain.store(block.certain, std::memory_order_relaxed);
        masks.possible.store(block.possible, std::memory_order_release);
    }
    // The list only grows: to make it longer by what a block may add, and shorter again, is work for each.
    if (tools->cubes_.size() < tools->count_ + kMostBlockCubes)
        tools->cubes_.resize(2 * tools->cubes_.size() + kMostBlockCubes);
    tools->count_ += kernels_.add(block, whole, nearest2, tools->cubes_.data() + tools->count_);
}

/// Adds the blocks x0 … x1, both included, of a row.
void ShapeNear::add_row(int32_t y, int32_t z, int32_t x0, int32_t x1, const Box3f& whole,
                        Tools* tools, float* nearest2) const {
    if (y < 0 || z < 0 || y >= size_.y || z >= size_.z) return;
    const auto gap = [&](int axis, int32_t block) {
        const float* const sides =
            &edges_[static_cast<size_t>(axis)][static_cast<size_t>(kCubes * block)];
        return gap2(whole.lo[axis], whole.hi[axis], sides[0], sides[kCubes]);
    };
    if (gap(1, y) + gap(2, z) > *nearest2) return;
    const auto row = static_cast<size_t>(z) * static_cast<size_t>(size_.y) + static_cast<size_t>(y);
    const auto begin = blocks_.begin() + static_cast<ptrdiff_t>(rows_[row]);
    const auto end = blocks_.begin() + static_cast<ptrdiff_t>(rows_[row + 1]);
    auto at = std::lower_bound(begin, end, x0 * kPatchCells,
                               [](const Vec3i& block, int32_t x) { return block.x < x; });
    for (; at != end && at->x <= x1 * kPatchCells; ++at)
        add_block(static_cast<size_t>(at - blocks_.begin()), whole, tools, nearest2);
}

void ShapeNear::bound(const Box3f& whole, std::span<const Box3f> boxes, Tools* tools,
                      NearRange* out) const {
    tools->count_ = 0;
    Vec3i lo, hi;  // the blocks that the box is in, which may lie beyond the lattice
    for (int a = 0; a < 3; ++a) {
        const float origin = field_.origin()[a];
        const auto block = [&](float x) {
            return static_cast<int32_t>(
                std::clamp(std::floor((x - origin) / block_mm_), -1e6f, 1e6f));
        };
        lo[a] = block(whole.lo[a]);
        hi[a] = block(whole.hi[a]);
    }
    // Of a surface that is there for certain, from any point of the box.
    float nearest2 = kInfinity;
    if (tools->of_ == this) {
        nearest2 = 0;
        for (size_t a = 0; a < 3; ++a) {
            const int axis = static_cast<int>(a);
            const float* const sides = &edges_[a][static_cast<size_t>(tools->last_.at[a])];
            const float most = std::max(whole.hi[axis] - sides[0], sides[1] - whole.lo[axis]);
            nearest2 += most * most;
        }
    }
    float seen = 0;  // how far all of it was looked at
    for (int32_t r = 0; r <= kMostShells; ++r) {
        seen = static_cast<float>(std::max(r - 1, 0)) * block_mm_ * (1 - kRelative);
        if (seen * seen > nearest2) break;
        for (int32_t z = lo.z - r; z <= hi.z + r; ++z) {
            for (int32_t y = lo.y - r; y <= hi.y + r; ++y) {
                const bool shell = z == lo.z - r || z == hi.z + r || y == lo.y - r || y == hi.y + r;
                if (shell || r == 0) {
                    add_row(y, z, lo.x - r, hi.x + r, whole, tools, &nearest2);
                } else {
                    add_row(y, z, lo.x - r, lo.x - r, whole, tools, &nearest2);
                    add_row(y, z, hi.x + r, hi.x + r, whole, tools, &nearest2);
                }
            }
        }
        seen = static_cast<float>(r) * block_mm_ * (1 - kRelative);
    }
    const std::span<NearCube> cubes(tools->cubes_.data(), tools->count_);
    float least2 = kInfinity;
    const auto note_last = [&](const NearCube& cube) {
        if (!cube.certain || !(cube.low2 < least2)) return;
        least2 = cube.low2;
        tools->last_ = cube;
        tools->of_ = this;
    };
    // Beyond what was looked at there may be more.
    const float seen2 = seen * seen;
    const auto range = [&](float low2, float high2) -> NearRange {
        const float low = std::sqrt(low2), high = std::sqrt(high2);
        const float slack = low * kRelative + largest_ * kOfCoordinates;
        return {std::max(low - slack, 0.0f),
                high + (high < kInfinity ? high * kRelative + largest_ * kOfCoordinates : 0.0f)};
    };
    if (boxes.size() == 1 && boxes[0].lo == whole.lo && boxes[0].hi == whole.hi) {
        // What was found on the way is about this box.
        float low2 = seen2;
        for (const NearCube& cube : cubes) {
            low2 = std::min(low2, cube.low2);
            note_last(cube);
        }
        out[0] = range(low2, nearest2);
        return;
    }
    // What is close bounds the boxes; most of the rest is then farther than they need.
    constexpr float kClose2 = 0.25f;
    size_t close = 0;
    for (NearCube& cube : cubes) {
        if (!(cube.low2 < kClose2 * nearest2)) continue;
        note_last(cube);
        std::swap(cube, cubes[close++]);
    }
    bound_boxes(boxes, seen2, close, tools);
    for (size_t b = 0; b < boxes.size(); ++b)
        out[b] = range(tools->boxes_.low2[b], tools->boxes_.high2[b]);
}

/// Sets the squares of the boxes' bounds by the cubes that were found, of which the first are close.
void ShapeNear::bound_boxes(std::span<const Box3f> boxes, float seen2, size_t close,
                            Tools* tools) const {
    OPENFAB_DCHECK(boxes.size() <= kMostNearBoxes);
    const std::span<const NearCube> cubes(tools->cubes_.data(), tools->count_);
    NearLattice lattice{};
    lattice.first = {std::numeric_limits<int32_t>::max(), std::numeric_limits<int32_t>::max(),
                     std::numeric_limits<int32_t>::max()};
    for (const NearCube& cube : cubes) {
        for (size_t a = 0; a < 3; ++a) {
            lattice.first[a] = std::min(lattice.first[a], cube.at[a]);
            lattice.end[a] = std::max(lattice.end[a], cube.at[a] + 1);
        }
    }
    size_t places = 0;
    for (size_t a = 0; a < 3; ++a) {
        lattice.sides[a] = edges_[a].data();
        if (cubes.empty()) lattice.first[a] = lattice.end[a];
        places += static_cast<size_t>(lattice.end[a] - lattice.first[a]);
    }
    if (tools->table_.size() < 2 * places) tools->table_.resize(2 * places);
    lattice.table = tools->table_.data();
    NearBoxes& to = tools->boxes_;
    const size_t end = (boxes.size() + kNearLanes - 1) / kNearLanes * kNearLanes;
    for (size_t b = 0; b < end; ++b) {
        const Box3f& box = boxes[std::min(b, boxes.size() - 1)];
        for (int a = 0; a < 3; ++a) {
            to.lo[static_cast<size_t>(a)][b] = box.lo[a];
            to.hi[static_cast<size_t>(a)][b] = box.hi[a];
        }
        to.low2[b] = seen2;
        to.high2[b] = kInfinity;
    }
    for (size_t b = 0; b < end; b += kNearLanes)
        kernels_.take(lattice, cubes, close, b, &to);
}

}  // namespace openfab::solid
