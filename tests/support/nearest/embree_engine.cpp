// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/nearest/embree_engine.h"

// Both versions agree in everything that is used here.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/infinity.h"
#include "runtime/nearest/engine/patch_cache.h"
#include "runtime/nearest/tree/triangle.h"
#include "runtime/nearest/voxel_center.h"
#include "tests/support/reference/closest_point.h"

namespace openfab::testing {
namespace {

using nearest::BlockAnswer;
using nearest::BlockQuery;
using nearest::PointAnswer;
using nearest::PointPacket;

class Engine final : public EmbreeEngine {
  public:
    Engine(const surface::Surface& surface, const std::array<float, OPENFAB_FRAME_COUNT>& frame)
        : ranges_(surface.ranges()), frame_(frame) {
        std::vector<nearest::InputTriangle> triangles;
        const auto count = static_cast<int32_t>(surface.patches().size());
        for (int32_t p = 0; p < count; ++p) {
            if ((surface.patches()[p].use & surface::kForQuery) == 0) continue;
            nearest::append_triangles(*surface.micro(p), p, &triangles);
        }
        frames_.resize(triangles.size());
        details_.resize(triangles.size());
        for (size_t i = 0; i < triangles.size(); ++i) {
            const nearest::InputTriangle& t = triangles[i];
            nearest::make_triangle(t.v[0], t.v[1], t.v[2], t.patch, t.triangle, &frames_[i],
                                   &details_[i]);
            for (const Vec3f& v : t.v) {
                for (int a = 0; a < 3; ++a)
                    largest_ = std::max(largest_, std::abs(static_cast<double>(v[a])));
            }
        }
        make_scene(triangles);
    }

    ~Engine() override {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }

    double allowed_mm(double exact_mm) const override {
        return 1e-5 * exact_mm + std::ldexp(largest_, -21);
    }
    int64_t triangle_count() const override { return static_cast<int64_t>(frames_.size()); }

    std::unique_ptr<nearest::Engine::Scratch> make_scratch() const override {
        return std::make_unique<EmbreeEngine::Scratch>();
    }

    void query(const BlockQuery& query, nearest::Engine::Scratch* scratch,
               BlockAnswer* answer) const override {
        auto& s = static_cast<EmbreeEngine::Scratch&>(*scratch);
        for (int32_t v = 0; v < nearest::kBlockVoxels; ++v) {
            const auto at = static_cast<size_t>(v);
            const bool asked =
                query.active == nullptr || (query.active[at >> 3] >> (v & 7) & 1) != 0;
            ++(asked ? s.counts.queried : s.counts.skipped);
            Found best;
            if (asked) {
                const Vec3i voxel = query.block + Vec3i{v >> 3 & 7, v >> 6, v & 7};
                best = closest(nearest::voxel_center(frame_, voxel), query.radius_mm, &s);
            }
            s.exact_mm[at] = best.exact_mm;
            answer->distance2[v] = best.hit.distance2;
            answer->item[v] = best.patch(*this);
            answer->in_patch.triangle[v] = best.triangle < 0 ? -1 : detail(best.triangle).triangle;
            answer->in_patch.bary1[v] = best.hit.bary1;
            answer->in_patch.bary2[v] = best.hit.bary2;
        }
    }

    void query_points(std::span<const PointPacket> packets, float radius_mm,
                      nearest::Engine::Scratch* scratch, PointAnswer* answers) const override {
        auto& s = static_cast<EmbreeEngine::Scratch&>(*scratch);
        for (size_t g = 0; g < packets.size(); ++g) {
            for (size_t l = 0; l < 8; ++l) {
                const Vec3f p{packets[g].p[0][l], packets[g].p[1][l], packets[g].p[2][l]};
                bool asked = (packets[g].mask >> l & 1u) != 0;
                s.counts.queried += asked ? 1 : 0;
                for (int a = 0; a < 3; ++a)
                    asked = asked && std::fabs(p[a]) < nearest::kMaxCoordinate;
                const Found best = asked ? closest(p, radius_mm, &s) : Found{};
                answers[g].distance2[l] = best.hit.distance2;
                answers[g].item[l] = best.patch(*this);
                answers[g].in_patch.triangle[l] =
                    best.triangle < 0 ? 0 : detail(best.triangle).triangle;
                answers[g].in_patch.bary1[l] = best.hit.bary1;
                answers[g].in_patch.bary2[l] = best.hit.bary2;
            }
        }
    }

    void bounds(const Vec3i& lowest, int32_t size, nearest::Engine::Scratch* scratch,
                nearest::BoxBounds* out) const override {
        auto& s = static_cast<EmbreeEngine::Scratch&>(*scratch);
        const Vec3f lo = nearest::voxel_center(frame_, lowest),
                    hi =
                        nearest::voxel_center(frame_, lowest + Vec3i{size - 1, size - 1, size - 1});
        const Vec3f middle = (lo + hi) * 0.5f;
        const double reach = 0.501 * static_cast<double>(length(hi - lo));
        const double distance = closest(middle, kInfinity, &s).exact_mm;
        out->clear();
        out->distance_hi = static_cast<float>(distance * 1.0001 + reach);
        Near near{this, vec_cast<double>(middle), {}};
        search(middle, static_cast<float>((distance + 2 * reach) * 1.001), &Engine::collect, &near);
        std::sort(near.triangles.begin(), near.triangles.end());
        const auto floats = static_cast<size_t>(ranges_.float_components);
        const auto ints = static_cast<size_t>(ranges_.int_components);
        for (const auto& [triangle, d] : near.triangles) {
            const auto p = static_cast<size_t>(detail(triangle).patch);
            out->add(static_cast<float>(std::max(0.0, d * 0.9999 - reach)),
                     {ranges_.float_lo.data() + p * floats, floats},
                     {ranges_.float_hi.data() + p * floats, floats},
                     {ranges_.int_lo.data() + p * ints, ints},
                     {ranges_.int_hi.data() + p * ints, ints});
        }
    }

  private:
    struct Found {
        nearest::Hit hit{kInfinity, 0, 0};
        int64_t triangle = -1;
        double exact_mm = kInfinity;

        int32_t patch(const Engine& engine) const {
            return triangle < 0 ? -1 : engine.detail(triangle).patch;
        }
    };
    struct Closest {
        const Engine* engine;
        Vec3f p;
        Found best;
    };
    struct Near {
        const Engine* engine;
        Vec3d p;
        std::vector<std::pair<int64_t, double>> triangles;  // with their distances
    };

    const nearest::TriangleDetail& detail(int64_t triangle) const { return details_[triangle]; }

    void make_scene(const std::vector<nearest::InputTriangle>& triangles) {
        device_ = rtcNewDevice(nullptr);
        scene_ = rtcNewScene(device_);
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* vertices = static_cast<float*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                    3 * sizeof(float), 3 * triangles.size()));
        auto* corners = static_cast<uint32_t*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    3 * sizeof(uint32_t), triangles.size()));
        for (size_t i = 0; i < 3 * triangles.size(); ++i) {
            const Vec3f& v = triangles[i / 3].v[i % 3];
            for (int a = 0; a < 3; ++a)
                *vertices++ = v[a];
            *corners++ = static_cast<uint32_t>(i);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
    }

    void search(const Vec3f& p, float radius, RTCPointQueryFunction visit, void* user) const {
        RTCPointQuery query{};
        query.x = p.x;
        query.y = p.y;
        query.z = p.z;
        query.radius = radius;
        RTCPointQueryContext context;
        rtcInitPointQueryContext(&context);
        rtcPointQuery(scene_, &query, &context, visit, user);
    }

    double exact_distance(int64_t triangle, const Vec3d& p) const {
        const nearest::TriangleFrame& f = frames_[triangle];
        const nearest::TriangleDetail& d = detail(triangle);
        const auto vec = [](const float* v) { return Vec3d{v[0], v[1], v[2]}; };
        return length(p - reference::closest_point(p, vec(f.v0), vec(d.v1), vec(d.v2)));
    }

    /// Returns the search radius if something is known to be at `exact_mm`: no triangle that may
    /// win in float is farther, including Embree's rounding.
    float reach(double exact_mm) const {
        return static_cast<float>(exact_mm + 4 * allowed_mm(exact_mm));
    }

    Found closest(const Vec3f& p, float radius_mm, EmbreeEngine::Scratch* scratch) const {
        float radius = reach(static_cast<double>(radius_mm));
        if (scratch->last >= 0)
            radius = std::min(radius, reach(exact_distance(scratch->last, vec_cast<double>(p))));
        Closest search_state{this, p, {}};
        search(p, radius, &Engine::visit, &search_state);
        Found best = search_state.best;
        if (best.triangle >= 0) scratch->last = best.triangle;
        return best.hit.distance2 <= radius_mm * radius_mm ? best : Found{};
    }

    static bool visit(RTCPointQueryFunctionArguments* args) {
        auto& s = *static_cast<Closest*>(args->userPtr);
        const auto triangle = static_cast<int64_t>(args->primID);
        const double exact = s.engine->exact_distance(triangle, vec_cast<double>(s.p));
        if (exact > s.best.exact_mm + 2 * s.engine->allowed_mm(s.best.exact_mm)) return false;
        const nearest::Hit hit =
            nearest::closest_point(s.engine->frames_[triangle], s.engine->detail(triangle), s.p);
        // Triangles are ordered by patch and index in the patch.
        if (hit.distance2 < s.best.hit.distance2 ||
            (hit.distance2 == s.best.hit.distance2 && triangle < s.best.triangle)) {
            s.best.hit = hit;
            s.best.triangle = triangle;
        }
        if (!(exact < s.best.exact_mm)) return false;
        s.best.exact_mm = exact;
        const float radius = s.engine->reach(exact);
        if (!(radius < args->query->radius)) return false;
        args->query->radius = radius;
        return true;
    }

    static bool collect(RTCPointQueryFunctionArguments* args) {
        auto& near = *static_cast<Near*>(args->userPtr);
        const auto triangle = static_cast<int64_t>(args->primID);
        near.triangles.emplace_back(triangle, near.engine->exact_distance(triangle, near.p));
        return false;
    }

    const surface::PatchRanges& ranges_;
    std::array<float, OPENFAB_FRAME_COUNT> frame_;
    std::vector<nearest::TriangleFrame> frames_;
    std::vector<nearest::TriangleDetail> details_;
    double largest_ = 0;
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
};

}  // namespace

std::unique_ptr<EmbreeEngine> make_embree_engine(
    const surface::Surface& surface, const std::array<float, OPENFAB_FRAME_COUNT>& frame) {
    return std::make_unique<Engine>(surface, frame);
}

}  // namespace openfab::testing
