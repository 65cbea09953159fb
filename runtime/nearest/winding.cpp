// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/winding.h"

#include <algorithm>
#include <cmath>

#include "runtime/nearest/exact.h"

namespace openfab::nearest {
namespace {

constexpr uint32_t kLeaf = 1u << 31;
constexpr uint32_t kFirst = (1u << 28) - 1;
constexpr size_t kMostInLeaf = 4;
/// Halving by count keeps a tree of 2^28 items this shallow.
constexpr size_t kDeepest = 64;

/// The sample lies above `lo` where it is not below it, and below `hi` only where it is: it is
/// moved up by an infinitesimal.
bool between(float at, float lo, float hi) {
    return at >= lo && at < hi;
}

/// Which side of the edge p -> q, seen along x, the moved sample is on: 0 only where the edge is a
/// point in (y, z).
int side_of_edge(const Vec3f& p, const Vec3f& q, const Vec3f& s) {
    const int sign = area_sign(p, q, s);
    if (sign != 0) return sign;
    if (q.z != p.z) return q.z < p.z ? 1 : -1;
    return q.y > p.y ? 1 : q.y < p.y ? -1 : 0;
}

/// What the triangle adds to the winding number of s: +1 where the ray leaves through it.
int32_t crossing(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& s) {
    const auto [y_lo, y_hi] = std::minmax({a.y, b.y, c.y});
    const auto [z_lo, z_hi] = std::minmax({a.z, b.z, c.z});
    if (!between(s.y, y_lo, y_hi) || !between(s.z, z_lo, z_hi)) return 0;
    const auto [x_lo, x_hi] = std::minmax({a.x, b.x, c.x});
    if (x_hi <= s.x) return 0;
    const int side = side_of_edge(a, b, s);
    if (side == 0 || side_of_edge(b, c, s) != side || side_of_edge(c, a, s) != side) return 0;
    // On the plane the moved sample is beyond it along x.
    if (x_lo <= s.x && volume_sign(a, b, c, s) != -side) return 0;
    return side;
}

}  // namespace

struct Winding::Item {
    Box3f box;
    int32_t patch;
    bool triangle;  ///< an identity patch; else diced on demand
};

Winding::Winding(const surface::Surface& surface, bool closed)
    : surface_(surface), closed_(closed) {
    std::vector<Item> items;
    const auto count = static_cast<int32_t>(surface.patches().size());
    for (int32_t p = 0; p < count; ++p) {
        const surface::Patch& patch = surface.patches()[static_cast<size_t>(p)];
        if ((patch.use & surface::kForCoverage) == 0 || patch.bounds.empty()) continue;
        items.push_back({patch.bounds, p, patch.kind == surface::PatchKind::kIdentity});
        for (int a = 0; a < 3; ++a) {
            largest_ =
                std::max({largest_, std::fabs(patch.bounds.lo[a]), std::fabs(patch.bounds.hi[a])});
        }
    }
    if (items.empty()) return;
    nodes_.reserve(2 * items.size());
    nodes_.emplace_back();
    build(0, items.data(), items.data() + items.size());
}

void Winding::build(size_t node, Item* first, Item* last) {
    Box3f box, centres;
    bool triangles = true;
    for (Item* i = first; i != last; ++i) {
        box.add(i->box);
        centres.add(i->box.center());
        triangles = triangles && i->triangle;
    }
    const auto count = static_cast<size_t>(last - first);
    uint32_t link = 0;
    if (count == 1 && !triangles) {
        link = kLeaf | static_cast<uint32_t>(first->patch);
    } else if (triangles && count <= kMostInLeaf) {
        const size_t begin = triangles_.size();
        box = {};
        for (Item* i = first; i != last; ++i) {
            const std::shared_ptr<const surface::MicroMesh> mesh = surface_.micro(i->patch);
            for (const std::array<int32_t, 3>& t : mesh->triangles) {
                const auto at = [&](size_t k) {
                    return mesh->positions[static_cast<size_t>(t[k])];
                };
                triangles_.push_back({at(0), at(1), at(2)});
                for (const Vec3f& v : triangles_.back())
                    box.add(v);
            }
        }
        // No triangle at all is an empty box, which no ray meets.
        link = kLeaf | static_cast<uint32_t>(triangles_.size() - begin) << 28 |
               static_cast<uint32_t>(begin);
    } else {
        const Vec3f extent = centres.size();
        const int axis = extent.z > extent.y ? 2 : 1;
        Item* middle = first + count / 2;
        std::nth_element(first, middle, last, [&](const Item& a, const Item& b) {
            const float ca = a.box.center()[axis], cb = b.box.center()[axis];
            return ca != cb ? ca < cb : a.patch < b.patch;
        });
        link = static_cast<uint32_t>(nodes_.size());
        nodes_.resize(nodes_.size() + 2);
        build(link, first, middle);
        build(link + 1, middle, last);
    }
    nodes_[node] = {box.lo.y, box.hi.y, box.lo.z, box.hi.z, box.hi.x, link};
}

int32_t Winding::number(const Vec3f& p) const {
    int32_t sum = 0;
    uint32_t stack[kDeepest];
    size_t waiting = 0;
    if (!nodes_.empty()) stack[waiting++] = 0;
    while (waiting != 0) {
        const Node& n = nodes_[stack[--waiting]];
        if (!between(p.y, n.y_lo, n.y_hi) || !between(p.z, n.z_lo, n.z_hi) || n.x_hi <= p.x)
            continue;
        if ((n.link & kLeaf) == 0) {
            stack[waiting++] = n.link;
            stack[waiting++] = n.link + 1;
            continue;
        }
        const uint32_t count = n.link >> 28 & 7u, first = n.link & kFirst;
        if (count == 0) {
            const std::shared_ptr<const surface::MicroMesh> mesh =
                surface_.micro(static_cast<int32_t>(first));
            const Vec3f* v = mesh->positions.data();
            for (const std::array<int32_t, 3>& t : mesh->triangles)
                sum += crossing(v[t[0]], v[t[1]], v[t[2]], p);
        }
        for (uint32_t i = first; i < first + count; ++i)
            sum += crossing(triangles_[i][0], triangles_[i][1], triangles_[i][2], p);
    }
    return sum;
}

bool Winding::one_side(const Vec3f& p, float distance, const Known& known) const {
    if (!(known.distance_mm >= 0)) return false;
    const Vec3f d = p - known.p;
    const float gap = std::sqrt(dot(d, d));
    float largest = largest_;
    for (int a = 0; a < 3; ++a)
        largest = std::max({largest, std::fabs(p[a]), std::fabs(known.p[a])});
    // Room for the rounding of distances and positions, as in kernel.inl.
    return gap * (1 + 0x1p-18f) + largest * 0x1p-18f < std::max(distance, known.distance_mm);
}

uint32_t Winding::inside(const PointGroup& group, const PointAnswer& answers,
                         const Centres& centres, Memory* memory) const {
    uint32_t result = 0;
    for (size_t l = 0; l < 8; ++l) {
        if ((group.mask >> l & 1u) == 0 || answers.patch[l] < 0) continue;
        const Vec3f p{group.p[0][l], group.p[1][l], group.p[2][l]};
        const float distance = std::sqrt(answers.distance2[l]);
        Known& mine = memory->known[l];
        const Known& beside = memory->known[l == 0 ? 7 : l - 1];
        bool inside = false;
        if (closed_ && one_side(p, distance, mine)) {
            inside = mine.inside;
        } else if (closed_ && one_side(p, distance, beside)) {
            inside = beside.inside;
        } else {
            Known centre;
            if ((centres.mask >> l & 1u) != 0) {
                const auto& at = centres.points->p;
                centre = {{at[0][l], at[1][l], at[2][l]}, 0, true};
            }
            inside =
                closed_ && one_side(p, distance - centres.slack_mm, centre) ? true : number(p) > 0;
        }
        mine = {p, distance, inside};
        if (inside) result |= 1u << l;
    }
    return result;
}

}  // namespace openfab::nearest
