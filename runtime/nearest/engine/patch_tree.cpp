// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/engine/patch_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/check.h"
#include "runtime/nearest/tree/oriented.h"

namespace openfab::nearest {
namespace {

/// Piece k of n triangles in `pieces` pieces is [first_of(k), first_of(k + 1)) in their order.
size_t first_of(size_t piece, size_t n, size_t pieces) {
    return n * piece / pieces;
}

size_t piece_count(size_t n) {
    return (n + kPieceTriangles - 1) / kPieceTriangles;
}

InputTriangle input_triangle(const surface::MicroMesh& mesh, int32_t patch, size_t t) {
    InputTriangle in{{}, patch, static_cast<int32_t>(t)};
    for (int k = 0; k < 3; ++k)
        in.v[k] = mesh.positions[static_cast<size_t>(mesh.triangles[t][k])];
    return in;
}

/// Orders the triangles of a patch by pieces: halves along the longest side, again and again.
class PieceCutter {
  public:
    explicit PieceCutter(const surface::MicroMesh& mesh)
        : pieces_(piece_count(mesh.triangles.size())), places_(mesh.triangles.size()) {
        for (size_t t = 0; t < places_.size(); ++t) {
            const std::array<int32_t, 3>& corners = mesh.triangles[t];
            const auto at = [&](size_t k) {
                return mesh.positions[static_cast<size_t>(corners[k])];
            };
            places_[t] = at(0) + at(1) + at(2);
        }
    }

    std::vector<uint16_t> order() {
        order_.resize(places_.size());
        for (size_t i = 0; i < order_.size(); ++i)
            order_[i] = static_cast<uint16_t>(i);
        cut(0, pieces_);
        return std::move(order_);
    }

  private:
    void cut(size_t first, size_t end) {
        if (end - first < 2) return;
        const size_t middle = first + (end - first) / 2;
        const auto at = [&](size_t piece) {
            return order_.begin() +
                   static_cast<std::ptrdiff_t>(first_of(piece, order_.size(), pieces_));
        };
        Box3f box;
        for (auto it = at(first); it != at(end); ++it)
            box.add(places_[*it]);
        const Vec3f size = box.size();
        int axis = size.y > size.x ? 1 : 0;
        axis = size.z > size[axis] ? 2 : axis;
        std::nth_element(at(first), at(middle), at(end), [&](uint16_t a, uint16_t b) {
            return places_[a][axis] < places_[b][axis];
        });
        cut(first, middle);
        cut(middle, end);
    }

    const size_t pieces_;
    std::vector<Vec3f> places_;  ///< [triangle]: the sum of its corners
    std::vector<uint16_t> order_;
};

/// A box around triangles, in the axes of their moments.
std::array<Vec3f, 8> box_corners(const std::vector<InputTriangle>& triangles, double margin) {
    Moments moments;
    for (const InputTriangle& t : triangles) {
        const Vec3d a = vec_cast<double>(t.v[0]), b = vec_cast<double>(t.v[1]),
                    c = vec_cast<double>(t.v[2]);
        const Vec3d facing = cross(b - a, c - a) * 0.5;
        moments.area = moments.area + facing;
        moments.add_point((a + b + c) * (1.0 / 3), std::max(1e-30, length(facing)));
    }
    const PrincipalFrame frame(moments);
    Range spread;
    for (const InputTriangle& t : triangles) {
        for (const Vec3f& v : t.v)
            spread.add(frame.coordinates(v));
    }
    return frame.box(spread).grown(margin).corners();
}

}  // namespace

void append_triangles(const surface::MicroMesh& mesh, int32_t patch,
                      std::vector<InputTriangle>* out) {
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
        out->push_back(input_triangle(mesh, patch, t));
}

std::shared_ptr<const PatchTree> make_patch_tree(const surface::Surface& surface, int32_t patch,
                                                 const PieceIds& ids, bool cut,
                                                 LatticeTreeBuilder* builder) {
    const std::shared_ptr<const surface::MicroMesh> diced = surface.micro(patch);
    const surface::MicroMesh& mesh = *diced;
    const size_t n = mesh.triangles.size(), pieces = piece_count(n);
    const bool can_cut = ids.first != PieceIds::kNone;
    auto made = std::make_shared<PatchTree>();
    if (const surface::Patch& of = surface.patches()[static_cast<size_t>(patch)];
        of.kind == surface::PatchKind::kLattice) {
        const LatticePatch lattice{&mesh, &of, patch};
        const bool in_pieces = can_cut && n > LatticeTreeBuilder::kWholeTriangles;
        if (const Tree* built = in_pieces ? builder->build_pieces(lattice, ids.id(patch, 0))
                                          : builder->build({&lattice, 1})) {
            made->tree = PackedTree(*built);
            made->lattice = in_pieces;
            return made;
        }
    }
    if (!cut || !can_cut || pieces < 2 || pieces > kMaxPieces) {
        std::vector<InputTriangle> triangles;
        append_triangles(mesh, patch, &triangles);
        made->tree = PackedTree(build_tree(triangles, {}, {.diced = true}));
        return made;
    }
    made->order = PieceCutter(mesh).order();
    float largest = 0;
    for (const Vec3f& p : mesh.positions) {
        made->bounds.add(p);
        for (int a = 0; a < 3; ++a)
            largest = std::max(largest, std::abs(p[a]));
    }
    // Holds the rounding of axes and corners, as for a node of the hierarchy.
    const double margin = std::ldexp(static_cast<double>(largest), -21);
    std::vector<InputPatch> boxes(pieces);
    std::vector<std::array<Vec3f, 8>> corners(pieces);
    std::vector<InputTriangle> triangles;
    for (size_t k = 0; k < pieces; ++k) {
        triangles.clear();
        boxes[k] = {{}, ids.id(patch, static_cast<int32_t>(k)), corners[k].data()};
        for (size_t i = first_of(k, n, pieces); i < first_of(k + 1, n, pieces); ++i) {
            triangles.push_back(input_triangle(mesh, patch, made->order[i]));
            for (const Vec3f& v : triangles.back().v)
                boxes[k].bounds.add(v);
        }
        corners[k] = box_corners(triangles, margin);
    }
    made->tree = PackedTree(build_tree({}, boxes, {.diced = true}));
    return made;
}

std::shared_ptr<const PatchTree> make_unit_tree(const surface::Surface& surface,
                                                std::span<const int32_t> unit,
                                                LatticeTreeBuilder* builder) {
    std::vector<std::shared_ptr<const surface::MicroMesh>> meshes;
    std::vector<LatticePatch> patches;
    meshes.reserve(unit.size());
    patches.reserve(unit.size());
    for (const int32_t patch : unit) {
        meshes.push_back(surface.micro(patch));
        patches.push_back(
            {meshes.back().get(), &surface.patches()[static_cast<size_t>(patch)], patch});
    }
    auto made = std::make_shared<PatchTree>();
    if (const Tree* built = builder->build(patches)) made->tree = PackedTree(*built);
    return made;
}

std::shared_ptr<const PatchTree> make_piece_tree(const surface::Surface& surface, int32_t patch,
                                                 const PatchTree& whole, int32_t piece,
                                                 LatticeTreeBuilder* builder) {
    const std::shared_ptr<const surface::MicroMesh> diced = surface.micro(patch);
    const surface::MicroMesh& mesh = *diced;
    auto made = std::make_shared<PatchTree>();
    if (whole.lattice) {
        const surface::Patch& of = surface.patches()[static_cast<size_t>(patch)];
        // A surface that is stopped dices nothing more.
        if (const Tree* built = builder->build_piece({&mesh, &of, patch}, piece))
            made->tree = PackedTree(*built);
        return made;
    }
    const size_t n = mesh.triangles.size(), pieces = piece_count(n), k = static_cast<size_t>(piece);
    if (n != whole.order.size()) return made;  // stopped
    std::vector<InputTriangle> triangles;
    triangles.reserve(kPieceTriangles);
    for (size_t i = first_of(k, n, pieces); i < first_of(k + 1, n, pieces); ++i)
        triangles.push_back(input_triangle(mesh, patch, whole.order[i]));
    made->tree = PackedTree(build_tree(triangles, {}, {.whole = whole.bounds, .diced = true}));
    return made;
}

}  // namespace openfab::nearest
