// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/hierarchy.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace openfab::nearest {
namespace {

/// Area, first and second moments of a set of triangles (or of boxes, taken as their corners),
/// about the origin. They add up, so the principal axes of a node follow from its children's
/// without a pass over its triangles.
struct Moments {
    double weight = 0;
    Vec3d first;
    double second[6] = {0, 0, 0, 0, 0, 0};  // xx, xy, xz, yy, yz, zz

    void add_point(const Vec3d& p, double w) {
        weight += w;
        first = first + p * w;
        const double s[6] = {p.x * p.x, p.x * p.y, p.x * p.z, p.y * p.y, p.y * p.z, p.z * p.z};
        for (int i = 0; i < 6; ++i)
            second[i] += w * s[i];
    }
    void add(const Moments& m) {
        weight += m.weight;
        first = first + m.first;
        for (int i = 0; i < 6; ++i)
            second[i] += m.second[i];
    }
};

struct Item {
    Box3f box;
    Vec3f centroid;
    int32_t triangle;  // index of the input triangle, or -1
    int32_t patch;     // index of the input patch, or -1
};

float half_area(const Box3f& b) {
    const Vec3f s = b.size();
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

/// Eigenvectors of a symmetric 3 x 3 matrix as rows of `axes`, by cyclic Jacobi rotations.
void principal_axes(const double cov[6], double axes[3][3]) {
    double a[3][3] = {{cov[0], cov[1], cov[2]}, {cov[1], cov[3], cov[4]}, {cov[2], cov[4], cov[5]}};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j)
            axes[i][j] = i == j ? 1.0 : 0.0;
    }
    for (int sweep = 0; sweep < 8; ++sweep) {
        const double off = std::abs(a[0][1]) + std::abs(a[0][2]) + std::abs(a[1][2]);
        if (off <= 1e-9 * (std::abs(a[0][0]) + std::abs(a[1][1]) + std::abs(a[2][2]))) break;
        for (int p = 0; p < 2; ++p) {
            for (int q = p + 1; q < 3; ++q) {
                if (a[p][q] == 0.0) continue;
                const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                const double t =
                    (theta >= 0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
                const double c = 1.0 / std::sqrt(t * t + 1.0);
                const double s = t * c;
                for (int k = 0; k < 3; ++k) {
                    const double x = a[k][p], y = a[k][q];
                    a[k][p] = c * x - s * y;
                    a[k][q] = s * x + c * y;
                }
                for (int k = 0; k < 3; ++k) {
                    const double x = a[p][k], y = a[q][k];
                    a[p][k] = c * x - s * y;
                    a[q][k] = s * x + c * y;
                }
                for (int k = 0; k < 3; ++k) {
                    const double x = axes[p][k], y = axes[q][k];
                    axes[p][k] = c * x - s * y;
                    axes[q][k] = s * x + c * y;
                }
            }
        }
    }
}

class Builder {
  public:
    Builder(const std::vector<InputTriangle>& triangles, const std::vector<InputPatch>& patches)
        : triangles_(triangles), patches_(patches) {}

    Tree build() {
        Tree tree;
        make_items();
        if (items_.empty()) return tree;
        for (const Item& item : items_) {
            for (int a = 0; a < 3; ++a) {
                largest_ = std::max({largest_, std::abs(item.box.lo[a]), std::abs(item.box.hi[a])});
            }
        }
        nodes_.resize(2 * items_.size());
        build_node(0, 0, items_.size());
        nodes_.resize(used_);
        nodes_.shrink_to_fit();
        // A leaf's range of items holds triangles alone, or one patch: number the triangles in that
        // order.
        std::vector<uint32_t> place(items_.size());
        for (size_t i = 0; i < items_.size(); ++i) {
            place[i] = static_cast<uint32_t>(tree.frames.size());
            if (items_[i].triangle < 0) continue;
            const InputTriangle& t = triangles_[static_cast<size_t>(items_[i].triangle)];
            if (tree.frames.empty()) {
                tree.frames.reserve(triangles_.size());
                tree.details.reserve(triangles_.size());
            }
            make_triangle(t.v[0], t.v[1], t.v[2], t.patch, t.triangle, &tree.frames.emplace_back(),
                          &tree.details.emplace_back());
        }
        for (Node& node : nodes_) {
            if (!node.is_leaf()) continue;
            const Item& item = items_[node.first()];
            const uint32_t first =
                item.triangle >= 0
                    ? place[node.first()]
                    : static_cast<uint32_t>(patches_[static_cast<size_t>(item.patch)].patch);
            node.link = Node::kLeaf | node.count() << 28 | first;
        }
        tree.nodes = std::move(nodes_);
        tree.largest_coordinate = largest_;
        return tree;
    }

  private:
    void make_items() {
        items_.reserve(triangles_.size() + patches_.size());
        for (size_t i = 0; i < triangles_.size(); ++i) {
            Item item{{}, {}, static_cast<int32_t>(i), -1};
            for (const Vec3f& v : triangles_[i].v)
                item.box.add(v);
            item.centroid = item.box.center();
            whole_.add(item.box);
            items_.push_back(item);
        }
        for (size_t i = 0; i < patches_.size(); ++i) {
            if (patches_[i].bounds.empty()) continue;
            whole_.add(patches_[i].bounds);
            items_.push_back(
                {patches_[i].bounds, patches_[i].bounds.center(), -1, static_cast<int32_t>(i)});
        }
    }

    static float longest_side(const Box3f& box) {
        const Vec3f size = box.size();
        return std::max({size.x, size.y, size.z});
    }

    Moments build_node(size_t node, size_t begin, size_t end) {
        Box3f box, centroids;
        for (size_t i = begin; i < end; ++i) {
            box.add(items_[i].box);
            centroids.add(items_[i].centroid);
        }
        Moments moments;
        const size_t middle = is_leaf(box, begin, end) ? begin : split(box, centroids, begin, end);
        if (middle == begin) {
            moments = leaf_moments(begin, end);
            const auto count = static_cast<uint32_t>(items_[begin].triangle < 0 ? 0 : end - begin);
            nodes_[node].link = Node::kLeaf | count << 28 | static_cast<uint32_t>(begin);
        } else {
            const size_t child = used_.fetch_add(2);
            nodes_[node].link = static_cast<uint32_t>(child);
            Moments right;
            constexpr size_t kParallel = 16384;
            if (end - begin > kParallel) {
                tbb::parallel_invoke([&] { moments = build_node(child, begin, middle); },
                                     [&] { right = build_node(child + 1, middle, end); });
            } else {
                moments = build_node(child, begin, middle);
                right = build_node(child + 1, middle, end);
            }
            moments.add(right);
        }
        fit_box(moments, box, begin, end, &nodes_[node]);
        return moments;
    }

    bool is_leaf(const Box3f& box, size_t begin, size_t end) const {
        if (end - begin == 1) return true;
        if (end - begin > kMaxLeafTriangles) return false;
        // Large triangles, as those of a card, stand alone: a box around several of them would span
        // the part, and bounds of a cube, which come from boxes, would tell nothing.
        constexpr float kLargeLeaf = 1.0f / 8;
        if (longest_side(box) > kLargeLeaf * longest_side(whole_)) return false;
        for (size_t i = begin; i < end; ++i) {
            if (items_[i].triangle < 0) return false;
        }
        return true;
    }

    /// Binned surface-area split; halves by count where all centroids coincide.
    size_t split(const Box3f& box, const Box3f& centroids, size_t begin, size_t end) {
        constexpr int kBins = 16;
        float best_cost = std::numeric_limits<float>::infinity();
        int best_axis = -1, best_bin = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const float lo = centroids.lo[axis];
            const float extent = centroids.hi[axis] - lo;
            if (!(extent > 0)) continue;
            Box3f bins[kBins];
            size_t counts[kBins] = {};
            for (size_t i = begin; i < end; ++i) {
                const int b = bin_of(items_[i].centroid[axis], lo, extent, kBins);
                bins[b].add(items_[i].box);
                ++counts[b];
            }
            float right_cost[kBins] = {};
            Box3f right;
            size_t n = 0;
            for (int b = kBins - 1; b > 0; --b) {
                if (counts[b] != 0) right.add(bins[b]);
                n += counts[b];
                right_cost[b] = n == 0 ? 0 : half_area(right) * static_cast<float>(n);
            }
            Box3f left;
            n = 0;
            for (int b = 0; b + 1 < kBins; ++b) {
                if (counts[b] != 0) left.add(bins[b]);
                n += counts[b];
                if (n == 0 || n == end - begin) continue;
                const float cost = half_area(left) * static_cast<float>(n) + right_cost[b + 1];
                if (cost < best_cost) {
                    best_cost = cost;
                    best_axis = axis;
                    best_bin = b;
                }
            }
        }
        const auto first = items_.begin() + static_cast<std::ptrdiff_t>(begin);
        const auto last = items_.begin() + static_cast<std::ptrdiff_t>(end);
        if (best_axis >= 0) {
            const float lo = centroids.lo[best_axis];
            const float extent = centroids.hi[best_axis] - lo;
            const auto it = std::partition(first, last, [&](const Item& item) {
                return bin_of(item.centroid[best_axis], lo, extent, kBins) <= best_bin;
            });
            const auto middle = static_cast<size_t>(it - items_.begin());
            if (middle != begin && middle != end) return middle;
        }
        (void)box;
        return begin + (end - begin) / 2;
    }

    static int bin_of(float x, float lo, float extent, int bins) {
        const float b = (x - lo) / extent * static_cast<float>(bins);
        return std::clamp(static_cast<int>(b), 0, bins - 1);
    }

    Moments leaf_moments(size_t begin, size_t end) const {
        Moments m;
        for (size_t i = begin; i < end; ++i) {
            if (items_[i].triangle < 0) {
                const Box3f& b = items_[i].box;
                const double w = std::max(1e-30, static_cast<double>(half_area(b)) / 8);
                for (int c = 0; c < 8; ++c)
                    m.add_point(vec_cast<double>(corner(b, c)), w);
                continue;
            }
            const Vec3f* v = triangles_[static_cast<size_t>(items_[i].triangle)].v;
            const Vec3d a = vec_cast<double>(v[0]), b = vec_cast<double>(v[1]),
                        c = vec_cast<double>(v[2]);
            const double area = std::max(1e-30, length(cross(b - a, c - a)) / 2);
            // Exact to second order: the triangle's moments are those of its three edge middles.
            m.add_point((a + b) * 0.5, area / 3);
            m.add_point((b + c) * 0.5, area / 3);
            m.add_point((c + a) * 0.5, area / 3);
        }
        return m;
    }

    static Vec3f corner(const Box3f& b, int c) {
        return {(c & 1) != 0 ? b.hi.x : b.lo.x, (c & 2) != 0 ? b.hi.y : b.lo.y,
                (c & 4) != 0 ? b.hi.z : b.lo.z};
    }

    /// The smaller, by surface, of the box along the principal axes and the axis-aligned box.
    void fit_box(const Moments& m, const Box3f& box, size_t begin, size_t end, Node* node) const {
        const Vec3d mean = m.first * (1.0 / m.weight);
        const double c[3] = {mean.x, mean.y, mean.z};
        double cov[6];
        for (int i = 0, k = 0; i < 3; ++i) {
            for (int j = i; j < 3; ++j, ++k)
                cov[k] = m.second[k] / m.weight - c[i] * c[j];
        }
        double axes[3][3];
        principal_axes(cov, axes);
        double lo[3] = {1e300, 1e300, 1e300}, hi[3] = {-1e300, -1e300, -1e300};
        const auto include = [&](const Vec3f& p) {
            for (int k = 0; k < 3; ++k) {
                const double x = axes[k][0] * p.x + axes[k][1] * p.y + axes[k][2] * p.z;
                lo[k] = std::min(lo[k], x);
                hi[k] = std::max(hi[k], x);
            }
        };
        for (size_t i = begin; i < end; ++i) {
            if (items_[i].triangle < 0) {
                for (int k = 0; k < 8; ++k)
                    include(corner(items_[i].box, k));
            } else {
                for (const Vec3f& v : triangles_[static_cast<size_t>(items_[i].triangle)].v)
                    include(v);
            }
        }
        const double s[3] = {hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]};
        const double oriented = s[0] * s[1] + s[1] * s[2] + s[2] * s[0];
        if (!(oriented < static_cast<double>(half_area(box)))) {
            for (int k = 0; k < 3; ++k) {
                for (int a = 0; a < 3; ++a)
                    axes[k][a] = k == a ? 1.0 : 0.0;
                lo[k] = box.lo[k];
                hi[k] = box.hi[k];
            }
        }
        // The margin holds the rounding of axes, centre and the kernel's dot products: 2^-21 of the
        // largest coordinate.
        const double margin = std::ldexp(static_cast<double>(largest_), -21);
        for (int k = 0; k < 3; ++k) {
            for (int a = 0; a < 3; ++a)
                node->axis[k][a] = static_cast<float>(axes[k][a]);
            node->center[k] = static_cast<float>((lo[k] + hi[k]) / 2);
            node->half[k] = static_cast<float>((hi[k] - lo[k]) / 2 + margin);
        }
    }

    const std::vector<InputTriangle>& triangles_;
    const std::vector<InputPatch>& patches_;
    std::vector<Item> items_;
    Box3f whole_;
    std::vector<Node> nodes_;
    std::atomic<size_t> used_{1};
    float largest_ = 0;
};

}  // namespace

Tree build_tree(const std::vector<InputTriangle>& triangles,
                const std::vector<InputPatch>& patches) {
    return Builder(triangles, patches).build();
}

}  // namespace openfab::nearest
