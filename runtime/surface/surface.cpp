// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/surface.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <utility>

#include "base/lru_cache.h"
#include "pieces/extent.h"
#include "runtime/surface/base_mesh.h"
#include "runtime/surface/dice_groups.h"
#include "runtime/surface/dicer.h"
#include "runtime/surface/displacement_bounds.h"
#include "runtime/surface/kernel_args.h"
#include "runtime/surface/lattice.h"
#include "runtime/surface/messages.h"
#include "runtime/surface/patch_table.h"
#include "runtime/surface/transform_box.h"

namespace openfab::surface {

size_t MicroMesh::bytes() const {
    return sizeof(MicroMesh) + positions.capacity() * sizeof(positions[0]) +
           triangles.capacity() * sizeof(triangles[0]) +
           vertex_attributes.capacity() * sizeof(float) +
           triangle_attributes.capacity() * sizeof(uint32_t);
}

namespace {

// A full tile with a few attributes takes about 60 kB.
constexpr size_t kShardBytes = 4u << 20;
// Lattice points that are evaluated at once for the log.
constexpr int32_t kLoggedPoints = 4096;

/// The patches of a group, diced (dice_groups.h).
struct DicedGroup {
    std::vector<MicroMesh> meshes;

    size_t bytes() const {
        size_t sum = sizeof(DicedGroup);
        for (const MicroMesh& mesh : meshes)
            sum += mesh.bytes();
        return sum;
    }
};

class DicedSurface final : public Surface {
  public:
    DicedSurface(const part::Part& part, const SurfaceOptions& options)
        : part_(part),
          isa_(options.isa),
          stop_(options.stop),
          args_(part),
          nearest_(*part.fablet),
          base_(part),
          cache_(options.cache_bytes, kShardBytes) {
        args_.set_stop(options.stop);
    }

    Result<void> set_up(const SurfaceOptions& options) {
        Result<PatchTable> table = make_patch_table(part_, options, args_, nearest_, &base_);
        if (!table) return table.error();
        table_ = std::move(*table);
        if (!table_.identity) groups_ = DiceGroups(table_.patches, options.micro_edge_mm);
        return {};
    }

    const std::vector<Patch>& patches() const override { return table_.patches; }
    const PatchRanges& ranges() const override { return table_.ranges; }
    bool identity() const override { return table_.identity; }
    void set_cache_bytes(size_t bytes) const override { cache_.set_budget(bytes); }
    void set_stop(const std::atomic<bool>* stop) const override {
        stop_ = stop;
        args_.set_stop(stop);
    }
    std::shared_ptr<const MicroMesh> micro(int32_t patch) const override;
    bool identity_corners(int32_t patch, std::array<Vec3f, 3>* out) const override {
        return base_.rounded_corners(table_.patches[patch].triangle, out);
    }
    void displacement_bounds(int32_t patch, std::vector<GrownPolygon>* out) const override {
        add_displacement_bounds(base_, table_, patch, out);
    }
    Box3d exact_box(const Affine3d& local_to_other) const override {
        return box_on_sides(local_to_other, {});
    }
    Box3d box_on_sides(const Affine3d& local_to_other,
                       std::span<const pieces::Side> sides) const override;
    SurfaceCounts counts() const override;
    Result<void> status() const override;
    void log(segments::PrintfLog* log) const override;

  private:
    void log_triangle(int32_t triangle, MicroBatch* batch) const;
    Box3d identity_box(const Affine3d& local_to_other, std::span<const pieces::Side> sides) const;
    std::unique_ptr<Dicer> take_dicer() const;
    void give_back(std::unique_ptr<Dicer> dicer) const;

    const part::Part& part_;
    const openfab_isa isa_;
    mutable const std::atomic<bool>* stop_;
    StaticArgs args_;
    NearestLayout nearest_;
    BaseMesh base_;
    PatchTable table_;
    DiceGroups groups_;
    mutable LruCache<int32_t, DicedGroup> cache_;  ///< by the first patch of the group
    mutable std::mutex dicers_mutex_;
    mutable std::vector<std::unique_ptr<Dicer>>
        dicers_;  ///< idle; as many as threads ever diced at once
    mutable std::atomic<int64_t> patches_diced_{0}, micro_triangles_{0};
    mutable std::atomic<int64_t> not_finite_{0}, cut_to_bound_{0};
    mutable std::atomic<abi::KernelStatus> error_{abi::KernelStatus{}};
};

std::unique_ptr<Dicer> DicedSurface::take_dicer() const {
    {
        const std::lock_guard lock(dicers_mutex_);
        if (!dicers_.empty()) {
            std::unique_ptr<Dicer> dicer = std::move(dicers_.back());
            dicers_.pop_back();
            return dicer;
        }
    }
    return std::make_unique<Dicer>(part_, base_, table_, args_, nearest_, isa_);
}

void DicedSurface::give_back(std::unique_ptr<Dicer> dicer) const {
    const std::lock_guard lock(dicers_mutex_);
    dicers_.push_back(std::move(dicer));
}

std::shared_ptr<const MicroMesh> DicedSurface::micro(int32_t patch) const {
    // One triangle is cheaper to make than to look up.
    const bool cached = table_.patches[patch].kind != PatchKind::kIdentity;
    const std::span<const int32_t> group = groups_.of(patch);
    const auto of_group = [&](std::shared_ptr<const DicedGroup> diced) {
        const auto place = static_cast<size_t>(std::ranges::find(group, patch) - group.begin());
        const MicroMesh* mesh = &diced->meshes[place];
        return std::shared_ptr<const MicroMesh>(std::move(diced), mesh);
    };
    if (cached) {
        if (stop_ != nullptr && stop_->load(std::memory_order_relaxed))
            return std::make_shared<MicroMesh>();
        if (std::shared_ptr<const DicedGroup> found = cache_.find(group[0]))
            return of_group(std::move(found));
    }
    auto diced = std::make_shared<DicedGroup>();
    std::unique_ptr<Dicer> dicer = take_dicer();
    abi::KernelStatus error;
    if (group.size() > 1) {
        error = dicer->dice_lattices(group, &diced->meshes);
    } else {
        diced->meshes.resize(1);
        error = dicer->dice(patch, diced->meshes.data());
    }
    for (const MicroMesh& mesh : diced->meshes)
        micro_triangles_ += static_cast<int64_t>(mesh.triangles.size());
    not_finite_ += dicer->not_finite();
    cut_to_bound_ += dicer->cut_to_bound();
    give_back(std::move(dicer));
    if (error.is_stopped()) return std::make_shared<MicroMesh>();
    if (!error.ok()) error_.store(error);
    if (!cached) return of_group(std::move(diced));
    patches_diced_ += static_cast<int64_t>(group.size());
    return of_group(cache_.insert(group[0], std::move(diced)));
}

/// Of identity triangles.
Box3d DicedSurface::identity_box(const Affine3d& local_to_other,
                                 std::span<const pieces::Side> sides) const {
    return tbb::parallel_reduce(
        tbb::blocked_range<size_t>(0, table_.patches.size(), 16384), Box3d{},
        [&](const auto& range, Box3d box) {
            for (size_t p = range.begin(); p < range.end(); ++p) {
                const Patch& patch = table_.patches[p];
                if (patch.kind != PatchKind::kIdentity || (patch.use & kForCoverage) == 0) continue;
                std::array<Vec3d, 3> corners;
                for (int32_t c = 0; c < 3; ++c) {
                    corners[static_cast<size_t>(c)] =
                        vec_cast<double>(round_position(base_.position(3 * patch.triangle + c)));
                }
                pieces::add_triangle(corners, sides, local_to_other, &box);
            }
            return box;
        },
        [](Box3d a, const Box3d& b) {
            a.add(b);
            return a;
        });
}

Box3d DicedSurface::box_on_sides(const Affine3d& local_to_other,
                                 std::span<const pieces::Side> sides) const {
    Box3d exact = identity_box(local_to_other, sides);
    std::vector<int32_t> open;  // patches whose vertices are not known yet
    if (!table_.identity) {
        for (size_t p = 0; p < table_.patches.size(); ++p) {
            const Patch& patch = table_.patches[p];
            if ((patch.use & kForCoverage) != 0 && patch.kind != PatchKind::kIdentity &&
                pieces::may_hold(sides, patch.bounds))
                open.push_back(static_cast<int32_t>(p));
        }
    }
    if (open.empty()) return exact;
    std::vector<Box3d> bounds(table_.patches.size());
    for (const int32_t p : open)
        bounds[p] = transform_box(local_to_other, table_.patches[p].bounds);
    std::vector<uint8_t> done(table_.patches.size(), 0);
    for (int side = 0; side < 6; ++side) {
        const int axis = side / 2;
        // The patch's possible extent along the direction, increasing outward.
        const auto reach = [&](const Box3d& box) {
            return side % 2 == 0 ? -box.lo[axis] : box.hi[axis];
        };
        // A heap, as few of them are visited.
        const auto nearer = [&](int32_t a, int32_t b) {
            const double ra = reach(bounds[a]), rb = reach(bounds[b]);
            return ra != rb ? ra < rb : a > b;
        };
        std::make_heap(open.begin(), open.end(), nearer);
        for (auto end = open.end(); end != open.begin(); --end) {
            const int32_t p = open.front();
            if (!exact.empty() && reach(bounds[p]) <= reach(exact)) break;
            std::pop_heap(open.begin(), end, nearer);
            if (std::exchange(done[p], 1) != 0) continue;
            const std::shared_ptr<const MicroMesh> mesh = micro(p);
            for (const auto& triangle : mesh->triangles) {
                const auto corner = [&](size_t c) {
                    return vec_cast<double>(mesh->positions[triangle[c]]);
                };
                pieces::add_triangle({corner(0), corner(1), corner(2)}, sides, local_to_other,
                                     &exact);
            }
        }
    }
    return exact;
}

SurfaceCounts DicedSurface::counts() const {
    SurfaceCounts counts;
    counts.micro_triangles = micro_triangles_;
    counts.not_finite = not_finite_;
    counts.cut_to_bound = cut_to_bound_;
    const auto cache = cache_.counts();
    counts.cache_hits = cache.hits;
    counts.cache_misses = patches_diced_;
    counts.cache_evictions = cache.evictions;
    counts.cache_peak_bytes = cache.peak_bytes;
    return counts;
}

void DicedSurface::log_triangle(int32_t triangle, MicroBatch* batch) const {
    if (base_.classes[triangle] != TriangleClass::kDisplaced) return;
    const int32_t n = base_.lattice_factor(triangle);
    const int32_t rows = std::max(kLoggedPoints / (n + 1), 1);
    for (int32_t b = 0; b <= n; b += rows) {
        if (stop_ != nullptr && stop_->load(std::memory_order_relaxed)) return;
        batch->clear();
        batch->add_tile(triangle, {0, b, n, std::min(b + rows - 1, n)});
        const abi::KernelStatus error = batch->evaluate();
        if (error.is_stopped()) return;
        if (!error.ok()) error_.store(error);
    }
}

void DicedSurface::log(segments::PrintfLog* log) const {
    if (part_.fablet->surface_segments.printf_count == 0) return;
    // What one thread logs, of triangles in order.
    struct Logged {
        const DicedSurface& surface;
        segments::PrintfLog log;
        MicroBatch batch;

        explicit Logged(const DicedSurface& of)
            : surface(of), batch(of.part_, of.base_, of.args_, of.nearest_, of.isa_) {
            batch.set_log(&log);
        }
        Logged(const Logged& other, tbb::split /*tag*/) : Logged(other.surface) {}
        void operator()(const tbb::blocked_range<int32_t>& triangles) {
            for (int32_t t = triangles.begin(); t < triangles.end(); ++t)
                surface.log_triangle(t, &batch);
        }
        void join(Logged& later) { log.append(&later.log); }
    };
    Logged all(*this);
    tbb::parallel_reduce(tbb::blocked_range<int32_t>(0, base_.triangle_count()), all);
    log->append(&all.log);
}

Result<void> DicedSurface::status() const {
    const abi::KernelStatus error = error_.load();
    if (error.ok()) return {};
    return internal_error(fmt::format(messages::kKernelFailed, part_.fablet->name, error.code()));
}

}  // namespace

std::vector<std::string> displacement_warnings(const part::Part& part,
                                               const SurfaceCounts& counts) {
    std::vector<std::string> lines;
    if (counts.not_finite > 0) {
        lines.push_back(fmt::format(messages::kNotFinite, part.name));
    }
    if (counts.cut_to_bound > 0) {
        lines.push_back(fmt::format(messages::kCutToBound, part.name, part.max_displacement_mm));
    }
    return lines;
}

Result<std::unique_ptr<Surface>> Surface::create(const part::Part& part,
                                                 const SurfaceOptions& options) {
    if (!(options.micro_edge_mm > 0)) return internal_error("micro_edge_mm must be above zero");
    if (Result<void> good = check_surface_input(part); !good) return good.error();
    auto surface = std::make_unique<DicedSurface>(part, options);
    if (Result<void> done = surface->set_up(options); !done) return done.error();
    return std::unique_ptr<Surface>(std::move(surface));
}

}  // namespace openfab::surface
