// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Every voxel of whole parts: the block engine gives the bits of the Embree twin, no distance
// differs from that in double by more than rule 16 allows, and a radius neither misses nor adds a
// voxel. Sampling is not enough: pruning that lost one voxel in a thousand has passed it.
//
// By default this compares small parts. OPENFAB_WHOLE_PART=1 takes a part of 50 mm instead, at
// printers' pitches: some ten minutes on two cores.

#include <gtest/gtest.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <mutex>

#include "runtime/nearest/engine.h"
#include "runtime/surface/surface.h"
#include "runtime/voxel/coverage.h"
#include "tests/support/mesh_surface.h"
#include "tests/support/meshes/meshes.h"
#include "tests/support/nearest/embree_engine.h"
#include "tests/support/places/places.h"
#include "tests/support/surface/hand_fablet.h"

namespace openfab::nearest {
namespace {

using testing::EmbreeEngine;
using testing::HandMode;
using testing::TriangleMesh;

#ifdef OPENFAB_SANITIZED
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

const Vec3d kCubes{0.085, 0.085, 0.085};
const Vec3d kPrinter{0.0423, 0.0847, 0.027};  // 600 x 300 dpi x 27 um

bool whole() {
    return std::getenv("OPENFAB_WHOLE_PART") != nullptr;
}

/// As the hand-written fablet requires it: uv and face, but no normals, so that displaced triangles
/// separate at their edges and strips join them.
mesh::Mesh as_scene_mesh(const TriangleMesh& from) {
    mesh::Mesh mesh;
    for (const Vec3f& p : from.positions)
        mesh.positions.push_back(vec_cast<double>(p));
    mesh.triangles = from.triangles;
    mesh::MeshAttribute uv;
    uv.name = "uv";
    uv.components = 2;
    for (const Vec3f& p : from.positions)
        uv.values.insert(uv.values.end(), {p.x / 50, p.y / 50});
    uv.corners = mesh.triangles;
    mesh::MeshAttribute face;
    face.name = "face";
    face.is_int = true;
    face.faces.assign(mesh.triangles.size(), 0);
    mesh.attributes = {uv, face};
    return mesh;
}

struct Counts {
    int64_t voxels = 0, in_radius = 0;
    double worst = 0;  ///< error of a distance, relative to the tolerance
    std::string wrong;

    void add(const Counts& c) {
        voxels += c.voxels;
        in_radius += c.in_radius;
        worst = std::max(worst, c.worst);
        if (wrong.empty()) wrong = c.wrong;
    }
};

bool same_answer(const BlockAnswer& a, const BlockAnswer& b, int v) {
    return std::memcmp(&a.distance2[v], &b.distance2[v], 4) == 0 && a.item[v] == b.item[v] &&
           a.in_patch.triangle[v] == b.in_patch.triangle[v] &&
           std::memcmp(&a.in_patch.bary1[v], &b.in_patch.bary1[v], 4) == 0 &&
           std::memcmp(&a.in_patch.bary2[v], &b.in_patch.bary2[v], 4) == 0;
}

class WholePart {
  public:
    WholePart(const TriangleMesh& mesh, bool displaced, const Vec3d& pitch, double micro_edge_mm)
        : part_(make_part(mesh, displaced)),
          grid_(testing::grid_around(part_, pitch, displaced ? 0.5 : 0.1)),
          base_(part::part_base_voxel(part_, grid_)) {
        surface::SurfaceOptions options;
        options.micro_edge_mm = micro_edge_mm;
        // Deep voxels need all of the surface: trees that do not fit are rebuilt for every block.
        options.cache_bytes = whole() ? size_t{2} << 30 : size_t{64} << 20;
        surface_ = std::move(*surface::Surface::create(part_, options));
        const auto frame = part::make_frame(part_, grid_);
        voxels_ = std::make_unique<voxel::Voxeliser>(part_, *surface_, grid_);
        BlockEngineOptions engine_options;
        engine_options.cache_bytes = 2 * options.cache_bytes;
        engine_ = make_block_engine(*surface_, frame, engine_options);
        twin_ = testing::make_embree_engine(*surface_, frame);
    }

    int64_t triangles() const { return twin_->triangle_count(); }

    Counts compare(float radius_mm) const {
        struct Thread {
            std::unique_ptr<Engine::Scratch> engine, twin;
            voxel::SlabMask mask;
            Counts counts;
        };
        tbb::enumerable_thread_specific<Thread> threads([&] {
            return Thread{engine_->make_scratch(), twin_->make_scratch(), {}, {}};
        });
        const Box3i box = voxels_->voxel_box();
        tbb::parallel_for(box.lo.z >> 3, (box.hi.z + 7) >> 3, [&](int32_t slab) {
            Thread& thread = threads.local();
            voxels_->coverage(slab, &thread.mask);
            for (int32_t y = 0; y < thread.mask.height; y += 8) {
                for (int32_t x = 0; x < thread.mask.width; x += 8) {
                    std::array<uint8_t, 64> demand;
                    for (int32_t i = 0; i < 64; ++i) {
                        demand[i] = thread.mask.mask[static_cast<size_t>(
                            (y + i / 8) * thread.mask.width + x + i % 8)];
                    }
                    const Vec3i at{thread.mask.x0 + x, thread.mask.y0 + y, 8 * slab};
                    compare_block(at, demand.data(), radius_mm, thread.engine.get(),
                                  static_cast<EmbreeEngine::Scratch*>(thread.twin.get()),
                                  &thread.counts);
                }
            }
        });
        Counts all;
        for (const Thread& thread : threads)
            all.add(thread.counts);
        return all;
    }

  private:
    static part::Part make_part(const TriangleMesh& mesh, bool displaced) {
        testing::PartOptions options;
        // Face 0 is not displaced, which the fablet infers.
        options.uniform_values =
            testing::hand_uniforms(displaced ? HandMode::kBumps : HandMode::kBack, 0.25f);
        return testing::make_part(testing::hand_fablet(false), as_scene_mesh(mesh), options);
    }

    void compare_block(const Vec3i& at, const uint8_t* demand, float radius_mm,
                       Engine::Scratch* engine_scratch, EmbreeEngine::Scratch* twin_scratch,
                       Counts* counts) const {
        if (std::all_of(demand, demand + 64, [](uint8_t b) { return b == 0; })) return;
        BlockQuery query{at - base_};
        query.active = demand;
        BlockAnswer want, got, bounded;
        twin_->query(query, twin_scratch, &want);
        engine_->query(query, engine_scratch, &got);
        query.radius_mm = radius_mm;
        engine_->query(query, engine_scratch, &bounded);
        for (int v = 0; v < kBlockVoxels; ++v) {
            if ((demand[v >> 3] >> (v & 7) & 1) == 0) continue;
            ++counts->voxels;
            const double exact = twin_scratch->exact_mm[v];
            const double error =
                std::abs(std::sqrt(static_cast<double>(got.distance2[v])) - exact) /
                twin_->allowed_mm(exact);
            counts->worst = std::max(counts->worst, error);
            const bool near = want.distance2[v] <= radius_mm * radius_mm;
            counts->in_radius += near ? 1 : 0;
            const bool as_asked = near ? same_answer(bounded, want, v)
                                       : bounded.item[v] == -1 && std::isinf(bounded.distance2[v]);
            if (error <= 1 && as_asked && same_answer(got, want, v)) continue;
            if (!counts->wrong.empty()) continue;
            std::ostringstream text;
            text.precision(10);
            text << "block " << at.x << " " << at.y << " " << at.z << " voxel " << v << ": "
                 << got.distance2[v] << " of " << got.item[v] << "/" << got.in_patch.triangle[v]
                 << ", to " << radius_mm << " mm " << bounded.distance2[v] << " of "
                 << bounded.item[v] << "/" << bounded.in_patch.triangle[v] << ", not "
                 << want.distance2[v] << " of " << want.item[v] << "/" << want.in_patch.triangle[v]
                 << ", in double " << exact << " squared is " << exact * exact;
            counts->wrong = text.str();
        }
    }

    part::Part part_;
    part::Grid grid_;
    Vec3i base_;
    std::unique_ptr<surface::Surface> surface_;
    std::unique_ptr<voxel::Voxeliser> voxels_;
    std::unique_ptr<Engine> engine_;
    std::unique_ptr<EmbreeEngine> twin_;
};

/// Closed, `diameter_mm` across, with long waves; 12 n² triangles.
TriangleMesh make_blob(int n, double diameter_mm) {
    return testing::make_ball(n, [&](const Vec3d& d) {
        const double waves =
            std::sin(3 * d.x + 1) * std::cos(4 * d.y) + 0.6 * std::sin(7 * d.z + 2 * d.x);
        return diameter_mm * 0.44 * (1 + 0.22 * waves);
    });
}

TriangleMesh make_mesh() {
    if (!whole()) return make_blob(kSanitized ? 8 : 20, kSanitized ? 1.5 : 5);
    return testing::read_obj(testing::source_dir() / "tests/data/meshes/spot.obj", 50.0);
}

void check(bool displaced, const Vec3d& pitch) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    // One micropolygon per voxel.
    const WholePart part(make_mesh(), displaced, pitch, std::cbrt(pitch.x * pitch.y * pitch.z));
    const Counts counts = part.compare(0.5f);
    std::printf(
        "%s, %.4g x %.4g x %.4g mm, %lld triangles: %lld voxels, %lld to 0.5 mm, the worst "
        "error is %.3f of what is allowed; %.0f s\n",
        displaced ? "displaced" : "base", pitch.x, pitch.y, pitch.z,
        static_cast<long long>(part.triangles()), static_cast<long long>(counts.voxels),
        static_cast<long long>(counts.in_radius), counts.worst,
        std::chrono::duration<double>(Clock::now() - start).count());
    std::fflush(stdout);
    EXPECT_EQ(counts.wrong, "");
    EXPECT_LE(counts.worst, 1);
    EXPECT_GT(counts.in_radius, 1000);
    // The part is too small under a sanitizer for a voxel to be beyond the radius.
    if (!kSanitized) {
        EXPECT_GT(counts.voxels, counts.in_radius + 1000);
    }
}

TEST(WholePartsAreExact, BaseInCubes) {
    check(false, kCubes);
}

TEST(WholePartsAreExact, DisplacedInCubes) {
    check(true, kCubes);
}

TEST(WholePartsAreExact, BaseAtPrintersPitch) {
    check(false, kPrinter);
}

TEST(WholePartsAreExact, DisplacedAtPrintersPitch) {
    check(true, kPrinter);
}

}  // namespace
}  // namespace openfab::nearest
