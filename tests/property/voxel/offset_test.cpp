// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Faces that move along their own normals, which stick out beyond each other at the edges where
// they meet: what is left is what no face has cut away, against closed forms.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "runtime/voxel/coverage.h"
#include "tests/support/reference/closest_point.h"
#include "tests/support/surface/worlds.h"

namespace openfab {
namespace {

using testing::HandMode;

/// Signed distances from planes that count: the least is positive inside, and voxels for which
/// it is nearly 0 are not judged.
using Shape = std::function<double(const Vec3d& p)>;

class Random {
  public:
    explicit Random(uint32_t seed) : random_(seed) {}
    double from(double lo, double hi) {
        return lo + (hi - lo) * static_cast<double>(random_() % 100001) / 100000;
    }
    int32_t whole(int32_t lo, int32_t hi) {
        return lo + static_cast<int32_t>(random_() % static_cast<uint32_t>(hi - lo + 1));
    }

  private:
    std::mt19937 random_;
};

/// A closed mesh of flat polygons, counter-clockwise seen from outside, whose triangles have the
/// polygons' normals; face is the polygon's number.
mesh::Mesh faceted(const std::vector<Vec3d>& positions,
                   const std::vector<std::vector<int32_t>>& polygons) {
    mesh::Mesh mesh;
    mesh.name = "faceted";
    mesh.positions = positions;
    mesh::MeshAttribute uv{"uv", false, 2, {0, 0}, {}, {}}, n{"n", false, 3, {}, {}, {}},
        face{"face", true, 1, {}, {}, {}};
    for (size_t f = 0; f < polygons.size(); ++f) {
        const std::vector<int32_t>& p = polygons[f];
        Vec3d sum;
        for (size_t i = 1; i + 1 < p.size(); ++i)
            sum = sum +
                  cross(positions[p[i]] - positions[p[0]], positions[p[i + 1]] - positions[p[0]]);
        const Vec3f unit = vec_cast<float>(sum * (1 / length(sum)));
        const auto value = static_cast<int32_t>(n.values.size() / 3);
        n.values.insert(n.values.end(), {unit.x, unit.y, unit.z});
        for (size_t i = 1; i + 1 < p.size(); ++i) {
            mesh.triangles.push_back({p[0], p[i], p[i + 1]});
            uv.corners.push_back({0, 0, 0});
            n.corners.push_back({value, value, value});
            face.faces.push_back(static_cast<int32_t>(f));
        }
    }
    mesh.attributes = {uv, n, face};
    return mesh;
}

/// An upright prism over a polygon that is counter-clockwise from above; its faces are bottom, top
/// and sides. `caps` lists the polygon in convex pieces.
mesh::Mesh prism(const std::vector<Vec2<double>>& polygon, double height,
                 const std::vector<std::vector<int32_t>>& caps) {
    std::vector<Vec3d> positions;
    const auto n = static_cast<int32_t>(polygon.size());
    for (const double z : {0.0, height}) {
        for (const Vec2<double>& p : polygon)
            positions.push_back({p.x, p.y, z});
    }
    std::vector<std::vector<int32_t>> faces;
    for (const std::vector<int32_t>& cap : caps) {
        faces.emplace_back(cap.rbegin(), cap.rend());
        faces.push_back(cap);
        for (int32_t& corner : faces.back())
            corner += n;
    }
    for (int32_t i = 0; i < n; ++i)
        faces.push_back({i, (i + 1) % n, (i + 1) % n + n, i + n});
    return faceted(positions, faces);
}

/// What is left of a convex mesh whose planes move by an offset each.
Shape moved_half_spaces(const mesh::Mesh& mesh, const std::function<double(int32_t)>& offset) {
    struct Plane {
        Vec3d n;
        double at;
    };
    std::vector<Plane> planes;
    const mesh::MeshAttribute& face = *mesh.find("face");
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& v = mesh.triangles[t];
        Vec3d n = cross(mesh.positions[v[1]] - mesh.positions[v[0]],
                        mesh.positions[v[2]] - mesh.positions[v[0]]);
        n = n * (1 / length(n));
        planes.push_back({n, dot(n, mesh.positions[v[0]]) + offset(face.faces[t])});
    }
    return [planes](const Vec3d& p) {
        double least = 1e9;
        for (const Plane& plane : planes)
            least = std::min(least, plane.at - dot(plane.n, p));
        return least;
    };
}

Affine3d turned(Random* random) {
    const Vec3d axis{random->from(-1, 1), random->from(-1, 1), random->from(0.1, 1)};
    const Vec3d u = axis * (1 / length(axis));
    const double angle = random->from(0, 6), c = std::cos(angle), s = std::sin(angle), k = 1 - c;
    Affine3d out;
    out.m = {c + k * u.x * u.x,       k * u.x * u.y - s * u.z, k * u.x * u.z + s * u.y,
             k * u.x * u.y + s * u.z, c + k * u.y * u.y,       k * u.y * u.z - s * u.x,
             k * u.x * u.z - s * u.y, k * u.y * u.z + s * u.x, c + k * u.z * u.z};
    return out;
}

/// Prints the mesh with all triangles displaced, in voxels of about `pitch`, and compares each voxel
/// with the shape of mesh space.
void expect_shape(const mesh::Mesh& mesh, HandMode mode, float amplitude, double pitch,
                  const Affine3d& turn, const Shape& shape, const std::string& what) {
    testing::PartOptions options;
    options.uniform_values = testing::hand_uniforms(mode, amplitude);
    options.transform = turn;
    const part::Part part = testing::make_part(testing::hand_fablet(false), mesh, options);
    surface::SurfaceOptions dicing;
    dicing.micro_edge_mm = pitch;
    const auto surface = std::move(*surface::Surface::create(part, dicing));
    ASSERT_EQ(testing::open_edges(testing::triangles_of(*surface, surface::kForCoverage)), 0)
        << what;
    part::Grid grid;
    const Box3d box = surface->exact_box(part.local_to_build);
    grid.pitch_mm = {pitch, pitch * 1.1, pitch * 0.9};
    grid.origin_mm = box.lo - grid.pitch_mm * 1.3;
    for (int axis = 0; axis < 3; ++axis)
        grid.size[axis] = static_cast<int32_t>(box.size()[axis] / grid.pitch_mm[axis]) + 4;
    const voxel::Voxeliser voxeliser(part, *surface, grid);
    // Vertices are snapped to 1/256 voxel, in each of three directions.
    const double slack = pitch / 100;
    int64_t wrong = 0;
    voxel::SlabMask mask;
    std::string first;
    for (int32_t z = 0; z < grid.size.z; ++z) {
        if (z % 8 == 0) voxeliser.coverage(z / 8, &mask);
        for (int32_t y = 0; y < grid.size.y; ++y) {
            for (int32_t x = 0; x < grid.size.x; ++x) {
                const Vec3d center{grid.origin_mm.x + (x + 0.5) * grid.pitch_mm.x,
                                   grid.origin_mm.y + (y + 0.5) * grid.pitch_mm.y,
                                   grid.origin_mm.z + (z + 0.5) * grid.pitch_mm.z};
                Vec3d p;  // the turn is a rotation
                for (size_t axis = 0; axis < 3; ++axis) {
                    p[static_cast<int>(axis)] = turn.m[axis] * center.x +
                                                turn.m[3 + axis] * center.y +
                                                turn.m[6 + axis] * center.z;
                }
                const double inside = shape(p);
                if (std::fabs(inside) < slack) continue;
                const bool in_mask = x >= mask.x0 && x < mask.x0 + mask.width && y >= mask.y0 &&
                                     y < mask.y0 + mask.height;
                const bool solid =
                    in_mask &&
                    (mask.mask[static_cast<size_t>((y - mask.y0) * mask.width + x - mask.x0)] >>
                         (z % 8) &
                     1) != 0;
                if (solid == (inside > 0)) continue;
                if (++wrong == 1) {
                    first = fmt::format("{} at {:.3f} {:.3f} {:.3f}, {:.4f} mm off",
                                        solid ? "solid" : "void", p.x, p.y, p.z, inside);
                }
            }
        }
    }
    EXPECT_EQ(wrong, 0) << what << ": " << first;
}

std::vector<int32_t> ring(int32_t n) {
    std::vector<int32_t> out;
    for (int32_t i = 0; i < n; ++i)
        out.push_back(i);
    return out;
}

TEST(Offset, ACubeCutBackIsASmallerCube) {
    const mesh::Mesh cube = testing::cube(20);
    for (const double pitch : {0.4, 0.53, 1.0, 1.7}) {
        for (const float depth : {-1.0f, -2.0f, -5.0f, -9.9f, -12.0f}) {
            expect_shape(cube, HandMode::kOffset, depth, pitch, {},
                         moved_half_spaces(cube, [&](int32_t) { return depth; }),
                         fmt::format("{} mm in voxels of {} mm", depth, pitch));
        }
    }
}

TEST(Offset, BoxesLoseADepthOfTheirOwnAtEachFace) {
    for (uint32_t seed = 1; seed <= 12; ++seed) {
        Random random(seed);
        mesh::Mesh box = mesh::make_box({random.from(2, 6), random.from(2, 6), random.from(2, 6)});
        const float depth = static_cast<float>(-random.from(0.1, 1.2));
        expect_shape(
            box, HandMode::kSteps, depth, random.from(0.11, 0.3),
            seed % 3 == 0 ? Affine3d{} : turned(&random),
            moved_half_spaces(box, [&](int32_t face) { return depth * (1 + face % 3) / 3; }),
            fmt::format("seed {}", seed));
    }
}

/// Sharp and blunt edges, in corners of three.
TEST(Offset, PrismsAreTheMovedHalfSpaces) {
    for (uint32_t seed = 1; seed <= 16; ++seed) {
        Random random(seed);
        const int32_t n = 3 + static_cast<int32_t>(seed % 7);
        std::vector<Vec2<double>> polygon;
        for (int32_t i = 0; i < n; ++i) {
            const double angle = 2 * std::numbers::pi * (i + random.from(-0.35, 0.35)) / n;
            polygon.push_back({3 * std::cos(angle), 2.5 * std::sin(angle)});
        }
        const mesh::Mesh mesh = prism(polygon, random.from(1.5, 4), {ring(n)});
        const float depth = static_cast<float>(-random.from(0.1, 0.7));
        expect_shape(mesh, HandMode::kOffset, depth, random.from(0.1, 0.2), turned(&random),
                     moved_half_spaces(mesh, [&](int32_t) { return depth; }),
                     fmt::format("seed {}, {} sides", seed, n));
    }
}

TEST(Offset, TetrahedraAreTheMovedHalfSpaces) {
    for (uint32_t seed = 1; seed <= 24; ++seed) {
        Random random(seed);
        std::vector<Vec3d> p;
        for (int32_t i = 0; i < 4; ++i)
            p.push_back({random.from(-3, 3), random.from(-3, 3), random.from(-3, 3)});
        if (dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]) > 0) std::swap(p[0], p[1]);
        const mesh::Mesh mesh = faceted(p, {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}});
        const float depth = static_cast<float>(-random.from(0.02, 0.5));
        expect_shape(mesh, HandMode::kOffset, depth, random.from(0.08, 0.15), {},
                     moved_half_spaces(mesh, [&](int32_t) { return depth; }),
                     fmt::format("seed {}", seed));
    }
}

/// Spikes of more than three faces.
TEST(Offset, PyramidsAreTheMovedHalfSpaces) {
    for (uint32_t seed = 1; seed <= 12; ++seed) {
        Random random(seed);
        const int32_t n = 3 + static_cast<int32_t>(seed % 5);
        std::vector<Vec3d> p;
        std::vector<std::vector<int32_t>> faces(1);
        for (int32_t i = 0; i < n; ++i) {
            const double angle = 2 * std::numbers::pi * (i + random.from(-0.35, 0.35)) / n;
            p.push_back({2 * std::cos(angle), 2 * std::sin(angle), 0});
            faces[0].insert(faces[0].begin(), i);
            faces.push_back({i, (i + 1) % n, n});
        }
        p.push_back({random.from(-0.5, 0.5), random.from(-0.5, 0.5), random.from(1, 8)});
        const mesh::Mesh mesh = faceted(p, faces);
        const float depth = static_cast<float>(-random.from(0.05, 0.5));
        expect_shape(mesh, HandMode::kOffset, depth, random.from(0.08, 0.15), turned(&random),
                     moved_half_spaces(mesh, [&](int32_t) { return depth; }),
                     fmt::format("seed {}", seed));
    }
}

/// At the concave edge the moved faces part, and the strip between them is a bevel.
TEST(Offset, AnLLosesTheStripsBevelToo) {
    for (uint32_t seed = 1; seed <= 8; ++seed) {
        Random random(seed);
        const double a = random.from(1.5, 3), b = random.from(1.5, 3), w = 5, h = random.from(2, 3);
        const mesh::Mesh mesh = prism({{0, 0}, {w, 0}, {w, b}, {a, b}, {a, w}, {0, w}}, h,
                                      {{0, 1, 2, 3}, {0, 3, 4, 5}});
        const double d = random.from(0.1, 0.7);
        const Shape shape = [=](const Vec3d& p) {
            const double box =
                std::min({p.x - d, w - d - p.x, p.y - d, w - d - p.y, p.z - d, h - d - p.z});
            const double x = p.x - (a - d), y = p.y - (b - d);  // into the notch
            const double notch = std::min({x, y, (x + y - d) / std::numbers::sqrt2});
            return std::min(box, -notch);
        };
        expect_shape(mesh, HandMode::kOffset, static_cast<float>(-d), random.from(0.1, 0.2),
                     turned(&random), shape, fmt::format("seed {}", seed));
    }
}

/// The mirror image: the faces of a hollow that grow into it.
TEST(Offset, AHollowThatGrowsShutIsASmallerHollow) {
    for (uint32_t seed = 1; seed <= 8; ++seed) {
        Random random(seed);
        const mesh::Mesh hollow = testing::cube(4);
        mesh::Mesh mesh = testing::joined(testing::cube(6), testing::inside_out(hollow), {1, 1, 1});
        // inside_out leaves the normals to others.
        mesh::MeshAttribute* n = nullptr;
        for (mesh::MeshAttribute& a : mesh.attributes)
            n = a.name == "n" ? &a : n;
        for (size_t i = n->values.size() / 2; i < n->values.size(); ++i)
            n->values[i] = -n->values[i];
        const double d = random.from(0.1, 0.9);
        const Shape shape = [=](const Vec3d& p) {
            const double inner = std::min(
                {p.x - 1 - d, 5 - d - p.x, p.y - 1 - d, 5 - d - p.y, p.z - 1 - d, 5 - d - p.z});
            const double outer = std::min({p.x, 6 - p.x, p.y, 6 - p.y, p.z, 6 - p.z});
            // The outside, where strips bevel the edges, is for other tests.
            return outer < 0.05 ? 0 : -inner;
        };
        expect_shape(mesh, HandMode::kOffset, static_cast<float>(d), random.from(0.15, 0.25),
                     turned(&random), shape, fmt::format("seed {}", seed));
    }
}

TEST(Offset, APlateThatIsCutThroughFromBothSidesIsGone) {
    const mesh::Mesh plate = testing::card(8, 6, 1);
    for (const float depth : {-0.3f, -0.49f, -0.51f, -0.8f, -1.5f, -4.0f}) {
        expect_shape(plate, HandMode::kOffset, depth, 0.2, {},
                     moved_half_spaces(plate, [&](int32_t) { return depth; }),
                     fmt::format("{} mm", depth));
    }
}

/// Depths that vary along the edges: only what lies within a face's depth below it goes.
TEST(Offset, DentsTakeWhatLiesAboveThem) {
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        Random random(seed);
        const Vec3d size{random.from(4, 7), random.from(4, 7), random.from(4, 7)};
        const mesh::Mesh box = mesh::make_box(size);
        const float depth = static_cast<float>(-random.from(0.2, 1.0));
        // The part's own space has its origin in the middle of the box.
        const Vec3d half = size * 0.5;
        const auto wave = [](double x) {
            const double f = x - std::floor(x);
            return 4 * f * (1 - f);
        };
        const Shape shape = [=](const Vec3d& at) {
            const Vec3d p = at - Vec3d{0, 0, half.z};
            double least = 1e9;
            for (int axis = 0; axis < 3; ++axis) {
                for (const double side : {-1.0, 1.0}) {
                    Vec3d foot = p;
                    foot[axis] = side * half[axis];
                    const double cut = -depth * wave(0.12 * foot.x + 0.45) *
                                       wave(0.11 * foot.y + 0.5) * wave(0.13 * foot.z + 0.5);
                    least = std::min(least, half[axis] - side * p[axis] - cut);
                }
            }
            // The wave is diced into flat pieces.
            return std::fabs(least) < 0.004 ? 0 : least;
        };
        expect_shape(box, HandMode::kDents, depth, random.from(0.1, 0.2), {}, shape,
                     fmt::format("seed {}", seed));
    }
}

/// The ends of faces that stick out beyond others lie outside, and so are never the nearest.
TEST(Offset, InsideTheNearestSurfaceIsWhatIsLeft) {
    const mesh::Mesh cube = testing::cube(4);
    testing::PartOptions options;
    options.uniform_values = testing::hand_uniforms(HandMode::kOffset, -0.6f);
    const part::Part part = testing::make_part(testing::hand_fablet(false), cube, options);
    surface::SurfaceOptions dicing;
    dicing.micro_edge_mm = 0.25;
    const auto surface = std::move(*surface::Surface::create(part, dicing));
    const auto triangles = testing::triangles_of(*surface, surface::kForQuery);
    Random random(1);
    for (int32_t i = 0; i < 200; ++i) {
        // Part space has its origin in the middle.
        const Vec3d p{random.from(-1.4, 1.4), random.from(-1.4, 1.4), random.from(-1.4, 1.4)};
        double nearest = 1e9;
        for (const auto& t : triangles) {
            const Vec3d at = reference::closest_point(
                p, vec_cast<double>(t[0]), vec_cast<double>(t[1]), vec_cast<double>(t[2]));
            nearest = std::min(nearest, length(p - at));
        }
        const double left = 1.4 - std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
        EXPECT_NEAR(nearest, left, 1e-6) << p.x << ' ' << p.y << ' ' << p.z;
    }
}

}  // namespace
}  // namespace openfab
