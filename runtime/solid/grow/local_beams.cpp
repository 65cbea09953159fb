// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/local_beams.h"

#include <algorithm>
#include <numeric>

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

}  // namespace

void LocalBeams::set(const GatheredBeams& from, const Vec3d& center_part_mm,
                     const openfab_fablet* fablet, bool keep_order) {
    attributes_ = nullptr;
    tree_ = nullptr;
    const size_t n = from.beams.size();
    if (n == 0) return;
    std::vector<uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0u);
    if (!keep_order) {
        std::ranges::sort(order, [&](uint32_t a, uint32_t b) {
            return grows_before(from.beams[a], from.beams[b]);
        });
    }
    auto beams = std::make_shared<mesh::Beams>();
    if (fablet != nullptr) beams->attributes = empty_attributes(*fablet);
    beams->nodes.reserve(2 * n);
    beams->beams.reserve(n);
    const size_t floats = from.floats.size() / n, ints = from.ints.size() / n;
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

}  // namespace openfab::solid
