// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/shape_solid.h"

#include "runtime/nearest/engine/attributes.h"
#include "runtime/solid/mesh/mesh_solid.h"
#include "runtime/solid/placed_tiles.h"
#include "runtime/solid/shape/shape_coverage.h"
#include "runtime/solid/shape/shape_engine.h"
#include "runtime/solid/shape/shape_field.h"
#include "runtime/solid/shape/shape_mesh.h"
#include "runtime/solid/shape/shape_surface.h"
#include "runtime/solid/shape/value_engine.h"

namespace openfab::solid {

namespace {

struct ShapeScratch final : Scratch {
    nearest::AttributeReader::Scratch attributes;
    ShapePoints points;
    std::vector<float> values;
};

/// What placements of a shape share.
struct SharedShape {
    SharedShape(const part::Part& part, const surface::SurfaceOptions& options,
                const Bodies& bodies)
        : field(*std::get<part::ShapeGeometry>(part.geometry).stage, bodies, *part.fablet,
                options.micro_edge_mm, options.isa) {}

    ShapeField field;
    bool asked = false;
    std::vector<Vec3i> blocks;              ///< of the surface
    std::unique_ptr<const ShapeNear> near;  ///< null where values are distances, or none is asked
    std::unique_ptr<const surface::Surface> surface;   ///< null where nothing reads nearest points
    std::shared_ptr<const nearest::BlockIndex> trees;  ///< likewise
    std::unique_ptr<nearest::AttributeReader> attributes;  ///< likewise; in no frame
};

class PlacedShape final : public PlacedTiles<ShapeCoverage> {
  public:
    PlacedShape(const SharedShape& shared, const Place& where)
        : PlacedTiles(shared.field, where), shared_(shared) {}

    void begin_queries() override {
        if (engine_ != nullptr || !shared_.asked) return;
        if (shared_.trees != nullptr) engine_ = nearest::make_block_engine(shared_.trees, frame_);
        if (shared_.attributes != nullptr)
            attributes_ = std::make_unique<nearest::AttributeReader>(*shared_.attributes, frame_);
        if (shared_.field.is_distance()) {
            engine_ = make_value_engine(shared_.field, voxels_, std::move(engine_));
        } else if (engine_ != nullptr) {
            engine_ = make_shape_engine(*shared_.near, voxels_, std::move(engine_));
        }
    }
    std::unique_ptr<Scratch> make_scratch() const override {
        auto scratch = std::make_unique<ShapeScratch>();
        scratch->engine = engine_->make_scratch();
        return scratch;
    }
    void read(const nearest::BlockAnswer& answer, const uint8_t* active,
              const nearest::AttributeTargets& targets, Scratch* scratch) const override {
        attributes_->read(answer, active, targets,
                          &static_cast<ShapeScratch*>(scratch)->attributes);
    }
    void read_points(const nearest::PointAnswer& answer, const nearest::PointTargets& targets,
                     Scratch* scratch) const override {
        attributes_->read_points(answer, targets, &static_cast<ShapeScratch*>(scratch)->attributes);
    }
    uint32_t inside(const nearest::PointPacket& packet, const nearest::PointAnswer& answers,
                    const KnownInside& /*known*/, Scratch* scratch) const override;

  private:
    const SharedShape& shared_;
    std::unique_ptr<nearest::AttributeReader> attributes_;
};

uint32_t PlacedShape::inside(const nearest::PointPacket& packet,
                             const nearest::PointAnswer& answers, const KnownInside& /*known*/,
                             Scratch* scratch) const {
    auto* mine = static_cast<ShapeScratch*>(scratch);
    const Box3f box = shared_.field.bounds();
    mine->points.resize(8);
    uint32_t asked = 0;
    for (size_t l = 0; l < 8; ++l) {
        bool in = (packet.mask >> l & 1) != 0 && answers.distance2[l] < kInfinity;
        for (size_t a = 0; a < 3; ++a) {
            const float p = packet.p[a][l];
            in = in && p >= box.lo[static_cast<int>(a)] && p <= box.hi[static_cast<int>(a)];
            mine->points.at[a][l] = p;
        }
        asked |= (in ? 1u : 0u) << l;
    }
    if (asked == 0) return 0;
    ShapeCalls* calls = shared_.field.take();
    const abi::KernelStatus status = calls->signs(mine->points, &mine->values);
    shared_.field.give(calls);
    if (!status.ok()) {
        shared_.field.note(status);
        return 0;
    }
    uint32_t inside = 0;
    for (size_t l = 0; l < 8; ++l)
        inside |= (mine->values[l] < 0 ? 1u : 0u) << l;
    return inside & asked;
}

class ShapeSolid final : public Solid, Dicing {
  public:
    ShapeSolid(const part::Part& part, const surface::SurfaceOptions& options, const Bodies& bodies)
        : options_(options), stop_(options.stop), shared_(part, options, bodies) {
        shared_.field.set_stop(stop_);
    }

    Result<void> check() const { return shared_.field.check(); }

    Box3d exact_box(const Affine3d& local_to_other) const override {
        return shared_.field.exact_box(local_to_other, {});
    }
    Box3d box_on_sides(const Affine3d& local_to_other,
                       std::span<const pieces::Side> sides) const override {
        return shared_.field.exact_box(local_to_other, sides);
    }
    Box3d voxels_beyond(const Affine3d& local_to_build, std::span<const pieces::Side> sides,
                        const Vec3d& pitch_mm, const Box3d& known) const override {
        return shared_.field.voxels_beyond(local_to_build, sides, pitch_mm, known);
    }
    Box3f bounds() const override { return shared_.field.bounds(); }
    bool sides(const std::array<const float*, 3>& lo, const std::array<const float*, 3>& hi,
               size_t n, int8_t* out) const override {
        if (shared_.field.is_distance()) return false;
        shared_.field.sides(lo, hi, n, out);
        return true;
    }
    const Dicing* dicing() const override { return shared_.surface == nullptr ? nullptr : this; }
    bool for_bounds() const override { return shared_.near == nullptr; }
    int64_t patches() const override {
        return static_cast<int64_t>(shared_.surface->patches().size());
    }
    surface::SurfaceCounts counts() const override { return shared_.surface->counts(); }
    void set_cache_bytes(size_t bytes) const override { shared_.surface->set_cache_bytes(bytes); }
    int64_t query_bytes() const override {
        return shared_.trees == nullptr
                   ? 0
                   : static_cast<int64_t>(nearest::estimated_bytes(*shared_.trees, 0));
    }
    int64_t body_bytes() const override { return shared_.field.body_bytes(); }
    Result<void> status() const override { return shared_.field.status(); }
    void set_stop(const std::atomic<bool>* stop) const override {
        stop_ = stop;
        shared_.field.set_stop(stop);
        if (shared_.surface != nullptr) shared_.surface->set_stop(stop);
    }
    void prepare(const Asked& asked, const QuerySetUp& queries) override;
    std::unique_ptr<Placed> place(const Place& where) const override {
        return std::make_unique<PlacedShape>(shared_, where);
    }

  private:
    const surface::SurfaceOptions options_;
    mutable const std::atomic<bool>* stop_;
    SharedShape shared_;
};

void ShapeSolid::prepare(const Asked& asked, const QuerySetUp& queries) {
    if (!asked.nearest) return;
    shared_.asked = true;
    const bool points = !shared_.field.is_distance() || asked.attributes || asked.geometry;
    if (points && shared_.surface == nullptr) {
        shared_.blocks = shared_.field.find_blocks(stop_);
        shared_.surface =
            make_shape_surface(shared_.field, shared_.blocks, options_.cache_bytes, stop_);
        if (!shared_.field.is_distance())
            shared_.near = std::make_unique<const ShapeNear>(shared_.field, shared_.blocks);
        shared_.trees = nearest::make_block_index(
            *shared_.surface, {.cache = queries.trees, .widest = widest_queries(queries.isa)});
    }
    if ((asked.attributes || asked.geometry) && shared_.attributes == nullptr) {
        shared_.attributes = std::make_unique<nearest::AttributeReader>(
            *shared_.surface, std::array<float, OPENFAB_FRAME_COUNT>{}, asked.geometry);
    }
}

}  // namespace

const Kind kShapeKind{
    .alike =
        [](const part::Part& a, const part::Part& b) {
            return a.fablet->has_surface == 0 || kMeshKind.alike(a, b);
        },
    // What displaces a shape starts from a mesh of it.
    .refine = [](const surface::SurfaceOptions& options, const Bodies& bodies,
                 part::Part* part) -> Result<void> {
        if (part->fablet->has_surface == 0) return {};
        Result<std::shared_ptr<const part::PartMesh>> mesh = mesh_of_shape(*part, options, bodies);
        if (!mesh) return mesh.error();
        part->mesh = std::move(*mesh);
        part->geometry = part::MeshGeometry{};
        return kMeshKind.refine(options, {}, part);
    },
    .make = [](const part::Part& part, const surface::SurfaceOptions& options,
               const Bodies& bodies) -> Result<std::shared_ptr<Solid>> {
        auto made = std::make_shared<ShapeSolid>(part, options, bodies);
        if (Result<void> fine = made->check(); !fine) return fine.error();
        return std::shared_ptr<Solid>(std::move(made));
    },
};

}  // namespace openfab::solid
