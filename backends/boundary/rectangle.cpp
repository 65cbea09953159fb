// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/boundary/rectangle.h"

namespace openfab::boundary {

Vec3i Rectangle::point(int32_t u2, int32_t v2) const {
    Vec3i p;
    p[axis] = 2 * plane;
    p[u_axis()] = u2;
    p[v_axis()] = v2;
    return p;
}

void Outline::clear() {
    for (std::vector<int32_t>* side : {&bottom, &top, &left, &right})
        side->clear();
}

void list_points(const Rectangle& rectangle, const Outline& outline, std::vector<Vec3i>* points) {
    points->clear();
    for (int32_t u : outline.bottom)
        points->push_back(rectangle.point(u, 2 * rectangle.v0));
    for (int32_t u : outline.top)
        points->push_back(rectangle.point(u, 2 * rectangle.v1));
    for (int32_t v : outline.left)
        points->push_back(rectangle.point(2 * rectangle.u0, v));
    for (int32_t v : outline.right)
        points->push_back(rectangle.point(2 * rectangle.u1, v));
}

void triangulate(const Outline& outline, std::vector<std::array<int32_t, 3>>* triangles) {
    triangles->clear();
    const auto bottoms = static_cast<int32_t>(outline.bottom.size());
    const auto tops = static_cast<int32_t>(outline.top.size());
    const int32_t top = bottoms, left = top + tops;
    const int32_t right = left + static_cast<int32_t>(outline.left.size());
    const int32_t end = right + static_cast<int32_t>(outline.right.size());
    // A fan over the left side, a strip between the rows, a fan over the right side. No fan has its
    // apex on the side that it covers.
    int32_t b = 0, t = 0;
    if (left < right) {
        int32_t below = 0;
        for (int32_t l = left; l < right; ++l) {
            triangles->push_back({below, 1, l});
            below = l;
        }
        triangles->push_back({below, 1, top});
        b = 1;
    }
    while (b + 1 < bottoms || t + 2 < tops) {
        const bool along_bottom =
            t + 2 >= tops || (b + 1 < bottoms && outline.bottom[static_cast<size_t>(b) + 1] <=
                                                     outline.top[static_cast<size_t>(t) + 1]);
        if (along_bottom) {
            triangles->push_back({b, b + 1, top + t});
            ++b;
        } else {
            triangles->push_back({b, top + t + 1, top + t});
            ++t;
        }
    }
    int32_t below = b;
    for (int32_t r = right; r < end; ++r) {
        triangles->push_back({top + t, below, r});
        below = r;
    }
    triangles->push_back({top + t, below, top + t + 1});
}

}  // namespace openfab::boundary
