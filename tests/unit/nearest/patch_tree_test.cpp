// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/engine/patch_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <span>

#include "runtime/nearest/engine/patch_cache.h"
#include "tests/support/mesh_surface.h"

namespace openfab::nearest {
namespace {

using openfab::testing::MeshSurface;

/// Patches of `triangles` of a ball of 1 mm.
MeshSurface ball(int32_t triangles) {
    return MeshSurface(openfab::testing::make_ball(9, [](const Vec3d&) { return 1.0; }), triangles,
                       0.5f);
}

bool holds(const Node& box, const Vec3f& p) {
    for (int k = 0; k < 3; ++k) {
        const float* axis = box.axis[k];
        const float along = axis[0] * p.x + axis[1] * p.y + axis[2] * p.z;
        if (!(std::fabs(along - box.center[k]) <= box.half[k])) return false;
    }
    return true;
}

TEST(PatchTree, SmallPatchesAreNotCut) {
    const MeshSurface surface = ball(static_cast<int32_t>(kPieceTriangles));
    LatticeTreeBuilder builder;
    const auto made = make_patch_tree(surface, 0, PieceIds::from(100, 100), true, &builder);
    EXPECT_EQ(made->tree.triangles(), kPieceTriangles);
    EXPECT_TRUE(made->order.empty());
}

TEST(PatchTree, PiecesHoldEachTriangleOnceInTheirBoxes) {
    const MeshSurface surface = ball(500);
    const auto mesh = surface.micro(0);
    const PieceIds ids = PieceIds::from(100, 100);
    const int32_t patch = 0;
    LatticeTreeBuilder builder;
    const auto whole = make_patch_tree(surface, patch, ids, true, &builder);
    EXPECT_EQ(whole->tree.triangles(), 0u);
    std::vector<int> seen(mesh->triangles.size());
    int pieces = 0;
    const std::span nodes(whole->view().nodes, whole->tree.nodes());
    for (const Node& node : nodes) {
        if (!node.is_leaf()) continue;
        ++pieces;
        ASSERT_EQ(node.count(), 0u);
        const auto id = static_cast<int32_t>(node.first());
        ASSERT_TRUE(ids.has(id));
        ASSERT_EQ(ids.patch(id), patch);
        const auto piece = make_piece_tree(surface, patch, *whole, ids.piece(id), &builder);
        EXPECT_LE(piece->tree.triangles(), kPieceTriangles);
        for (const TriangleDetail& detail :
             std::span(piece->view().details, piece->tree.triangles())) {
            ASSERT_EQ(detail.patch, patch);
            ++seen[static_cast<size_t>(detail.triangle)];
            for (const int32_t v : mesh->triangles[static_cast<size_t>(detail.triangle)]) {
                const Vec3f& p = mesh->positions[static_cast<size_t>(v)];
                ASSERT_TRUE(holds(node, p));
                ASSERT_TRUE(holds(nodes[0], p));
            }
        }
    }
    EXPECT_EQ(pieces, 4);
    EXPECT_EQ(seen, std::vector<int>(mesh->triangles.size(), 1));
}

TEST(PatchTree, WithoutIdsForAllPiecesNoPatchIsCut) {
    const size_t most = (static_cast<size_t>(kMaxItems) - 100) / kMaxPieces;
    EXPECT_EQ(PieceIds::from(100, most).first, 100);
    const PieceIds none = PieceIds::from(100, most + 1);
    EXPECT_FALSE(none.has(kMaxItems - 1));
    const MeshSurface surface = ball(500);
    LatticeTreeBuilder builder;
    const auto made = make_patch_tree(surface, 0, none, true, &builder);
    EXPECT_EQ(made->tree.triangles(), 500u);
}

TEST(PatchTree, IsCutOnceItWasEvicted) {
    const MeshSurface surface = ball(500);
    LazyTreelets treelets(surface);
    const PatchUnits units(surface, &treelets.boxes());
    const PieceIds ids = PieceIds::from(surface.patches().size(), surface.patches().size());
    for (const size_t cache_bytes : {size_t{0}, size_t{1} << 30}) {
        PatchCache cache(cache_bytes);
        PatchBoxes boxes(surface.patches().size());
        const TreeSources sources{&cache, &surface, PatchCache::new_surface_id(), &treelets, &units,
                                  &boxes, ids};
        PatchPins first, second;
        first.begin(sources);
        EXPECT_NE(PatchPins::fetch(&first, 0)->frames, nullptr);
        second.begin(sources);
        EXPECT_EQ(PatchPins::fetch(&second, 0)->frames == nullptr, cache_bytes == 0);
    }
}

TEST(PatchTree, OfACrowdedSurfaceIsCutAtOnce) {
    const MeshSurface surface = ball(500);
    LazyTreelets treelets(surface);
    const PatchUnits units(surface, &treelets.boxes());
    const PieceIds ids = PieceIds::from(surface.patches().size(), surface.patches().size());
    PatchCache cache(size_t{1} << 30);
    PatchBoxes boxes(surface.patches().size());
    PatchPins pins;
    pins.begin(
        {&cache, &surface, PatchCache::new_surface_id(), &treelets, &units, &boxes, ids, true});
    EXPECT_EQ(PatchPins::fetch(&pins, 0)->frames, nullptr);
    EXPECT_NE(PatchPins::fetch(&pins, ids.id(0, 1))->frames, nullptr);
}

TEST(PatchTree, OfASurfaceThatStopsNoMorePiecesCome) {
    MeshSurface surface = ball(500);
    PatchCache cache(0);
    LazyTreelets treelets(surface);
    const PatchUnits units(surface, &treelets.boxes());
    PatchBoxes boxes(surface.patches().size());
    const PieceIds ids = PieceIds::from(surface.patches().size(), surface.patches().size());
    const TreeSources sources{&cache, &surface, PatchCache::new_surface_id(), &treelets, &units,
                              &boxes, ids};
    PatchPins before, pins;
    before.begin(sources);
    PatchPins::fetch(&before, 0);
    pins.begin(sources);
    EXPECT_NE(PatchPins::fetch(&pins, 0)->nodes, nullptr);
    EXPECT_NE(PatchPins::fetch(&pins, ids.id(0, 1))->nodes, nullptr);
    surface.stop();
    EXPECT_EQ(PatchPins::fetch(&pins, ids.id(0, 2))->nodes, nullptr);
    EXPECT_EQ(PatchPins::fetch(&pins, 1)->nodes, nullptr);
}

}  // namespace
}  // namespace openfab::nearest
