// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/mesh/mesh_solid.h"

#include <algorithm>
#include <span>
#include <vector>

#include "runtime/nearest/engine/attributes.h"
#include "runtime/nearest/engine/winding.h"
#include "runtime/solid/mesh/mesh_tops.h"
#include "runtime/surface/crowding.h"
#include "runtime/surface/long_triangles.h"
#include "runtime/surface/morton_order.h"
#include "runtime/voxel/coverage.h"
#include "runtime/voxel/patch_index.h"

namespace openfab::solid {

namespace {

// Measured with a mesh of 1.28 M displaced triangles. Per base triangle: sides, corners and
// classes, and a patch. Per diced patch: the search for the bounding box, the index, and the tree
// while it is built.
constexpr int64_t kTriangleBytes = 140;
constexpr int64_t kPatchBytes = 48;
constexpr int64_t kPatchTreeBytes = 340;

struct MeshScratch final : Scratch {
    nearest::AttributeReader::Scratch attributes;
    nearest::Winding::Memory memory;
};

/// What placements of a mesh share.
struct Shared {
    std::shared_ptr<const surface::Surface> surface;
    std::shared_ptr<const voxel::PatchIndex> patches;
    std::shared_ptr<const nearest::BlockIndex> trees;      ///< null where nothing queries
    std::unique_ptr<nearest::AttributeReader> attributes;  ///< likewise; in no frame
    std::unique_ptr<const nearest::Winding> winding;       ///< null where no query needs a sign
};

class PlacedMesh final : public Placed {
  public:
    PlacedMesh(const Shared& shared, const Place& where)
        : shared_(shared),
          part_(where.part),
          grid_(where.grid),
          frame_(where.frame),
          voxeliser_(where.part, *shared.surface, where.grid, where.waiting_bytes, shared.patches) {
    }

    Box3i voxel_box() const override { return voxeliser_.voxel_box(); }
    void coverage(int32_t slab, voxel::SlabMask* out, const std::atomic<bool>* stop,
                  double* seconds) const override {
        voxeliser_.coverage(slab, out, stop, seconds);
    }
    void forget_slabs() const override { voxeliser_.drop_waiting(); }
    void raise_tops(const Columns& columns, TopRows* rows) const override {
        const GridSurface on{part_, *shared_.surface, *shared_.patches, grid_};
        if (shared_.surface->identity()) {
            raise_to_covered(on, columns, rows);
        } else {
            raise_to_bounds(on, columns, rows);
        }
    }
    void begin_queries() override {
        if (engine_ != nullptr || shared_.trees == nullptr) return;
        engine_ = nearest::make_block_engine(shared_.trees, frame_);
        if (shared_.attributes != nullptr)
            attributes_ = std::make_unique<nearest::AttributeReader>(*shared_.attributes, frame_);
    }
    std::unique_ptr<Scratch> make_scratch() const override {
        auto scratch = std::make_unique<MeshScratch>();
        scratch->engine = engine_->make_scratch();
        return scratch;
    }
    void read(const nearest::BlockAnswer& answer, const uint8_t* active,
              const nearest::AttributeTargets& targets, Scratch* scratch) const override {
        attributes_->read(answer, active, targets, &static_cast<MeshScratch*>(scratch)->attributes);
    }
    void read_points(const nearest::PointAnswer& answer, const nearest::PointTargets& targets,
                     Scratch* scratch) const override {
        attributes_->read_points(answer, targets, &static_cast<MeshScratch*>(scratch)->attributes);
    }
    uint32_t inside(const nearest::PointPacket& packet, const nearest::PointAnswer& answers,
                    const KnownInside& known, Scratch* scratch) const override {
        return shared_.winding->inside(packet, answers, {known.points, known.mask, known.slack_mm},
                                       &static_cast<MeshScratch*>(scratch)->memory);
    }

  private:
    const Shared& shared_;
    const part::Part& part_;
    const part::Grid grid_;
    const std::array<float, OPENFAB_FRAME_COUNT> frame_;
    voxel::Voxeliser voxeliser_;
    std::unique_ptr<nearest::AttributeReader> attributes_;
};

class MeshSolid final : public Solid, Dicing {
  public:
    MeshSolid(const part::Part& part, std::shared_ptr<const surface::Surface> surface)
        : part_(part) {
        shared_.surface = std::move(surface);
    }

    Box3d exact_box(const Affine3d& local_to_other) const override {
        return surface().exact_box(local_to_other);
    }
    Box3d box_on_sides(const Affine3d& local_to_other,
                       std::span<const pieces::Side> sides) const override {
        return surface().box_on_sides(local_to_other, sides);
    }
    Box3f bounds() const override {
        Box3f box;
        for (const surface::Patch& patch : surface().patches()) {
            if ((patch.use & surface::kForCoverage) != 0) box.add(patch.bounds);
        }
        return box;
    }
    const Dicing* dicing() const override { return surface().identity() ? nullptr : this; }
    int64_t patches() const override { return static_cast<int64_t>(surface().patches().size()); }
    double crowding() const override { return surface::crowding(surface().patches()); }
    int64_t index_bytes(bool asked) const override {
        const auto diced = std::ranges::count_if(surface().patches(), [](const surface::Patch& p) {
            return p.kind != surface::PatchKind::kIdentity;
        });
        return int64_t{diced} * (asked ? kPatchBytes + kPatchTreeBytes : kPatchBytes);
    }
    int64_t query_bytes() const override {
        return static_cast<int64_t>(
            nearest::estimated_bytes(*shared_.trees, part_.mesh->positions.size()));
    }
    surface::SurfaceCounts counts() const override { return surface().counts(); }
    Result<void> status() const override { return surface().status(); }
    void set_cache_bytes(size_t bytes) const override { surface().set_cache_bytes(bytes); }
    void set_stop(const std::atomic<bool>* stop) const override { surface().set_stop(stop); }

    void prepare(const Asked& asked, const QuerySetUp& queries) override;
    std::unique_ptr<Placed> place(const Place& where) const override {
        return std::make_unique<PlacedMesh>(shared_, where);
    }

  private:
    const surface::Surface& surface() const { return *shared_.surface; }

    const part::Part& part_;
    Shared shared_;
};

void MeshSolid::prepare(const Asked& asked, const QuerySetUp& queries) {
    const bool trees = asked.nearest && shared_.trees == nullptr;
    std::vector<uint64_t> along;
    if (shared_.patches == nullptr || trees) along = surface::morton_order(surface().patches());
    if (shared_.patches == nullptr)
        shared_.patches = std::make_shared<const voxel::PatchIndex>(surface(), along);
    if (trees) {
        shared_.trees = nearest::make_block_index(
            surface(), {.cache = queries.trees, .widest = widest_queries(queries.isa)}, along);
    }
    if (asked.attributes && shared_.attributes == nullptr) {
        shared_.attributes = std::make_unique<nearest::AttributeReader>(
            surface(), std::array<float, OPENFAB_FRAME_COUNT>{}, asked.geometry);
    }
    if (asked.sign && shared_.winding == nullptr)
        shared_.winding = std::make_unique<const nearest::Winding>(surface());
}

}  // namespace

std::shared_ptr<Solid> make_solid_of(const part::Part& part,
                                     std::shared_ptr<const surface::Surface> surface) {
    return std::make_shared<MeshSolid>(part, std::move(surface));
}

const Kind kMeshKind{
    .alike =
        [](const part::Part& a, const part::Part& b) {
            return a.max_displacement_mm == b.max_displacement_mm &&
                   same_arguments(a.fablet->surface, a, b) &&
                   same_arguments(a.fablet->surface_bounds, a, b);
        },
    .refine = [](const surface::SurfaceOptions& options, const Bodies& /*bodies*/,
                 part::Part* part) -> Result<void> {
        Result<std::shared_ptr<const part::PartMesh>> mesh = surface::mesh_to_dice(*part, options);
        if (!mesh) return mesh.error();
        part->mesh = std::move(*mesh);
        return {};
    },
    .bytes =
        [](const part::Part& part) {
            return part.fablet->has_surface == 0
                       ? int64_t{0}
                       : static_cast<int64_t>(part.mesh->triangles.size()) * kTriangleBytes;
        },
    .make = [](const part::Part& part, const surface::SurfaceOptions& options,
               const Bodies& /*bodies*/) -> Result<std::shared_ptr<Solid>> {
        Result<std::unique_ptr<surface::Surface>> made = surface::Surface::create(part, options);
        if (!made) return made.error();
        return make_solid_of(part, std::move(*made));
    },
};

}  // namespace openfab::solid
