// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/micro/nearest/embree_baseline.h"

#include <embree3/rtcore.h>

#include <cstring>
#include <limits>

namespace openfab::bench {
namespace {

struct Vec {
    float x, y, z;
};
inline Vec operator-(Vec a, Vec b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec operator+(Vec a, Vec b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec operator*(float s, Vec a) {
    return {s * a.x, s * a.y, s * a.z};
}
inline float dot(Vec a, Vec b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Closest point on a triangle by Voronoi regions (Ericson 2005, 5.1.5).
inline Vec closest_point(Vec p, Vec a, Vec b, Vec c) {
    const Vec ab = b - a, ac = c - a, ap = p - a;
    const float d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0.0f && d2 <= 0.0f) return a;
    const Vec bp = p - b;
    const float d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0.0f && d4 <= d3) return b;
    const Vec cp = p - c;
    const float d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0.0f && d5 <= d6) return c;
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0f && d1 >= 0.0f && d3 <= 0.0f) return a + (d1 / (d1 - d3)) * ab;
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0f && d2 >= 0.0f && d6 <= 0.0f) return a + (d2 / (d2 - d6)) * ac;
    const float va = d3 * d6 - d5 * d4;
    if (va <= 0.0f && (d4 - d3) >= 0.0f && (d5 - d6) >= 0.0f) {
        return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
    }
    const float denominator = 1.0f / (va + vb + vc);
    return a + (vb * denominator) * ab + (vc * denominator) * ac;
}

struct State {
    const Vec* positions;
    const uint32_t* triangles;
    EmbreeHit* hit;
};

bool visit(RTCPointQueryFunctionArguments* args) {
    State& state = *static_cast<State*>(args->userPtr);
    const uint32_t* t = state.triangles + 3 * static_cast<size_t>(args->primID);
    const Vec p{args->query->x, args->query->y, args->query->z};
    const Vec q =
        closest_point(p, state.positions[t[0]], state.positions[t[1]], state.positions[t[2]]);
    const Vec d = p - q;
    const float distance2 = dot(d, d);
    if (!(distance2 < state.hit->distance2)) return false;
    *state.hit = {distance2, args->primID, {q.x, q.y, q.z}};
    const float distance = __builtin_sqrtf(distance2);
    if (!(distance < args->query->radius)) return false;
    args->query->radius = distance;
    return true;
}

}  // namespace

struct EmbreeBaseline::Impl {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    std::vector<Vec> positions;
    std::vector<uint32_t> triangles;
};

EmbreeBaseline::EmbreeBaseline(const std::vector<float>& positions,
                               const std::vector<uint32_t>& triangles)
    : impl_(std::make_unique<Impl>()) {
    impl_->device = rtcNewDevice("threads=1");
    impl_->positions.resize(positions.size() / 3 + 1);  // Embree reads 16 bytes at the last vertex
    std::memcpy(impl_->positions.data(), positions.data(), positions.size() * sizeof(float));
    impl_->triangles = triangles;
    RTCGeometry geometry = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               impl_->positions.data(), 0, sizeof(Vec), positions.size() / 3);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               impl_->triangles.data(), 0, 3 * sizeof(uint32_t),
                               triangles.size() / 3);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(geometry);
    impl_->scene = rtcNewScene(impl_->device);
    rtcSetSceneBuildQuality(impl_->scene, RTC_BUILD_QUALITY_HIGH);
    rtcSetSceneFlags(impl_->scene, RTC_SCENE_FLAG_NONE);
    rtcAttachGeometry(impl_->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(impl_->scene);
}

EmbreeBaseline::~EmbreeBaseline() {
    rtcReleaseScene(impl_->scene);
    rtcReleaseDevice(impl_->device);
}

bool EmbreeBaseline::query(const float point[3], float radius, EmbreeHit* hit) const {
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    RTCPointQuery query;
    query.x = point[0];
    query.y = point[1];
    query.z = point[2];
    query.time = 0;
    query.radius = radius;
    hit->distance2 = std::numeric_limits<float>::infinity();
    State state{impl_->positions.data(), impl_->triangles.data(), hit};
    rtcPointQuery(impl_->scene, &query, &context, visit, &state);
    return hit->distance2 < std::numeric_limits<float>::infinity();
}

}  // namespace openfab::bench
