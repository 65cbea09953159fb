// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>

#include "base/infinity.h"
#include "runtime/solid/beams/beam_engine.h"

namespace openfab::solid {

BeamAttributes::BeamAttributes(const part::PartBeams& source, const openfab_fablet& fablet) {
    for (size_t i = 0; i < source.attributes.size(); ++i) {
        const openfab_varying& input = fablet.nearest[i];
        const bool is_float = input.scalar == OPENFAB_FLOAT;
        for (int32_t k = 0; k < input.components; ++k) {
            Component c;
            c.is_bool = input.scalar == OPENFAB_BOOL;
            c.stride = static_cast<size_t>(input.components);
            float lo = kInfinity, hi = -kInfinity;
            if (source.attributes[i] >= 0) {
                const mesh::BeamAttribute& from =
                    source.beams->attributes[static_cast<size_t>(source.attributes[i])];
                if (is_float) {
                    c.values = from.values.data() + k;
                    for (size_t at = static_cast<size_t>(k); at < from.values.size();
                         at += c.stride) {
                        lo = std::min(lo, from.values[at]);
                        hi = std::max(hi, from.values[at]);
                    }
                } else {
                    c.values = from.ints.data() + k;
                }
            } else {
                c.otherwise = input.default_bits[k];
                lo = hi = std::bit_cast<float>(c.otherwise);
            }
            if (is_float) {
                float_lo_.push_back(lo);
                float_hi_.push_back(hi);
            }
            (is_float ? floats_ : ints_).push_back(c);
        }
    }
}

float BeamAttributes::value(const Component& c, int32_t node) {
    if (c.values == nullptr) return std::bit_cast<float>(c.otherwise);
    return static_cast<const float*>(c.values)[static_cast<size_t>(node) * c.stride];
}

uint32_t BeamAttributes::flat(const Component& c, int32_t beam) {
    if (c.values == nullptr) return c.otherwise;
    const int32_t v = static_cast<const int32_t*>(c.values)[static_cast<size_t>(beam) * c.stride];
    return c.is_bool ? (v != 0 ? 1u : 0u) : static_cast<uint32_t>(v);
}

void BeamAttributes::read(const BeamTree& tree, const std::array<float, OPENFAB_FRAME_COUNT>& frame,
                          const nearest::BlockAnswer& answer, const uint8_t* active,
                          const nearest::AttributeTargets& targets) const {
    const auto put = [](auto* const* arrays, size_t i, int32_t v, auto value) {
        if (arrays != nullptr && arrays[i] != nullptr) arrays[i][v] = value;
    };
    const bool steps = targets.gradients != nullptr;
    for (int32_t v = 0; v < nearest::kBlockVoxels; ++v) {
        const bool found =
            answer.item[v] >= 0 && (active == nullptr || (active[v >> 3] >> (v & 7) & 1) != 0);
        BeamSurfacePoint at;
        const BeamRecord* beam = nullptr;
        float step[3] = {};
        if (found) {
            beam = &tree.beams()[static_cast<size_t>(answer.item[v])];
            at = nearest_of_beam(*beam, answer.point_at(static_cast<size_t>(v)));
            for (size_t a = 0; steps && a < 3; ++a) {
                const size_t from = 3 * a;  // STEP_I, STEP_J, STEP_K
                step[a] = (at.share_step.x * frame[from] + at.share_step.y * frame[from + 1]) +
                          at.share_step.z * frame[from + 2];
            }
        }
        for (size_t c = 0; c < floats_.size(); ++c) {
            const float v0 = found ? value(floats_[c], beam->nodes[0]) : 0;
            const float rise = found ? value(floats_[c], beam->nodes[1]) - v0 : 0;
            put(targets.values, c, v, v0 + at.share * rise);
            for (size_t a = 0; steps && a < 3; ++a)
                put(targets.gradients, 3 * c + a, v, step[a] * rise);
        }
        for (size_t c = 0; c < ints_.size(); ++c)
            put(targets.flat, c, v, found ? flat(ints_[c], beam->number) : 0u);
    }
}

void BeamAttributes::read_points(const BeamTree& tree, const nearest::PointAnswer& answer,
                                 const nearest::PointTargets& targets) const {
    for (size_t l = 0; l < 8; ++l) {
        const bool found = answer.item[l] >= 0;
        BeamSurfacePoint at;
        const BeamRecord* beam = nullptr;
        if (found) {
            beam = &tree.beams()[static_cast<size_t>(answer.item[l])];
            at = nearest_of_beam(*beam, answer.point_at(l));
            at.position = answer.point_at(l);
        }
        for (int a = 0; a < 3; ++a) {
            if (targets.position[a] != nullptr) targets.position[a][l] = at.position[a];
            if (targets.normal[a] != nullptr) targets.normal[a][l] = at.normal[a];
        }
        for (size_t c = 0; targets.values != nullptr && c < floats_.size(); ++c) {
            if (targets.values[c] == nullptr) continue;
            const float v0 = found ? value(floats_[c], beam->nodes[0]) : 0;
            const float rise = found ? value(floats_[c], beam->nodes[1]) - v0 : 0;
            targets.values[c][l] = v0 + at.share * rise;
        }
        for (size_t c = 0; targets.flat != nullptr && c < ints_.size(); ++c) {
            if (targets.flat[c] != nullptr)
                targets.flat[c][l] = found ? flat(ints_[c], beam->number) : 0u;
        }
    }
}

void BeamAttributes::add_case(const BeamRecord& beam, float distance_lo,
                              nearest::BoxBounds* out) const {
    std::vector<float> lo, hi;
    std::vector<int32_t> ints;
    for (const Component& c : floats_) {
        // a + t (b - a) may be beyond b by what rounding adds.
        const float a = value(c, beam.nodes[0]), b = value(c, beam.nodes[1]);
        const float end = a + (b - a);
        lo.push_back(std::min({a, b, end}));
        hi.push_back(std::max({a, b, end}));
    }
    for (const Component& c : ints_)
        ints.push_back(static_cast<int32_t>(flat(c, beam.number)));
    out->add(distance_lo, lo, hi, ints, ints);
}

void BeamAttributes::add_all(float distance_lo, nearest::BoxBounds* out) const {
    const std::vector<int32_t> least(ints_.size(), INT32_MIN), most(ints_.size(), INT32_MAX);
    std::vector<float> lo = float_lo_, hi = float_hi_;
    for (size_t c = 0; c < lo.size(); ++c) {
        lo[c] = std::nextafter(lo[c], -kInfinity);
        hi[c] = std::nextafter(hi[c], kInfinity);
    }
    out->add(distance_lo, lo, hi, least, most);
}

}  // namespace openfab::solid
