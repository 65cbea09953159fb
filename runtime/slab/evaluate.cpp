// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/slab/evaluate.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "runtime/slab/clock.h"

namespace openfab::slab {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr size_t kBlockValues = nearest::kBlockVoxels;
constexpr size_t kBatchValues = kBlockValues * BlockEvaluator::kBatch;

/// Octant o of a block has the upper half along x where bit 0 is set, y bit 1, z bit 2. Its first
/// column of row y < 4, and its bits in the four bytes of that row.
constexpr size_t octant_row(int32_t o, int32_t y) {
    return static_cast<size_t>((4 * (o >> 1 & 1) + y) * 8 + 4 * (o & 1));
}
constexpr uint32_t octant_bits(int32_t o) {
    return (o >> 2) != 0 ? 0xf0f0f0f0u : 0x0f0f0f0fu;
}

void grow(auto* values, size_t count) {
    if (values->size() < count) values->resize(count);
}

}  // namespace

BlockEvaluator::BlockEvaluator(const openfab_stage_set& set, openfab_isa isa, size_t parts)
    : calls_(set, isa), isa_(isa), scratch_(parts), attribute_scratch_(parts), phases_(parts) {
    owned_.resize(64 * kBatch);
    demand_.resize(64 * kBatch);
    demanded_.resize(kBatchValues);
    tiles_.resize(static_cast<size_t>(calls_.tile_values()) * kBatch);
    codes_.resize(kBatchValues);
    distance_.resize(kBatchValues);
}

nearest::Engine::Scratch* BlockEvaluator::scratch(const PrintPart& part) {
    std::unique_ptr<nearest::Engine::Scratch>& mine = scratch_[static_cast<size_t>(part.owner)];
    if (mine == nullptr) mine = part.engine->make_scratch();
    return mine.get();
}

nearest::QueryCounts BlockEvaluator::query_counts() const {
    nearest::QueryCounts sum;
    for (const auto& s : scratch_) {
        if (s != nullptr) sum.add(s->counts);
    }
    sum.add(phases_.query_counts());
    return sum;
}

// Makes room for the part's inputs, and notes which of them its volume kernel reads.
void BlockEvaluator::prepare(const PrintPart& part) {
    const auto floats = static_cast<size_t>(part.nearest.floats());
    const auto ints = static_cast<size_t>(part.nearest.ints());
    grow(&values_, floats * kBatchValues);
    grow(&gradients_, part.volume.gradients ? floats * 3 * kBatchValues : 0);
    grow(&flat_, ints * kBatchValues);
    grow(&weights_, static_cast<size_t>(part.slots()) * kBatchValues);
    value_targets_.assign(floats, nullptr);
    gradient_targets_.assign(floats * 3, nullptr);
    flat_targets_.assign(ints, nullptr);
    const openfab_kernel& kernel = part.part->fablet->volume;
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        const openfab_arg& arg = kernel.args[i];
        if (arg.kind == OPENFAB_ARG_NEAREST) {
            const size_t c = part.nearest.place(arg.a, arg.b);
            if (part.nearest.is_float(arg.a)) {
                value_targets_[c] = &values_[c * kBatchValues];
            } else {
                flat_targets_[c] = &flat_[c * kBatchValues];
            }
        } else if (arg.kind == OPENFAB_ARG_NEAREST_GRAD) {
            const size_t c = part.nearest.place(arg.a, 0) * 3 + static_cast<size_t>(arg.b);
            gradient_targets_[c] = &gradients_[c * kBatchValues];
        }
    }
}

// Finds which of the owned voxels look at their nearest surface point: all, where the fablet has no
// kernel that tells. 0 or a Halide error code.
int BlockEvaluator::find_demand(const PrintPart& part, int32_t n) {
    const auto bytes = static_cast<size_t>(64 * n);
    std::copy_n(owned_.begin(), bytes, demand_.begin());
    const openfab_kernel& kernel = part.part->fablet->volume_demand;
    if (kernel.arg_count == 0) return 0;
    arguments_.begin(kernel, part, corners_.data(), n, 8);
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        if (kernel.args[i].kind == OPENFAB_ARG_DEMAND) arguments_.set_blocks(i, demanded_.data());
    }
    if (const int status = arguments_.run(isa_); status != 0) return status;
    for (size_t byte = 0; byte < bytes; ++byte) {
        uint32_t bits = 0;
        for (size_t z = 0; z < 8; ++z)
            bits |= static_cast<uint32_t>(demanded_[8 * byte + z] & 1) << z;
        demand_[byte] &= static_cast<uint8_t>(bits);
    }
    return 0;
}

// Octants that hold one composition whatever a query would say need none: for any distance in the
// interval the volume kernel gives that composition, and the middle's is one. 0 or a Halide error
// code.
int BlockEvaluator::settle_octants(const PrintPart& part, int32_t n) {
    octants_.clear();
    octant_places_.clear();
    for (int32_t i = 0; i < n; ++i) {
        const int32_t* corner = &corners_[static_cast<size_t>(3 * i)];
        for (int32_t o = 0; o < 8; ++o) {
            uint32_t asked = 0;
            for (int32_t y = 0; y < 4; ++y) {
                uint32_t row;
                std::memcpy(&row, &demand_[static_cast<size_t>(64 * i) + octant_row(o, y)], 4);
                asked |= row & octant_bits(o);
            }
            if (asked == 0) continue;
            octants_.push_back(
                {corner[0] + 4 * (o & 1), corner[1] + 4 * (o >> 1 & 1), corner[2] + 4 * (o >> 2)});
            octant_places_.push_back(8 * i + o);
        }
    }
    if (octants_.empty()) return 0;
    if (const int status =
            cube_bounds_.bound(part, 4, octants_, QueryBounds::kMiddle, bound_tools(part));
        status != 0)
        return status;
    octant_weights_.resize(static_cast<size_t>(part.slots()));
    for (size_t k = 0; k < octants_.size(); ++k) {
        const auto block = static_cast<size_t>(octant_places_[k] >> 3);
        near_points_[block][near_count_[block]++] = cube_bounds_.point_near_middle(k);
        if (!cube_bounds_.one_composition(k, &octant_weights_)) continue;
        const int32_t place = octant_places_[k], o = place & 7;
        settled_[static_cast<size_t>(place >> 3)] |= static_cast<uint8_t>(1 << o);
        settled_distance_[static_cast<size_t>(place)] = cube_bounds_.middle_distance(k);
        for (int32_t y = 0; y < 4; ++y) {
            uint8_t* at = &demand_[static_cast<size_t>(64 * (place >> 3)) + octant_row(o, y)];
            uint32_t row;
            std::memcpy(&row, at, 4);
            row &= ~octant_bits(o);
            std::memcpy(at, &row, 4);
        }
    }
    return 0;
}

// Gives the settled octants of a block a distance of their intervals.
void BlockEvaluator::fill_settled(int32_t place) {
    float* out = &distance_[static_cast<size_t>(place) * kBlockValues];
    for (int32_t o = 0; o < 8; ++o) {
        if ((settled_[static_cast<size_t>(place)] >> o & 1) == 0) continue;
        const float distance = settled_distance_[static_cast<size_t>(8 * place + o)];
        for (int32_t y = 0; y < 4; ++y) {
            for (size_t x = 0; x < 4; ++x)
                std::fill_n(out + 8 * (octant_row(o, y) + x) + 4 * (o >> 2), 4, distance);
        }
    }
}

// Zeros the inputs of one block of the batch; the targets stand at its place.
void BlockEvaluator::clear_inputs(const PrintPart& part, int32_t place) {
    const auto clear = [](const auto& targets) {
        for (auto* target : targets) {
            if (target != nullptr) std::fill_n(target, kBlockValues, 0);
        }
    };
    clear(value_targets_);
    clear(gradient_targets_);
    clear(flat_targets_);
    if (part.volume.distance)
        std::fill_n(&distance_[static_cast<size_t>(place) * kBlockValues], kBlockValues, 0.0f);
}

// Fills the inputs of one block of the batch, 0 where a voxel does not ask; the targets stand at
// its place.
void BlockEvaluator::query(const PrintPart& part, int32_t place) {
    const uint8_t* demand = &demand_[static_cast<size_t>(64 * place)];
    if (std::all_of(demand, demand + 64, [](uint8_t bits) { return bits == 0; })) {
        scratch(part)->counts.skipped += nearest::kBlockVoxels;
        clear_inputs(part, place);
        if (part.volume.distance) fill_settled(place);
        return;
    }
    nearest::BlockQuery query;
    const int32_t* corner = &corners_[static_cast<size_t>(3 * place)];
    query.block = {corner[0], corner[1], corner[2]};
    query.demand = demand;
    query.near = {near_points_[static_cast<size_t>(place)].data(),
                  near_count_[static_cast<size_t>(place)]};
    part.engine->query(query, scratch(part), &answer_);
    if (part.volume.attributes || part.volume.gradients) {
        const nearest::AttributeTargets targets{
            value_targets_.data(), part.volume.gradients ? gradient_targets_.data() : nullptr,
            flat_targets_.data()};
        part.attributes->read(answer_, demand, targets,
                              &attribute_scratch_[static_cast<size_t>(part.owner)]);
    }
    if (part.volume.distance) {
        // Owned voxels are inside, so the distance is negative; taken from 0 so that none gives +0.
        // What does not ask is infinitely far in the answer.
        float* out = &distance_[static_cast<size_t>(place) * kBlockValues];
        for (size_t v = 0; v < kBlockValues; ++v) {
            const float d2 = answer_.distance2[v];
            out[v] = 0.0f - std::sqrt(d2 < kInfinity ? d2 : 0.0f);
        }
        fill_settled(place);
    }
}

const void* BlockEvaluator::input(const PrintPart& part, const openfab_arg& arg) const {
    switch (arg.kind) {
        case OPENFAB_ARG_DISTANCE:
            return distance_.data();
        case OPENFAB_ARG_NEAREST: {
            const size_t first = part.nearest.place(arg.a, arg.b) * kBatchValues;
            if (part.nearest.is_float(arg.a)) return &values_[first];
            return &flat_[first];
        }
        case OPENFAB_ARG_NEAREST_GRAD:
            return &gradients_[(part.nearest.place(arg.a, 0) * 3 + static_cast<size_t>(arg.b)) *
                               kBatchValues];
        default:
            return nullptr;
    }
}

int BlockEvaluator::run_volume(const PrintPart& part, int32_t n, PointPrints* prints) {
    const openfab_kernel& kernel = part.part->fablet->volume;
    const int32_t slots = part.slots();
    const auto written = static_cast<int32_t>(
        std::count_if(kernel.args, kernel.args + kernel.arg_count,
                      [](const openfab_arg& arg) { return arg.kind == OPENFAB_ARG_WEIGHT; }));
    // A slot that the fablet never sets may have no output.
    if (written < slots)
        std::fill_n(weights_.begin(), static_cast<size_t>(n * slots) * kBlockValues, 0.0f);
    if (part.part->fablet->volume_phases.step_count > 0) {
        return phases_.run(
            part, isa_, corners_.data(), owned_.data(), n,
            [&](const openfab_arg& arg) { return input(part, arg); }, weights_.data(), prints);
    }
    arguments_.begin(kernel, part, corners_.data(), n, 8);
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        if (kernel.args[i].kind == OPENFAB_ARG_WEIGHT) {
            arguments_.set_blocks(
                i, &weights_[static_cast<size_t>(kernel.args[i].a) * kBlockValues], slots * 512);
        } else if (!arguments_.is_set(i)) {
            arguments_.set_blocks(i, input(part, kernel.args[i]));
        }
    }
    return arguments_.run(isa_);
}

int BlockEvaluator::normalise(const PrintPart& part, int32_t n) {
    uint8_t slices = 0;
    for (size_t i = 0; i < static_cast<size_t>(64 * n); ++i)
        slices |= owned_[i];
    if (std::has_single_bit(slices) && n > 1)
        return normalise_slice(part, n, std::countr_zero(slices));
    const int status =
        calls_.normalise(weights_.data(), part.slots(), part.slot_material.data(), owned_.data(), n,
                         tiles_.data(), codes_.data(), unusable_.data());
    for (int32_t i = 0; i < 8 * n; ++i)
        counts.unusable += unusable_[static_cast<size_t>(i)];
    return status;
}

// Where one slice of the blocks is all that is asked for (the first of a large print), it goes
// through the kernel as a slice of a block that is made up of eight of them. What it writes for
// other slices of a tile is what was there before: nobody looks at it.
int BlockEvaluator::normalise_slice(const PrintPart& part, int32_t n, int32_t z) {
    const auto slots = static_cast<size_t>(part.slots()),
               channels = static_cast<size_t>(calls_.channels());
    const int32_t packed = (n + 7) / 8;
    grow(&slice_weights_, kBatchValues / 8 * slots);
    if (n % 8 != 0) std::fill(slice_weights_.begin(), slice_weights_.end(), 0.0f);
    slice_owned_.assign(64 * static_cast<size_t>(packed), 0);
    slice_codes_.resize(kBatchValues / 8);
    slice_tiles_.resize(tiles_.size() / 8);
    const auto at = [](size_t block) { return block / 8; };
    for (size_t i = 0; i < static_cast<size_t>(n); ++i) {
        for (size_t v = 0; v < 64; ++v) {
            const auto bit = static_cast<uint8_t>(owned_[64 * i + v] >> z & 1);
            slice_owned_[64 * at(i) + v] |= static_cast<uint8_t>(bit << i % 8);
        }
        for (size_t s = 0; s < slots; ++s) {
            const float* from = &weights_[(i * slots + s) * kBlockValues] + z;
            float* to = &slice_weights_[(at(i) * slots + s) * kBlockValues] + i % 8;
            for (size_t v = 0; v < 64; ++v)
                to[8 * v] = from[8 * v];
        }
    }
    const int status = calls_.normalise(slice_weights_.data(), part.slots(),
                                        part.slot_material.data(), slice_owned_.data(), packed,
                                        slice_tiles_.data(), slice_codes_.data(), unusable_.data());
    for (int32_t i = 0; i < 8 * packed; ++i)
        counts.unusable += unusable_[static_cast<size_t>(i)];
    for (size_t i = 0; i < static_cast<size_t>(n); ++i) {
        const uint8_t* codes = &slice_codes_[at(i) * kBlockValues] + i % 8;
        for (size_t v = 0; v < 64; ++v)
            codes_[i * kBlockValues + 8 * v + static_cast<size_t>(z)] = codes[8 * v];
        const uint16_t* from = &slice_tiles_[at(i) * kBlockValues * channels] + i % 8;
        uint16_t* to = &tiles_[i * kBlockValues * channels] + z;
        for (size_t v = 0; v < 64 * channels; ++v)
            to[8 * v] = from[8 * v];
    }
    return status;
}

int BlockEvaluator::evaluate(const PrintPart& part, int32_t group, const OwnedBlock* blocks,
                             int32_t n, bool finer, RowBand* band, PointPrints* prints) {
    const double start = seconds_now();
    prepare(part);
    for (int32_t i = 0; i < n; ++i) {
        int32_t* corner = &corners_[static_cast<size_t>(3 * i)];
        corner[0] = 8 * blocks[i].block - part.base.x;
        corner[1] = 8 * band->row - part.base.y;
        corner[2] = 8 * group - part.base.z;
        std::copy(blocks[i].owned.begin(), blocks[i].owned.end(),
                  &owned_[static_cast<size_t>(64 * i)]);
    }
    if (part.volume.any()) {
        if (const int status = find_demand(part, n); status != 0) return status;
        settled_.fill(0);
        near_count_.fill(0);
        if (finer && part.bounds.distance) {
            if (const int status = settle_octants(part, n); status != 0) return status;
        }
    }
    for (int32_t i = 0; i < n && part.volume.any(); ++i) {
        query(part, i);
        const auto advance = [](auto& targets) {
            for (auto*& t : targets) {
                if (t != nullptr) t += kBlockValues;
            }
        };
        advance(value_targets_);
        advance(gradient_targets_);
        advance(flat_targets_);
    }
    const double queried = seconds_now();
    int status = run_volume(part, n, prints);
    const double evaluated = seconds_now();
    if (status != 0) return status;
    status = normalise(part, n);
    if (status != 0) return status;
    for (int32_t i = 0; i < n; ++i) {
        const auto place = static_cast<size_t>(i);
        band->merge(blocks[i].block, blocks[i].owned.data(), &codes_[place * kBlockValues],
                    &tiles_[place * static_cast<size_t>(calls_.tile_values())], calls_.channels());
    }
    counts.evaluated += n;
    counts.seconds_nearest += queried - start;
    counts.seconds_volume += evaluated - queried;
    counts.seconds_normalise += seconds_now() - evaluated;
    return 0;
}

int BlockEvaluator::constant_block(const PrintPart& part, const float* weights, uint8_t* codes,
                                   uint16_t* tile) {
    grow(&weights_, static_cast<size_t>(part.slots()) * kBatchValues);
    for (int32_t s = 0; s < part.slots(); ++s) {
        std::fill_n(weights_.begin() + static_cast<std::ptrdiff_t>(s * 512), kBlockValues,
                    weights[s]);
    }
    std::fill_n(owned_.begin(), 64, uint8_t{255});
    return calls_.normalise(weights_.data(), part.slots(), part.slot_material.data(), owned_.data(),
                            1, tile, codes, unusable_.data());
}

}  // namespace openfab::slab
