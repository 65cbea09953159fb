// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/slab/cull.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "runtime/slab/clock.h"

namespace openfab::slab {

namespace {

// More different compositions than this and the rest is evaluated: finding one among them would
// cost more than it saves.
constexpr size_t kMostConstants = 256;

constexpr int32_t kSides[] = {8, 4, 2, 1};  // of cubes, in blocks

// Largest multiple of `side` that is not above `value`.
int32_t align_down(int32_t value, int32_t side) {
    return value >= 0 ? value / side * side : -((-value + side - 1) / side * side);
}

}  // namespace

void PartCull::mark_covered(const voxel::GroupMask& mask) {
    first_x_ = mask.x0 / 8;
    first_y_ = mask.y0 / 8;
    blocks_x_ = mask.width / 8;
    blocks_y_ = mask.height / 8;
    blocks_.assign(static_cast<size_t>(blocks_x_) * blocks_y_, kNotCovered);
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

int PartCull::run(const PrintPart& part, int32_t group, const voxel::GroupMask& mask, bool cull,
                  BlockEvaluator* evaluator, CubeBounds* bounds, int64_t* room) {
    mark_covered(mask);
    constants_.clear();
    evaluator->counts.total += std::count(blocks_.begin(), blocks_.end(), kEvaluate);
    if (!cull || part.part->fablet->volume_bounds.arg_count == 0 || blocks_.empty()) return 0;
    const double start = seconds_now();
    std::vector<CullCube> open, cubes;
    for (int32_t y = align_down(first_y_, kSides[0]); y < end_y(); y += kSides[0]) {
        for (int32_t x = align_down(first_x_, kSides[0]); x < end_x(); x += kSides[0])
            open.push_back({x, y});
    }
    int status = 0;
    for (int32_t side : kSides) {
        cubes.clear();
        for (const CullCube& c : open) {
            if (any_covered(c, side)) cubes.push_back(c);
        }
        open.clear();
        if (cubes.empty()) break;
        for (size_t first = 0; first < cubes.size() && status == 0;
             first += CubeBounds::kMostCubes) {
            const std::span<const CullCube> some(
                &cubes[first], std::min(CubeBounds::kMostCubes, cubes.size() - first));
            status = bounds->bound(part, group, side, some, evaluator);
            if (status == 0) status = settle(part, side, some, *bounds, evaluator, room, &open);
        }
        if (status != 0) break;
    }
    evaluator->counts.filled +=
        std::count_if(blocks_.begin(), blocks_.end(), [](int32_t b) { return b >= 0; });
    evaluator->counts.seconds_bounds += seconds_now() - start;
    return status;
}

int64_t CubeBounds::most_bytes(const PrintPart& part) {
    // Numbers of an entry: its corner and distances; every component low and high, as it comes and
    // as the kernel reads it; every weight low and high. Lists that grow by doubling hold twice.
    const int64_t components = part.nearest.floats() + part.nearest.ints();
    const int64_t numbers = 2 * 5 + components * (2 * 2 + 2) + 2 * int64_t{part.slots()};
    return static_cast<int64_t>(kMostCubes) *
           (nearest::BoxBounds::kMostCases * 4 * numbers + int64_t{2 * sizeof(size_t)});
}

void CubeBounds::add_entry(const PrintPart& part, const Vec3i& corner,
                           const nearest::NearestCase& of) {
    for (int a = 0; a < 3; ++a)
        corners_.push_back(corner[a]);
    // Only voxels inside the part count, where the distance is negative.
    distance_lo_.push_back(0.0f - box_.distance_hi);
    distance_hi_.push_back(0.0f - of.distance_lo);
    if (!part.bounds.any()) return;
    for (const std::vector<float>* v : {&of.float_lo, &of.float_hi})
        case_floats_.insert(case_floats_.end(), v->begin(), v->end());
    for (const std::vector<int32_t>* v : {&of.int_lo, &of.int_hi})
        case_ints_.insert(case_ints_.end(), v->begin(), v->end());
}

// From entry after entry to component after component.
void CubeBounds::lay_out(const PrintPart& part) {
    const size_t n = distance_lo_.size();
    const auto transpose = [n](size_t components, const auto& from, auto* lo, auto* hi) {
        lo->resize(components * n);
        hi->resize(components * n);
        for (size_t i = 0; i < n && !from.empty(); ++i) {
            for (size_t c = 0; c < components; ++c) {
                (*lo)[c * n + i] = from[2 * components * i + c];
                (*hi)[c * n + i] = from[2 * components * i + components + c];
            }
        }
    };
    transpose(static_cast<size_t>(part.nearest.floats()), case_floats_, &float_lo_, &float_hi_);
    transpose(static_cast<size_t>(part.nearest.ints()), case_ints_, &int_lo_, &int_hi_);
}

// Intervals of what the queries can give in each cube, then of the weights.
int CubeBounds::bound(const PrintPart& part, int32_t group, int32_t side,
                      std::span<const CullCube> cubes, BlockEvaluator* evaluator) {
    first_entry_.assign(1, 0);
    corners_.clear();
    distance_lo_.clear();
    distance_hi_.clear();
    case_floats_.clear();
    case_ints_.clear();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (std::vector<float>* v : {&unknown_.float_lo, &unknown_.float_hi})
        v->assign(static_cast<size_t>(part.nearest.floats()), nan);
    unknown_.int_lo.assign(static_cast<size_t>(part.nearest.ints()),
                           std::numeric_limits<int32_t>::min());
    unknown_.int_hi.assign(static_cast<size_t>(part.nearest.ints()),
                           std::numeric_limits<int32_t>::max());
    // Groups are in grid voxels, so a cube holds the whole group whatever its side.
    const int32_t z = align_down(group, side) * 8 - part.base.z;
    for (const CullCube& cube : cubes) {
        const Vec3i corner{8 * cube.x - part.base.x, 8 * cube.y - part.base.y, z};
        box_.clear();
        box_.distance_hi = std::numeric_limits<float>::infinity();
        if (part.bounds.any())
            part.engine->bounds(corner, 8 * side, evaluator->scratch(part), &box_);
        for (int32_t k = 0; k < box_.count; ++k)
            add_entry(part, corner, box_.cases[static_cast<size_t>(k)]);
        if (box_.count == 0) add_entry(part, corner, unknown_);
        first_entry_.push_back(distance_lo_.size());
    }
    lay_out(part);
    const size_t n = distance_lo_.size();
    // A slot that the fablet never sets may have no output; then it is 0.
    for (std::vector<float>* v : {&weight_lo_, &weight_hi_})
        v->assign(static_cast<size_t>(part.slots()) * n, 0.0f);

    const openfab_kernel& kernel = part.part->fablet->volume_bounds;
    KernelArguments& arguments = evaluator->arguments();
    arguments.begin(kernel, part, corners_.data(), static_cast<int32_t>(n), 8 * side);
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        const openfab_arg& arg = kernel.args[i];
        const auto slot = static_cast<size_t>(arg.a) * n;
        const bool lo = arg.kind == OPENFAB_ARG_NEAREST_LO;
        switch (arg.kind) {
            case OPENFAB_ARG_DISTANCE_LO:
                arguments.set_list(i, distance_lo_.data());
                break;
            case OPENFAB_ARG_DISTANCE_HI:
                arguments.set_list(i, distance_hi_.data());
                break;
            case OPENFAB_ARG_WEIGHT_LO:
                arguments.set_list(i, &weight_lo_[slot]);
                break;
            case OPENFAB_ARG_WEIGHT_HI:
                arguments.set_list(i, &weight_hi_[slot]);
                break;
            case OPENFAB_ARG_NEAREST_LO:
            case OPENFAB_ARG_NEAREST_HI: {
                const size_t first = part.nearest.place(arg.a, arg.b) * n;
                if (part.nearest.is_float(arg.a)) {
                    arguments.set_list(i, lo ? &float_lo_[first] : &float_hi_[first]);
                } else {
                    arguments.set_list(i, lo ? &int_lo_[first] : &int_hi_[first]);
                }
                break;
            }
            default:
                break;
        }
    }
    return arguments.run(evaluator->isa());
}

bool CubeBounds::one_composition(size_t cube, std::vector<float>* weights) const {
    const size_t n = distance_lo_.size();
    const size_t first = first_entry_[cube];
    for (size_t s = 0; s < weights->size(); ++s) {
        (*weights)[s] = weight_lo_[s * n + first];
        for (size_t e = first; e < first_entry_[cube + 1]; ++e) {
            // False for NaN, too.
            if (!(weight_lo_[s * n + e] == (*weights)[s] && weight_hi_[s * n + e] == (*weights)[s]))
                return false;
        }
    }
    return true;
}

// Fills the cubes that can hold one composition only; the others, in quarters, go to `open`.
int PartCull::settle(const PrintPart& part, int32_t side, std::span<const CullCube> cubes,
                     const CubeBounds& bounds, BlockEvaluator* evaluator, int64_t* room,
                     std::vector<CullCube>* open) {
    std::vector<float> weights(static_cast<size_t>(part.slots()));
    for (size_t i = 0; i < cubes.size(); ++i) {
        int32_t index = kEvaluate;
        if (bounds.one_composition(i, &weights)) {
            const int status = add_constant(part, weights.data(), evaluator, room, &index);
            if (status != 0) return status;
        }
        const CullCube& c = cubes[i];
        if (index == kEvaluate) {
            const int32_t half = side / 2;
            if (half == 0) continue;
            for (const CullCube& quarter : {c, CullCube{c.x + half, c.y}, CullCube{c.x, c.y + half},
                                            CullCube{c.x + half, c.y + half}}) {
                open->push_back(quarter);
            }
            continue;
        }
        for (int32_t y = std::max(c.y, first_y_); y < std::min(c.y + side, end_y()); ++y) {
            for (int32_t x = std::max(c.x, first_x_); x < std::min(c.x + side, end_x()); ++x) {
                int32_t& block =
                    blocks_[static_cast<size_t>((y - first_y_) * blocks_x_ + (x - first_x_))];
                if (block == kEvaluate) block = index;
            }
        }
    }
    return 0;
}

int PartCull::add_constant(const PrintPart& part, const float* weights, BlockEvaluator* evaluator,
                           int64_t* room, int32_t* index) {
    const auto slots = static_cast<size_t>(part.slots());
    for (size_t i = constants_.size(); i-- > 0;) {
        if (std::equal(weights, weights + slots, constants_[i].weights.begin())) {
            *index = static_cast<int32_t>(i);
            return 0;
        }
    }
    const auto codes = static_cast<int64_t>(sizeof(Constant) + 512 + slots * sizeof(float));
    const int64_t bytes = codes + evaluator->tile_values() * int64_t{sizeof(uint16_t)};
    if (constants_.size() == kMostConstants || bytes > *room) return 0;
    Constant added;
    added.weights.assign(weights, weights + slots);
    added.codes.resize(512);
    added.tile.resize(static_cast<size_t>(evaluator->tile_values()));
    const int status =
        evaluator->constant_block(part, weights, added.codes.data(), added.tile.data());
    added.code = added.codes[0];
    added.mixed = added.code == OPENFAB_CODE_MIXED;
    if (!added.mixed) {
        added.codes = {};
        added.tile = {};
    }
    *room -= added.mixed ? bytes : codes;
    *index = static_cast<int32_t>(constants_.size());
    constants_.push_back(std::move(added));
    return status;
}

int64_t PartCull::blocks_to_evaluate() const {
    return std::count(blocks_.begin(), blocks_.end(), kEvaluate);
}

}  // namespace openfab::slab
