// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/point_order.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace openfab::volume {
namespace {

using nearest::PointAnswer;
using nearest::PointPacket;

constexpr size_t kPacketLanes = 8;
constexpr float kNowhere = std::numeric_limits<float>::infinity();

/// Calls visit(lane) for each bit of the mask.
template <typename Visit>
void each_lane(uint32_t mask, const Visit& visit) {
    for (uint32_t left = mask; left != 0; left &= left - 1)
        visit(static_cast<size_t>(std::countr_zero(left)));
}

/// The points that an engine answers have coordinates below this.
bool usable(float x) {
    return std::fabs(x) < nearest::kMaxCoordinate;
}

/// Spreads ten bits to every third.
uint32_t spread(uint32_t x) {
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

/// The range along one axis of the active lanes of packets, empty if there are none.
struct Range {
    float low = kNowhere, high = -kNowhere;
    void add(float x) {
        if (!usable(x)) return;
        low = std::min(low, x);
        high = std::max(high, x);
    }
};

}  // namespace

bool PointOrder::scattered(std::span<const PointPacket> points, float near_mm) {
    size_t scattered = 0;
    for (const PointPacket& packet : points) {
        bool apart = std::popcount(packet.mask) < 5;
        for (const auto& coordinates : packet.p) {
            Range range;
            each_lane(packet.mask, [&](size_t l) { range.add(coordinates[l]); });
            apart = apart || range.high - range.low > near_mm;
        }
        scattered += apart ? 1 : 0;
    }
    return scattered > points.size() / 4 && points.size() > 1;
}

std::span<const PointPacket> PointOrder::gather(std::span<const PointPacket> points) {
    Range range[3];
    size_t active = 0;
    for (const PointPacket& packet : points) {
        active += static_cast<size_t>(std::popcount(packet.mask));
        for (size_t a = 0; a < 3; ++a)
            each_lane(packet.mask, [&](size_t l) { range[a].add(packet.p[a][l]); });
    }
    float longest = 0;
    for (const Range& r : range)
        longest = std::max(longest, r.high - r.low);
    constexpr float kSteps = 1023;
    const float scale = longest > 0 ? kSteps / longest : 0;
    order_.clear();
    order_.reserve(active);
    for (size_t k = 0; k < points.size(); ++k) {
        each_lane(points[k].mask, [&](size_t l) {
            uint32_t key = 0;
            for (size_t a = 0; a < 3; ++a) {
                const float x = points[k].p[a][l];
                const float at = usable(x) ? std::min((x - range[a].low) * scale, kSteps) : 0;
                key |= spread(static_cast<uint32_t>(at)) << a;
            }
            order_.push_back(uint64_t{key} << 32 | (k * kPacketLanes + l));
        });
    }
    std::sort(order_.begin(), order_.end());
    packets_.resize((active + kPacketLanes - 1) / kPacketLanes);
    for (size_t i = 0; i < active; ++i) {
        const auto from = static_cast<uint32_t>(order_[i]);
        PointPacket& to = packets_[i / kPacketLanes];
        for (size_t a = 0; a < 3; ++a)
            to.p[a][i % kPacketLanes] = points[from / kPacketLanes].p[a][from % kPacketLanes];
        to.mask = (2u << (i % kPacketLanes)) - 1;
    }
    return packets_;
}

void PointOrder::scatter(std::span<const PointAnswer> gathered,
                         std::span<PointAnswer> answers) const {
    for (PointAnswer& none : answers) {
        none = {};
        std::fill_n(none.distance2, kPacketLanes, kNowhere);
        std::fill_n(none.item, kPacketLanes, -1);
    }
    for (size_t i = 0; i < order_.size(); ++i) {
        const auto number = static_cast<uint32_t>(order_[i]);
        PointAnswer& to = answers[number / kPacketLanes];
        const PointAnswer& from = gathered[i / kPacketLanes];
        const size_t l = number % kPacketLanes, f = i % kPacketLanes;
        to.distance2[l] = from.distance2[f];
        to.item[l] = from.item[f];
        // Or a point, of the same size.
        to.in_patch.triangle[l] = from.in_patch.triangle[f];
        to.in_patch.bary1[l] = from.in_patch.bary1[f];
        to.in_patch.bary2[l] = from.in_patch.bary2[f];
    }
}

}  // namespace openfab::volume
