// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Shapes by hand-written kernels: coverage voxel by voxel against the function, volumes and distances
// against closed forms, the diced surface closed, and what makes a shape impossible.

#include "runtime/solid/shape/shape_solid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "abi/shape_distance.h"
#include "mesh/model/primitives.h"
#include "runtime/part/part_mesh.h"
#include "runtime/part/shape_stage.h"
#include "runtime/solid/cut/cut.h"
#include "runtime/solid/kinds/kinds.h"
#include "runtime/solid/messages.h"
#include "runtime/solid/shape/shape_mesh.h"
#include "runtime/solid/shape/shape_surface.h"
#include "runtime/solid/voxel_frame.h"
#include "tests/support/says/says.h"
#include "tests/unit/solid/covered.h"
#include "tests/unit/solid/made_shape.h"

namespace openfab::solid {
namespace {

void expect_coverage(const Made& made, double pitch, double volume) {
    const auto solid = solid_of(made, pitch);
    ASSERT_NE(solid, nullptr);
    const part::Grid grid = grid_of(*solid, made, pitch);
    const auto frame = part::make_frame(made.part, grid);
    const Vec3i base = part::part_base_voxel(made.part, grid);
    solid->prepare({}, {});
    const auto placed = solid->place({made.part, grid, frame});
    const std::vector<uint8_t> all = covered(*placed, grid);
    const VoxelFrame centres(frame);
    int64_t inside = 0, different = 0;
    std::vector<int32_t> tops(static_cast<size_t>(grid.size.x) * grid.size.y, 0);
    size_t i = 0;
    for (int32_t z = 0; z < grid.size.z; ++z) {
        for (int32_t y = 0; y < grid.size.y; ++y) {
            for (int32_t x = 0; x < grid.size.x; ++x, ++i) {
                const Box3f at = centres.box(Vec3i{x, y, z} - base, Vec3i{x, y, z} - base);
                inside += all[i];
                different += (made.function(at.lo) < 0) != (all[i] != 0) ? 1 : 0;
                if (all[i] != 0) tops[static_cast<size_t>(y) * grid.size.x + x] = z;
            }
        }
    }
    EXPECT_EQ(different, 0);
    EXPECT_NEAR(static_cast<double>(inside) * pitch * pitch * pitch / volume, 1, 1e-4);
    TopRows rows;
    rows.width = grid.size.x;
    rows.top.assign(tops.size(), 0);
    placed->raise_tops({0, 0, grid.size.x, grid.size.y}, &rows);
    EXPECT_EQ(rows.top, tops);
    // As support asks: some columns at a time, which end within tiles.
    constexpr int32_t kWide = 43, kHigh = 21;
    for (int32_t y = 0; y < grid.size.y; y += kHigh) {
        for (int32_t x = 0; x < grid.size.x; x += kWide) {
            rows.top.assign(tops.size(), 0);
            const Columns columns{x, y, std::min(x + kWide, grid.size.x),
                                  std::min(y + kHigh, grid.size.y)};
            placed->raise_tops(columns, &rows);
            for (int32_t at = 0; at < grid.size.x * grid.size.y; ++at) {
                const int32_t column = at % grid.size.x, row = at / grid.size.x;
                const bool asked = column >= columns.x0 && column < columns.x1 &&
                                   row >= columns.y0 && row < columns.y1;
                const auto i = static_cast<size_t>(at);
                ASSERT_EQ(rows.top[i], asked ? tops[i] : 0) << column << ", " << row;
            }
        }
    }
    EXPECT_TRUE(solid->status());
}

TEST(ShapeSolid, CoversWhatIsNegative) {
    expect_coverage(*make<ball>({8, 8, 8}), 0.035, 4.0 / 3 * M_PI * 64);
    expect_coverage(*make<ring>({11, 11, 3}), 0.035, 2 * M_PI * M_PI * 4 * 2.25);
    expect_coverage(*make<brick>({6, 8, 4}), 0.035, 6 * 8 * 4);
    expect_coverage(*make<pill>({4, 4, 8}), 0.035, M_PI * 4 * 4 + 4.0 / 3 * M_PI * 8);
    expect_coverage(*make<cone>({7, 7, 5}), 0.035, M_PI * 9 * 4 / 3);
}

/// The distances of voxel centres in some blocks.
void expect_distances(const Made& made, double pitch, double tolerance) {
    const auto solid = solid_of(made, pitch);
    ASSERT_NE(solid, nullptr);
    const part::Grid grid = grid_of(*solid, made, pitch);
    const auto frame = part::make_frame(made.part, grid);
    solid->prepare({.nearest = true}, {OPENFAB_ISA_AVX2, nearest::make_patch_cache(64 << 20)});
    const auto placed = solid->place({made.part, grid, frame});
    placed->begin_queries();
    const auto scratch = placed->make_scratch();
    const VoxelFrame centres(frame);
    auto answer = std::make_unique<nearest::BlockAnswer>();
    double worst = 0;
    for (int32_t block = -24; block <= 24; block += 8) {
        const Vec3i lowest{block, block / 2 / 8 * 8, -block / 16 * 8};
        placed->engine()->query({.block = lowest}, scratch->engine.get(), answer.get());
        nearest::BlockBounds bounds;
        placed->engine()->bound_blocks({&lowest, 1}, scratch->engine.get(), &bounds);
        float low = 0, high = 0;
        placed->engine()->bound_whole_blocks({&lowest, 1}, scratch->engine.get(), &low, &high);
        // Of octants that cubes of four cells bound, and of no less than the block.
        EXPECT_LE(high - low, (4 * 2 + 8) * std::sqrt(3.0f) * pitch + 0.8f);
        const nearest::BlockPieces& pieces = placed->engine()->pieces();
        for (size_t p = 0; p < pieces.lowest.size(); ++p) {
            // Cubes of four cells at most, and the piece.
            EXPECT_LE(bounds.high[p] - bounds.low[p], 4 * 2 * std::sqrt(3.0f) * pitch + 0.8f);
            for (int32_t k = 0; k < pieces.size.x * pieces.size.y * pieces.size.z; ++k) {
                const Vec3i in{k % pieces.size.x, k / pieces.size.x % pieces.size.y,
                               k / pieces.size.x / pieces.size.y};
                const Vec3i from = pieces.lowest[p] + in, at = lowest + from;
                const float d = std::sqrt(
                    answer->distance2[static_cast<size_t>((from.y * 8 + from.x) * 8 + from.z)]);
                const Vec3f centre = centres.box(at, at).lo;
                const float want = std::fabs(made.function(centre));
                worst = std::max(worst, static_cast<double>(std::fabs(d - want)));
                EXPECT_LE(bounds.low[p], d);
                EXPECT_GE(bounds.high[p], d);
                EXPECT_LE(low, d);
                EXPECT_GE(high, d);
                if (k != 0) continue;
                nearest::PointPacket packet;
                for (int32_t a = 0; a < 3; ++a)
                    std::fill_n(packet.p[a], 8, centre[a]);
                nearest::PointBounds around;
                placed->engine()->bound_points({&packet, 1}, {}, 0.01f, scratch->engine.get(),
                                               &around);
                EXPECT_LE(around.low[0], d);
                EXPECT_GE(around.high[0], d);
            }
        }
    }
    EXPECT_LE(worst, tolerance);
    EXPECT_TRUE(solid->status());
}

TEST(ShapeSolid, DeclaredDistancesAreTheValue) {
    expect_distances(*make<ball>({8, 8, 8}, true), 0.1, 0);
    expect_distances(*make<cone>({7, 7, 5}, true), 0.1, 0);
}

// A cell's chords lie within 3/8 of its square over the radius.
TEST(ShapeSolid, DicedDistancesAreWithinAFiftiethOfAVoxel) {
    expect_distances(*make<ball>({8, 8, 8}), 0.1, 0.002);
    expect_distances(*make<pill>({4, 4, 8}), 0.07, 0.0014);
    expect_distances(*make<ring>({11, 11, 3}), 0.06, 0.0012);
}

TEST(ShapeSolid, TheDicedSurfaceIsClosedAndHasAttributes) {
    for (const auto& made :
         {make<ball>({8, 8, 8}), make<ring>({11, 11, 3}), make<brick>({6, 8, 4})}) {
        const ShapeField field(*part::stage_of(made->part), {}, made->fablet, 0.17,
                               OPENFAB_ISA_AVX2);
        const std::vector<Vec3i> blocks = field.find_blocks(nullptr);
        const auto surface = make_shape_surface(field, blocks, 64 << 20, nullptr);
        EXPECT_GT(surface->patches().size(), 8u);
        std::map<std::array<float, 6>, int> edges;
        double volume = 0;
        for (size_t p = 0; p < surface->patches().size(); ++p) {
            const auto mesh = surface->micro(static_cast<int32_t>(p));
            ASSERT_FALSE(mesh->triangles.empty());
            ASSERT_EQ(mesh->vertex_attributes.size(), mesh->positions.size());
            for (size_t v = 0; v < mesh->positions.size(); ++v) {
                EXPECT_EQ(mesh->vertex_attributes[v], mesh->positions[v].z);
                EXPECT_LT(std::fabs(made->function(mesh->positions[v])), 2e-6f);
            }
            for (const auto& triangle : mesh->triangles) {
                std::array<Vec3f, 3> c;
                for (size_t k = 0; k < 3; ++k)
                    c[k] = mesh->positions[static_cast<size_t>(triangle[k])];
                volume += static_cast<double>(dot(c[0], cross(c[1], c[2]))) / 6;
                for (size_t k = 0; k < 3; ++k) {
                    const Vec3f a = c[k], b = c[(k + 1) % 3];
                    ++edges[{a.x, a.y, a.z, b.x, b.y, b.z}];
                    --edges[{b.x, b.y, b.z, a.x, a.y, a.z}];
                }
            }
        }
        for (const auto& [edge, sum] : edges)
            EXPECT_EQ(sum, 0);
        EXPECT_GT(volume, 100);
    }
}

/// A shape of a part that is scaled.
std::unique_ptr<Made> scaled(std::unique_ptr<Made> made, const Vec3d& by) {
    auto stage = std::make_shared<part::ShapeStage>(*part::stage_of(made->part));
    stage->stretch = {by.x, by.y, by.z};
    auto box = std::make_shared<part::PartMesh>(*made->part.mesh);
    for (Vec3d& p : box->positions)
        p = {p.x * by.x, p.y * by.y, p.z * by.z};
    made->part.mesh = box;
    made->part.geometry = part::ShapeGeometry{std::move(stage)};
    return made;
}

float ball_of_six(const Vec3f& p) {
    return length(p) - 6;
}
float flat_ball(const Vec3f& p) {
    return length(Vec3f{p.x * (1 / 1.5f), p.y, p.z * 2.0f}) - 4;
}

// Values of one that is scaled alike in all directions are distances still.
TEST(ShapeSolid, IsScaled) {
    for (const bool is_distance : {false, true}) {
        const auto made = scaled(make<ball>({8, 8, 8}, is_distance), {1.5, 1.5, 1.5});
        made->function = ball_of_six;
        expect_distances(*made, 0.1, is_distance ? 2e-6 : 0.002);
        const auto flat = scaled(make<ball>({8, 8, 8}, is_distance), {1.5, 1, 0.5});
        flat->function = flat_ball;
        expect_coverage(*flat, 0.03, 4.0 / 3 * M_PI * 64 * 0.75);
        const auto solid = solid_of(*flat, 0.1);
        solid->prepare({.nearest = true}, {OPENFAB_ISA_AVX2, nearest::make_patch_cache(64 << 20)});
        EXPECT_NE(solid->dicing(), nullptr);
        const Box3d size = solid->exact_box({});
        EXPECT_NEAR(size.hi.x, 6, 1e-3);
        EXPECT_NEAR(size.lo.z, -2, 1e-3);
    }
}

/// The distance to an object, less 1.
int grown(void** args) {
    for (int32_t i = 0; i < count(args[1]); ++i)
        out(args[1])[i] = in(args[0])[i] - 1;
    return 0;
}
int grown_bounds(void** args) {
    for (int32_t i = 0; i < count(args[2]); ++i) {
        out(args[2])[i] = in(args[0])[i] - 1;
        out(args[3])[i] = in(args[1])[i] - 1;
    }
    return 0;
}
const openfab_arg kGrownArgs[] = {{abi::kShapeDistance, OPENFAB_FLOAT, 0, 0},
                                  {OPENFAB_ARG_SHAPE_VALUE, OPENFAB_FLOAT, 0, 0}};
const openfab_arg kGrownBoundArgs[] = {{abi::kShapeDistanceLo, OPENFAB_FLOAT, 0, 0},
                                       {abi::kShapeDistanceHi, OPENFAB_FLOAT, 0, 0},
                                       {OPENFAB_ARG_SHAPE_VALUE_LO, OPENFAB_FLOAT, 0, 0},
                                       {OPENFAB_ARG_SHAPE_VALUE_HI, OPENFAB_FLOAT, 0, 0}};
float round_brick(const Vec3f& p) {
    return brick(p) - 1;
}

// A box with edges that are round: what is within 1 of a box, a mesh whose middle is elsewhere.
TEST(ShapeSolid, AsksForTheDistanceToAMesh) {
    const auto made = make<round_brick>({8.5, 10.5, 6.5}, true);
    made->shape.values = {{grown, grown, grown}, 2, kGrownArgs, 0};
    made->shape.bounds = {{grown_bounds, grown_bounds, grown_bounds}, 4, kGrownBoundArgs, 0};
    auto body = std::make_shared<part::Part>();
    openfab_fablet plain{};
    plain.name = "plain";
    body->fablet = &plain;
    body->mesh =
        *part::make_part_mesh(mesh::make_box({6, 8, 4}), plain, {1, 0, 0, 0, 1, 0, 0, 0, 1});
    auto stage = std::make_shared<part::ShapeStage>(*part::stage_of(made->part));
    stage->bodies.push_back(body);
    // The mesh stands on z = 0; that of the shape is about its middle.
    auto box = std::make_shared<part::PartMesh>(*stage->mesh);
    box->center_part_mm = body->mesh->center_part_mm;
    stage->mesh = box;
    made->part.geometry = part::ShapeGeometry{std::move(stage)};
    const Result<std::shared_ptr<Solid>> solid = make_solid(made->part, options_of(0.1));
    ASSERT_TRUE(solid) << solid.error().text();
    const double volume =
        6 * 8 * 4 + 2 * (6 * 8 + 8 * 4 + 4 * 6) + M_PI * (6 + 8 + 4) + 4.0 / 3 * M_PI;
    expect_coverage(*made, 0.04, volume);
    expect_distances(*made, 0.1, 4e-6);
}

// What @Surface moves.
TEST(ShapeSolid, AMeshOfItIsClosedAndHasNormalsAndAttributes) {
    const auto made = make<ball>({8.5, 8.5, 8.5});
    auto box = std::make_shared<part::PartMesh>(*made->part.mesh);
    box->nearest_attributes.push_back({OPENFAB_FLOAT, 1, {0}, {}});
    made->part.mesh = box;
    const auto mesh = mesh_of_shape(made->part, options_of(0.1), {});
    ASSERT_TRUE(mesh);
    const part::PartMesh& m = **mesh;
    std::map<std::array<int32_t, 2>, int> edges;
    double volume = 0;
    ASSERT_EQ(m.corner_normals.size(), 3 * m.triangles.size());
    ASSERT_EQ(m.nearest_attributes.size(), 1u);
    ASSERT_EQ(m.nearest_attributes[0].corner_values.size(), 3 * m.triangles.size());
    for (size_t t = 0; t < m.triangles.size(); ++t) {
        std::array<Vec3d, 3> c;
        for (size_t k = 0; k < 3; ++k) {
            const int32_t from = m.triangles[t][k], to = m.triangles[t][(k + 1) % 3];
            c[k] = m.positions[static_cast<size_t>(from)];
            ++edges[{from, to}];
            --edges[{to, from}];
            const Vec3f n = m.corner_normals[3 * t + k];
            // Differences of floats: their last bits over an eighth of a cell.
            EXPECT_NEAR(dot(n, vec_cast<float>(c[k])) / 4, 1, 1e-4);
            EXPECT_EQ(m.nearest_attributes[0].corner_values[3 * t + k], static_cast<float>(c[k].z));
        }
        volume += dot(c[0], cross(c[1], c[2])) / 6;
    }
    for (const auto& [edge, sum] : edges)
        EXPECT_EQ(sum, 0);
    // Chords of 0.1 mm lie within the ball.
    EXPECT_NEAR(volume / (4.0 / 3 * M_PI * 64), 1, 1e-3);
}

// A face that lies along a side of the box of all is found without dicing it.
TEST(ShapeSolid, ItsBoxIsThatOfItsFaces) {
    const auto made = make<brick>({6.5, 8.5, 4.5});
    const auto solid = solid_of(*made, 0.05);
    ASSERT_NE(solid, nullptr);
    const Box3d box = solid->exact_box({});
    for (int a = 0; a < 3; ++a) {
        const double half = std::array{3.0, 4.0, 2.0}[static_cast<size_t>(a)];
        EXPECT_NEAR(box.lo[a], -half, 0.05 / 1024 + 1e-5);
        EXPECT_NEAR(box.hi[a], half, 0.05 / 1024 + 1e-5);
    }
}

// Not where its box does.
TEST(ShapeSolid, APieceOfItEndsWhereTheShapeDoes) {
    const auto made = make<brick>({6.5, 8.5, 4.5});
    const auto solid = solid_of(*made, 0.05);
    ASSERT_NE(solid, nullptr);
    part::Part part = made->part;
    part.local_to_build = {};
    auto piece = std::make_shared<part::Piece>();
    piece->region.sides.push_back({{0, 0, 1}, 0, false});
    part.piece = std::move(piece);
    const Box3d box = box_in_build(part, *solid);
    constexpr std::array kLow{-3.0, -4.0, -2.0}, kHigh{3.0, 4.0, 0.0};
    for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(box.lo[a], kLow[static_cast<size_t>(a)], 1e-3);
        EXPECT_NEAR(box.hi[a], kHigh[static_cast<size_t>(a)], 1e-3);
    }
}

void expect_refused(const Made& made, const ::testing::Matcher<std::string>& what) {
    const Result<std::shared_ptr<Solid>> solid = kShapeKind.make(made.part, options_of(0.1), {});
    ASSERT_FALSE(solid);
    EXPECT_THAT(solid.error().text(), what);
}

TEST(ShapeSolid, RefusesWhatIsNoSolid) {
    expect_refused(*make<ball>({8, 8, 6}), testing::Says(messages::kShapeOpen, "-*"));
    expect_refused(*make<nothing>({8, 8, 8}), testing::Says(messages::kNowhereNegative));
    expect_refused(*make<wrong>({8, 8, 8}), testing::Says(messages::kShapeNaN, "(*"));
}

}  // namespace
}  // namespace openfab::solid
