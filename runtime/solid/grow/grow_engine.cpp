// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/grow_engine.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/at.h"
#include "base/infinity.h"

namespace openfab::solid {

namespace {

/// A region has 4 blocks along x, beginning in it.
constexpr int32_t kRegionVoxels = 32;

/// Returns the largest multiple of `by`, a power of two, that is no larger.
int32_t down_to(int32_t x, int32_t by) {
    return x & ~(by - 1);
}

class GrowEngine final : public nearest::Engine {
  public:
    GrowEngine(const Grown& grown, const std::array<float, OPENFAB_FRAME_COUNT>& frame,
               const openfab_fablet* fablet)
        : grown_(grown), frame_(frame), fablet_(fablet) {}

    std::unique_ptr<Scratch> make_scratch() const override {
        return std::make_unique<GrowScratch>();
    }

    void query(const nearest::BlockQuery& query, Scratch* scratch,
               nearest::BlockAnswer* answer) const override {
        auto* mine = static_cast<GrowScratch*>(scratch);
        // Beams that hold a voxel touch its row of blocks; only where a voxel is in none are others looked for.
        GrowScratch::Region* region = find_touching(query.block, 8, true, mine);
        if (!ask(query, region, true, mine, answer) && !grown_.failed()) {
            region = &find_near(query.block, mine);
            ask(query, region, false, mine, answer);
        }
    }

    void query_points(std::span<const nearest::PointPacket> packets, float radius_mm,
                      Scratch* scratch, nearest::PointAnswer* answers) const override {
        auto* mine = static_cast<GrowScratch*>(scratch);
        mine->gathered.clear();
        for (size_t g = 0; g < packets.size(); ++g) {
            if (scratch->stopped()) return;
            nearest::PointAnswer& to = answers[g];
            to = {};
            for (size_t l = 0; l < 8; ++l) {
                to.distance2[l] = kInfinity;
                to.item[l] = -1;
                if (!packets[g].asks(l)) continue;
                ++mine->counts.queried;
                const size_t before = mine->gathered.beams.size();
                const float d = grown_.nearest(packets[g].point(l), &mine->gathered);
                if (mine->gathered.beams.size() == before) continue;
                if (std::fabs(d) <= radius_mm) {
                    to.item[l] = static_cast<int32_t>(before);
                    to.distance2[l] = d * d;
                }
            }
        }
        take_points(packets, answers, mine);
    }

    // Bounds are of covered voxels, whose nearest beams and bodies touch their block. Nothing is known where these are
    // not kept: to make them costs more than most bounds save, and answers would mostly make them once more.
    void bound_blocks(std::span<const Vec3i> blocks, Scratch* scratch,
                      nearest::BlockBounds* bounds) const override {
        auto* mine = static_cast<GrowScratch*>(scratch);
        const nearest::BlockPieces& cut = pieces();
        for (size_t i = 0; i < blocks.size(); ++i) {
            const GrowScratch::Region* region = find_touching(blocks[i], 8, false, mine);
            for (size_t q = 0; q < cut.lowest.size(); ++q) {
                bounds[i].low[q] = 0;
                bounds[i].high[q] = kInfinity;
                if (region == nullptr) continue;
                const VoxelBall ball = voxel_ball(frame(), blocks[i] + cut.lowest[q], cut.size);
                const auto [low, high] = magnitude(distance_in(*region, ball.middle), ball);
                bounds[i].low[q] = low;
                bounds[i].high[q] = high;
            }
        }
    }

    void bounds(const Vec3i& lowest, int32_t size, Scratch* scratch,
                nearest::BoxBounds* out) const override {
        out->clear();
        out->distance_hi = kInfinity;
        // What grows in a larger cube may be far from the slices that are printed: nothing is known of it.
        if (size > 8) return;
        auto* mine = static_cast<GrowScratch*>(scratch);
        const GrowScratch::Region* found = find_touching(lowest, size, false, mine);
        if (found == nullptr) return;
        const GrowScratch::Region& region = *found;
        if (!region.beams.empty()) region.engine->bounds(lowest, size, region.scratch.get(), out);
        const std::vector<LocalBodies::Body>& bodies = region.bodies.bodies();
        if (bodies.empty()) return;
        const VoxelBall ball = voxel_ball(frame(), lowest, {size, size, size});
        const float nearest = distance_in(region, ball.middle);
        out->distance_hi = magnitude(nearest, ball)[1];
        for (size_t i = 0; i < bodies.size(); ++i) {
            const float d = distance_of(bodies[i], ball.middle);
            // Its distance and that of the nearest change by no more than a radius.
            if (d - nearest <= 2 * reach_of(ball, std::max(std::fabs(d), std::fabs(nearest))))
                region.bodies.add_case(i, magnitude(d, ball)[0], out);
        }
    }

  private:
    VoxelFrame frame() const { return VoxelFrame(frame_); }

    /// Returns by how much a distance `d` at the middle of a ball may differ from that of its other points.
    float reach_of(const VoxelBall& ball, float d) const {
        return ball.radius + grown_.slack(ball.middle, std::fabs(d) + ball.radius);
    }
    /// Returns the range of the magnitude of signed distances in a ball.
    std::array<float, 2> magnitude(float middle, const VoxelBall& ball) const {
        const float d = std::fabs(middle);
        if (!(d < kInfinity)) return {0, kInfinity};
        return {std::max(0.0f, d - reach_of(ball, d)), d + reach_of(ball, d)};
    }
    float distance_of(const LocalBodies::Body& body, const Vec3f& p) const {
        return body.body.distance(vec_cast<double>(p) + grown_.center());
    }
    /// Returns the least signed distance to what a region has; +inf if that is nothing.
    float distance_in(const GrowScratch::Region& region, const Vec3f& p) const {
        float least =
            region.beams.empty() ? kInfinity : region.beams.tree().nearest(p, -1).distance;
        for (const LocalBodies::Body& body : region.bodies.bodies())
            least = std::min(least, distance_of(body, p));
        return least;
    }

    /// Gives the answers of points their places in the scratch, and their nearest points. `item` was among what was
    /// gathered.
    void take_points(std::span<const nearest::PointPacket> packets, nearest::PointAnswer* answers,
                     GrowScratch* mine) const {
        mine->of_points.set(mine->gathered, grown_.center(), fablet_, true);
        mine->bodies_of_points.set(mine->gathered, fablet_, true);
        // The tree has an order of its own.
        std::vector<int32_t> place(mine->gathered.beams.size(), -1);
        std::vector<size_t> beams;
        for (size_t i = 0; i < place.size(); ++i) {
            if (mine->gathered.beams[i].body < 0) beams.push_back(i);
        }
        const auto first_body = static_cast<int32_t>(mine->of_points.size());
        for (int32_t i = 0; i < first_body; ++i) {
            const BeamRecord& beam = at(mine->of_points.tree().beams(), i);
            place[beams[static_cast<size_t>(beam.number)]] = i;
        }
        std::vector<LocalBodies::Body>& bodies = mine->bodies_of_points.bodies();
        for (size_t i = 0; i < bodies.size(); ++i)
            place[bodies[i].from] = first_body + static_cast<int32_t>(i);
        for (size_t g = 0; g < packets.size(); ++g) {
            nearest::PointAnswer& to = answers[g];
            for (size_t l = 0; l < 8; ++l) {
                if (to.item[l] < 0) continue;
                to.item[l] = place[static_cast<size_t>(to.item[l])];
                const Vec3f p = packets[g].point(l);
                if (to.item[l] < first_body) {
                    const BeamRecord& beam =
                        mine->of_points.tree().beams()[static_cast<size_t>(to.item[l])];
                    to.set_point(l, nearest_of_beam(beam, p).position);
                    continue;
                }
                LocalBodies::Body& body = bodies[static_cast<size_t>(to.item[l] - first_body)];
                const Vec3d at = vec_cast<double>(p) + grown_.center();
                body.body.ask({&at, 1}, true, &mine->found);
                body.normal = mine->found[0].normal;
                to.set_point(l, local(mine->found[0].position));
            }
        }
    }
    /// Returns a point of part space, part-local.
    Vec3f local(const Vec3f& p) const {
        return vec_cast<float>(vec_cast<double>(p) - grown_.center());
    }

    /// Answers by what a region has; `holding`: by those that hold a voxel. Returns whether all active voxels lie in
    /// one of them.
    bool ask(const nearest::BlockQuery& query, GrowScratch::Region* region, bool holding,
             GrowScratch* mine, nearest::BlockAnswer* answer) const {
        mine->asked = region;
        if (region->beams.empty()) {
            std::fill_n(answer->distance2, nearest::kBlockVoxels, kInfinity);
            std::fill_n(answer->item, nearest::kBlockVoxels, -1);
        } else {
            // What is farther may yet be deeper than a body.
            nearest::BlockQuery beams = query;
            if (!region->bodies.empty()) beams.radius_mm = kInfinity;
            region->engine->query(beams, region->scratch.get(), answer);
            mine->counts.add(region->scratch->counts);
            region->scratch->counts = {};
        }
        if (!region->bodies.empty()) return ask_bodies(query, region, holding, mine, answer);
        const VoxelFrame voxels = frame();
        for (int32_t v = 0; v < nearest::kBlockVoxels; ++v) {
            if (!is_active(query, v)) continue;
            if (answer->item[v] < 0) return false;
            const BeamRecord& beam =
                region->beams.tree().beams()[static_cast<size_t>(answer->item[v])];
            if (!(beam_distance(beam, centre(voxels, query, v)) < 0)) return false;
        }
        return true;
    }

    static bool is_active(const nearest::BlockQuery& query, int32_t v) {
        return query.active == nullptr || (query.active[v >> 3] >> (v & 7) & 1) != 0;
    }
    static Vec3f centre(const VoxelFrame& voxels, const nearest::BlockQuery& query, int32_t v) {
        const Vec3i at = query.block + Vec3i{v >> 3 & 7, v >> 6, v & 7};
        return voxels.box(at, at).lo;
    }

    /// Takes the bodies of a region into answers of its beams.
    bool ask_bodies(const nearest::BlockQuery& query, GrowScratch::Region* region, bool holding,
                    GrowScratch* mine, nearest::BlockAnswer* answer) const {
        const VoxelFrame voxels = frame();
        mine->depths.assign(nearest::kBlockVoxels, kInfinity);
        std::vector<int32_t> active;
        std::vector<Vec3d> points;
        for (int32_t v = 0; v < nearest::kBlockVoxels; ++v) {
            if (!is_active(query, v)) continue;
            const Vec3f p = centre(voxels, query, v);
            active.push_back(v);
            points.push_back(vec_cast<double>(p) + grown_.center());
            if (answer->item[v] < 0) continue;
            mine->depths[static_cast<size_t>(v)] = beam_distance(
                region->beams.tree().beams()[static_cast<size_t>(answer->item[v])], p);
        }
        const VoxelBall ball = voxel_ball(voxels, query.block, {8, 8, 8});
        const Vec3d middle = vec_cast<double>(ball.middle) + grown_.center();
        const auto first_body = static_cast<int32_t>(region->beams.size());
        const std::vector<LocalBodies::Body>& bodies = region->bodies.bodies();
        // The nearest first, so that others are seen to be farther; of those as near the first that grows counts.
        std::vector<std::pair<float, size_t>> order;
        for (size_t i = 0; i < bodies.size(); ++i)
            order.emplace_back(bodies[i].body.distance(middle), i);
        std::ranges::sort(order);
        for (const auto& [distance, i] : order) {
            float least = distance - ball.radius;
            least -= grown_.slack(ball.middle, std::fabs(distance) + ball.radius);
            float most = -kInfinity;
            for (const int32_t v : active)
                most = std::max(most, mine->depths[static_cast<size_t>(v)]);
            if (least > (holding ? std::min(most, 0.0f) : most)) break;
            bodies[i].body.ask(points, true, &mine->found);
            const int32_t number = first_body + static_cast<int32_t>(i);
            for (size_t k = 0; k < active.size(); ++k) {
                const auto v = static_cast<size_t>(active[k]);
                const float d = mine->found[k].distance;
                const bool first = d == mine->depths[v] && answer->item[v] > number;
                if (!(d < mine->depths[v] || first)) continue;
                mine->depths[v] = d;
                answer->distance2[v] = d * d;
                answer->item[v] = number;
                answer->set_point(v, local(mine->found[k].position));
            }
        }
        mine->counts.queried += static_cast<int64_t>(active.size());
        bool inside = true;
        for (const int32_t v : active) {
            inside = inside && mine->depths[static_cast<size_t>(v)] < 0;
            if (answer->distance2[v] <= query.radius_mm * query.radius_mm) continue;
            answer->distance2[v] = kInfinity;
            answer->item[v] = -1;
        }
        return inside;
    }

    /// Returns a region that holds a cube of up to 8 voxels a side, with the beams that touch it; null where these
    /// are not kept and not to be made.
    GrowScratch::Region* find_touching(const Vec3i& lowest, int32_t size, bool make,
                                       GrowScratch* mine) const {
        const Vec3i key{down_to(lowest.x, kRegionVoxels), lowest.y, lowest.z};
        const auto holds = [&](const GrowScratch::Region& region) {
            const Vec3i from = lowest - region.key;
            return region.used != 0 && region.engine_of == this && region.key.x == key.x &&
                   from.y >= 0 && from.y + size <= 8 && from.z >= 0 && from.z + size <= 8;
        };
        GrowScratch::Region* oldest = mine->regions.data();
        for (GrowScratch::Region& region : mine->regions) {
            if (holds(region)) {
                region.used = ++mine->uses;
                return &region;
            }
            if (region.used < oldest->used) oldest = &region;
        }
        Box3f box = frame().box(key, key + Vec3i{kRegionVoxels + 7, 7, 7});
        const float margin = grown_.slack(box.hi, 0);
        box.lo = box.lo - Vec3f{margin, margin, margin};
        box.hi = box.hi + Vec3f{margin, margin, margin};
        mine->gathered.clear();
        if (make) {
            grown_.collect(box, &mine->gathered);
        } else if (!grown_.collect_kept(box, &mine->gathered)) {
            return nullptr;
        }
        oldest->engine_of = this;
        oldest->key = key;
        oldest->used = ++mine->uses;
        take(mine->gathered, oldest);
        // Where beams crowd, few regions are kept.
        size_t kept = 0;
        for (const GrowScratch::Region& region : mine->regions)
            kept += region.beams.size();
        for (GrowScratch::Region& region : mine->regions) {
            if (kept <= GrowScratch::kMostKept || &region == oldest) continue;
            kept -= region.beams.size();
            region = {};
        }
        return oldest;
    }

    /// Returns all beams that may be nearest to a voxel of a block.
    GrowScratch::Region& find_near(const Vec3i& block, GrowScratch* mine) const {
        const VoxelBall ball = voxel_ball(frame(), block, {8, 8, 8});
        const float d = grown_.nearest(ball.middle, nullptr);
        mine->gathered.clear();
        if (d < kInfinity) grown_.collect(ball.middle, d + 2 * ball.radius, &mine->gathered);
        take(mine->gathered, &mine->around);
        return mine->around;
    }

    void take(const GatheredBeams& gathered, GrowScratch::Region* region) const {
        region->scratch = nullptr;
        region->engine = nullptr;
        region->beams.set(gathered, grown_.center(), fablet_);
        region->bodies.set(gathered, fablet_);
        if (region->beams.empty()) return;
        region->engine =
            make_beam_engine(region->beams.tree(), frame(), region->beams.attributes());
        region->scratch = region->engine->make_scratch();
    }

    const Grown& grown_;
    const std::array<float, OPENFAB_FRAME_COUNT> frame_;
    const openfab_fablet* fablet_;
};

}  // namespace

std::unique_ptr<nearest::Engine> make_grow_engine(
    const Grown& grown, const std::array<float, OPENFAB_FRAME_COUNT>& frame,
    const openfab_fablet* fablet) {
    return std::make_unique<GrowEngine>(grown, frame, fablet);
}

}  // namespace openfab::solid
