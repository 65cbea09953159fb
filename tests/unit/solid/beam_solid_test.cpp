// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Beams against all of them compared in doubles: distances, attributes, coverage, bounds, tops; volumes
// against closed forms.

#include "runtime/solid/beams/beam_solid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "mesh/read/beams_text.h"
#include "runtime/part/bind_beams.h"
#include "runtime/part/part_mesh.h"
#include "runtime/solid/beams/beam_tree.h"
#include "runtime/solid/kinds/kinds.h"
#include "runtime/solid/voxel_frame.h"
#include "tests/unit/solid/covered.h"

namespace openfab::solid {
namespace {

const openfab_varying kInputs[] = {{"heat", "float", OPENFAB_FLOAT, 1, -1, nullptr},
                                   {"kind", "int", OPENFAB_INT, 1, -1, nullptr}};

/// What the union says of a point, in doubles.
struct Truth {
    double distance = 1e300, heat = 0;
    size_t beam = 0;
};

/// A round cone is the union of balls along its axis: the least distance to one, at which place.
struct OnAxis {
    double distance = 0, share = 0;
};

OnAxis distance_to(const mesh::Beams& beams, const mesh::Beam& beam, const Vec3d& p) {
    const Vec3d a = beams.nodes[beam.nodes[0]], along = beams.nodes[beam.nodes[1]] - a;
    const double r0 = beam.radii[0], r1 = beam.radii[1], square = dot(along, along);
    const auto at = [&](double t) {
        return OnAxis{length(p - (a + along * t)) - (r0 + t * (r1 - r0)), t};
    };
    const OnAxis ends[2] = {at(0), at(1)};
    OnAxis best = ends[0].distance <= ends[1].distance ? ends[0] : ends[1];
    const double fall = r0 - r1;
    if (square <= fall * fall) return best;
    // Where the derivative of the distance along the axis is that of the radius.
    const double y = dot(p - a, along) / square;
    const double x = length(p - (a + along * y));
    const double t = y - x * fall / std::sqrt(square * (square - fall * fall));
    return t > 0 && t < 1 ? at(t) : best;
}

Truth truth(const mesh::Beams& beams, const Vec3d& p) {
    Truth best;
    const std::vector<float>& heat = beams.attributes[0].values;
    for (size_t i = 0; i < beams.beams.size(); ++i) {
        const mesh::Beam& beam = beams.beams[i];
        const auto [d, t] = distance_to(beams, beam, p);
        if (d >= best.distance) continue;
        best = {d, heat[beam.nodes[0]] + t * (heat[beam.nodes[1]] - heat[beam.nodes[0]]), i};
    }
    return best;
}

mesh::Beams random_beams(int count, double size, uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> at(0, size), radius(0.05, 1.2), step(-4, 4);
    mesh::Beams out;
    out.attributes = {{"heat", false, 1, {}, {}}, {"kind", true, 1, {}, {}}};
    for (int i = 0; i < count; ++i) {
        const Vec3d a{at(random), at(random), at(random)};
        out.nodes.push_back(a);
        out.nodes.push_back(a + Vec3d{step(random), step(random), step(random)});
        out.beams.push_back(
            {{2 * i, 2 * i + 1},
             {static_cast<float>(radius(random)), static_cast<float>(radius(random))}});
        if (i % 10 == 0) out.beams.back().nodes[1] = 2 * i;  // a ball
        if (i % 10 == 0) out.beams.back().radii[1] = out.beams.back().radii[0];
        out.attributes[0].values.push_back(static_cast<float>(at(random)));
        out.attributes[0].values.push_back(static_cast<float>(at(random)));
        out.attributes[1].ints.push_back(i);
    }
    return out;
}

mesh::Beams beams_of(const std::string& text) {
    Result<mesh::ReadBeams> read = mesh::parse_beams(text, "test.txt", 1 << 24);
    EXPECT_TRUE(read) << read.error().text();
    return read ? read->beams : mesh::Beams{};
}

/// A turned part of beams in a grid of its own.
struct Made {
    std::shared_ptr<const mesh::Beams> beams;
    openfab_fablet fablet{};
    part::Part part;
    std::shared_ptr<Solid> solid;
    part::Grid grid;
    std::array<float, OPENFAB_FRAME_COUNT> frame{};
    Vec3i base;
    std::unique_ptr<Placed> placed;
    std::unique_ptr<Scratch> scratch;

    Made(const mesh::Beams& from, double pitch, double scale = 1)
        : beams(std::make_shared<const mesh::Beams>(from)) {
        fablet.abi_version = OPENFAB_ABI_VERSION;
        fablet.name = "Made";
        fablet.nearest_count = from.attributes.empty() ? 0 : 2;
        fablet.nearest = kInputs;
        const std::array<double, 9> s{scale, 0, 0, 0, scale, 0, 0, 0, scale};
        part.name = "beams";
        part.fablet = &fablet;
        part.mesh = *part::make_part_mesh(mesh::box_mesh("beams", from), fablet, s);
        part.geometry = part::BeamGeometry{part::make_part_beams(beams, fablet, s, *part.mesh)};
        part.local_to_build.m = {0.40923325984932796, -0.9119847905251406, 0.02849352354321616,
                                 0.708653140405184,   0.2980114870440326,  -0.6395309845376336,
                                 0.5747511336456527,  0.28190937451709513, 0.76823709812298};
        EXPECT_EQ(&kind_of(part), &kBeamKind);
        solid = *kBeamKind.make(part, {}, {});
        const Box3d box = solid->exact_box(part.local_to_build);
        grid.pitch_mm = {pitch, pitch * 1.3, pitch * 0.8};
        for (int a = 0; a < 3; ++a) {
            const double p = grid.pitch_mm[a];
            const double lo = std::floor(box.lo[a] / p), hi = std::ceil(box.hi[a] / p);
            grid.origin_mm[a] = lo * p;
            grid.size[a] = static_cast<int32_t>(hi - lo);
        }
        frame = part::make_frame(part, grid);
        base = part::part_base_voxel(part, grid);
        solid->prepare({.nearest = true, .attributes = fablet.nearest_count > 0, .sign = true}, {});
        placed = solid->place({part, grid, frame});
        placed->begin_queries();
        scratch = placed->make_scratch();
    }
    Made(const Made&) = delete;
    Made& operator=(const Made&) = delete;

    /// Part-local to the beams' own space.
    Vec3d own(const Vec3f& p) const {
        return (vec_cast<double>(p) + part.mesh->center_part_mm) *
               (1 / std::get<part::BeamGeometry>(part.geometry).beams->scale);
    }
    Vec3f centre(const Vec3i& voxel) const { return VoxelFrame(frame).box(voxel, voxel).lo; }
    std::vector<uint8_t> covered() const { return solid::covered(*placed, grid); }
};

TEST(BeamSolid, TheTruthIsTheLeastOverBalls) {
    const mesh::Beams beams = random_beams(300, 4, 9);
    for (const mesh::Beam& beam : beams.beams) {
        const Vec3d p{1, 2, 3};
        double least = 1e300;
        for (int i = 0; i <= 2000; ++i) {
            const double t = i / 2000.0;
            const Vec3d c = beams.nodes[beam.nodes[0]] * (1 - t) + beams.nodes[beam.nodes[1]] * t;
            least = std::min(least, length(p - c) - (beam.radii[0] * (1 - t) + beam.radii[1] * t));
        }
        EXPECT_NEAR(distance_to(beams, beam, p).distance, least, 1e-5);
    }
}

TEST(BeamSolid, PointsFindTheNearestOfAThousand) {
    const mesh::Beams beams = random_beams(1000, 40, 7);
    const Made made(beams, 0.3);
    std::mt19937 random(11);
    std::uniform_real_distribution<float> at(-26, 26);
    std::vector<nearest::PointPacket> packets(12500);
    for (nearest::PointPacket& packet : packets) {
        for (auto& axis : packet.p)
            for (float& x : axis)
                x = at(random);
    }
    std::vector<nearest::PointAnswer> answers(packets.size());
    made.placed->engine()->query_points(packets, kInfinity, made.scratch->engine.get(),
                                        answers.data());
    double worst = 0, worst_heat = 0;
    int other_side = 0, other_beam = 0;
    for (size_t g = 0; g < packets.size(); ++g) {
        const uint32_t inside = made.placed->inside(packets[g], answers[g], {}, made.scratch.get());
        std::array<float, 8> heat{};
        std::array<uint32_t, 8> kind{};
        float* floats[] = {heat.data()};
        uint32_t* ints[] = {kind.data()};
        std::array<std::array<float, 8>, 6> surface{};
        nearest::PointTargets targets;
        for (size_t a = 0; a < 3; ++a)
            targets.position[a] = surface[a].data(), targets.normal[a] = surface[3 + a].data();
        targets.values = floats;
        targets.flat = ints;
        made.placed->read_points(answers[g], targets, made.scratch.get());
        for (size_t l = 0; l < 8; ++l) {
            const Vec3f p{packets[g].p[0][l], packets[g].p[1][l], packets[g].p[2][l]};
            const Truth want = truth(beams, made.own(p));
            const double d = std::sqrt(static_cast<double>(answers[g].distance2[l]));
            worst = std::max(worst, std::fabs(d - std::fabs(want.distance)));
            other_side += (inside >> l & 1) != (want.distance < 0 ? 1u : 0u) &&
                          std::fabs(want.distance) > 1e-5;
            // Seams between beams may be on either side of a tie.
            if (kind[l] != want.beam) {
                ++other_beam;
                continue;
            }
            worst_heat = std::max(worst_heat, std::fabs(static_cast<double>(heat[l]) - want.heat));
            const Vec3f on{surface[0][l], surface[1][l], surface[2][l]};
            const Vec3f out{surface[3][l], surface[4][l], surface[5][l]};
            EXPECT_NEAR(static_cast<double>(length(on - p)), d, 2e-5);
            EXPECT_NEAR(static_cast<double>(length(out)), 1.0, 1e-5);
            if (d > 1e-2) {
                const float sign = want.distance < 0 ? -1.0f : 1.0f;
                EXPECT_GT(dot(p - on, out) * sign, 0.999f * static_cast<float>(d));
            }
        }
    }
    // Rule 16 with coordinates of 26 mm.
    EXPECT_LE(worst, 26 * 0x1p-20);
    EXPECT_LE(worst_heat, 1e-2);
    EXPECT_EQ(other_side, 0);
    EXPECT_LE(other_beam, 10);
}

TEST(BeamSolid, BlocksHaveTheBitsOfPointsAndBoundsHoldThem) {
    for (const double scale : {1.0, 2.5}) {
        const Made made(random_beams(300, 12, 3), 0.21, scale);
        auto answer = std::make_unique<nearest::BlockAnswer>();
        std::vector<float> heat(512), step(3 * 512);
        std::vector<uint32_t> kind(512);
        float* floats[] = {heat.data()};
        float* steps[] = {step.data(), step.data() + 512, step.data() + 1024};
        uint32_t* ints[] = {kind.data()};
        std::mt19937 random(5);
        std::uniform_int_distribution<int32_t> at(-4, 4);
        for (int k = 0; k < 60; ++k) {
            const Vec3i lowest{8 * at(random), 8 * at(random), 8 * at(random)};
            std::array<uint8_t, 64> active{};
            for (uint8_t& bits : active)
                bits = static_cast<uint8_t>(random());
            made.placed->engine()->query({.block = lowest, .active = active.data()},
                                         made.scratch->engine.get(), answer.get());
            made.placed->read(*answer, active.data(), {floats, steps, ints}, made.scratch.get());
            nearest::BlockBounds bounds;
            made.placed->engine()->bound_blocks({&lowest, 1}, made.scratch->engine.get(), &bounds);
            nearest::BoxBounds box;
            made.placed->engine()->bounds(lowest, 8, made.scratch->engine.get(), &box);
            nearest::PointPacket packet;
            for (size_t column = 0; column < 64; ++column) {
                for (size_t z = 0; z < 8; ++z) {
                    const Vec3f p = made.centre(lowest + Vec3i{static_cast<int32_t>(column % 8),
                                                               static_cast<int32_t>(column / 8),
                                                               static_cast<int32_t>(z)});
                    for (size_t a = 0; a < 3; ++a)
                        packet.p[a][z] = p[static_cast<int>(a)];
                }
                packet.mask = active[column];
                nearest::PointAnswer one;
                made.placed->engine()->query_points({&packet, 1}, kInfinity,
                                                    made.scratch->engine.get(), &one);
                for (size_t z = 0; z < 8; ++z) {
                    const size_t v = 8 * column + z;
                    EXPECT_EQ(answer->distance2[v], one.distance2[z]);
                    EXPECT_EQ(answer->item[v], one.item[z]);
                    if ((active[column] >> z & 1) == 0) {
                        EXPECT_EQ(heat[v], 0);
                        continue;
                    }
                    const float d = std::sqrt(answer->distance2[v]);
                    const auto& pieces = made.placed->engine()->pieces();
                    for (size_t q = 0; q < 32; ++q) {
                        const Vec3i in =
                            Vec3i{static_cast<int32_t>(column % 8),
                                  static_cast<int32_t>(column / 8), static_cast<int32_t>(z)} -
                            pieces.lowest[q];
                        bool holds = true;
                        for (int a = 0; a < 3; ++a)
                            holds = holds && in[a] >= 0 && in[a] < pieces.size[a];
                        if (!holds) continue;
                        EXPECT_LE(bounds.low[q], d);
                        EXPECT_GE(bounds.high[q], d);
                    }
                    EXPECT_LE(d, box.distance_hi);
                    bool in_case = false;
                    for (int32_t c = 0; c < box.count; ++c) {
                        const nearest::NearestCase& one_case = box.cases[static_cast<size_t>(c)];
                        in_case |= d >= one_case.distance_lo && heat[v] >= one_case.float_lo[0] &&
                                   heat[v] <= one_case.float_hi[0] &&
                                   static_cast<int32_t>(kind[v]) >= one_case.int_lo[0] &&
                                   static_cast<int32_t>(kind[v]) <= one_case.int_hi[0];
                    }
                    EXPECT_TRUE(in_case);
                }
            }
        }
    }
}

TEST(BeamSolid, CoversWhatIsInsideTheUnion) {
    mesh::Beams beams = random_beams(150, 9, 21);
    const Made made(beams, 0.2);
    const std::vector<uint8_t> all = made.covered();
    std::vector<int32_t> tops(static_cast<size_t>(made.grid.size.x) * made.grid.size.y, 0);
    int64_t different = 0, inside = 0;
    size_t i = 0;
    for (int32_t z = 0; z < made.grid.size.z; ++z) {
        for (int32_t y = 0; y < made.grid.size.y; ++y) {
            for (int32_t x = 0; x < made.grid.size.x; ++x, ++i) {
                inside += all[i];
                if (all[i] != 0) tops[static_cast<size_t>(y) * made.grid.size.x + x] = z;
                const double d =
                    truth(beams, made.own(made.centre(Vec3i{x, y, z} - made.base))).distance;
                different += std::fabs(d) > 1e-5 && (d < 0) != (all[i] != 0) ? 1 : 0;
            }
        }
    }
    EXPECT_GT(inside, 10000);
    EXPECT_EQ(different, 0);
    TopRows rows;
    rows.width = made.grid.size.x;
    rows.top.assign(tops.size(), 0);
    made.placed->raise_tops({0, 0, made.grid.size.x, made.grid.size.y}, &rows);
    EXPECT_EQ(rows.top, tops);
    // In parts, too.
    rows.top.assign(tops.size(), 0);
    made.placed->raise_tops({0, 0, made.grid.size.x, 13}, &rows);
    made.placed->raise_tops({0, 13, 21, made.grid.size.y}, &rows);
    made.placed->raise_tops({21, 13, made.grid.size.x, made.grid.size.y}, &rows);
    EXPECT_EQ(rows.top, tops);
}

double volume(const mesh::Beams& beams, double pitch) {
    const Made made(beams, pitch);
    const std::vector<uint8_t> all = made.covered();
    return static_cast<double>(std::ranges::count(all, 1)) * pitch * pitch * pitch * 1.3 * 0.8;
}

TEST(BeamSolid, VolumesAreThoseOfClosedForms) {
    const double ball = 4.0 / 3 * M_PI;
    EXPECT_NEAR(
        volume(beams_of("node 0 0 0 2\nnode 5 0 0 2\nstrut 0 1"), 0.03) / (ball * 8 + M_PI * 4 * 5),
        1, 1e-4);
    EXPECT_NEAR(volume(beams_of("node 1 2 3 2\nball 0"), 0.019) / (ball * 8), 1, 1e-4);
    // A round cone: the cone between the circles in which it touches its balls, and their caps.
    const double r0 = 2, r1 = 0.7, d = 4, k = (r0 - r1) / d, c = std::sqrt(1 - k * k);
    const double height = d - k * (r0 - r1), q0 = r0 * c, q1 = r1 * c;
    const double cone = M_PI * height / 3 * (q0 * q0 + q0 * q1 + q1 * q1);
    const auto cap = [](double r, double h) { return M_PI * h * h * (3 * r - h) / 3; };
    EXPECT_NEAR(volume(beams_of("node 0 0 0 2\nnode 0 4 0 0.7\nstrut 0 1"), 0.03) /
                    (cone + cap(r0, r0 + r0 * k) + cap(r1, r1 - r1 * k)),
                1, 1e-4);
    // Two that cross: less what two cylinders share, 16/3 r³.
    EXPECT_NEAR(volume(beams_of("node -5 0 0 1\nnode 5 0 0 1\nnode 0 -5 0 1\nnode 0 5 0 1\n"
                                "strut 0 1\nstrut 2 3"),
                       0.03) /
                    (2 * (ball + M_PI * 10) - 16.0 / 3),
                1, 1e-4);
    // One ball that holds the other.
    EXPECT_NEAR(volume(beams_of("node 0 0 0 2\nnode 1 0 0 0.5\nstrut 1 0"), 0.019) / (ball * 8), 1,
                1e-4);
    // Sharp.
    const double s = 0.5, sc = std::sqrt(0.75);
    EXPECT_NEAR(volume(beams_of("node 0 0 0 2\nnode 0 0 4 0\nstrut 0 1"), 0.03) /
                    (M_PI / 3 * 4 * sc * sc * 3 + cap(2, 2 + 2 * s)),
                1, 1e-4);
}

mesh::Beams cut_beam(mesh::BeamEnd first, mesh::BeamEnd second) {
    mesh::Beams out = beams_of("node 0 0 0 2\nnode 0 3 4 1\nstrut 0 1");
    out.beams[0].ends = {first, second};
    return out;
}

TEST(BeamSolid, BeamsCutAcrossHaveFlatEndsOrDomes) {
    const double cone = M_PI * 5 / 3 * (4 + 2 + 1), half = 2.0 / 3 * M_PI;
    EXPECT_NEAR(volume(cut_beam(mesh::BeamEnd::kFlat, mesh::BeamEnd::kFlat), 0.03) / cone, 1, 1e-4);
    EXPECT_NEAR(
        volume(cut_beam(mesh::BeamEnd::kDome, mesh::BeamEnd::kFlat), 0.03) / (cone + half * 8), 1,
        1e-4);
    EXPECT_NEAR(volume(cut_beam(mesh::BeamEnd::kDome, mesh::BeamEnd::kDome), 0.03) /
                    (cone + half * 8 + half),
                1, 1e-4);
}

TEST(BeamSolid, DistancesOfCutBeamsAreThoseOfTheirOutline) {
    using mesh::BeamEnd;
    for (const auto& [first, second] : {std::pair{BeamEnd::kFlat, BeamEnd::kFlat},
                                        {BeamEnd::kDome, BeamEnd::kFlat},
                                        {BeamEnd::kFlat, BeamEnd::kDome}}) {
        const mesh::Beams beams = cut_beam(first, second);
        const BeamRecord record = make_record(beams.beams[0], 0, beams.nodes[0], beams.nodes[1], 1);
        // Points of the outline, (y, x), close together.
        std::vector<std::array<double, 2>> outline;
        for (int i = 0; i <= 4000; ++i) {
            const double t = i / 4000.0, turn = t * M_PI / 2;
            outline.push_back({5 * t, 2 - t});
            outline.push_back(first == BeamEnd::kFlat
                                  ? std::array{0.0, 2 * t}
                                  : std::array{-2 * std::sin(turn), 2 * std::cos(turn)});
            outline.push_back(second == BeamEnd::kFlat
                                  ? std::array{5.0, t}
                                  : std::array{5 + std::sin(turn), std::cos(turn)});
        }
        std::mt19937 random(2);
        std::uniform_real_distribution<float> at(-4, 9);
        for (int i = 0; i < 300; ++i) {
            const float y = at(random), x = std::fabs(at(random)) / 2;
            double least = 1e300;
            for (const auto& [py, px] : outline)
                least = std::min(least, std::hypot(y - py, x - px));
            const bool inside = (y >= 0 && y <= 5 && x < 2 - y / 5) ||
                                (first == BeamEnd::kDome && y < 0 && std::hypot(y, x) < 2) ||
                                (second == BeamEnd::kDome && y > 5 && std::hypot(y - 5, x) < 1);
            // Along (0, 0.6, 0.8), and across by x.
            const float d = beam_distance(record, {x, 0.6f * y, 0.8f * y});
            EXPECT_NEAR(static_cast<double>(d), inside ? -least : least, 2e-3) << y << " " << x;
        }
    }
}

TEST(BeamSolid, BoxesAreTight) {
    const Made made(beams_of("node 0 0 0 1\nnode 10 0 0 2\nstrut 0 1"), 0.1);
    const Box3d box =
        made.solid->exact_box({{1, 0, 0, 0, 1, 0, 0, 0, 1}, made.part.mesh->center_part_mm});
    EXPECT_NEAR(box.lo.x, -1, 1e-12);
    EXPECT_NEAR(box.hi.x, 12, 1e-12);
    EXPECT_NEAR(box.lo.y, -2, 1e-12);
    // Turned by 45 degrees about z: the balls decide.
    const double h = std::sqrt(0.5);
    const Box3d turned = made.solid->exact_box(
        {{h, -h, 0, h, h, 0, 0, 0, 1},
         Affine3d{{h, -h, 0, h, h, 0, 0, 0, 1}, {}}.apply(made.part.mesh->center_part_mm)});
    EXPECT_NEAR(turned.hi.x, 10 * h + 2, 1e-12);
    EXPECT_NEAR(turned.lo.y, -1, 1e-12);
}

TEST(BeamSolid, TiesGoToTheFirst) {
    mesh::Beams beams = beams_of(
        "attribute kind int\nnode 0 0 0 1\nnode 5 0 0 1\nnode 5 5 0 1\n"
        "strut 0 1 7\nstrut 1 2 8\nball 1 9");
    beams.attributes.insert(beams.attributes.begin(), {"heat", false, 1, {0, 1, 2}, {}});
    const Made made(beams, 0.1);
    nearest::PointPacket packet;
    const Vec3d p = Vec3d{5, 0, 3} - made.part.mesh->center_part_mm;
    for (size_t l = 0; l < 8; ++l) {
        for (size_t a = 0; a < 3; ++a)
            packet.p[a][l] = static_cast<float>(p[static_cast<int>(a)]);
    }
    nearest::PointAnswer answer;
    made.placed->engine()->query_points({&packet, 1}, kInfinity, made.scratch->engine.get(),
                                        &answer);
    std::array<uint32_t, 8> kind{};
    uint32_t* ints[] = {kind.data()};
    nearest::PointTargets targets;
    targets.flat = ints;
    made.placed->read_points(answer, targets, made.scratch.get());
    EXPECT_EQ(kind[0], 7u);
    EXPECT_EQ(answer.distance2[0], 4.0f);
}

}  // namespace
}  // namespace openfab::solid
