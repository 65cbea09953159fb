// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/hierarchy.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>

#include "runtime/nearest/tree/oriented.h"
#include "runtime/nearest/tree/split.h"

namespace openfab::nearest {
namespace {

class Builder {
  public:
    Builder(const std::vector<InputTriangle>& triangles, const std::vector<InputPatch>& patches,
            const TreeSurroundings& around)
        : triangles_(triangles), patches_(patches), around_(around), whole_(around.whole) {}

    Tree build() {
        Tree tree;
        make_items();
        if (items_.empty()) return tree;
        const Extent all = extent_of(items_, 0, items_.size());
        whole_.add(all.boxes.box());
        for (int a = 0; a < 3; ++a)
            largest_ = std::max({largest_, std::abs(whole_.lo[a]), std::abs(whole_.hi[a])});
        // Not cleared: unused pages are never touched.
        const auto nodes = std::make_unique_for_overwrite<Node[]>(2 * items_.size());
        nodes_ = nodes.get();
        build_node(0, 0, items_.size(), all);
        const auto copy_nodes = [&] { tree.nodes.assign(nodes_, nodes_ + used_); };
        const auto size_frames = [&] { tree.frames.resize(triangles_.size()); };
        const auto size_details = [&] { tree.details.resize(triangles_.size()); };
        if (items_.size() > kParallel) {
            tbb::parallel_invoke(copy_nodes, size_frames, size_details);
        } else {
            copy_nodes();
            size_frames();
            size_details();
        }
        nodes_ = tree.nodes.data();
        make_triangles(&tree);
        const TriangleList one_ring = make_one_ring();
        Features features = make_features(tree.frames, tree.details, one_ring);
        tree.cones =
            around_.diced ? std::vector<NodeCone>(tree.nodes.size()) : make_cones(tree, features);
        make_leaf_features(features, &tree);
        tree.edges = std::move(features.edges);
        tree.vertices = std::move(features.vertices);
        tree.largest_coordinate = largest_;
        tree.spacing = spacing(tree.nodes[0]);
        tree.longest_edge = std::max(longest_edge(tree.details), longest_edge(one_ring.details));
        return tree;
    }

  private:
    /// Estimates the spacing of triangles as if they were spread over the largest side of the
    /// root's box.
    float spacing(const Node& all) const {
        if (triangles_.empty()) return 0;
        const float* h = all.half;
        const float side = 4 * std::max({h[0] * h[1], h[1] * h[2], h[2] * h[0]});
        return std::sqrt(side / static_cast<float>(triangles_.size()));
    }

    void make_items() {
        items_.resize(triangles_.size());
        for_all(triangles_.size(), [&](size_t i) {
            Box3f box;
            for (const Vec3f& v : triangles_[i].v)
                box.add(v);
            items_[i] = {box.lo, static_cast<int32_t>(i), box.hi, 1};
        });
        for (size_t i = 0; i < patches_.size(); ++i) {
            const Box3f& box = patches_[i].bounds;
            if (!box.empty()) items_.push_back({box.lo, ~static_cast<int32_t>(i), box.hi, 1});
        }
    }

    static bool is_patch(const Item& item) { return item.index < 0; }
    const InputTriangle& triangle(const Item& item) const { return triangles_[item.index]; }
    const InputPatch& patch(const Item& item) const {
        return patches_[static_cast<size_t>(~item.index)];
    }

    /// Calls each(i) for all i below `count`. Small loops stay in this thread, which may hold a
    /// lock (tree/treelets.h).
    template <typename Each>
    static void for_all(size_t count, const Each& each) {
        if (count <= kParallel) {
            for (size_t i = 0; i < count; ++i)
                each(i);
            return;
        }
        tbb::parallel_for(tbb::blocked_range<size_t>(0, count, kParallel), [&](const auto& range) {
            for (size_t i = range.begin(); i < range.end(); ++i)
                each(i);
        });
    }

    /// A leaf's range of items holds triangles alone, or one patch: triangles are numbered in that
    /// order.
    void make_triangles(Tree* tree) {
        std::vector<uint32_t> index;  // [item]: its triangle's index; empty if there are no patches
        if (items_.size() != triangles_.size()) {
            uint32_t next = 0;
            for (const Item& item : items_) {
                index.push_back(next);
                next += is_patch(item) ? 0 : 1;
            }
        }
        const auto index_of = [&](size_t i) { return index.empty() ? i : index[i]; };
        for_all(items_.size(), [&](size_t i) {
            if (is_patch(items_[i])) return;
            const InputTriangle& t = triangle(items_[i]);
            make_triangle(t.v[0], t.v[1], t.v[2], t.patch, t.triangle, &tree->frames[index_of(i)],
                          &tree->details[index_of(i)]);
        });
        for_all(used_, [&](size_t n) {
            Node& node = nodes_[n];
            if (!node.is_leaf()) return;
            const Item& item = items_[node.first()];
            const uint32_t first = is_patch(item) ? static_cast<uint32_t>(patch(item).patch)
                                                  : static_cast<uint32_t>(index_of(node.first()));
            node.link = Node::kLeaf | node.count() << 28 | first;
        });
    }

    /// Returns at least the longest edge, from the margins, which are proportional
    /// (tree/triangle.h).
    static float longest_edge(const std::vector<TriangleDetail>& details) {
        float margin = 0;
        for (const TriangleDetail& d : details)
            margin = std::max(margin, d.margin);
        return std::ldexp(margin, 23) * 1.0001f;
    }

    TriangleList make_one_ring() const {
        TriangleList one_ring;
        one_ring.frames.resize(around_.one_ring.size());
        one_ring.details.resize(around_.one_ring.size());
        for (size_t i = 0; i < around_.one_ring.size(); ++i) {
            const InputTriangle& t = around_.one_ring[i];
            make_triangle(t.v[0], t.v[1], t.v[2], t.patch, t.triangle, &one_ring.frames[i],
                          &one_ring.details[i]);
        }
        return one_ring;
    }

    struct Part {
        size_t begin, end;
        Extent extent;
        float area;  ///< of its box; 0 if it is a leaf
    };
    Part make_part(size_t begin, size_t end, const Extent& extent) const {
        const Box3f box = extent.boxes.box();
        return {begin, end, extent, is_leaf(box, begin, end) ? 0 : half_area(box)};
    }

    /// Splits a range in two, then the largest parts again; returns the number of parts.
    size_t split(size_t begin, size_t end, const Extent& extent, Part* parts) {
        parts[0] = {begin, end, extent, 1};
        size_t count = 1;
        while (count < kMaxChildren) {
            size_t largest = 0;
            for (size_t i = 1; i < count; ++i)
                largest = parts[i].area > parts[largest].area ? i : largest;
            const Part whole = parts[largest];
            if (!(whole.area > 0)) break;
            Extent sides[2];
            const size_t middle = split_items(whole.extent, whole.begin, whole.end, &items_, sides);
            for (size_t i = count; i > largest + 1; --i)
                parts[i] = parts[i - 1];
            parts[largest] = make_part(whole.begin, middle, sides[0]);
            parts[largest + 1] = make_part(middle, whole.end, sides[1]);
            ++count;
        }
        return count;
    }

    Moments build_node(size_t node, size_t begin, size_t end, const Extent& extent) {
        const Box3f box = extent.boxes.box();
        Moments moments;
        if (is_leaf(box, begin, end)) {
            moments = leaf_moments(begin, end);
            const auto count = static_cast<uint32_t>(is_patch(items_[begin]) ? 0 : end - begin);
            nodes_[node].link = Node::kLeaf | count << 28 | static_cast<uint32_t>(begin);
        } else {
            Part parts[kMaxChildren];
            const size_t count = split(begin, end, extent, parts);
            const size_t child = used_.fetch_add(count);
            nodes_[node].link = static_cast<uint32_t>((count - 1) << 29 | child);
            Moments of[kMaxChildren];
            const auto build_child = [&](size_t i) {
                of[i] = build_node(child + i, parts[i].begin, parts[i].end, parts[i].extent);
            };
            if (end - begin > kParallel) {
                tbb::parallel_for(size_t{0}, count, build_child);
            } else {
                for (size_t i = 0; i < count; ++i)
                    build_child(i);
            }
            moments = of[0];
            for (size_t i = 1; i < count; ++i)
                moments.add(of[i]);
        }
        fit_box(moments, box, begin, end, &nodes_[node]);
        return moments;
    }

    bool is_leaf(const Box3f& box, size_t begin, size_t end) const {
        if (end - begin == 1) return true;
        const int32_t most = around_.diced ? kMaxDicedLeafTriangles : kMaxLeafTriangles;
        if (end - begin > static_cast<size_t>(most)) return false;
        // Large triangles, such as those of a card, get leaves of their own: a box around several
        // of them would span the part, and bounds of a cube, which come from boxes, would be
        // useless.
        constexpr float kLargeLeaf = 1.0f / 8;
        if (box.longest_side() > kLargeLeaf * whole_.longest_side()) return false;
        for (size_t i = begin; i < end; ++i) {
            if (is_patch(items_[i])) return false;
        }
        return true;
    }

    Moments leaf_moments(size_t begin, size_t end) const {
        Moments m;
        for (size_t i = begin; i < end; ++i) {
            if (is_patch(items_[i])) {
                const double area = static_cast<double>(half_area(items_[i].box()));
                for (int c = 0; c < 8; ++c)
                    m.add_point(vec_cast<double>(patch_corner(items_[i], c)),
                                std::max(1e-30, area / 8));
                continue;
            }
            const Vec3f* v = triangle(items_[i]).v;
            const Vec3d a = vec_cast<double>(v[0]), b = vec_cast<double>(v[1]),
                        c = vec_cast<double>(v[2]);
            const Vec3d facing = cross(b - a, c - a) * 0.5;
            const double area = std::max(1e-30, length(facing));
            m.area = m.area + facing;
            // Exact to second order: the triangle's moments are those of its three edge middles.
            m.add_point((a + b) * 0.5, area / 3);
            m.add_point((b + c) * 0.5, area / 3);
            m.add_point((c + a) * 0.5, area / 3);
        }
        return m;
    }

    Vec3f patch_corner(const Item& item, int c) const {
        const Vec3f* corners = patch(item).corners;
        return corners != nullptr ? corners[c] : corner_of(item.box(), c);
    }

    /// Fits the node's box: the one in the axes of the moments or the axis-aligned one, whichever
    /// has the smaller surface.
    void fit_box(const Moments& m, const Box3f& box, size_t begin, size_t end, Node* node) const {
        const PrincipalFrame frame(m);
        Range spread;
        const auto add = [&](size_t first, size_t last, Range* sum) {
            for (size_t i = first; i < last; ++i) {
                if (is_patch(items_[i])) {
                    for (int k = 0; k < 8; ++k)
                        sum->add(frame.coordinates(patch_corner(items_[i], k)));
                } else {
                    for (const Vec3f& v : triangle(items_[i]).v)
                        sum->add(frame.coordinates(v));
                }
            }
        };
        sum_up(begin, end, add, &spread);
        OrientedBox fit = frame.box(spread);
        if (!(fit.half_area() < static_cast<double>(half_area(box)))) {
            for (int k = 0; k < 3; ++k) {
                for (int a = 0; a < 3; ++a)
                    fit.axis[k][a] = k == a ? 1.0 : 0.0;
                fit.lo[k] = box.lo[k];
                fit.hi[k] = box.hi[k];
            }
        }
        // The margin holds the rounding of axes, center and the kernel's dot products.
        const double margin = static_cast<double>(largest_) * 0x1p-21;
        for (int k = 0; k < 3; ++k) {
            for (int a = 0; a < 3; ++a)
                node->axis[k][a] = static_cast<float>(fit.axis[k][a]);
            node->center[k] = static_cast<float>((fit.lo[k] + fit.hi[k]) / 2);
            node->half[k] = static_cast<float>((fit.hi[k] - fit.lo[k]) / 2 + margin);
        }
    }

    const std::vector<InputTriangle>& triangles_;
    const std::vector<InputPatch>& patches_;
    const TreeSurroundings& around_;
    std::vector<Item> items_;
    Box3f whole_;
    Node* nodes_ = nullptr;
    std::atomic<size_t> used_{1};
    float largest_ = 0;
};

}  // namespace

Tree build_tree(const std::vector<InputTriangle>& triangles, const std::vector<InputPatch>& patches,
                const TreeSurroundings& around) {
    return Builder(triangles, patches, around).build();
}

}  // namespace openfab::nearest
