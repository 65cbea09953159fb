// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/engine/winding.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "base/infinity.h"
#include "runtime/nearest/engine/exact.h"
#include "simd/intrinsics.h"

namespace openfab::nearest {
namespace {

constexpr uint32_t kLeaf = 1u << 31;
constexpr uint32_t kFirst = (1u << 28) - 1;
constexpr size_t kMaxTrianglesInLeaf = 4;
/// Halving by count limits the depth of a tree of 2^28 items to this.
constexpr size_t kMaxDepth = 64;

/// Calls visit(lane) for each bit of the mask.
template <typename Visit>
void each_lane(uint32_t mask, const Visit& visit) {
    for (uint32_t left = mask; left != 0; left &= left - 1)
        visit(static_cast<size_t>(std::countr_zero(left)));
}

Vec3f point(const PointPacket& packet, size_t lane) {
    return {packet.p[0][lane], packet.p[1][lane], packet.p[2][lane]};
}

/// Returns the side of the edge p -> q, seen along x, on which the perturbed sample is: 0 only
/// where the edge is a point in (y, z).
int side_of_edge(const Vec3f& p, const Vec3f& q, const Vec3f& s) {
    const int sign = area_sign(p, q, s);
    if (sign != 0) return sign;
    if (q.z != p.z) return q.z < p.z ? 1 : -1;
    return q.y > p.y ? 1 : q.y < p.y ? -1 : 0;
}

/// Returns the triangle's contribution to the winding number of s: +1 where the ray leaves through
/// it. x_lo is the triangle's least x.
int32_t crossing(const Vec3f& a, const Vec3f& b, const Vec3f& c, float x_lo, const Vec3f& s) {
    const int side = side_of_edge(a, b, s);
    if (side == 0 || side_of_edge(b, c, s) != side || side_of_edge(c, a, s) != side) return 0;
    // A sample on the plane is perturbed beyond it along x.
    if (x_lo <= s.x && volume_sign(a, b, c, s) != -side) return 0;
    return side;
}

enum class Step { kPast, kIn, kOut, kUnsure };

/// Returns how the segment q -> p crosses the triangle. Certain only if it also holds for both
/// points perturbed by an infinitesimal.
Step step(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& q, const Vec3f& p) {
    const int from = volume_sign(a, b, c, q), to = volume_sign(a, b, c, p);
    if (from == to && from != 0) return Step::kPast;
    // The side of each edge on which the line through both points passes.
    const int e0 = volume_sign(q, p, a, b), e1 = volume_sign(q, p, b, c),
              e2 = volume_sign(q, p, c, a);
    const auto [least, most] = std::minmax({e0, e1, e2});
    if (least < 0 && most > 0) return Step::kPast;
    if (from == 0 || to == 0 || least != most) return Step::kUnsure;
    return from > 0 ? Step::kIn : Step::kOut;
}

}  // namespace

/// The paths to trace from the lanes of a packet: rays along +x, or segments from points with known
/// winding numbers.
struct Winding::Paths {
    const PointPacket& to;
    const PointPacket* from;  ///< null: rays
    alignas(16) float lo[3][8],
        hi[3][8];  ///< boxes of the lanes' paths; empty in inactive lanes
    Box3f all;
    Numbers sums{};       ///< of crossings
    uint32_t unsure = 0;  ///< lanes whose sum is uncertain

    Paths(const PointPacket& to_, const PointPacket* from_) : to(to_), from(from_) {
        std::fill_n(lo[0], 24, kInfinity);
        std::fill_n(hi[0], 24, -kInfinity);
        each_lane(to.mask, [&](size_t l) {
            Box3f box;
            box.add(point(to, l));
            if (from != nullptr) {
                box.add(point(*from, l));
            } else {
                box.hi.x = kInfinity;
            }
            all.add(box);
            for (int a = 0; a < 3; ++a)
                lo[a][l] = box.lo[a], hi[a][l] = box.hi[a];
        });
    }

    /// Returns the lanes whose path may meet something in the box.
    uint32_t meeting(const Box3f& box) const {
        if (!all.overlaps(box)) return 0;
        uint32_t result = 0;
        for (int half = 0; half < 8; half += 4) {
            __m128 apart = _mm_setzero_ps();
            for (int a = 0; a < 3; ++a) {
                const __m128 above =
                    _mm_cmpgt_ps(_mm_load_ps(lo[a] + half), _mm_set1_ps(box.hi[a]));
                const __m128 below =
                    _mm_cmplt_ps(_mm_load_ps(hi[a] + half), _mm_set1_ps(box.lo[a]));
                apart = _mm_or_ps(apart, _mm_or_ps(above, below));
            }
            result |= (~static_cast<uint32_t>(_mm_movemask_ps(apart)) & 0xfu) << half;
        }
        return result;
    }

    void cross(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
        Box3f box;
        box.add(a), box.add(b), box.add(c);
        each_lane(meeting(box), [&](size_t l) {
            if (from == nullptr) {
                sums[l] += crossing(a, b, c, box.lo.x, point(to, l));
                return;
            }
            const Step s = step(a, b, c, point(*from, l), point(to, l));
            if (s == Step::kUnsure) unsure |= 1u << l;
            sums[l] += s == Step::kIn ? 1 : s == Step::kOut ? -1 : 0;
        });
    }
};

struct Winding::Item {
    Box3f box;
    int32_t patch;
    bool triangle;  ///< an identity patch; else diced on demand
};

Winding::Winding(const surface::Surface& surface, bool closed)
    : surface_(surface), closed_(closed) {
    std::vector<Item> items;
    size_t diced = 0;
    const auto count = static_cast<int32_t>(surface.patches().size());
    for (int32_t p = 0; p < count; ++p) {
        const surface::Patch& patch = surface.patches()[p];
        if ((patch.use & surface::kForCoverage) == 0 || patch.bounds.empty()) continue;
        items.push_back({patch.bounds, p, patch.kind == surface::PatchKind::kIdentity});
        diced += items.back().triangle ? 0 : 1;
        for (int a = 0; a < 3; ++a) {
            largest_ =
                std::max({largest_, std::fabs(patch.bounds.lo[a]), std::fabs(patch.bounds.hi[a])});
        }
    }
    if (items.empty()) return;
    nodes_.reserve(2 * items.size());
    diced_.reserve(diced);
    nodes_.emplace_back();
    build(0, items.data(), items.data() + items.size());
}

void Winding::build(size_t node, Item* first, Item* last) {
    Box3f box, centers;
    bool triangles = true;
    for (Item* i = first; i != last; ++i) {
        box.add(i->box);
        centers.add(i->box.center());
        triangles = triangles && i->triangle;
    }
    const auto count = static_cast<size_t>(last - first);
    uint32_t link = 0;
    if (count == 1 && !triangles) {
        link = kLeaf | static_cast<uint32_t>(diced_.size());
        diced_.push_back({first->patch, kUnknown, {}});
    } else if (triangles && count <= kMaxTrianglesInLeaf) {
        const size_t begin = triangles_.size();
        box = {};
        for (Item* i = first; i != last; ++i) {
            const std::shared_ptr<const surface::MicroMesh> mesh = surface_.micro(i->patch);
            for (const std::array<int32_t, 3>& t : mesh->triangles) {
                const auto at = [&](size_t k) { return mesh->positions[t[k]]; };
                triangles_.push_back({at(0), at(1), at(2)});
                for (const Vec3f& v : triangles_.back())
                    box.add(v);
            }
        }
        // Without triangles the box is empty, and no path meets it.
        link = kLeaf | static_cast<uint32_t>(triangles_.size() - begin) << 28 |
               static_cast<uint32_t>(begin);
    } else {
        // Splits along x do not help rays, but do help segments among diced patches.
        const Vec3f extent = centers.size();
        int axis = extent.z > extent.y ? 2 : 1;
        if (!triangles && extent.x > extent[axis]) axis = 0;
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
    nodes_[node] = {box, link};
}

/// Adds the paths' crossings with one diced patch.
void Winding::follow(size_t index, Paths* paths, TriangleRuns* runs) const {
    Diced& diced = diced_[index];
    const std::atomic_ref<uint8_t> state(diced.state);
    const bool known = state.load(std::memory_order_acquire) == kKnown;
    if (known && paths->meeting(diced.box) == 0) return;
    std::shared_ptr<const surface::MicroMesh> mesh;
    const std::vector<Box3f>& boxes = runs->of(surface_, diced.patch, &mesh);
    if (uint8_t unknown = kUnknown;
        !known && state.compare_exchange_strong(unknown, kBeingWritten)) {
        for (const Box3f& box : boxes)
            diced.box.add(box);
        state.store(kKnown, std::memory_order_release);
    }
    for (size_t run = 0; run < boxes.size(); ++run) {
        if (paths->meeting(boxes[run]) == 0) continue;
        if (mesh == nullptr) mesh = surface_.micro(diced.patch);
        const Vec3f* v = mesh->positions.data();
        const size_t end = std::min((run + 1) * TriangleRuns::kTriangles, mesh->triangles.size());
        for (size_t t = run * TriangleRuns::kTriangles; t < end; ++t) {
            const std::array<int32_t, 3>& corner = mesh->triangles[t];
            paths->cross(v[corner[0]], v[corner[1]], v[corner[2]]);
        }
    }
}

void Winding::follow(Paths* paths, TriangleRuns* runs) const {
    uint32_t stack[kMaxDepth];
    size_t waiting = 0;
    if (!nodes_.empty()) stack[waiting++] = 0;
    while (waiting != 0) {
        const Node& n = nodes_[stack[--waiting]];
        if (paths->meeting(n.box) == 0) continue;
        if ((n.link & kLeaf) == 0) {
            stack[waiting++] = n.link;
            stack[waiting++] = n.link + 1;
            continue;
        }
        const uint32_t count = n.link >> 28 & 7u, first = n.link & kFirst;
        if (count == 0) follow(size_t{first}, paths, runs);
        for (uint32_t i = first; i < first + count; ++i)
            paths->cross(triangles_[i][0], triangles_[i][1], triangles_[i][2]);
    }
}

int32_t Winding::number(const Vec3f& p) const {
    PointPacket one;
    for (int a = 0; a < 3; ++a)
        one.p[a][0] = p[a];
    one.mask = 1;
    Paths ray(one, nullptr);
    TriangleRuns runs;
    follow(&ray, &runs);
    return ray.sums[0];
}

/// Computes the active lanes: by a segment from the closest point with a known number if that is
/// shorter than the ray, and by the ray if the segment is undecided.
Winding::Numbers Winding::numbers(const PointPacket& packet, const std::array<Known, 8>& known,
                                  TriangleRuns* runs) const {
    Numbers result{};
    PointPacket by_ray = packet, by_segment = packet, from;
    by_segment.mask = 0;
    const bool segments = closed_ && !diced_.empty();
    each_lane(segments ? packet.mask : 0, [&](size_t l) {
        const Vec3f p = point(packet, l);
        const float ray = std::max(nodes_[0].box.hi.x - p.x, 0.0f);
        float least2 = ray * ray;
        for (const Known& k : known) {
            const float d2 = dot(p - k.p, p - k.p);
            if (!(k.distance_mm >= 0) || k.number == kAboveZero || !(d2 < least2)) continue;
            least2 = d2;
            for (int a = 0; a < 3; ++a)
                from.p[a][l] = k.p[a];
            result[l] = k.number;
            by_segment.mask |= 1u << l;
        }
    });
    if (by_segment.mask != 0) {
        Paths paths(by_segment, &from);
        follow(&paths, runs);
        each_lane(by_segment.mask, [&](size_t l) { result[l] += paths.sums[l]; });
        by_ray.mask &= ~by_segment.mask | paths.unsure;
    }
    if (by_ray.mask != 0) {
        Paths paths(by_ray, nullptr);
        follow(&paths, runs);
        each_lane(by_ray.mask, [&](size_t l) { result[l] = paths.sums[l]; });
    }
    return result;
}

bool Winding::one_side(const Vec3f& p, float distance, const Known& known) const {
    if (!(known.distance_mm >= 0)) return false;
    const Vec3f d = p - known.p;
    const float gap = std::sqrt(dot(d, d));
    float largest = largest_;
    for (int a = 0; a < 3; ++a)
        largest = std::max({largest, std::fabs(p[a]), std::fabs(known.p[a])});
    // Margin for the rounding of distances and positions, as in kernel/kernel_table.h.
    return gap * (1 + 0x1p-18f) + largest * 0x1p-18f < std::max(distance, known.distance_mm);
}

uint32_t Winding::inside(const PointPacket& packet, const PointAnswer& answers,
                         const Centers& centers, Memory* memory) const {
    const std::array<Known, 8> before = memory->known;
    PointPacket asking = packet;  // lanes whose number does not follow from known ones
    asking.mask = 0;
    uint32_t followers = 0;  // that share the number of the previous lane, which is still unknown
    uint32_t answered = 0;
    for (size_t l = 0; l < 8; ++l) {
        if ((packet.mask >> l & 1u) == 0 || answers.item[l] < 0) continue;
        answered |= 1u << l;
        const Vec3f p = point(packet, l);
        const float distance = std::sqrt(answers.distance2[l]);
        Known& mine = memory->known[l];
        const Known& beside = memory->known[l == 0 ? 7 : l - 1];
        Known center;
        if ((centers.mask >> l & 1u) != 0) center = {point(*centers.points, l), 0, kAboveZero};
        int32_t number = 0;
        if (closed_ && one_side(p, distance, mine)) {
            number = mine.number;
        } else if (closed_ && one_side(p, distance, beside)) {
            number = beside.number;
            if (l != 0 && ((asking.mask | followers) >> (l - 1) & 1u) != 0) followers |= 1u << l;
        } else if (closed_ && one_side(p, distance - centers.slack_mm, center)) {
            number = kAboveZero;
        } else {
            asking.mask |= 1u << l;
        }
        mine = {p, distance, number};
    }
    Numbers found{};
    if (asking.mask != 0) found = numbers(asking, before, &memory->runs);
    uint32_t result = 0;
    each_lane(answered, [&](size_t l) {
        int32_t& number = memory->known[l].number;
        if ((asking.mask >> l & 1u) != 0) number = found[l];
        if ((followers >> l & 1u) != 0) number = memory->known[l - 1].number;
        if (number > 0) result |= 1u << l;
    });
    return result;
}

}  // namespace openfab::nearest
