// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/reference/brute_force.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/infinity.h"
#include "runtime/nearest/engine/patch_cache.h"
#include "runtime/nearest/tree/triangle.h"
#include "runtime/nearest/voxel_center.h"

namespace openfab::reference {
namespace {

using namespace nearest;

class BruteForceEngine final : public Engine {
  public:
    BruteForceEngine(const surface::Surface& surface,
                     const std::array<float, OPENFAB_FRAME_COUNT>& frame)
        : ranges_(surface.ranges()), frame_(frame) {
        std::vector<InputTriangle> triangles;
        const auto count = static_cast<int32_t>(surface.patches().size());
        for (int32_t p = 0; p < count; ++p) {
            if ((surface.patches()[p].use & surface::kForQuery) == 0) continue;
            append_triangles(*surface.micro(p), p, &triangles);
        }
        frames_.resize(triangles.size());
        details_.resize(triangles.size());
        for (size_t i = 0; i < triangles.size(); ++i) {
            const InputTriangle& t = triangles[i];
            make_triangle(t.v[0], t.v[1], t.v[2], t.patch, t.triangle, &frames_[i], &details_[i]);
        }
    }

    std::unique_ptr<Scratch> make_scratch() const override { return std::make_unique<Scratch>(); }

    void query(const BlockQuery& query, Scratch* scratch, BlockAnswer* answer) const override {
        for (int32_t y = 0; y < 8; ++y) {
            for (int32_t x = 0; x < 8; ++x) {
                for (int32_t z = 0; z < 8; ++z) {
                    const int32_t v = (y * 8 + x) * 8 + z;
                    const bool asked =
                        query.active == nullptr || (query.active[y * 8 + x] >> z & 1) != 0;
                    ++(asked ? scratch->counts.queried : scratch->counts.skipped);
                    answer_voxel(query.block + Vec3i{x, y, z}, asked, query.radius_mm, v, answer);
                }
            }
        }
    }

    void query_points(std::span<const PointPacket> packets, float radius_mm, Scratch* scratch,
                      PointAnswer* answers) const override {
        for (size_t g = 0; g < packets.size(); ++g) {
            for (size_t l = 0; l < 8; ++l) {
                const Vec3f p{packets[g].p[0][l], packets[g].p[1][l], packets[g].p[2][l]};
                const bool asked = (packets[g].mask >> l & 1u) != 0;
                const bool finite = std::fabs(p.x) < kMaxCoordinate &&
                                    std::fabs(p.y) < kMaxCoordinate &&
                                    std::fabs(p.z) < kMaxCoordinate;
                scratch->counts.queried += asked ? 1 : 0;
                const Winner best = asked && finite ? closest(p, radius_mm) : Winner{};
                answers[g].distance2[l] = best.hit.distance2;
                answers[g].item[l] = best.patch;
                answers[g].in_patch.triangle[l] = best.patch < 0 ? 0 : best.triangle;
                answers[g].in_patch.bary1[l] = best.hit.bary1;
                answers[g].in_patch.bary2[l] = best.hit.bary2;
            }
        }
    }

    void bounds(const Vec3i& lowest, int32_t size, Scratch*, BoxBounds* out) const override {
        // From the nearest point of the center, by the triangle inequality; with the attributes of
        // everything in reach.
        const Vec3f lo = center(lowest), hi = center(lowest + Vec3i{size - 1, size - 1, size - 1});
        const Vec3f middle = (lo + hi) * 0.5f;
        const float reach = length(hi - lo) * 0.5f * 1.001f;
        float least = kInfinity;
        for (size_t i = 0; i < frames_.size(); ++i) {
            least = std::min(least, closest_point(frames_[i], details_[i], middle).distance2);
        }
        out->clear();
        out->distance_hi = std::sqrt(least) * 1.0001f + reach;
        const auto floats = static_cast<size_t>(ranges_.float_components);
        const auto ints = static_cast<size_t>(ranges_.int_components);
        for (size_t i = 0; i < frames_.size(); ++i) {
            const float d = std::sqrt(closest_point(frames_[i], details_[i], middle).distance2);
            const float lowest_d = d * 0.9999f - reach;
            if (lowest_d > out->distance_hi) continue;
            const auto p = static_cast<size_t>(details_[i].patch);
            out->add(std::max(0.0f, lowest_d), {ranges_.float_lo.data() + p * floats, floats},
                     {ranges_.float_hi.data() + p * floats, floats},
                     {ranges_.int_lo.data() + p * ints, ints},
                     {ranges_.int_hi.data() + p * ints, ints});
        }
    }

  private:
    Vec3f center(const Vec3i& voxel) const { return voxel_center(frame_, voxel); }

    struct Winner {
        Hit hit{kInfinity, 0, 0};
        int32_t patch = -1, triangle = -1;
    };

    Winner closest(const Vec3f& p, float radius) const {
        Winner best;
        for (size_t i = 0; i < frames_.size(); ++i) {
            const Hit hit = closest_point(frames_[i], details_[i], p);
            // Patches and their triangles are in ascending order: the first wins ties.
            if (!(hit.distance2 < best.hit.distance2) || !(hit.distance2 <= radius * radius))
                continue;
            best = {hit, details_[i].patch, details_[i].triangle};
        }
        return best;
    }

    void answer_voxel(const Vec3i& voxel, bool asked, float radius, int32_t v,
                      BlockAnswer* answer) const {
        const Winner best = asked ? closest(center(voxel), radius) : Winner{};
        answer->distance2[v] = best.hit.distance2;
        answer->item[v] = best.patch;
        answer->in_patch.triangle[v] = best.triangle;
        answer->in_patch.bary1[v] = best.hit.bary1;
        answer->in_patch.bary2[v] = best.hit.bary2;
    }

    const surface::PatchRanges& ranges_;
    std::array<float, OPENFAB_FRAME_COUNT> frame_;
    std::vector<TriangleFrame> frames_;
    std::vector<TriangleDetail> details_;
};

}  // namespace

std::unique_ptr<nearest::Engine> make_brute_force_engine(
    const surface::Surface& surface, const std::array<float, OPENFAB_FRAME_COUNT>& frame) {
    return std::make_unique<BruteForceEngine>(surface, frame);
}

}  // namespace openfab::reference
