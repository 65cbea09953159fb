// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/chunks.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>

#include "runtime/nearest/oriented.h"
#include "runtime/nearest/split.h"
#include "runtime/nearest/vertex_numbers.h"
#include "runtime/surface/curve.h"

namespace openfab::nearest {
namespace {

/// A chunk has no more triangles than these. Of fewer, more would lie around each chunk, which is
/// looked through for its ring; of more, a first slice would wait for more of what it does not
/// need. With so few, a tree is built without tasks (kParallel), as it must be under a lock.
constexpr size_t kMostTriangles = 1024;
/// A mesh of fewer is not worth it.
constexpr size_t kLeastTriangles = 512;
/// What is grouped into chunks: so many neighbours at most.
constexpr size_t kCellTriangles = 64;
/// Triangles that are longer than this, in the size of the whole, stand alone: the box of their
/// chunk would be large, too.
constexpr float kLarge = 1.0f / 8;

/// get(patch) of all patches, added up.
template <typename Sum, typename Add>
Sum over_all(const std::vector<surface::Patch>& patches, const Sum& none, const Add& add) {
    return tbb::parallel_reduce(
        tbb::blocked_range<size_t>(0, patches.size(), kParallel), none,
        [&](const auto& range, Sum sum) {
            for (size_t i = range.begin(); i < range.end(); ++i)
                add(patches[i], &sum);
            return sum;
        },
        [](Sum a, const Sum& b) {
            a.add(b);
            return a;
        });
}

struct Count {
    size_t n = 0;
    void add(const Count& other) { n += other.n; }
};

bool is_whole(const surface::Patch& patch) {
    return (patch.use & surface::kForQuery) != 0 && patch.kind == surface::PatchKind::kIdentity;
}

}  // namespace

Chunks::Chunks(const surface::Surface& surface, std::span<const uint64_t> along)
    : surface_(surface), first_id_(static_cast<int32_t>(surface.patches().size())) {
    const std::vector<surface::Patch>& all = surface.patches();
    whole_ = over_all(all, Box3f{}, [](const surface::Patch& patch, Box3f* sum) {
        if ((patch.use & surface::kForQuery) != 0 && !patch.bounds.empty()) sum->add(patch.bounds);
    });
    const float large = kLarge * whole_.longest_side();
    const Count fit = over_all(all, Count{}, [&](const surface::Patch& patch, Count* sum) {
        sum->n += is_whole(patch) && patch.bounds.longest_side() <= large ? 1 : 0;
    });
    const bool worth_it = fit.n >= kLeastTriangles;
    std::vector<uint64_t> found, kept;
    if (worth_it && along.empty()) along = found = surface::along_curve(all);
    if (!worth_it || fit.n < all.size()) along = kept = share_out(along, worth_it ? large : -1);
    if (!along.empty()) {
        group_cells(along, cut_cells(along));
        place_boxes();
    }
    made_ = std::make_unique<std::atomic<const Made*>[]>(count());
}

Chunks::~Chunks() {
    for (size_t c = 0; c < count(); ++c)
        delete made_[c].load();
}

/// Lists what is in no chunk: triangles that are larger, and other patches. Returns the rest of the
/// curve.
std::vector<uint64_t> Chunks::share_out(std::span<const uint64_t> along, float large) {
    const std::vector<surface::Patch>& all = surface_.patches();
    const auto fits = [&](const surface::Patch& patch) {
        return is_whole(patch) && patch.bounds.longest_side() <= large;
    };
    for (size_t i = 0; i < all.size(); ++i) {
        const auto patch = static_cast<int32_t>(i);
        std::array<Vec3f, 3> v;
        if (is_whole(all[i])) {
            if (!fits(all[i]) && surface_.identity_corners(patch, &v))
                triangles_.push_back({{v[0], v[1], v[2]}, patch, 0});
        } else if ((all[i].use & surface::kForQuery) != 0) {
            boxes_.push_back({all[i].bounds, patch});
        }
    }
    std::vector<uint64_t> rest;
    for (const uint64_t place : along) {
        if (fits(all[place & 0xffffffffu])) rest.push_back(place);
    }
    return rest;
}

/// Cells are cubes of the curve, halves or quarters of them, so that they are compact.
std::vector<Chunks::Cell> Chunks::cut_cells(std::span<const uint64_t> along) const {
    std::vector<Cell> cells;
    struct Span {
        size_t first, end;
        int bit;  ///< the highest place in which it may still be cut
    };
    std::vector<Span> left{{0, along.size(), surface::kCurveBits - 1}};
    while (!left.empty()) {
        const Span span = left.back();
        left.pop_back();
        if (span.end - span.first <= kCellTriangles) {
            if (span.first != span.end)
                cells.push_back(
                    {static_cast<uint32_t>(span.first), static_cast<uint32_t>(span.end)});
            continue;
        }
        size_t middle = span.first + (span.end - span.first) / 2;
        if (span.bit >= 0) {
            const auto begin = along.begin() + static_cast<std::ptrdiff_t>(span.first);
            const auto end = along.begin() + static_cast<std::ptrdiff_t>(span.end);
            const auto upper = [&](uint64_t item) { return (item >> (32 + span.bit) & 1u) == 0; };
            middle = static_cast<size_t>(std::partition_point(begin, end, upper) - along.begin());
        }
        left.push_back({middle, span.end, span.bit - 1});
        left.push_back({span.first, middle, span.bit - 1});
    }
    return cells;
}

/// Groups neighbouring cells, as a hierarchy over them would, into chunks.
void Chunks::group_cells(std::span<const uint64_t> along, const std::vector<Cell>& cells) {
    const std::vector<surface::Patch>& all = surface_.patches();
    std::vector<Item> items(cells.size());
    tbb::parallel_for(tbb::blocked_range<size_t>(0, cells.size(), 256), [&](const auto& range) {
        for (size_t c = range.begin(); c < range.end(); ++c) {
            Box3f box;
            for (size_t i = cells[c].first; i < cells[c].end; ++i)
                box.add(all[along[i] & 0xffffffffu].bounds);
            items[c] = {box.lo, static_cast<int32_t>(c), box.hi, cells[c].end - cells[c].first};
        }
    });
    struct Span {
        size_t first, end;
        Extent extent;
    };
    std::vector<std::pair<size_t, size_t>> groups;
    std::vector<Span> left{{0, items.size(), extent_of(items, 0, items.size())}};
    while (!left.empty()) {
        const Span span = left.back();
        left.pop_back();
        if (span.extent.weight <= kMostTriangles) {
            groups.emplace_back(span.first, span.end);
            first_cell_.push_back(first_cell_.back() +
                                  static_cast<uint32_t>(span.end - span.first));
            first_.push_back(first_.back() + static_cast<uint32_t>(span.extent.weight));
            continue;
        }
        Extent sides[2];
        const size_t middle = split_items(span.extent, span.first, span.end, &items, sides);
        left.push_back({middle, span.end, sides[1]});
        left.push_back({span.first, middle, sides[0]});
    }
    order_.resize(along.size());
    cells_.resize(items.size());
    tbb::parallel_for(size_t{0}, groups.size(), [&](size_t g) {
        uint32_t place = first_[g];
        CellBox* box = cells_.data() + first_cell_[g];
        for (size_t i = groups[g].first; i < groups[g].second; ++i) {
            const Cell& cell = cells[static_cast<size_t>(items[i].index)];
            *box++ = {items[i].box(), place, place + (cell.end - cell.first)};
            for (size_t k = cell.first; k < cell.end; ++k)
                order_[place++] = static_cast<int32_t>(along[k] & 0xffffffffu);
        }
    });
}

/// A close box around each chunk, along its principal axes.
void Chunks::place_boxes() {
    const std::vector<surface::Patch>& all = surface_.patches();
    float largest = 0;
    for (int a = 0; a < 3; ++a)
        largest = std::max({largest, std::abs(whole_.lo[a]), std::abs(whole_.hi[a])});
    // As for a node of the hierarchy: holds the rounding of axes and corners.
    const double margin = std::ldexp(static_cast<double>(largest), -21);
    corners_.resize(count());
    bounds_.resize(count());
    tbb::parallel_for(size_t{0}, count(), [&](size_t c) {
        const std::span<const int32_t> chunk = patches(first_id_ + static_cast<int32_t>(c));
        Moments moments;
        for (const int32_t patch : chunk) {
            const Vec3f middle = all[static_cast<size_t>(patch)].bounds.center();
            moments.add_point(vec_cast<double>(middle), 1);
        }
        const Along along(moments);
        Range spread;
        for (const int32_t patch : chunk) {
            std::array<Vec3f, 3> v;
            if (!surface_.identity_corners(patch, &v)) continue;
            for (const Vec3f& p : v) {
                spread.add(along.of(p));
                bounds_[c].add(p);
            }
        }
        if (bounds_[c].empty()) return;
        OrientedBox box = along.box(spread);
        for (int k = 0; k < 3; ++k) {
            box.lo[k] -= margin;
            box.hi[k] += margin;
        }
        corners_[c] = box.corners();
    });
    for (size_t c = 0; c < count(); ++c) {
        if (!bounds_[c].empty())
            boxes_.push_back({bounds_[c], first_id_ + static_cast<int32_t>(c), corners_[c].data()});
    }
}

void Chunks::forget_input() {
    triangles_ = {};
    boxes_ = {};
    corners_ = {};
}

size_t Chunks::bytes_to_come(size_t vertices) const {
    const size_t triangles = order_.size() - triangles_made_.load(std::memory_order_relaxed);
    if (triangles == 0) return 0;
    // Of a closed surface; of triangles that share nothing it is too many edges.
    const size_t edges = vertices + order_.size();
    const auto components =
        static_cast<size_t>(surface_.ranges().float_components + surface_.ranges().int_components);
    // Leaves hold three triangles or more, and are most of the nodes.
    const size_t all =
        order_.size() * (sizeof(TriangleFrame) + sizeof(TriangleDetail) +
                         (sizeof(Node) + sizeof(NodeCone) + sizeof(LeafFeatures)) / 2) +
        edges * sizeof(EdgeFeature) + vertices * sizeof(VertexFeature) +
        (order_.size() + edges + vertices) * HalfSpaces::kValues * sizeof(int16_t) +
        count() * (sizeof(Made) + 1024) + order_.size() * 8 * components;
    return static_cast<size_t>(static_cast<double>(all) * static_cast<double>(triangles) /
                               static_cast<double>(order_.size()));
}

std::vector<InputTriangle> Chunks::triangles_of(int32_t id) const {
    std::vector<InputTriangle> triangles;
    triangles.reserve(patches(id).size());
    for (const int32_t patch : patches(id)) {
        std::array<Vec3f, 3> v;
        if (surface_.identity_corners(patch, &v))
            triangles.push_back({{v[0], v[1], v[2]}, patch, 0});
    }
    return triangles;
}

/// The triangles of other chunks that share a vertex with those of a chunk.
std::vector<InputTriangle> Chunks::ring_around(int32_t id,
                                               const std::vector<InputTriangle>& chunk) const {
    VertexNumbers vertices(3 * chunk.size());
    for (const InputTriangle& t : chunk) {
        for (const Vec3f& p : t.v)
            vertices.add(p);
    }
    const auto self = static_cast<size_t>(id - first_id_);
    const auto touches = [&](const Box3f& box) {
        const std::span<const CellBox> own = cells_of(self);
        return box.overlaps(bounds_[self]) &&
               std::any_of(own.begin(), own.end(),
                           [&](const CellBox& cell) { return cell.box.overlaps(box); });
    };
    std::vector<InputTriangle> ring;
    for (size_t c = 0; c < count(); ++c) {
        if (c == self || !bounds_[c].overlaps(bounds_[self])) continue;
        for (const CellBox& cell : cells_of(c)) {
            if (!touches(cell.box)) continue;
            for (uint32_t i = cell.first; i < cell.end; ++i) {
                std::array<Vec3f, 3> v;
                if (!surface_.identity_corners(order_[i], &v)) continue;
                if (vertices.has(v[0]) || vertices.has(v[1]) || vertices.has(v[2]))
                    ring.push_back({{v[0], v[1], v[2]}, order_[i], 0});
            }
        }
    }
    return ring;
}

const TreeView* Chunks::make(int32_t id) const {
    const auto c = static_cast<size_t>(id - first_id_);
    // Nothing here may wait for tasks: this thread could take up one that needs this very chunk.
    const std::lock_guard lock(making_[c % making_.size()]);
    if (const Made* made = made_[c].load(std::memory_order_acquire)) return &made->view;
    const std::vector<InputTriangle> triangles = triangles_of(id);
    Tree tree = build_tree(triangles, {}, {whole_, ring_around(id, triangles)});
    NodeRanges ranges(tree, surface_.ranges(), nullptr);
    const size_t bytes = tree.bytes() + ranges.bytes();
    auto made = std::make_unique<Made>(Made{std::move(ranges), {}});
    if (!tree.nodes.empty()) made->view = trees_.keep(tree);
    made->view.ranges = &made->ranges;
    made_count_.fetch_add(1, std::memory_order_relaxed);
    bytes_made_.fetch_add(bytes, std::memory_order_relaxed);
    triangles_made_.fetch_add(patches(id).size(), std::memory_order_relaxed);
    const TreeView* view = &made->view;
    made_[c].store(made.release(), std::memory_order_release);
    return view;
}

}  // namespace openfab::nearest
