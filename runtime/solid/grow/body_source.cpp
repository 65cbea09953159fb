// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/body_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace openfab::solid {

namespace {

// Of diced bodies: a shape's mostly.
constexpr size_t kTreeBytes = 32u << 20;

}  // namespace

BodySource::BodySource(const part::ShapeStage& stage, const Bodies& bodies, openfab_isa isa)
    : queries_{isa, nearest::make_patch_cache(kTreeBytes)} {
    for (size_t i = 0; i < bodies.size(); ++i) {
        standing_.push_back(nullptr);
        if (bodies[i] != nullptr)
            standing_.back() =
                std::make_shared<const Standing>(stage.bodies[i], bodies[i], queries_);
    }
}

Result<void> BodySource::status() const {
    for (const auto& one : standing_) {
        if (one == nullptr) continue;
        if (Result<void> fine = one->solid().status(); !fine) return fine;
    }
    return {};
}

void BodySource::set_stop(const std::atomic<bool>* stop) const {
    for (const auto& one : standing_) {
        if (one != nullptr) one->solid().set_stop(stop);
    }
}

size_t BodySource::share_bytes(size_t bytes) const {
    std::vector<const Dicing*> dicing;
    for (const auto& one : standing_) {
        if (one != nullptr && one->solid().dicing() != nullptr)
            dicing.push_back(one->solid().dicing());
    }
    for (const Dicing* one : dicing)
        one->set_cache_bytes(bytes / 2 / dicing.size());
    return dicing.empty() ? bytes : bytes / 2;
}

bool BodySource::holds(const Box3f& outer, const Box3f& inner) {
    for (int a = 0; a < 3; ++a) {
        const float slack = std::max(std::fabs(outer.lo[a]), std::fabs(outer.hi[a])) * 0x1p-18f;
        if (!(inner.lo[a] >= outer.lo[a] - slack && inner.hi[a] <= outer.hi[a] + slack))
            return false;
    }
    return true;
}

std::string BodySource::text(const Vec3f& p) {
    const auto plain = [](float x) { return std::fabs(x) < 1e-9f ? 0.0f : x; };
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", plain(p.x), plain(p.y), plain(p.z));
}

}  // namespace openfab::solid
