// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/stretched/stretched_engine.h"

#include <cmath>
#include <vector>

#include "base/at.h"

namespace openfab::solid {

namespace {

using nearest::PointPacket;

/// More than what floats of a bound lose.
constexpr float kSlack = 0x1p-20f;

struct StretchedEngineScratch final : nearest::Engine::Scratch {
    explicit StretchedEngineScratch(nearest::Engine::Scratch* of) : source(of) {}

    nearest::Engine::Scratch* source;
    std::vector<PointPacket> points, hints;
};

class StretchedEngine final : public nearest::Engine {
  public:
    StretchedEngine(const Engine& source, const Stretch& stretch)
        : source_(source),
          stretch_(stretch),
          least_(static_cast<float>(stretch.least())),
          least2_(static_cast<float>(stretch.least() * stretch.least())) {}

    /// PlacedStretched makes them.
    std::unique_ptr<Scratch> make_scratch() const override { return nullptr; }

    void prepare(std::span<const Vec3i> blocks, Scratch* scratch) const override {
        const Asking asking(scratch);
        source_.prepare(blocks, asking.source);
    }
    void query(const nearest::BlockQuery& query, Scratch* scratch,
               nearest::BlockAnswer* answer) const override {
        const Asking asking(scratch);
        nearest::BlockQuery asked = query;
        asked.radius_mm /= least_;
        source_.query(asked, asking.source, answer);
        for (float& distance2 : answer->distance2)
            distance2 *= least2_;
    }
    void query_points(std::span<const PointPacket> packets, float radius_mm, Scratch* scratch,
                      nearest::PointAnswer* answers) const override {
        const Asking asking(scratch);
        source_.query_points(moved(packets, &asking.mine->points), radius_mm / least_,
                             asking.source, answers);
        for (size_t g = 0; g < packets.size() && !scratch->stopped(); ++g) {
            for (float& distance2 : answers[g].distance2)
                distance2 *= least2_;
        }
    }
    void bound_points(std::span<const PointPacket> packets, std::span<const PointPacket> hints,
                      float tolerance_mm, Scratch* scratch,
                      nearest::PointBounds* bounds) const override {
        const Asking asking(scratch);
        source_.bound_points(moved(packets, &asking.mine->points),
                             moved(hints, &asking.mine->hints), tolerance_mm / least_,
                             asking.source, bounds);
        for (size_t g = 0; g < packets.size(); ++g) {
            nearest::PointBounds& of = bounds[g];
            for (size_t l = 0; l < 8; ++l) {
                of.low[l] = low(of.low[l]);
                of.high[l] = high(of.high[l]);
                const Vec3f at = stretch_.to({of.point[0][l], of.point[1][l], of.point[2][l]});
                for (size_t a = 0; a < 3; ++a)
                    of.point[a][l] = at[static_cast<int>(a)];
            }
        }
    }
    const nearest::BlockPieces& pieces() const override { return source_.pieces(); }
    void bound_blocks(std::span<const Vec3i> blocks, Scratch* scratch,
                      nearest::BlockBounds* bounds) const override {
        const Asking asking(scratch);
        source_.bound_blocks(blocks, asking.source, bounds);
        for (size_t i = 0; i < blocks.size(); ++i) {
            for (float& bound : bounds[i].low)
                bound = low(bound);
            for (float& bound : bounds[i].high)
                bound = high(bound);
        }
    }
    void bounds(const Vec3i& lowest, int32_t size, Scratch* scratch,
                nearest::BoxBounds* out) const override {
        const Asking asking(scratch);
        source_.bounds(lowest, size, asking.source, out);
        out->distance_hi = high(out->distance_hi);
        for (int32_t i = 0; i < out->count; ++i) {
            float& distance_lo = at(out->cases, i).distance_lo;
            distance_lo = low(distance_lo);
        }
    }

  private:
    /// One call of the source.
    struct Asking {
        explicit Asking(Scratch* scratch)
            : mine(static_cast<StretchedEngineScratch*>(scratch)), source(mine->source) {
            source->stop = mine->stop;
        }
        ~Asking() { mine->counts = source->counts; }
        Asking(const Asking&) = delete;
        Asking& operator=(const Asking&) = delete;

        StretchedEngineScratch* mine;
        Scratch* source;
    };

    std::span<const PointPacket> moved(std::span<const PointPacket> packets,
                                       std::vector<PointPacket>* to) const {
        to->resize(packets.size());
        for (size_t g = 0; g < packets.size(); ++g)
            (*to)[g] = stretch_.back(packets[g]);
        return *to;
    }
    float low(float distance) const { return distance * least_ * (1 - kSlack); }
    float high(float distance) const { return distance * least_ * (1 + kSlack); }

    const Engine& source_;
    const Stretch stretch_;
    const float least_, least2_;
};

}  // namespace

PointPacket Stretch::back(const PointPacket& packet) const {
    PointPacket out = packet;
    for (size_t l = 0; l < 8; ++l) {
        const Vec3d p{packet.p[0][l], packet.p[1][l], packet.p[2][l]};
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) continue;
        const Vec3d q = back(p);
        for (size_t a = 0; a < 3; ++a)
            out.p[a][l] = static_cast<float>(q[static_cast<int>(a)]);
    }
    return out;
}

std::unique_ptr<nearest::Engine> make_stretched_engine(const nearest::Engine& source,
                                                       const Stretch& stretch) {
    return std::make_unique<StretchedEngine>(source, stretch);
}

std::unique_ptr<nearest::Engine::Scratch> make_stretched_scratch(nearest::Engine::Scratch* source) {
    return std::make_unique<StretchedEngineScratch>(source);
}

}  // namespace openfab::solid
