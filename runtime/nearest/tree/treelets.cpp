// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/treelets.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>

#include "runtime/nearest/tree/oriented.h"
#include "runtime/nearest/tree/split.h"
#include "runtime/nearest/tree/vertex_numbers.h"
#include "runtime/surface/morton_order.h"

namespace openfab::nearest {
namespace {

/// Maximum triangles of a treelet. Smaller ones have more neighbours to search for their one-ring;
/// larger ones delay the first slice by building what it does not need. A tree of this size is
/// built without tasks (kParallel), as it must be under a lock.
constexpr size_t kMaxTriangles = 1024;
/// Smaller meshes are not partitioned.
constexpr size_t kMinTriangles = 512;
/// Maximum triangles of a cell; treelets are made of cells.
constexpr size_t kCellTriangles = 64;
/// Triangles longer than this, relative to the whole, are in no treelet: its box would be large,
/// too.
constexpr float kLarge = 1.0f / 8;

/// Accumulates add(patch, &sum) over all patches, in parallel.
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

LazyTreelets::LazyTreelets(const surface::Surface& surface, std::span<const uint64_t> morton)
    : surface_(surface), first_id_(static_cast<int32_t>(surface.patches().size())) {
    const std::vector<surface::Patch>& all = surface.patches();
    whole_ = over_all(all, Box3f{}, [](const surface::Patch& patch, Box3f* sum) {
        if ((patch.use & surface::kForQuery) != 0 && !patch.bounds.empty()) sum->add(patch.bounds);
    });
    const float large = kLarge * whole_.longest_side();
    const Count fit = over_all(all, Count{}, [&](const surface::Patch& patch, Count* sum) {
        sum->n += is_whole(patch) && patch.bounds.longest_side() <= large ? 1 : 0;
    });
    const bool worth_it = fit.n >= kMinTriangles;
    std::vector<uint64_t> found, kept;
    if (worth_it && morton.empty()) morton = found = surface::morton_order(all);
    if (!worth_it || fit.n < all.size()) morton = kept = partition(morton, worth_it ? large : -1);
    if (!morton.empty()) {
        group_cells(morton, cut_cells(morton));
        place_boxes();
    }
    made_ = std::make_unique<std::atomic<const Treelet*>[]>(count());
}

LazyTreelets::~LazyTreelets() {
    for (size_t c = 0; c < count(); ++c)
        delete made_[c].load();
}

/// Lists what is in no treelet, large triangles and other patches. Returns the rest of the Morton
/// order.
std::vector<uint64_t> LazyTreelets::partition(std::span<const uint64_t> morton, float large) {
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
    for (const uint64_t item : morton) {
        if (fits(all[item & 0xffffffffu])) rest.push_back(item);
    }
    return rest;
}

/// Cuts the Morton order into cells: cubes, or halves or quarters of them, so that they are
/// compact.
std::vector<LazyTreelets::Cell> LazyTreelets::cut_cells(std::span<const uint64_t> morton) const {
    std::vector<Cell> cells;
    struct Span {
        size_t first, end;
        int bit;  ///< the highest bit by which it can still be cut
    };
    std::vector<Span> left{{0, morton.size(), surface::kMortonBits - 1}};
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
            const auto begin = morton.begin() + static_cast<std::ptrdiff_t>(span.first);
            const auto end = morton.begin() + static_cast<std::ptrdiff_t>(span.end);
            const auto upper = [&](uint64_t item) { return (item >> (32 + span.bit) & 1u) == 0; };
            middle = static_cast<size_t>(std::partition_point(begin, end, upper) - morton.begin());
        }
        left.push_back({middle, span.end, span.bit - 1});
        left.push_back({span.first, middle, span.bit - 1});
    }
    return cells;
}

/// Groups neighbouring cells into treelets, as a hierarchy over them would.
void LazyTreelets::group_cells(std::span<const uint64_t> morton, const std::vector<Cell>& cells) {
    const std::vector<surface::Patch>& all = surface_.patches();
    std::vector<Item> items(cells.size());
    tbb::parallel_for(tbb::blocked_range<size_t>(0, cells.size(), 256), [&](const auto& range) {
        for (size_t c = range.begin(); c < range.end(); ++c) {
            Box3f box;
            for (size_t i = cells[c].first; i < cells[c].end; ++i)
                box.add(all[morton[i] & 0xffffffffu].bounds);
            items[c] = {box.lo, static_cast<int32_t>(c), box.hi, cells[c].end - cells[c].first};
        }
    });
    struct Span {
        size_t first, end;
        Extent extent;
    };
    std::vector<std::pair<size_t, size_t>> spans;
    std::vector<Span> left{{0, items.size(), extent_of(items, 0, items.size())}};
    while (!left.empty()) {
        const Span span = left.back();
        left.pop_back();
        if (span.extent.weight <= kMaxTriangles) {
            spans.emplace_back(span.first, span.end);
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
    order_.resize(morton.size());
    cells_.resize(items.size());
    tbb::parallel_for(size_t{0}, spans.size(), [&](size_t g) {
        uint32_t index = first_[g];
        CellBox* box = cells_.data() + first_cell_[g];
        for (size_t i = spans[g].first; i < spans[g].second; ++i) {
            const Cell& cell = cells[items[i].index];
            *box++ = {items[i].box(), index, index + (cell.end - cell.first)};
            for (size_t k = cell.first; k < cell.end; ++k)
                order_[index++] = static_cast<int32_t>(morton[k] & 0xffffffffu);
        }
    });
}

/// Fits a box around each treelet, in its principal axes.
void LazyTreelets::place_boxes() {
    const std::vector<surface::Patch>& all = surface_.patches();
    float largest = 0;
    for (int a = 0; a < 3; ++a)
        largest = std::max({largest, std::abs(whole_.lo[a]), std::abs(whole_.hi[a])});
    // Holds the rounding of axes and corners, as for a node of the hierarchy.
    const double margin = std::ldexp(static_cast<double>(largest), -21);
    corners_.resize(count());
    bounds_.resize(count());
    tbb::parallel_for(size_t{0}, count(), [&](size_t c) {
        const std::span<const int32_t> treelet = patches(first_id_ + static_cast<int32_t>(c));
        Moments moments;
        for (const int32_t patch : treelet) {
            const Vec3f center = all[patch].bounds.center();
            moments.add_point(vec_cast<double>(center), 1);
        }
        const PrincipalFrame frame(moments);
        Range spread;
        for (const int32_t patch : treelet) {
            std::array<Vec3f, 3> v;
            if (!surface_.identity_corners(patch, &v)) continue;
            for (const Vec3f& p : v) {
                spread.add(frame.coordinates(p));
                bounds_[c].add(p);
            }
        }
        if (bounds_[c].empty()) return;
        corners_[c] = frame.box(spread).grown(margin).corners();
    });
    for (size_t c = 0; c < count(); ++c) {
        if (!bounds_[c].empty())
            boxes_.push_back({bounds_[c], first_id_ + static_cast<int32_t>(c), corners_[c].data()});
    }
}

void LazyTreelets::release_input() {
    triangles_ = {};
    boxes_ = {};
    corners_ = {};
}

size_t LazyTreelets::estimated_bytes(size_t vertices) const {
    const size_t triangles = order_.size() - triangles_made_.load(std::memory_order_relaxed);
    if (triangles == 0) return 0;
    // Exact for a closed surface; too many if triangles share nothing.
    const size_t edges = vertices + order_.size();
    const auto components =
        static_cast<size_t>(surface_.ranges().float_components + surface_.ranges().int_components);
    // Leaves hold three triangles or more, and are most of the nodes.
    const size_t all =
        order_.size() * (sizeof(TriangleFrame) + sizeof(TriangleDetail) +
                         (sizeof(Node) + sizeof(NodeCone) + sizeof(LeafFeatures)) / 2) +
        edges * sizeof(EdgeFeature) + vertices * sizeof(VertexFeature) +
        (order_.size() + edges + vertices) * HalfSpaces::kValues * sizeof(int16_t) +
        count() * (sizeof(Treelet) + 1024) + order_.size() * 8 * components;
    return static_cast<size_t>(static_cast<double>(all) * static_cast<double>(triangles) /
                               static_cast<double>(order_.size()));
}

std::vector<InputTriangle> LazyTreelets::triangles_of(int32_t id) const {
    std::vector<InputTriangle> triangles;
    triangles.reserve(patches(id).size());
    for (const int32_t patch : patches(id)) {
        std::array<Vec3f, 3> v;
        if (surface_.identity_corners(patch, &v))
            triangles.push_back({{v[0], v[1], v[2]}, patch, 0});
    }
    return triangles;
}

/// Finds the triangles of other treelets that share a vertex with those of a treelet.
std::vector<InputTriangle> LazyTreelets::one_ring_of(
    int32_t id, const std::vector<InputTriangle>& treelet) const {
    VertexNumbers vertices(3 * treelet.size());
    for (const InputTriangle& t : treelet) {
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
    std::vector<InputTriangle> one_ring;
    for (size_t c = 0; c < count(); ++c) {
        if (c == self || !bounds_[c].overlaps(bounds_[self])) continue;
        for (const CellBox& cell : cells_of(c)) {
            if (!touches(cell.box)) continue;
            for (uint32_t i = cell.first; i < cell.end; ++i) {
                std::array<Vec3f, 3> v;
                if (!surface_.identity_corners(order_[i], &v)) continue;
                if (vertices.has(v[0]) || vertices.has(v[1]) || vertices.has(v[2]))
                    one_ring.push_back({{v[0], v[1], v[2]}, order_[i], 0});
            }
        }
    }
    return one_ring;
}

const TreeView* LazyTreelets::make(int32_t id) const {
    const auto c = static_cast<size_t>(id - first_id_);
    // Nothing here may wait for tasks: this thread could start one that needs this very treelet.
    const std::lock_guard lock(making_[c % making_.size()]);
    if (const Treelet* made = made_[c].load(std::memory_order_acquire)) return &made->view;
    const std::vector<InputTriangle> triangles = triangles_of(id);
    Tree tree = build_tree(triangles, {}, {whole_, one_ring_of(id, triangles)});
    NodeRanges ranges(tree, surface_.ranges(), nullptr, nullptr);
    const size_t bytes = tree.bytes() + ranges.bytes();
    auto made = std::make_unique<Treelet>(Treelet{std::move(ranges), {}});
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
