// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The winding number at any point equals that of 128-bit integers, also for points on vertices,
// edges and faces; and numbers derived from distances agree with it.

#include <gtest/gtest.h>

#include <cmath>

#include "runtime/nearest/engine/exact.h"
#include "runtime/nearest/engine/winding.h"
#include "tests/support/mesh_surface.h"
#include "tests/support/reference/inside.h"

namespace openfab::nearest {
namespace {

using testing::MeshSurface;
using testing::TriangleMesh;

/// Coordinates that are whole multiples of 2^-20, as the reference's integers: a point n becomes
/// its voxel n, whose center is 256 n + 128.
int64_t to_lattice(float x) {
    const double n = std::ldexp(static_cast<double>(x), 20);
    EXPECT_EQ(n, std::floor(n));
    return static_cast<int64_t>(n);
}

std::vector<reference::SnappedTriangle> lattice_triangles(const TriangleMesh& mesh) {
    std::vector<reference::SnappedTriangle> out;
    for (const auto& t : mesh.triangles) {
        reference::SnappedTriangle s;
        for (size_t k = 0; k < 3; ++k) {
            const Vec3f& p = mesh.positions[t[k]];
            for (int a = 0; a < 3; ++a)
                s[k][a] = 256 * to_lattice(p[a]) + 128;
        }
        out.push_back(s);
    }
    return out;
}

int32_t reference_number(const std::vector<reference::SnappedTriangle>& triangles, const Vec3f& p) {
    Vec3i n;
    for (int a = 0; a < 3; ++a)
        n[a] = static_cast<int32_t>(to_lattice(p[a]));
    return reference::winding(triangles, n);
}

/// Rounds to multiples of 2^-bits.
float round_to(float x, int bits) {
    return static_cast<float>(
        std::ldexp(std::floor(std::ldexp(static_cast<double>(x), bits)), -bits));
}

void round_mesh(TriangleMesh* mesh, int bits) {
    for (Vec3f& p : mesh->positions) {
        for (int a = 0; a < 3; ++a)
            p[a] = round_to(p[a], bits);
    }
}

/// `bits`: of the lattice of points; few of them put points on edges and vertices.
void check(const TriangleMesh& mesh, int bits, int per_patch, uint32_t seed, int count) {
    const MeshSurface surface(mesh, per_patch, per_patch == 0 ? 0 : 0.25f);
    const Winding winding(surface, false);
    const auto triangles = lattice_triangles(mesh);
    std::mt19937 random(seed);
    const Box3f box = mesh.box();
    int inside = 0, outside = 0;
    for (int i = 0; i < count; ++i) {
        Vec3f p;
        for (int a = 0; a < 3; ++a) {
            const float u = static_cast<float>(random() >> 8) * 0x1p-24f;
            p[a] = round_to(box.lo[a] + (u * 1.2f - 0.1f) * box.size()[a], bits);
        }
        const Vec3f& v = mesh.positions[random() % mesh.positions.size()];
        if (i % 7 == 0) p = v;
        if (i % 7 == 1) p.y = v.y, p.z = v.z;
        if (i % 7 == 2) p.z = v.z;
        const int32_t want = reference_number(triangles, p);
        ASSERT_EQ(winding.number(p), want) << p.x << " " << p.y << " " << p.z;
        ++(want > 0 ? inside : outside);
    }
    EXPECT_GT(inside, 0);
    EXPECT_GT(outside, 0);
}

TEST(WindingIsExact, CellsOfAGrid) {
    const std::vector<Vec3i> cells = {{0, 0, 0}, {1, 0, 0},  {1, 1, 0}, {0, 0, 1},
                                      {2, 2, 0}, {-2, 0, 0}, {-3, 1, 1}};
    const TriangleMesh mesh = testing::make_cells(cells, 1.0f);
    for (const int per_patch : {0, 6}) {
        check(mesh, 1, per_patch, 1, 3000);
        check(mesh, 20, per_patch, 2, 1000);
    }
}

TEST(WindingIsExact, CurvedMeshes) {
    TriangleMesh torus = testing::make_torus(48, 24, 2.0, 0.8);
    round_mesh(&torus, 20);
    TriangleMesh ball =
        testing::make_ball(10, [](const Vec3d& d) { return 1.5 + 0.3 * d.x * d.y; });
    round_mesh(&ball, 4);
    for (const int per_patch : {0, 50}) {
        check(torus, 20, per_patch, 3, 500);
        check(torus, 3, per_patch, 4, 500);
        check(ball, 4, per_patch, 5, 2000);
    }
}

TEST(WindingIsExact, RandomSoups) {
    for (uint32_t seed = 1; seed <= 4; ++seed) {
        TriangleMesh soup = testing::make_soup(seed, 150, 2.0f, 2.0f);
        const int bits = seed % 2 == 0 ? 2 : 20;
        round_mesh(&soup, bits);
        check(soup, bits, 0, seed, 1500);
    }
}

__extension__ typedef __int128 Wide;

Wide determinant(const int64_t* a, const int64_t* b, const int64_t* c) {
    Wide sum = 0;
    for (int k = 0; k < 3; ++k) {
        const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
        sum += static_cast<Wide>(c[k]) * (a[k1] * b[k2] - a[k2] * b[k1]);
    }
    return sum;
}

int sign_of(Wide x) {
    return x > 0 ? 1 : x < 0 ? -1 : 0;
}

TEST(WindingIsExact, SignsOfDeterminantsNearZero) {
    // Three points one ulp apart around the diagonal, far from the origin, and one 2^-60 from the
    // origin: no double holds the differences, and the last one decides only where the others give
    // zero.
    std::mt19937 random(5);
    int areas = 0, volumes = 0;
    for (int i = 0; i < 20000; ++i) {
        int64_t c[4][3];
        Vec3f v[4];
        for (int k = 0; k < 4; ++k) {
            const int64_t base = static_cast<int64_t>(random() % 3) * 100 + (1 << 23);
            for (int a = 0; a < 3; ++a) {
                c[k][a] = k == 0 ? random() % 2 : base + static_cast<int64_t>(random() % 2);
                v[k][a] = static_cast<float>(c[k][a]) * (k == 0 ? 0x1p-60f : 1.0f);
            }
        }
        const auto *a = c[0], *b = c[1], *d = c[2], *s = c[3];
        const Wide area = static_cast<Wide>(b[1]) * d[2] - static_cast<Wide>(b[2]) * d[1];
        const Wide near_area = -(b[1] * a[2] + a[1] * d[2]) + (b[2] * a[1] + a[2] * d[1]);
        ASSERT_EQ(area_sign(v[0], v[1], v[2]), sign_of(area != 0 ? area : near_area));
        ASSERT_EQ(area_sign(v[1], v[2], v[0]), sign_of(area != 0 ? area : near_area));
        const Wide volume = determinant(b, d, s);
        const Wide near_volume =
            -(determinant(a, d, s) + determinant(b, a, s) + determinant(b, d, a));
        ASSERT_EQ(volume_sign(v[0], v[1], v[2], v[3]), sign_of(volume != 0 ? volume : near_volume));
        areas += area == 0 && near_area != 0 ? 1 : 0;
        volumes += volume == 0 && near_volume != 0 ? 1 : 0;
    }
    EXPECT_GT(areas, 100);
    EXPECT_GT(volumes, 100);
}

/// Both in one mesh, the second moved.
TriangleMesh together(TriangleMesh a, const TriangleMesh& b, const Vec3f& offset) {
    const auto first = static_cast<int32_t>(a.positions.size());
    for (const Vec3f& p : b.positions)
        a.add(p + offset);
    for (std::array<int32_t, 3> t : b.triangles) {
        for (int32_t& v : t)
            v += first;
        a.triangles.push_back(t);
    }
    return a;
}

/// Packets of points whose number only follows from the previous points, not from distances.
class Walk {
  public:
    Walk(const TriangleMesh& mesh, int per_patch)
        : surface_(mesh, per_patch, 0.25f),
          winding_(surface_),
          triangles_(lattice_triangles(mesh)) {}

    void ask(const PointPacket& packet) {
        PointAnswer answer{};
        const uint32_t got = winding_.inside(packet, answer, {}, &memory_);
        for (uint32_t l = 0; l < 8; ++l) {
            const Vec3f p{packet.p[0][l], packet.p[1][l], packet.p[2][l]};
            const int32_t want = reference_number(triangles_, p);
            ASSERT_EQ((got >> l & 1u) != 0, want > 0) << p.x << " " << p.y << " " << p.z;
            ASSERT_EQ(memory_.known[l].number, want) << p.x << " " << p.y << " " << p.z;
            above_one_ += want > 1 ? 1 : 0;
            outside_ += want <= 0 ? 1 : 0;
        }
    }

    int above_one() const { return above_one_; }
    int outside() const { return outside_; }

  private:
    const MeshSurface surface_;
    const Winding winding_;
    const std::vector<reference::SnappedTriangle> triangles_;
    Winding::Memory memory_;
    int above_one_ = 0, outside_ = 0;
};

/// Row by row as blocks query them, `step` apart from `lo` on; then as many at random, on the same
/// lattice.
void walk(const TriangleMesh& mesh, const Vec3f& lo, float step, const Vec3i& size, Walk* out) {
    const auto at = [&](int32_t i, int axis) { return lo[axis] + static_cast<float>(i) * step; };
    for (int32_t z = 0; z < size.z; z += 8) {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x) {
                PointPacket packet;
                for (int l = 0; l < 8; ++l)
                    packet.p[0][l] = at(x, 0), packet.p[1][l] = at(y, 1),
                    packet.p[2][l] = at(z + l, 2);
                out->ask(packet);
                if (::testing::Test::HasFatalFailure()) return;
            }
        }
    }
    std::mt19937 random(11);
    for (int g = 0; g < 500; ++g) {
        PointPacket packet;
        for (int l = 0; l < 8; ++l) {
            for (int a = 0; a < 3; ++a)
                packet.p[a][l] =
                    at(static_cast<int32_t>(random() % static_cast<uint32_t>(size[a])), a);
            const Vec3f& v = mesh.positions[random() % mesh.positions.size()];
            if (l == 3) packet.p[0][l] = v.x, packet.p[1][l] = v.y, packet.p[2][l] = v.z;
        }
        out->ask(packet);
        if (::testing::Test::HasFatalFailure()) return;
    }
}

TEST(WindingIsExact, NumbersFollowFromPointsBefore) {
    TriangleMesh torus = testing::make_torus(40, 20, 2.0, 0.8);
    round_mesh(&torus, 20);
    const TriangleMesh tori = together(torus, torus, {1, 0.5f, 0.25f});
    {
        Walk rows(tori, 12);
        walk(tori, {-3, -1, -1}, 0.09375f, {70, 24, 24}, &rows);
        EXPECT_GT(rows.above_one(), 100);
        EXPECT_GT(rows.outside(), 100);
    }
    // Points on vertices, edges and planes.
    TriangleMesh ball = testing::make_ball(6, [](const Vec3d& d) { return 1.5 + 0.3 * d.x * d.y; });
    round_mesh(&ball, 3);
    const TriangleMesh cells = testing::make_cells({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, 1.0f);
    for (const TriangleMesh& mesh :
         {together(ball, ball, {0.5f, 0.25f, 0.125f}), together(cells, cells, {0.5f, 0, 0.25f})}) {
        Walk rows(mesh, 5);
        walk(mesh, {-2, -2, -2}, 0.125f, {32, 32, 32}, &rows);
        EXPECT_GT(rows.above_one(), 100);
        EXPECT_GT(rows.outside(), 100);
    }
}

TEST(WindingIsExact, StepsLookOnlyAtWhatTheyPass) {
    const MeshSurface surface(testing::make_torus(240, 120, 20.0, 8.0), 32, 0.25f);
    const Winding winding(surface);
    Winding::Memory memory;
    const PointAnswer nothing{};
    int groups = 0;
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 600; ++x, ++groups) {
            PointPacket packet;
            for (int l = 0; l < 8; ++l) {
                packet.p[0][l] = -29 + 0.1f * static_cast<float>(x);
                packet.p[1][l] = 0.1f * static_cast<float>(y);
                packet.p[2][l] = 0.1f * static_cast<float>(l);
            }
            winding.inside(packet, nothing, {}, &memory);
        }
    }
    // A third of it for the boxes of patches, once. Rays would meet up to four sheets each.
    EXPECT_LT(surface.times_made(), groups / 2);
}

TEST(WindingIsExact, ConclusionsFromDistancesChangeNothing) {
    std::mt19937 random(9);
    for (const TriangleMesh& mesh :
         {testing::make_torus(48, 24, 2.0, 0.8),
          testing::make_cells({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {2, 2, 0}}, 1.0f)}) {
        const MeshSurface surface(mesh, 12, 0.2f);
        const auto engine =
            make_block_engine(surface, testing::make_test_frame({0.1f, 0.1f, 0.1f}, {}));
        const auto scratch = engine->make_scratch();
        const Winding winding(surface);
        Winding::Memory memory;
        const Box3f box = mesh.box();
        for (int g = 0; g < 2000; ++g) {
            PointPacket packet, centers;
            for (int l = 0; l < 8; ++l) {
                for (int a = 0; a < 3; ++a) {
                    const float u = static_cast<float>(random() >> 8) * 0x1p-24f;
                    centers.p[a][l] = box.lo[a] + (u * 1.2f - 0.1f) * box.size()[a];
                    const float w = static_cast<float>(random() >> 8) * 0x1p-24f - 0.5f;
                    packet.p[a][l] = centers.p[a][l] + w * (g % 2 == 0 ? 0.1f : 0.5f);
                    if (g % 3 == 0 && l > 0) packet.p[a][l] = packet.p[a][0] + w * 0.2f;
                }
            }
            PointAnswer answer;
            engine->query_points({&packet, 1}, std::numeric_limits<float>::infinity(),
                                 scratch.get(), &answer);
            uint32_t inside = 0;
            for (uint32_t l = 0; l < 8; ++l) {
                const Vec3f c{centers.p[0][l], centers.p[1][l], centers.p[2][l]};
                if (winding.number(c) > 0) inside |= 1u << l;
            }
            const uint32_t got =
                winding.inside(packet, answer, {&centers, inside, 0.001f}, &memory);
            for (uint32_t l = 0; l < 8; ++l) {
                const Vec3f p{packet.p[0][l], packet.p[1][l], packet.p[2][l]};
                ASSERT_EQ((got >> l & 1u) != 0, winding.number(p) > 0) << g << " " << l;
            }
        }
    }
}

}  // namespace
}  // namespace openfab::nearest
