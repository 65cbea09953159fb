// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/lattice_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/infinity.h"
#include "runtime/nearest/tree/lattice_leaves.h"
#include "runtime/nearest/tree/split.h"

namespace openfab::nearest {
namespace {

using Area = LatticeLeaves::Area;

/// Fits boxes around points, the last axis along the area vector of their triangles.
class BoxFit {
  public:
    /// `along`: any direction across the triangles. Where they face several ways, the axes are
    /// those of the part.
    BoxFit(const Area& area, const Vec3f& along, const Vec3f& origin)
        : origin_{origin.x, origin.y, origin.z, 0} {
        constexpr float kFacing = 0.5f;
        const float facing = length(area.vector);
        if (facing > kFacing * area.size) set_axes(area.vector, along);
        for (int a = 0; a < 3; ++a)
            columns_[a] = F4{axis_[0][a], axis_[1][a], axis_[2][a], 0};
    }
    void add(const Vec3f& p) {
        const F4 d = F4{p.x, p.y, p.z, 0} - origin_;
        spread_.add(columns_[0] * d[0] + columns_[1] * d[1] + columns_[2] * d[2]);
    }
    void add(const Vec3f* points, int32_t count) {
        for (int32_t i = 0; i < count; ++i)
            add(points[i]);
    }
    /// `margin` holds the rounding of axes, center and the kernel's dot products.
    void store(double margin, Node* node) const {
        float reach = 0;
        for (int k = 0; k < 3; ++k)
            reach = std::max({reach, std::abs(spread_.lo[k]), std::abs(spread_.hi[k])});
        // The error of a coordinate is less than 2^-21 of its point's distance from the origin.
        margin += std::ldexp(static_cast<double>(reach), -20);
        for (int k = 0; k < 3; ++k) {
            double center = 0.5 * (static_cast<double>(spread_.lo[k]) + spread_.hi[k]);
            for (int a = 0; a < 3; ++a) {
                node->axis[k][a] = axis_[k][a];
                center += static_cast<double>(axis_[k][a]) * origin_[a];
            }
            node->center[k] = static_cast<float>(center);
            node->half[k] = static_cast<float>(
                0.5 * (static_cast<double>(spread_.hi[k]) - spread_.lo[k]) + margin);
        }
    }

  private:
    void set_axes(const Vec3f& facing, const Vec3f& along) {
        const Vec3d f = vec_cast<double>(facing), n = f * (1 / length(f));
        const auto across = [&](const Vec3d& d) { return d - n * dot(d, n); };
        const Vec3d way = vec_cast<double>(along);
        Vec3d u = across(way);
        if (!(dot(u, u) > 1e-6 * dot(way, way))) {
            const Vec3d least = std::abs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
            u = across(least);
        }
        u = u * (1 / length(u));
        const Vec3d axes[3] = {u, cross(n, u), n};
        for (int k = 0; k < 3; ++k) {
            for (int a = 0; a < 3; ++a)
                axis_[k][a] = static_cast<float>(axes[k][a]);
        }
    }

    float axis_[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    F4 columns_[3], origin_;
    Range spread_;
};

class Builder {
  public:
    Builder(UnitFeatures* unit, LatticeLeaves* leaves, Tree* tree)
        : unit_(*unit), leaves_(*leaves), tree_(*tree) {
        clear();
    }

    bool build(std::span<const LatticePatch> patches) {
        for (const LatticePatch& patch : patches) {
            if (patch.mesh->triangles.empty()) continue;
            filled_.push_back(&patch);
            measure(patch);
        }
        if (filled_.empty()) return true;
        // Patches that are alone know their neighbours by the lattice.
        if (filled_.size() > 1) unit_.find(filled_);
        take_nodes(1);
        Area area;
        if (!build_patches(0, 0, filled_.size(), &area)) return false;
        finish();
        return true;
    }

    bool build_pieces(const LatticePatch& patch, int32_t first_id) {
        measure(patch);
        if (!leaves_.begin(patch)) return false;
        pieces_ = &patch;
        first_id_ = first_id;
        take_nodes(1);
        build_block(0, whole_block());
        return true;
    }

    bool build_piece(const LatticePatch& patch, int32_t piece) {
        if (!leaves_.begin(patch)) return false;
        const CellBlock block{piece % kAcross * kColumns, piece / kAcross * kRows, kColumns, kRows};
        if (leaves_.cells().count(block) == 0) return false;
        measure(patch);
        leaves_.prepare(block);
        take_nodes(1);
        build_block(0, block);
        finish();
        return true;
    }

  private:
    static constexpr int32_t kColumns = LatticeTreeBuilder::kPieceColumns,
                             kRows = LatticeTreeBuilder::kPieceRows,
                             kAcross = surface::kTileEdges / kColumns;

    void measure(const LatticePatch& patch) {
        for (const Vec3f& p : patch.mesh->positions)
            largest_ = std::max({largest_, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        margin_ = std::ldexp(static_cast<double>(largest_), -21);
        tree_.largest_coordinate = largest_;
    }

    void finish() {
        const float* h = tree_.nodes[0].half;
        const float side = 4 * std::max({h[0] * h[1], h[1] * h[2], h[2] * h[0]});
        tree_.spacing = std::sqrt(side / static_cast<float>(tree_.frames.size()));
        float margin = 0;
        for (const TriangleDetail& d : tree_.details)
            margin = std::max(margin, d.margin);
        tree_.longest_edge = std::ldexp(margin, 23) * 1.0001f;
    }

    void clear() {
        tree_.nodes.clear();
        tree_.frames.clear();
        tree_.details.clear();
        tree_.edges.clear();
        tree_.vertices.clear();
        tree_.leaves.clear();
        tree_.half_spaces.values.clear();
        tree_.cones.clear();
        tree_.largest_coordinate = tree_.spacing = tree_.longest_edge = 0;
    }

    size_t take_nodes(size_t count) {
        const size_t first = tree_.nodes.size();
        tree_.nodes.resize(first + count);
        tree_.leaves.resize(first + count);
        return first;
    }
    void set_inner(size_t node, size_t child, size_t count) {
        tree_.nodes[node].link = static_cast<uint32_t>((count - 1) << 29 | child);
    }

    /// Builds the node over patches [begin, end) of `filled_`.
    bool build_patches(size_t node, size_t begin, size_t end, Area* area) {
        if (end - begin == 1) {
            const LatticePatch& patch = *filled_[begin];
            if (!leaves_.begin(patch)) return false;
            const CellBlock all = whole_block();
            if (filled_.size() > 1) {
                leaves_.take_from(unit_, unit_.first_triangle(begin));
            } else {
                leaves_.prepare(all);
            }
            *area = build_block(node, all);
            return true;
        }
        const size_t count = std::min<size_t>(kMaxChildren, end - begin);
        const size_t child = take_nodes(count);
        set_inner(node, child, count);
        for (size_t i = 0; i < count; ++i) {
            Area of;
            const auto at = [&](size_t k) { return begin + (end - begin) * k / count; };
            if (!build_patches(child + i, at(i), at(i + 1), &of)) return false;
            area->add(of);
        }
        const std::vector<Vec3f>& first = filled_[begin]->mesh->positions;
        const std::vector<Vec3f>& last = filled_[end - 1]->mesh->positions;
        BoxFit fit(*area, last[0] - first[0], first[0]);
        for (size_t i = begin; i < end; ++i) {
            for (const Vec3f& p : filled_[i]->mesh->positions)
                fit.add(p);
        }
        fit.store(margin_, &tree_.nodes[node]);
        return true;
    }

    CellBlock whole_block() const {
        const LatticeCells& cells = leaves_.cells();
        CellBlock all{0, 0, 2, 1};
        while (all.width < cells.columns() || all.height < cells.rows())
            all.width *= 2, all.height *= 2;
        return all;
    }

    /// Builds the node of a block with triangles. Blocks are twice as wide as high, down to two
    /// cells side by side, which have four triangles at most.
    Area build_block(size_t node, CellBlock block) {
        const LatticeCells& cells = leaves_.cells();
        for (;;) {
            const int32_t triangles = cells.count(block);
            if (pieces_ != nullptr && block.width <= kColumns) return add_piece(node, block);
            // Of a patch in pieces only those become leaves, however few triangles a block has.
            if (pieces_ == nullptr && triangles <= kMaxDicedLeafTriangles) {
                const auto first = static_cast<uint32_t>(tree_.frames.size());
                LeafFeatures leaf;
                const Area area = leaves_.append(block, &leaf, &tree_);
                tree_.leaves[node] = leaf;
                tree_.nodes[node].link =
                    Node::kLeaf | static_cast<uint32_t>(triangles) << 28 | first;
                fit_leaf(area, first, static_cast<uint32_t>(triangles), node);
                return area;
            }
            std::array<CellBlock, kMaxChildren> parts;
            size_t count = 0;
            for (int32_t i = 0; i < 4; ++i) {
                const int32_t width = block.width / 2, height = block.height / 2;
                const CellBlock part{block.a + (i & 1) * width, block.b + (i >> 1) * height, width,
                                     height};
                if (cells.count(part) > 0) parts[count++] = part;
            }
            if (count == 1) {
                block = parts[0];
                continue;
            }
            const size_t child = take_nodes(count);
            set_inner(node, child, count);
            Area area;
            for (size_t i = 0; i < count; ++i)
                area.add(build_block(child + i, parts[i]));
            fit_block(area, block, node);
            return area;
        }
    }

    Area add_piece(size_t node, const CellBlock& block) {
        const LatticeCells& cells = leaves_.cells();
        const Vec3f* positions = leaves_.positions();
        const CellBlock in = cells.clip(block);
        Area area;
        const auto add = [&](int32_t triangle) {
            if (triangle < 0) return;
            const std::array<int32_t, 3>& v =
                pieces_->mesh->triangles[static_cast<size_t>(triangle)];
            const Vec3f facing =
                cross(positions[v[1]] - positions[v[0]], positions[v[2]] - positions[v[0]]);
            area.add({facing, length(facing)});
        };
        for (int32_t b = in.b; b < in.b + in.height; ++b) {
            for (int32_t a = in.a; a < in.a + in.width; ++a) {
                add(cells.upper(a, b));
                add(cells.lower(a, b));
            }
        }
        add_known_points(in, &tree_.leaves[node]);
        const int32_t piece = block.b / kRows * kAcross + block.a / kColumns;
        tree_.nodes[node].link = Node::kLeaf | static_cast<uint32_t>(first_id_ + piece);
        fit_block(area, block, node);
        return area;
    }

    /// Adds corners of triangles in a block, every other one along its rows and columns.
    void add_known_points(const CellBlock& in, LeafFeatures* leaf) {
        leaf->first_vertex = static_cast<uint32_t>(tree_.vertices.size());
        const auto add = [&](int32_t triangle, size_t corner) {
            if (triangle < 0) return;
            const std::array<int32_t, 3>& v =
                pieces_->mesh->triangles[static_cast<size_t>(triangle)];
            VertexFeature known{};
            for (int a = 0; a < 3; ++a)
                known.v[a] = leaves_.positions()[v[corner]][a];
            tree_.vertices.push_back(known);
            ++leaf->vertices;
        };
        const LatticeCells& cells = leaves_.cells();
        for (int32_t b = 0; b < in.height; ++b) {
            for (int32_t a = 0; a < in.width; ++a) {
                const bool even = a % 2 == 0 && b % 2 == 0, odd = a % 2 != 0 && b % 2 != 0;
                if (even) add(cells.upper(in.a + a, in.b + b), 0);
                if (odd && (a + 1 == in.width || b + 1 == in.height))
                    add(cells.lower(in.a + a, in.b + b), 1);
            }
        }
    }

    void fit_leaf(const Area& area, uint32_t first, uint32_t count, size_t node) {
        const auto at = [](const float* v) { return Vec3f{v[0], v[1], v[2]}; };
        const Vec3f origin = at(tree_.frames[first].v0);
        BoxFit fit(area, at(tree_.details[first].v1) - origin, origin);
        for (uint32_t t = first; t < first + count; ++t) {
            fit.add(at(tree_.frames[t].v0));
            fit.add(at(tree_.details[t].v1));
            fit.add(at(tree_.details[t].v2));
        }
        fit.store(margin_, &tree_.nodes[node]);
    }

    void fit_block(const Area& area, const CellBlock& block, size_t node) {
        const LatticeCells& cells = leaves_.cells();
        const Vec3f* positions = leaves_.positions();
        const int32_t rows = std::min(block.b + block.height, cells.rows());
        const auto last = [&](int32_t b) {
            return std::min(block.a + block.width, cells.points(b) - 1);
        };
        const Vec3f* start = positions + cells.vertex(block.a, block.b);
        BoxFit fit(area, start[last(block.b) - block.a] - *start, *start);
        for (int32_t b = block.b; b <= rows; ++b) {
            if (last(b) >= block.a)
                fit.add(positions + cells.vertex(block.a, b), last(b) - block.a + 1);
        }
        fit.store(margin_, &tree_.nodes[node]);
    }

    std::vector<const LatticePatch*> filled_;  ///< those with triangles
    const LatticePatch* pieces_ = nullptr;     ///< the patch whose pieces are leaves
    int32_t first_id_ = 0;                     ///< of the pieces
    UnitFeatures& unit_;
    LatticeLeaves& leaves_;
    Tree& tree_;
    float largest_ = 0;
    double margin_ = 0;
};

}  // namespace

LatticeTreeBuilder::LatticeTreeBuilder()
    : unit_(std::make_unique<UnitFeatures>()), leaves_(std::make_unique<LatticeLeaves>()) {}
LatticeTreeBuilder::~LatticeTreeBuilder() = default;

const Tree* LatticeTreeBuilder::build(std::span<const LatticePatch> patches) {
    return Builder(unit_.get(), leaves_.get(), &tree_).build(patches) ? &tree_ : nullptr;
}

const Tree* LatticeTreeBuilder::build_pieces(const LatticePatch& patch, int32_t first_id) {
    return Builder(unit_.get(), leaves_.get(), &tree_).build_pieces(patch, first_id) ? &tree_
                                                                                     : nullptr;
}

const Tree* LatticeTreeBuilder::build_piece(const LatticePatch& patch, int32_t piece) {
    return Builder(unit_.get(), leaves_.get(), &tree_).build_piece(patch, piece) ? &tree_ : nullptr;
}

}  // namespace openfab::nearest
