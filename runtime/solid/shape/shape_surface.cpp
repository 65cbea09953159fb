// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/shape_surface.h"

#include <limits>

#include "base/infinity.h"
#include "base/lru_cache.h"

namespace openfab::solid {

namespace {

// A block's mesh takes about 20 kB.
constexpr size_t kShardBytes = 4u << 20;

class ShapeSurface final : public surface::Surface {
  public:
    ShapeSurface(const ShapeField& field, const std::vector<Vec3i>& blocks, size_t cache_bytes,
                 const std::atomic<bool>* stop)
        : field_(field), stop_(stop), blocks_(blocks), cache_(cache_bytes, kShardBytes) {
        ranges_.float_components = field.float_components();
        ranges_.int_components = field.int_components();
        const auto floats = blocks_.size() * static_cast<size_t>(ranges_.float_components);
        const auto ints = blocks_.size() * static_cast<size_t>(ranges_.int_components);
        ranges_.float_lo.assign(floats, -kInfinity);
        ranges_.float_hi.assign(floats, kInfinity);
        ranges_.int_lo.assign(ints, std::numeric_limits<int32_t>::min());
        ranges_.int_hi.assign(ints, std::numeric_limits<int32_t>::max());
        for (const Vec3i& lowest : blocks_) {
            surface::Patch patch;
            patch.kind = surface::PatchKind::kSeam;
            patch.bounds = field.block_box(lowest);
            patches_.push_back(patch);
        }
    }

    const std::vector<surface::Patch>& patches() const override { return patches_; }
    const surface::PatchRanges& ranges() const override { return ranges_; }
    bool identity() const override { return false; }
    std::shared_ptr<const surface::MicroMesh> micro(int32_t patch) const override {
        if (stop_ != nullptr && stop_->load(std::memory_order_relaxed))
            return std::make_shared<surface::MicroMesh>();
        if (auto found = cache_.find(patch)) return found;
        auto mesh = std::make_shared<surface::MicroMesh>();
        field_.dice(blocks_[static_cast<size_t>(patch)], mesh.get());
        micro_triangles_ += static_cast<int64_t>(mesh->triangles.size());
        return cache_.insert(patch, std::move(mesh));
    }
    bool identity_corners(int32_t /*patch*/, std::array<Vec3f, 3>* /*out*/) const override {
        return false;
    }
    void displacement_bounds(int32_t /*patch*/,
                             std::vector<surface::GrownPolygon>* /*out*/) const override {}
    Box3d exact_box(const Affine3d& local_to_other) const override {
        return field_.exact_box(local_to_other, {});
    }
    surface::SurfaceCounts counts() const override {
        surface::SurfaceCounts counts;
        counts.micro_triangles = micro_triangles_;
        const auto cache = cache_.counts();
        counts.cache_hits = cache.hits;
        counts.cache_misses = cache.misses;
        counts.cache_evictions = cache.evictions;
        counts.cache_peak_bytes = cache.peak_bytes;
        return counts;
    }
    void set_cache_bytes(size_t bytes) const override { cache_.set_budget(bytes); }
    void set_stop(const std::atomic<bool>* stop) const override { stop_ = stop; }
    Result<void> status() const override { return field_.status(); }

  private:
    const ShapeField& field_;
    mutable const std::atomic<bool>* stop_;
    const std::vector<Vec3i>& blocks_;  ///< lowest cells, by patch
    std::vector<surface::Patch> patches_;
    surface::PatchRanges ranges_;
    mutable LruCache<int32_t, surface::MicroMesh> cache_;  ///< by patch
    mutable std::atomic<int64_t> micro_triangles_{0};
};

}  // namespace

std::unique_ptr<surface::Surface> make_shape_surface(const ShapeField& field,
                                                     const std::vector<Vec3i>& blocks,
                                                     size_t cache_bytes,
                                                     const std::atomic<bool>* stop) {
    return std::make_unique<ShapeSurface>(field, blocks, cache_bytes, stop);
}

}  // namespace openfab::solid
