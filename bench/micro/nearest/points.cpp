// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Queries at any point on one core, against Embree's rtcPointQuery fresh and seeded from the point
// before, on the same points in interleaved rounds: columns of 8 voxels inside a part, moved by a
// wave as a fablet would, or scattered. Signed: with the side, by distances from the voxels'
// centers and rays. Prints medians in M queries/s of thread time.

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>

#include "base/infinity.h"
#include "bench/micro/nearest/embree_baseline.h"
#include "runtime/nearest/engine.h"
#include "runtime/nearest/engine/winding.h"
#include "tests/support/mesh_surface.h"

namespace openfab::bench {
namespace {

using nearest::PointAnswer;
using nearest::PointPacket;
using testing::TriangleMesh;

const Vec3f kPitch{25.4f / 150, 25.4f / 150, 0.06f};

double thread_seconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> v) {
    std::sort(v.begin(), v.end());
    return v[v.size() / 2];
}

struct Points {
    std::vector<PointPacket> centers, moved;
};

/// Runs of columns along x as a print visits them, spread over the part; all centers are inside.
Points make_points(const TriangleMesh& mesh, const nearest::Winding& winding, float wave,
                   size_t most) {
    Points out;
    const Box3f box = mesh.box();
    std::mt19937 random(1);
    const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
    while (out.centers.size() < most) {
        Vec3f at;
        for (int a = 0; a < 3; ++a)
            at[a] = box.lo[a] + unit() * box.size()[a];
        for (int run = 0; run < 48; ++run) {
            PointPacket c, m;
            bool inside = true;
            for (int l = 0; l < 8; ++l) {
                const Vec3f p{at.x + static_cast<float>(run % 8) * kPitch.x,
                              at.y + static_cast<float>(run / 8) * kPitch.y,
                              at.z + static_cast<float>(l) * kPitch.z};
                inside = inside && winding.number(p) > 0;
                for (int a = 0; a < 3; ++a) {
                    const float phase = p[(a + 1) % 3] * 2.1f + p[(a + 2) % 3] * 1.7f;
                    c.p[a][l] = p[a];
                    m.p[a][l] = p[a] + wave * std::sin(phase);
                }
            }
            if (!inside) continue;
            out.centers.push_back(c);
            out.moved.push_back(m);
        }
    }
    return out;
}

double run_engine(const nearest::Engine& engine, const nearest::Winding* winding,
                  const Points& points) {
    const auto scratch = engine.make_scratch();
    nearest::Winding::Memory memory;
    double sum = 0;
    for (size_t g = 0; g < points.moved.size(); ++g) {
        PointAnswer answer;
        engine.query_points({&points.moved[g], 1}, kInfinity, scratch.get(), &answer);
        if (winding != nullptr) {
            const uint32_t inside = winding->inside(
                points.moved[g], answer, {&points.centers[g], 0xff, kPitch.x * 0x1p-7f}, &memory);
            sum += static_cast<double>(inside & 1u) * 1e-9;
        }
        for (const float d2 : answer.distance2)
            sum += static_cast<double>(d2);
    }
    return sum;
}

double run_embree(const EmbreeBaseline& embree, const Points& points, bool seeded) {
    double sum = 0;
    EmbreeHit hit{};
    bool have_hit = false;
    for (const PointPacket& g : points.moved) {
        for (int l = 0; l < 8; ++l) {
            const Vec3f p{g.p[0][l], g.p[1][l], g.p[2][l]};
            float radius = kInfinity;
            if (seeded && have_hit) {
                const Vec3f d = p - Vec3f{hit.point[0], hit.point[1], hit.point[2]};
                radius = length(d) * 1.00001f + 1e-6f;
            }
            have_hit = embree.query(&p.x, radius, &hit);
            sum += static_cast<double>(hit.distance2);
        }
    }
    return sum;
}

void run_mesh(const char* name, const TriangleMesh& mesh, size_t groups, int rounds) {
    if (mesh.triangles.empty()) return;
    const testing::MeshSurface surface(mesh);
    const auto engine = nearest::make_block_engine(surface, testing::make_test_frame(kPitch, {}));
    const nearest::Winding winding(surface);
    std::vector<float> positions;
    std::vector<uint32_t> triangles;
    for (const Vec3f& p : mesh.positions)
        positions.insert(positions.end(), {p.x, p.y, p.z});
    for (const auto& t : mesh.triangles) {
        for (const int32_t v : t)
            triangles.push_back(static_cast<uint32_t>(v));
    }
    const EmbreeBaseline embree(positions, triangles);
    for (const float wave : {0.1f, 1.0f}) {
        const Points points = make_points(mesh, winding, wave, groups);
        std::vector<double> ours, with_side, fresh, seeded;
        const auto timed = [](std::vector<double>* times, const auto& work) {
            const double start = thread_seconds();
            const double result = work();
            times->push_back(thread_seconds() - start);
            return result;
        };
        double sum = 0, embree_sum = 0;
        for (int round = 0; round < rounds; ++round) {
            sum = timed(&ours, [&] { return run_engine(*engine, nullptr, points); });
            timed(&with_side, [&] { return run_engine(*engine, &winding, points); });
            embree_sum = timed(&fresh, [&] { return run_embree(embree, points, false); });
            timed(&seeded, [&] { return run_embree(embree, points, true); });
        }
        const double n = static_cast<double>(points.moved.size()) * 8e-6;
        const auto rate = [&](const std::vector<double>& times) { return n / median(times); };
        std::printf("%-10s %8zu  wave %.1f mm  %8.3f %8.3f  %8.3f %8.3f  %6.1fx %6.1fx%s\n", name,
                    mesh.triangles.size(), static_cast<double>(wave), rate(ours), rate(with_side),
                    rate(fresh), rate(seeded), rate(ours) / rate(fresh), rate(ours) / rate(seeded),
                    std::fabs(sum - embree_sum) > 1e-4 * sum ? "  sums differ" : "");
    }
}

int run(int argc, char** argv) {
    size_t groups = 4000;
    int rounds = 5;
    for (int i = 1; i + 1 < argc; i += 2) {
        if (std::strcmp(argv[i], "--groups") == 0) groups = std::strtoull(argv[i + 1], nullptr, 10);
        if (std::strcmp(argv[i], "--rounds") == 0) rounds = std::atoi(argv[i + 1]);
    }
    std::printf(
        "M queries/s               points      unsigned   signed  Embree: fresh   seeded     "
        "ratios\n");
    const auto blob = [](int n) {
        return testing::make_ball(n, [](const Vec3d& d) {
            const double waves =
                std::sin(3 * d.x + 1) * std::cos(4 * d.y) + 0.6 * std::sin(7 * d.z + 2 * d.x);
            const double fine = std::sin(90 * d.x) * std::sin(83 * d.y) * std::sin(97 * d.z);
            return 22.0 * (1 + 0.22 * waves) + 0.12 * fine;
        });
    };
    run_mesh("blob70k", blob(76), groups, rounds);
    run_mesh("blob280k", blob(152), groups, rounds);
    run_mesh("spot", testing::read_obj(OPENFAB_SOURCE_DIR "/tests/data/meshes/spot.obj", 50.0),
             groups, rounds);
    return 0;
}

}  // namespace
}  // namespace openfab::bench

int main(int argc, char** argv) {
    return openfab::bench::run(argc, argv);
}
