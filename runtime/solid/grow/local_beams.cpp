// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/local_beams.h"

#include <algorithm>
#include <numeric>
#include <span>

namespace openfab::solid {

namespace {

/// Makes the attributes of @nearest inputs, in their order.
std::vector<mesh::BeamAttribute> empty_attributes(const openfab_fablet& fablet) {
    std::vector<mesh::BeamAttribute> out;
    for (int32_t i = 0; i < fablet.nearest_count; ++i) {
        mesh::BeamAttribute& attribute = out.emplace_back();
        attribute.name = fablet.nearest[i].name;
        attribute.is_int = fablet.nearest[i].scalar != OPENFAB_FLOAT;
        attribute.components = fablet.nearest[i].components;
    }
    return out;
}

/// Returns the places of the beams, or of the bodies, in the order in which they grow.
std::vector<uint32_t> order_of(const GatheredBeams& from, bool bodies, bool keep_order) {
    std::vector<uint32_t> order;
    for (uint32_t i = 0; i < from.beams.size(); ++i) {
        if ((from.beams[i].body >= 0) == bodies) order.push_back(i);
    }
    if (!keep_order) {
        std::ranges::sort(order, [&](uint32_t a, uint32_t b) {
            return grows_before(from.beams[a], from.beams[b]);
        });
    }
    return order;
}

}  // namespace

void LocalBeams::set(const GatheredBeams& from, const Vec3d& center_part_mm,
                     const openfab_fablet* fablet, bool keep_order) {
    attributes_ = nullptr;
    tree_ = nullptr;
    const std::vector<uint32_t> order = order_of(from, false, keep_order);
    const size_t all = from.beams.size(), n = order.size();
    if (n == 0) return;
    auto beams = std::make_shared<mesh::Beams>();
    if (fablet != nullptr) beams->attributes = empty_attributes(*fablet);
    beams->nodes.reserve(2 * n);
    beams->beams.reserve(n);
    const size_t floats = from.floats.size() / all, ints = from.ints.size() / all;
    for (const uint32_t i : order) {
        const GrownBeam& grown = from.beams[i];
        const auto node = static_cast<int32_t>(beams->nodes.size());
        mesh::Beam& beam = beams->beams.emplace_back();
        beam.nodes = {node, node + 1};
        beam.radii = grown.radius;
        if (grown.flat) beam.ends = {mesh::BeamEnd::kFlat, mesh::BeamEnd::kFlat};
        for (const Vec3f& end : grown.end)
            beams->nodes.push_back(vec_cast<double>(end));
        size_t number = i * floats, whole = i * ints;
        for (mesh::BeamAttribute& attribute : beams->attributes) {
            const auto count = static_cast<size_t>(attribute.components);
            if (attribute.is_int) {
                for (size_t k = 0; k < count; ++k)
                    attribute.ints.push_back(static_cast<int32_t>(from.ints[whole + k]));
                whole += count;
                continue;
            }
            for (size_t e = 0; e < 2; ++e) {
                for (size_t k = 0; k < count; ++k)
                    attribute.values.push_back(from.floats[number + e * (floats / 2) + k]);
            }
            number += count;
        }
    }
    source_.scale = 1;
    source_.center_part_mm = center_part_mm;
    source_.attributes.resize(beams->attributes.size());
    std::iota(source_.attributes.begin(), source_.attributes.end(), 0);
    source_.beams = std::move(beams);
    tree_ = std::make_unique<const BeamTree>(source_);
    if (fablet != nullptr) attributes_ = std::make_unique<const BeamAttributes>(source_, *fablet);
}

void LocalBodies::set(const GatheredBeams& from, const openfab_fablet* fablet, bool keep_order) {
    bodies_.clear();
    values_.clear();
    flat_.clear();
    floats_ = ints_ = 0;
    if (from.bodies.empty()) return;
    const size_t all = from.beams.size();
    const size_t floats = from.floats.size() / all, ints = from.ints.size() / all;
    std::vector<bool> is_bool;
    for (int32_t i = 0; fablet != nullptr && i < fablet->nearest_count; ++i) {
        const openfab_varying& input = fablet->nearest[i];
        if (input.scalar == OPENFAB_FLOAT) continue;
        is_bool.insert(is_bool.end(), static_cast<size_t>(input.components),
                       input.scalar == OPENFAB_BOOL);
    }
    floats_ = fablet == nullptr ? 0 : floats / 2;
    ints_ = is_bool.size();
    for (const uint32_t i : order_of(from, true, keep_order)) {
        const GrownBeam& place = from.beams[i];
        bodies_.push_back(
            {from.bodies[static_cast<size_t>(place.body)], {place.end[0], place.end[1]}, {}, i});
        for (size_t k = 0; k < floats_; ++k)
            values_.push_back(from.floats[i * floats + k]);
        for (size_t k = 0; k < ints_; ++k) {
            const uint32_t bits = from.ints[i * ints + k];
            flat_.push_back(is_bool[k] ? (bits != 0 ? 1u : 0u) : bits);
        }
    }
}

void LocalBodies::add_case(size_t body, float distance_lo, nearest::BoxBounds* out) const {
    const std::span<const float> floats(values_.data() + body * floats_, floats_);
    std::vector<int32_t> ints;
    for (size_t k = 0; k < ints_; ++k)
        ints.push_back(static_cast<int32_t>(flat_[body * ints_ + k]));
    out->add(distance_lo, floats, floats, ints, ints);
}

void LocalBodies::read(size_t body, size_t place, const nearest::AttributeTargets& targets) const {
    for (size_t k = 0; k < floats_; ++k) {
        if (targets.values != nullptr && targets.values[k] != nullptr)
            targets.values[k][place] = values_[body * floats_ + k];
        for (size_t a = 0; targets.gradients != nullptr && a < 3; ++a) {
            if (targets.gradients[3 * k + a] != nullptr) targets.gradients[3 * k + a][place] = 0;
        }
    }
    for (size_t k = 0; targets.flat != nullptr && k < ints_; ++k) {
        if (targets.flat[k] != nullptr) targets.flat[k][place] = flat_[body * ints_ + k];
    }
}

}  // namespace openfab::solid
