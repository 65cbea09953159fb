// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/point_queries.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace openfab::volume {
namespace {

using nearest::PointAnswer;
using nearest::PointPacket;
using segments::kLanes;

constexpr float kAnywhere = std::numeric_limits<float>::infinity();
constexpr float kNearVoxels = 16;

/// Returns the 8 values of a lane group in one state.
float* floats(const segments::States& states, int32_t state, int32_t group) {
    return reinterpret_cast<float*>(states[state]) + kLanes * group;
}

PointPacket points_of(const openfab_query& query, int32_t group, const segments::States& states,
                      uint32_t mask) {
    PointPacket out;
    for (size_t a = 0; a < 3; ++a)
        std::copy_n(floats(states, query.point[a], group), kLanes, out.p[a]);
    out.mask = mask;
    return out;
}

/// Negative inside. Subtracted from 0, so that a point on the surface has +0.
float with_sign(float distance, bool inside) {
    return inside ? 0.0f - distance : distance;
}

}  // namespace

void PointQueries::begin(const PlacedPart& part, const int32_t* corners, const uint8_t* owned,
                         openfab_isa isa, const std::atomic<bool>* stop) {
    part_ = &part;
    corners_ = corners;
    owned_ = owned;
    stop_ = stop;
    walk_ = walk_kernels(isa);
    values_.resize(static_cast<size_t>(part.nearest.floats()));
    flat_.resize(static_cast<size_t>(part.nearest.ints()));
}

nearest::QueryCounts PointQueries::counts() const {
    nearest::QueryCounts sum;
    for (const auto& scratch : scratch_) {
        if (scratch != nullptr) sum.add(scratch->engine->counts);
    }
    return sum;
}

uint32_t PointQueries::wanted(const openfab_query& query, int32_t group,
                              const segments::States& states) const {
    const uint32_t* guard = states[query.guard] + kLanes * group;
    uint32_t mask = 0;
    for (uint32_t l = 0; l < kLanes; ++l)
        mask |= (guard[l] != 0 ? 1u : 0u) << l;
    return mask & owned_[group];
}

/// Returns the centres of a lane group's voxels, in the order of operations of abi/fablet_table.h.
PointPacket PointQueries::centres(int32_t group) const {
    const int32_t* corner = corners_ + static_cast<ptrdiff_t>(3 * (group / 64));
    const float x = static_cast<float>(corner[0] + group % 8) + 0.5f;
    const float y = static_cast<float>(corner[1] + group / 8 % 8) + 0.5f;
    PointPacket out;
    for (size_t a = 0; a < 3; ++a) {
        const auto at = [&](size_t base) { return part_->frame[base + a]; };
        for (int32_t l = 0; l < kLanes; ++l) {
            const float z = static_cast<float>(corner[2] + l) + 0.5f;
            out.p[a][l] = ((x * at(OPENFAB_FRAME_STEP_I) + y * at(OPENFAB_FRAME_STEP_J)) +
                           z * at(OPENFAB_FRAME_STEP_K)) +
                          at(OPENFAB_FRAME_ORIGIN);
        }
    }
    return out;
}

abi::KernelStatus PointQueries::ask(const solid::Placed& placed, int32_t part,
                                    const std::vector<PointPacket>& points, bool scattered) {
    std::unique_ptr<solid::Scratch>& scratch = scratch_[part];
    if (scratch == nullptr) scratch = placed.make_scratch();
    nearest::Engine::Scratch& engine = *scratch->engine;
    engine.stop = stop_;
    const auto status = [&] {
        return engine.stopped() ? abi::KernelStatus::stopped() : abi::KernelStatus();
    };
    answers_.resize(points.size());
    // Voxels side by side that ask for points beside their own are near each other already.
    const float near_mm = kNearVoxels * part_->largest_pitch_mm;
    if (!scattered || !PointOrder::scattered(points, near_mm)) {
        placed.engine()->query_points(points, kAnywhere, &engine, answers_.data());
        return status();
    }
    const std::span<const PointPacket> gathered = order_.gather(points);
    gathered_.resize(gathered.size());
    placed.engine()->query_points(gathered, kAnywhere, &engine, gathered_.data());
    order_.scatter(gathered_, answers_);
    return status();
}

abi::KernelStatus PointQueries::answer(const openfab_query& query, std::span<const int32_t> groups,
                                       const segments::States& states) {
    groups_.clear();
    points_.clear();
    for (const int32_t group : groups) {
        if (const uint32_t mask = wanted(query, group, states); mask != 0) {
            groups_.push_back(group);
            points_.push_back(points_of(query, group, states, mask));
            continue;
        }
        for (int32_t i = 0; i < query.output_count; ++i)
            std::fill_n(states[query.outputs[i].state] + kLanes * group, kLanes, 0u);
    }
    if (groups_.empty()) return {};
    if (query.stop >= 0) return answer_walk(query, states);
    return query.object < 0 ? answer_own(query, states) : answer_object(query, states);
}

abi::KernelStatus PointQueries::answer_own(const openfab_query& query,
                                           const segments::States& states) {
    const abi::KernelStatus status = ask(*part_->placed, part_->owner, points_, true);
    if (!status.ok()) return status;
    for (size_t k = 0; k < groups_.size(); ++k) {
        if (part_->points.sign) write_distance(query, k, states);
        write_surface(query, groups_[k], states, answers_[k]);
    }
    return {};
}

void PointQueries::write_distance(const openfab_query& query, size_t entry,
                                  const segments::States& states) {
    const int32_t group = groups_[entry];
    const PointPacket& points = points_[entry];
    const PointAnswer& answer = answers_[entry];
    const PointPacket centre = centres(group);
    uint32_t at_centre = 0;
    for (size_t l = 0; l < kLanes; ++l) {
        const bool same = points.p[0][l] == centre.p[0][l] && points.p[1][l] == centre.p[1][l] &&
                          points.p[2][l] == centre.p[2][l];
        at_centre |= (same ? 1u : 0u) << l;
    }
    // Coverage snaps vertices to 1/256 of a voxel.
    const float slack = part_->largest_pitch_mm * 0x1p-7f;
    PointPacket elsewhere = points;
    elsewhere.mask &= ~at_centre;
    const uint32_t inside =
        at_centre | part_->placed->inside(elsewhere, answer, {&centre, owned_[group], slack},
                                          scratch_[part_->owner].get());
    for (int32_t i = 0; i < query.output_count; ++i) {
        const openfab_query_output& out = query.outputs[i];
        if (out.kind != OPENFAB_QUERY_DISTANCE) continue;
        float* to = floats(states, out.state, group);
        for (size_t l = 0; l < kLanes; ++l) {
            const float d = with_sign(std::sqrt(answer.distance2[l]), (inside >> l & 1u) != 0);
            to[l] = (points.mask >> l & 1u) != 0 ? d : 0.0f;
        }
    }
}

/// Positions, normals and attributes.
void PointQueries::write_surface(const openfab_query& query, int32_t group,
                                 const segments::States& states, const PointAnswer& answer) {
    nearest::PointTargets targets;
    std::fill(values_.begin(), values_.end(), nullptr);
    std::fill(flat_.begin(), flat_.end(), nullptr);
    bool any = false;
    for (int32_t i = 0; i < query.output_count; ++i) {
        const openfab_query_output& out = query.outputs[i];
        float* to = floats(states, out.state, group);
        any = any || out.kind != OPENFAB_QUERY_DISTANCE;
        if (out.kind == OPENFAB_QUERY_POSITION) targets.position[out.b] = to;
        if (out.kind == OPENFAB_QUERY_NORMAL) targets.normal[out.b] = to;
        if (out.kind != OPENFAB_QUERY_ATTRIBUTE) continue;
        const size_t index = part_->nearest.index(out.a, out.b);
        if (part_->nearest.is_float(out.a)) {
            values_[index] = to;
        } else {
            flat_[index] = states[out.state] + kLanes * group;
        }
    }
    if (!any) return;
    targets.values = values_.data();
    targets.flat = flat_.data();
    part_->placed->read_points(answer, targets, scratch_[part_->owner].get());
}

abi::KernelStatus PointQueries::find_least(int32_t object, bool scattered) {
    least_.resize(points_.size());
    for (auto& least : least_)
        least.fill(kAnywhere);
    for (const QueryTarget& target : part_->targets[object]) {
        moved_ = points_;
        for (PointPacket& group : moved_) {
            for (size_t l = 0; l < kLanes; ++l) {
                const Vec3d p{group.p[0][l], group.p[1][l], group.p[2][l]};
                const Vec3f q = vec_cast<float>(target.to_local.apply(p));
                for (size_t a = 0; a < 3; ++a)
                    group.p[a][l] = q[static_cast<int>(a)];
            }
        }
        const abi::KernelStatus status = ask(*target.placed, target.part, moved_, scattered);
        if (!status.ok()) return status;
        for (size_t k = 0; k < moved_.size(); ++k) {
            const uint32_t inside =
                target.placed->inside(moved_[k], answers_[k], {}, scratch_[target.part].get());
            for (size_t l = 0; l < kLanes; ++l) {
                const float d = std::sqrt(answers_[k].distance2[l]);
                least_[k][l] = std::min(least_[k][l], with_sign(d, (inside >> l & 1u) != 0));
            }
        }
    }
    return {};
}

abi::KernelStatus PointQueries::answer_object(const openfab_query& query,
                                              const segments::States& states) {
    const abi::KernelStatus status = find_least(query.object, true);
    if (!status.ok()) return status;
    for (size_t k = 0; k < groups_.size(); ++k) {
        for (int32_t i = 0; i < query.output_count; ++i) {
            float* to = floats(states, query.outputs[i].state, groups_[k]);
            for (size_t l = 0; l < kLanes; ++l)
                to[l] = (points_[k].mask >> l & 1u) != 0 ? least_[k][l] : 0.0f;
        }
    }
    return {};
}

/// The nodes of a lattice of walks.
bool PointQueries::sample(std::span<const Vec3f> points, float* own, float* object) {
    points_.clear();
    for (size_t k = 0; k < points.size(); ++k) {
        const size_t lane = k % kLanes;
        if (lane == 0) points_.emplace_back().mask = 0;
        points_.back().mask |= 1u << lane;
        for (size_t a = 0; a < 3; ++a)
            points_.back().p[a][lane] = points[k][static_cast<int>(a)];
    }
    if (!ask(*part_->placed, part_->owner, points_, false).ok()) return false;
    uint32_t inside = 0;
    for (size_t k = 0; k < points.size(); ++k) {
        const size_t packet = k / kLanes, lane = k % kLanes;
        if (lane == 0)
            inside = part_->placed->inside(points_[packet], answers_[packet], {},
                                           scratch_[part_->owner].get());
        // Positive inside.
        own[k] = with_sign(std::sqrt(answers_[packet].distance2[lane]), (inside >> lane & 1) == 0);
    }
    if (object == nullptr) return true;
    if (!find_least(walks_to_, false).ok()) return false;
    for (size_t k = 0; k < points.size(); ++k)
        object[k] = least_[k / kLanes][k % kLanes];
    return true;
}

/// Reads for a lane from the shared lattice, and where that is full, from one of this thread. False: the print is to stop.
bool PointQueries::read(WalkLattice* lattice, WalkLanes* lanes, size_t lane) {
    using Outcome = WalkLattice::Outcome;
    const Vec3f p = lanes->asked(lane);
    const float stop = lanes->stop[lane];
    WalkField field;
    Outcome outcome = lattice->read(p, stop, this, &field);
    if (outcome == Outcome::kFull) {
        if (spare_ == nullptr) spare_ = lattice->another(kSpareBytes);
        outcome = spare_->read(p, stop, this, &field);
    }
    if (outcome == Outcome::kFull) {
        spare_->clear();
        outcome = spare_->read(p, stop, this, &field);
    }
    if (outcome == Outcome::kRead) lanes->know(lane, field);
    return outcome != Outcome::kStopped;
}

abi::KernelStatus PointQueries::answer_walk(const openfab_query& query,
                                            const segments::States& states) {
    WalkLattice* const lattice = part_->lattices[static_cast<size_t>(query.object + 1)].get();
    walks_to_ = query.object;
    if (spare_of_ != lattice) spare_ = nullptr;
    spare_of_ = lattice;
    walked_ = points_;  // which the lattice's queries overwrite
    const size_t count = kLanes * groups_.size();
    const auto write = [&](size_t point, const Vec3f& end, bool on_object) {
        const int32_t at = kLanes * groups_[point / kLanes] + static_cast<int32_t>(point % kLanes);
        for (int32_t i = 0; i < query.output_count; ++i) {
            const openfab_query_output& out = query.outputs[i];
            states[out.state][at] = out.kind == OPENFAB_QUERY_END
                                        ? std::bit_cast<uint32_t>(end[out.b])
                                        : (on_object ? 1u : 0u);
        }
    };
    // Where a walk ends, the next one begins.
    WalkLanes lanes;
    std::array<size_t, WalkLanes::kCount> points{};
    size_t next = 0;
    uint32_t used = 0;
    const auto begin = [&](uint32_t lane) {
        for (; next < count; ++next) {
            const PointPacket& packet = walked_[next / kLanes];
            const size_t l = next % kLanes;
            if (!packet.asks(l)) {
                write(next, {}, false);
                continue;
            }
            const size_t at = kLanes * static_cast<size_t>(groups_[next / kLanes]) + l;
            lanes.begin(lane, packet.point(l), std::bit_cast<float>(states[query.stop][at]),
                        static_cast<int32_t>(states[query.seed][at]));
            points[lane] = next++;
            used |= 1u << lane;
            return;
        }
    };
    for (uint32_t lane = 0; lane < WalkLanes::kCount; ++lane)
        begin(lane);
    while (used != 0) {
        for (uint32_t left = walk_.read(lattice->cells(), &lanes); left != 0; left &= left - 1) {
            if (!read(lattice, &lanes, static_cast<size_t>(std::countr_zero(left))))
                return abi::KernelStatus::stopped();
        }
        for (uint32_t left = walk_.take(&lanes) & used; left != 0; left &= left - 1) {
            const auto lane = static_cast<uint32_t>(std::countr_zero(left));
            write(points[lane], lanes.end(lane), lanes.on_object[lane] != 0);
            used &= ~(1u << lane);
            begin(lane);
        }
    }
    return {};
}

}  // namespace openfab::volume
