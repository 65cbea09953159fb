// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "deformation/refine.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace openfab::deformation {

namespace {

using Triangle = std::array<int32_t, 3>;

uint64_t key_of(int32_t a, int32_t b) {
    const auto [low, high] = std::minmax(a, b);
    return static_cast<uint64_t>(static_cast<uint32_t>(low)) << 32 | static_cast<uint32_t>(high);
}

/// The middles of edges, by their ends.
template <typename Make>
class Middles {
  public:
    explicit Middles(Make make) : make_(std::move(make)) {}
    int32_t of(int32_t a, int32_t b) {
        const auto [known, fresh] = middles_.try_emplace(key_of(a, b), 0);
        if (fresh) known->second = make_(std::min(a, b), std::max(a, b));
        return known->second;
    }

  private:
    Make make_;
    std::unordered_map<uint64_t, int32_t> middles_;
};

/// Divides a triangle whose edge i, from corner i to the next, has the middle m[i], or -1. Sets the
/// corners of the new ones as numbers: 0 to 2 the old, 3 to 5 the middles.
int parts_of(const std::array<bool, 3>& split, std::array<Triangle, 4>* parts) {
    const int count = split[0] + split[1] + split[2];
    if (count == 0) {
        (*parts)[0] = {0, 1, 2};
        return 1;
    }
    if (count == 3) {
        *parts = {Triangle{0, 3, 5}, Triangle{3, 1, 4}, Triangle{5, 4, 2}, Triangle{3, 4, 5}};
        return 4;
    }
    // Turned so that the edge that is divided alone, or the one that is not, comes first.
    int32_t first = 0;
    while (split[static_cast<size_t>(first)] != (count == 1))
        ++first;
    const int32_t a = first, b = (first + 1) % 3, c = (first + 2) % 3;
    if (count == 1) {
        (*parts)[0] = {a, 3 + a, c};
        (*parts)[1] = {3 + a, b, c};
        return 2;
    }
    (*parts)[0] = {3 + b, c, 3 + c};
    (*parts)[1] = {a, b, 3 + b};
    (*parts)[2] = {a, 3 + b, 3 + c};
    return 3;
}

}  // namespace

std::optional<std::vector<int32_t>> refine(double longest_mm, size_t most, Surface* surface) {
    std::vector<int32_t> from(surface->triangles.size());
    std::iota(from.begin(), from.end(), 0);
    std::vector<Vec3d>& positions = surface->positions;
    const auto is_long = [&](int32_t a, int32_t b) {
        const Vec3d d = positions[static_cast<size_t>(a)] - positions[static_cast<size_t>(b)];
        return d.x * d.x + d.y * d.y + d.z * d.z > longest_mm * longest_mm;
    };
    for (bool any = true; any;) {
        any = false;
        Middles places([&](int32_t a, int32_t b) {
            positions.push_back(
                (positions[static_cast<size_t>(a)] + positions[static_cast<size_t>(b)]) * 0.5);
            return static_cast<int32_t>(positions.size() - 1);
        });
        std::vector<std::array<bool, 3>> splits(surface->triangles.size());
        size_t count = 0;
        for (size_t i = 0; i < splits.size(); ++i) {
            const Triangle& t = surface->triangles[i];
            count += 1;
            for (size_t e = 0; e < 3; ++e) {
                splits[i][e] = is_long(t[e], t[(e + 1) % 3]);
                count += splits[i][e] ? 1 : 0;
                any |= splits[i][e];
            }
        }
        if (count > most) return std::nullopt;
        if (!any) break;
        const auto divide = [&](std::vector<Triangle>* triangles, auto&& middle) {
            std::vector<Triangle> out;
            out.reserve(count);
            std::array<Triangle, 4> parts;
            for (size_t i = 0; i < splits.size(); ++i) {
                const Triangle& t = (*triangles)[i];
                std::array<int32_t, 6> corners{t[0], t[1], t[2], -1, -1, -1};
                for (size_t e = 0; e < 3; ++e) {
                    if (splits[i][e]) corners[3 + e] = middle(t[e], t[(e + 1) % 3]);
                }
                const int made = parts_of(splits[i], &parts);
                for (int p = 0; p < made; ++p) {
                    Triangle one = parts[static_cast<size_t>(p)];
                    for (int32_t& corner : one)
                        corner = corners[static_cast<size_t>(corner)];
                    out.push_back(one);
                }
            }
            *triangles = std::move(out);
        };
        for (Surface::Attribute& attribute : surface->attributes) {
            const auto components = static_cast<size_t>(attribute.components);
            Middles values([&](int32_t a, int32_t b) {
                std::vector<float>& all = attribute.values;
                const auto made = static_cast<int32_t>(all.size() / components);
                for (size_t c = 0; c < components; ++c) {
                    all.push_back(0.5f * (all[static_cast<size_t>(a) * components + c] +
                                          all[static_cast<size_t>(b) * components + c]));
                }
                return made;
            });
            divide(&attribute.corners, [&](int32_t a, int32_t b) { return values.of(a, b); });
        }
        std::vector<int32_t> whose;
        whose.reserve(count);
        std::array<Triangle, 4> ignored;
        for (size_t i = 0; i < splits.size(); ++i)
            whose.insert(whose.end(), static_cast<size_t>(parts_of(splits[i], &ignored)), from[i]);
        from = std::move(whose);
        divide(&surface->triangles, [&](int32_t a, int32_t b) { return places.of(a, b); });
    }
    return from;
}

}  // namespace openfab::deformation
