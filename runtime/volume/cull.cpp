// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/cull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>

#include "base/stage_timer.h"

namespace openfab::volume {

namespace {

// Beyond this many different mixtures the rest is evaluated: finding one would cost more than it
// saves.
constexpr size_t kMostConstants = 256;

constexpr int32_t kSides[] = {8, 4, 2, 1};  // of cubes, in blocks

// Largest multiple of `side` that is not above `value`.
int32_t align_down(int32_t value, int32_t side) {
    return value >= 0 ? value / side * side : -((-value + side - 1) / side * side);
}

/// Returns whether cubes are bounded by approximate distances of some of their points. These are
/// queries; on a displaced surface they would dice patches that no voxel needs, which costs more
/// than they cull beyond the cases of undiced patches.
bool points_tell(const PlacedPart& part) {
    return part.bounds.distance && !part.solid->bounds_dice();
}

}  // namespace

void PartCull::mark_covered(const voxel::SlabMask& mask) {
    first_x_ = mask.x0 / 8;
    first_y_ = mask.y0 / 8;
    blocks_x_ = mask.width / 8;
    blocks_y_ = mask.height / 8;
    blocks_.assign(static_cast<size_t>(blocks_x_) * blocks_y_, kNotCovered);
    blind_.assign(blocks_.size(), std::numeric_limits<float>::quiet_NaN());
    attributes_.assign(blocks_.size(), nullptr);
    kept_attributes_.clear();
    for (int32_t y = 0; y < mask.height; ++y) {
        const uint8_t* row = &mask.mask[static_cast<size_t>(y) * mask.width];
        int32_t* out = &blocks_[static_cast<size_t>(y / 8) * blocks_x_];
        for (int32_t b = 0; b < blocks_x_; ++b) {
            uint64_t columns;
            std::memcpy(&columns, row + 8 * b, 8);
            if (columns != 0) out[b] = kEvaluate;
        }
    }
}

bool PartCull::any_covered(const CullCube& cube, int32_t side) const {
    for (int32_t y = std::max(cube.y, first_y_); y < std::min(cube.y + side, end_y()); ++y) {
        for (int32_t x = std::max(cube.x, first_x_); x < std::min(cube.x + side, end_x()); ++x) {
            if (at(x, y) == kEvaluate) return true;
        }
    }
    return false;
}

abi::KernelStatus PartCull::run(const PlacedPart& part, int32_t slab, const voxel::SlabMask& mask,
                                bool cull, BlockEvaluator* evaluator, std::atomic<int64_t>* room) {
    const StageTimer timer(Stage::kCulling, &evaluator->counts.seconds_bounds);
    mark_covered(mask);
    constants_.clear();
    tries_ = {};
    evaluator->counts.total += std::count(blocks_.begin(), blocks_.end(), kEvaluate);
    if (!cull || part.part->fablet->volume_bounds.arg_count == 0 || blocks_.empty()) return {};
    tries_.reach = part.solid->bounds_dice() && part.bounds.distance && part.bounds_say_looks &&
                   part.part->fablet->volume_segments.step_count == 0;
    std::vector<CullCube> open, cubes;
    for (int32_t y = align_down(first_y_, kSides[0]); y < end_y(); y += kSides[0]) {
        for (int32_t x = align_down(first_x_, kSides[0]); x < end_x(); x += kSides[0])
            open.push_back({x, y});
    }
    const bool points = points_tell(part);
    const bool cases = !points || part.bounds.attributes;
    // Distances of points dice patches and make their trees; cases need their boxes alone.
    const bool cases_first = part.solid->bounds_dice();
    abi::KernelStatus status;
    for (int32_t side : kSides) {
        cubes.clear();
        for (const CullCube& c : open) {
            if (any_covered(c, side)) cubes.push_back(c);
        }
        open.clear();
        if (cubes.empty()) break;
        const auto fill_by = [&](BoundSource source) {
            if (!status.ok()) return;
            status = fill_uniform_cubes(part, slab, side, source, evaluator, room, &cubes);
        };
        if (cases && cases_first) fill_by(BoundSource::kPerCase);
        if (points) fill_by(BoundSource::kCenterDistance);
        if (cases && !cases_first) fill_by(BoundSource::kPerCase);
        if (!status.ok()) break;
        const int32_t half = side / 2;
        if (half == 0) break;
        for (const CullCube& c : cubes) {
            for (const auto& [x, y] : {std::pair(0, 0), {half, 0}, {0, half}, {half, half}})
                open.push_back({c.x + x, c.y + y, c.blind, c.attributes});
        }
    }
    if (status.ok()) status = probe_pieces(part, slab, evaluator);
    evaluator->counts.filled +=
        std::count_if(blocks_.begin(), blocks_.end(), [](int32_t b) { return b >= 0; });
    return status;
}

abi::KernelStatus PartCull::fill_uniform_cubes(const PlacedPart& part, int32_t slab, int32_t side,
                                               BoundSource from, BlockEvaluator* evaluator,
                                               std::atomic<int64_t>* room,
                                               std::vector<CullCube>* cubes) {
    CubeBounds& bounds = evaluator->cube_bounds();
    std::vector<float> weights(static_cast<size_t>(part.slots()));
    // Slabs are in grid voxels, so a cube holds the whole slab whatever its side.
    const int32_t z = align_down(slab, side) * 8 - part.base.z;
    size_t left = 0;
    for (size_t first = 0; first < cubes->size(); first += kMostCubes) {
        const size_t count = std::min(kMostCubes, cubes->size() - first);
        lowest_.clear();
        known_.clear();
        for (size_t i = first; i < first + count; ++i) {
            const CullCube& c = (*cubes)[i];
            lowest_.push_back({8 * c.x - part.base.x, 8 * c.y - part.base.y, z});
            known_.push_back({c.blind, c.attributes});
        }
        if (evaluator->stopped()) return abi::KernelStatus::stopped();
        if (const abi::KernelStatus status =
                bounds.bound(part, 8 * side, lowest_, known_, from, evaluator->bound_tools(part));
            !status.ok())
            return status;
        for (size_t i = 0; i < count; ++i) {
            CullCube cube = (*cubes)[first + i];
            int32_t index = kEvaluate;
            if (bounds.is_uniform(i, &weights)) {
                const abi::KernelStatus status =
                    add_constant(part, weights.data(), evaluator, room, &index);
                if (!status.ok()) return status;
            }
            if (index == kEvaluate) {
                note_blind(bounds, i, side, from, &cube);
                (*cubes)[left++] = cube;
            } else {
                fill(cube, side, index);
            }
        }
    }
    cubes->resize(left);
    return {};
}

// Notes what is known of a cube, where no voxel of it has to know its nearest surface point, and of
// attributes that all of its voxels have.
void PartCull::note_blind(const CubeBounds& bounds, size_t number, int32_t side, BoundSource from,
                          CullCube* cube) {
    if (from != BoundSource::kPerCase) return;
    const nearest::NearestCase* attributes = nullptr;
    const bool kept =
        !bounds.attributes_of(number, &found_) || keep_attributes(&(attributes = &found_));
    if (!kept) return;
    cube->attributes = attributes;
    const bool blind = !bounds.looks(number);
    if (blind) cube->blind = bounds.range_of(number);
    if (side != 1) return;
    const auto block = static_cast<size_t>((cube->y - first_y_) * blocks_x_ + (cube->x - first_x_));
    attributes_[block] = attributes;
    if (blind) blind_[block] = bounds.distance_of(number);
}

// Replaces the attributes by equal ones that are kept; returns false if there are too many.
bool PartCull::keep_attributes(const nearest::NearestCase** attributes) {
    constexpr size_t kMostKept = 64;
    // Compared as bits: what is not known is NaN.
    const auto same = [](const auto& a, const auto& b) {
        return a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
    };
    const nearest::NearestCase& found = **attributes;
    for (const auto& kept : kept_attributes_) {
        if (!same(kept->float_lo, found.float_lo) || !same(kept->int_lo, found.int_lo) ||
            !same(kept->int_hi, found.int_hi))
            continue;
        *attributes = kept.get();
        return true;
    }
    if (kept_attributes_.size() == kMostKept) return false;
    kept_attributes_.push_back(std::make_unique<const nearest::NearestCase>(found));
    *attributes = kept_attributes_.back().get();
    return true;
}

void PartCull::fill(const CullCube& cube, int32_t side, int32_t constant_index) {
    tries_.pieces = true;
    for (int32_t y = std::max(cube.y, first_y_); y < std::min(cube.y + side, end_y()); ++y) {
        for (int32_t x = std::max(cube.x, first_x_); x < std::min(cube.x + side, end_x()); ++x) {
            int32_t& block =
                blocks_[static_cast<size_t>((y - first_y_) * blocks_x_ + (x - first_x_))];
            if (block == kEvaluate) block = constant_index;
        }
    }
}

// Lists some of the blocks that may have to look at the surface.
void PartCull::list_some(const PlacedPart& part, int32_t slab) {
    constexpr size_t kTried = 8;
    const size_t step = std::max<size_t>(blocks_.size() / kTried, 1);
    lowest_.clear();
    known_.clear();
    for (size_t from = 0; from < blocks_.size(); from += step) {
        size_t i = from;
        while (i < std::min(from + step, blocks_.size()) &&
               (blocks_[i] != kEvaluate || !std::isnan(blind_[i])))
            ++i;
        if (i == std::min(from + step, blocks_.size())) continue;
        const auto at = static_cast<int32_t>(i);
        lowest_.push_back({8 * (first_x_ + at % blocks_x_) - part.base.x,
                           8 * (first_y_ + at / blocks_x_) - part.base.y, 8 * slab - part.base.z});
        known_.push_back({{}, attributes_[i], true});
    }
}

// Where no cube was filled, parts of some blocks are probed for whether culling them pays.
abi::KernelStatus PartCull::probe_pieces(const PlacedPart& part, int32_t slab,
                                         BlockEvaluator* evaluator) {
    // Of a displaced part the search of a block's corners, which its query needs as well, tells of
    // its pieces; but whether that tells enough is found out by trying.
    const bool dices = part.solid->bounds_dice();
    if (dices) tries_.pieces = false;
    if (tries_.pieces ||
        !(dices ? part.bounds.distance && part.bounds_say_looks : points_tell(part)))
        return {};
    list_some(part, slab);
    if (lowest_.empty()) return {};
    CubeBounds& bounds = evaluator->cube_bounds();
    const abi::KernelStatus status =
        bounds.bound_pieces(part, lowest_, known_, evaluator->bound_tools(part));
    std::vector<float> weights(static_cast<size_t>(part.slots()));
    const size_t pieces = CubeBounds::kPieces * lowest_.size(), enough = dices ? pieces / 8 : 1;
    size_t culled = 0;
    for (size_t i = 0; i < pieces && status.ok() && culled < enough; ++i)
        culled += bounds.is_uniform(i, &weights) || !bounds.looks(i) ? 1 : 0;
    tries_.pieces = culled >= std::max<size_t>(enough, 1);
    return status;
}

/// Returns whether what the voxels of a uniform block become depends on where they are.
bool PartCull::has_rule(const PlacedPart& part, const Constant& constant) {
    return part.own_dither && constant.code == OPENFAB_CODE_MIXED;
}

abi::KernelStatus PartCull::add_constant(const PlacedPart& part, const float* weights,
                                         BlockEvaluator* evaluator, std::atomic<int64_t>* room,
                                         int32_t* index) {
    const auto slots = static_cast<size_t>(part.slots());
    for (size_t i = constants_.size(); i-- > 0;) {
        if (std::equal(weights, weights + slots, constants_[i].weights.begin())) {
            if (!has_rule(part, constants_[i])) *index = static_cast<int32_t>(i);
            return {};
        }
    }
    const auto bytes =
        static_cast<int64_t>(sizeof(Constant) + slots * sizeof(float) +
                             static_cast<size_t>(part.channels.count()) * 8 * sizeof(uint16_t));
    if (constants_.size() == kMostConstants) return {};
    if (room->fetch_sub(bytes) < bytes) {
        room->fetch_add(bytes);
        return {};
    }
    Constant added;
    added.weights.assign(weights, weights + slots);
    const abi::KernelStatus status =
        constant_column(part, evaluator->isa(), weights, &added.column);
    added.code = added.column.codes[0];
    if (!has_rule(part, added)) *index = static_cast<int32_t>(constants_.size());
    constants_.push_back(std::move(added));
    return status;
}

void PartCull::Constant::merge(int32_t block, const uint8_t* owned, const abi::Channels& channels,
                               dither::RowBand* band) const {
    static constexpr std::array<int32_t, 64> kAll = [] {
        std::array<int32_t, 64> all{};
        std::iota(all.begin(), all.end(), 0);
        return all;
    }();
    const int32_t number = band->add_columns(1);
    place_fractions(channels, column.fractions.data(), band->fractions_at(number));
    band->merge(block, owned, {kAll, column.codes.data(), number, true});
}

int64_t PartCull::blocks_to_evaluate() const {
    return std::count(blocks_.begin(), blocks_.end(), kEvaluate);
}

}  // namespace openfab::volume
