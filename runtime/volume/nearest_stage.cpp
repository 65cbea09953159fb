// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/nearest_stage.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "base/infinity.h"
#include "base/stage_timer.h"

namespace openfab::volume {

namespace {

constexpr size_t kBlockValues = nearest::kBlockVoxels;

bool is_zero(const uint8_t* active) {
    return std::all_of(active, active + 64, [](uint8_t bits) { return bits == 0; });
}

/// Bit z of the result is byte z, which is 0 or 1.
uint8_t pack_bits(const uint8_t* bytes) {
    uint64_t all;
    std::memcpy(&all, bytes, 8);
    return static_cast<uint8_t>((all & 0x0101010101010101u) * 0x0102040810204080u >> 56);
}

}  // namespace

solid::Scratch* NearestStage::Tools::scratch_of(const PlacedPart& part) {
    std::unique_ptr<solid::Scratch>& mine = scratch[part.owner];
    if (mine == nullptr) mine = part.placed->make_scratch();
    return mine.get();
}

nearest::Engine::Scratch* NearestStage::scratch(const PlacedPart& part) {
    Tools* tools = tools_.take([&] { return std::make_unique<Tools>(parts_); });
    nearest::Engine::Scratch* out = tools->scratch_of(part)->engine.get();
    tools_.give(tools);
    return out;
}

nearest::QueryCounts NearestStage::query_counts() const {
    nearest::QueryCounts sum;
    for (const auto& tools : tools_.all()) {
        for (const auto& s : tools->scratch) {
            if (s != nullptr) sum.add(s->engine->counts);
        }
    }
    return sum;
}

double NearestStage::seconds() const {
    double sum = 0;
    for (const auto& tools : tools_.all())
        sum += tools->seconds;
    return sum;
}

int NearestStage::answer_request(openfab_nearest_source* source,
                                 const openfab_nearest_request* request) {
    auto* stage = static_cast<NearestStage*>(source);
    Tools* tools = stage->tools_.take([&] { return std::make_unique<Tools>(stage->parts_); });
    {
        const StageTimer timer(Stage::kNearest, &tools->seconds);
        stage->answer(*request, tools);
    }
    stage->tools_.give(tools);
    return 0;
}

// Allocates a block's results, and notes which of them are read.
void NearestStage::prepare(const PlacedPart& part, Tools* tools) {
    if (tools->prepared == &part) return;
    tools->prepared = &part;
    const auto floats = static_cast<size_t>(part.nearest.floats());
    const auto ints = static_cast<size_t>(part.nearest.ints());
    tools->values.resize(floats * kBlockValues);
    tools->gradients.resize(part.volume.gradients ? floats * 3 * kBlockValues : 0);
    tools->flat.resize(ints * kBlockValues);
    tools->value_targets.assign(floats, nullptr);
    tools->gradient_targets.assign(floats * 3, nullptr);
    tools->flat_targets.assign(ints, nullptr);
    tools->fields.clear();
    const openfab_fablet& fablet = *part.part->fablet;
    for (int32_t i = 0; i < fablet.field_count; ++i) {
        const openfab_arg& arg = fablet.fields[i];
        if (arg.kind == OPENFAB_ARG_DISTANCE) {
            tools->fields.push_back(tools->distance);
        } else if (arg.kind == OPENFAB_ARG_NEAREST_GRAD) {
            const size_t c = part.nearest.index(arg.a, 0) * 3 + static_cast<size_t>(arg.b);
            tools->gradient_targets[c] = &tools->gradients[c * kBlockValues];
            tools->fields.push_back(tools->gradient_targets[c]);
        } else if (part.nearest.is_float(arg.a)) {
            const size_t c = part.nearest.index(arg.a, arg.b);
            tools->value_targets[c] = &tools->values[c * kBlockValues];
            tools->fields.push_back(tools->value_targets[c]);
        } else {
            const size_t c = part.nearest.index(arg.a, arg.b);
            tools->flat_targets[c] = &tools->flat[c * kBlockValues];
            // Copied as bits, see openfab_nearest_request.
            tools->fields.push_back(reinterpret_cast<const float*>(tools->flat_targets[c]));
        }
    }
}

// Finds which voxels of the request's blocks query, and shares the search between the queries of
// all of them; not on a displaced surface, where it would hold the patches near all of them at once,
// nor where pieces were culled, whose bounds have searched.
void NearestStage::find_active(std::span<const int32_t> columns,
                               const openfab_nearest_request& request, Tools* tools) const {
    const int32_t first = columns.front() / 64, last = columns.back() / 64;
    tools->active.assign(64 * static_cast<size_t>(last - first + 1), 0);
    for (size_t i = 0; i < columns.size(); ++i) {
        uint8_t bits =
            pack_bits(request.demand + static_cast<ptrdiff_t>(i) * request.demand_stride);
        bits &= batch_.owned[static_cast<size_t>(columns[i])];
        const auto block = static_cast<size_t>(columns[i] / 64);
        const auto column = static_cast<size_t>(columns[i] % 64);
        if (!batch_.culled.empty())
            bits &= static_cast<uint8_t>(~batch_.culled[block].culled[column]);
        tools->active[static_cast<size_t>(columns[i] - 64 * first)] = bits;
    }
    if (!batch_.culled.empty() || batch_.part->solid->dicing() != nullptr) return;
    tools->asking.clear();
    for (int32_t block = first; block <= last; ++block) {
        if (!is_zero(&tools->active[static_cast<size_t>(64 * (block - first))]))
            tools->asking.push_back(batch_.blocks[block]);
    }
    batch_.part->engine().prepare(tools->asking, tools->scratch_of(*batch_.part)->engine.get());
}

void NearestStage::answer(const openfab_nearest_request& request, Tools* tools) const {
    // A tail of the loop over columns may ask beyond the list.
    const auto first = static_cast<size_t>(request.first);
    if (first >= batch_.columns.size()) return;
    const std::span<const int32_t> columns = batch_.columns.subspan(
        first, std::min(static_cast<size_t>(request.count), batch_.columns.size() - first));
    if (columns.empty()) return;
    prepare(*batch_.part, tools);
    find_active(columns, request, tools);
    for (size_t i = 0; i < columns.size();) {
        const int32_t block = columns[i] / 64;
        query(static_cast<size_t>(block),
              &tools->active[static_cast<size_t>(64 * (block - columns.front() / 64))], tools);
        for (; i < columns.size() && columns[i] / 64 == block; ++i) {
            float* to = request.results + static_cast<ptrdiff_t>(i) * request.column_stride;
            const auto at = static_cast<ptrdiff_t>(8 * (columns[i] % 64));
            for (const float* field : tools->fields) {
                std::memcpy(to, field + at, 8 * sizeof(float));
                to += request.field_stride;
            }
        }
    }
}

// Computes the fields of one block, 0 where a voxel does not query.
void NearestStage::query(size_t block, const uint8_t* active, Tools* tools) const {
    const PlacedPart& part = *batch_.part;
    solid::Scratch* scratch = tools->scratch_of(part);
    if (is_zero(active)) {
        scratch->engine->counts.skipped += nearest::kBlockVoxels;
        const auto clear = [](const auto& targets) {
            for (auto* target : targets) {
                if (target != nullptr) std::fill_n(target, kBlockValues, 0);
            }
        };
        clear(tools->value_targets);
        clear(tools->gradient_targets);
        clear(tools->flat_targets);
        std::fill_n(tools->distance, kBlockValues, 0.0f);
        fill_culled(block, tools);
        fill_attributes(block, false, tools);
        return;
    }
    nearest::BlockQuery query;
    query.block = batch_.blocks[block];
    query.active = active;
    query.radius_mm = batch_.culled.empty() ? kInfinity : batch_.culled[block].reach;
    part.engine().query(query, scratch->engine.get(), &tools->answer);
    if (part.volume.attributes || part.volume.gradients) {
        const nearest::AttributeTargets targets{
            tools->value_targets.data(),
            part.volume.gradients ? tools->gradient_targets.data() : nullptr,
            tools->flat_targets.data()};
        part.placed->read(tools->answer, active, targets, scratch);
        fill_attributes(block, true, tools);
    }
    if (part.volume.distance) {
        // Owned voxels are inside, so the distance is negative; taken from 0 so that none gives +0.
        // Voxels that do not query are infinitely far in the answer.
        for (size_t v = 0; v < kBlockValues; ++v) {
            const float d2 = tools->answer.distance2[v];
            tools->distance[v] = 0.0f - std::sqrt(d2 < kInfinity ? d2 : 0.0f);
        }
        if (query.radius_mm < kInfinity) {
            for (size_t v = 0; v < kBlockValues; ++v) {
                const bool beyond = !(tools->answer.distance2[v] < kInfinity);
                if (beyond && (active[v / 8] >> v % 8 & 1) != 0)
                    tools->distance[v] = 0.0f - query.radius_mm;
            }
        }
        fill_culled(block, tools);
    }
}

// Gives voxels without an answer the attributes that all voxels of the block have.
void NearestStage::fill_attributes(size_t block, bool answered, Tools* tools) const {
    const nearest::NearestCase* known =
        batch_.culled.empty() ? nullptr : batch_.culled[block].attributes;
    if (known == nullptr) return;
    const auto fill = [&](const auto& lo, const auto& hi, const auto& targets) {
        for (size_t c = 0; c < lo.size(); ++c) {
            if (!(lo[c] == hi[c]) || targets[c] == nullptr) continue;
            const auto value = std::bit_cast<std::decay_t<decltype(*targets[c])>>(lo[c]);
            for (size_t v = 0; v < kBlockValues; ++v) {
                if (!answered || tools->answer.item[v] < 0) targets[c][v] = value;
            }
        }
    };
    fill(known->float_lo, known->float_hi, tools->value_targets);
    fill(known->int_lo, known->int_hi, tools->flat_targets);
}

// Gives the culled pieces of a block a distance from their intervals.
void NearestStage::fill_culled(size_t block, Tools* tools) const {
    if (batch_.culled.empty()) return;
    const CulledBlock& culled = batch_.culled[block];
    const nearest::BlockPieces& pieces = batch_.part->engine().pieces();
    for (uint32_t left = culled.pieces; left != 0; left &= left - 1) {
        const auto p = static_cast<size_t>(std::countr_zero(left));
        for_each_column(pieces, p, [&](size_t column, uint8_t) {
            std::fill_n(tools->distance + 8 * column + pieces.lowest[p].z, pieces.size.z,
                        culled.distance[p]);
        });
    }
}

}  // namespace openfab::volume
