// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/stretched/stretched_solid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/affine.h"
#include "base/infinity.h"
#include "runtime/part/stretch.h"
#include "runtime/solid/stretched/stretched_engine.h"
#include "runtime/surface/transform_box.h"

namespace openfab::solid {

namespace {

struct StretchedScratch final : Scratch {
    std::unique_ptr<Scratch> source;
};

Scratch* source_of(Scratch* scratch) {
    return static_cast<StretchedScratch*>(scratch)->source.get();
}

/// The source where its part is placed: part-local points of both are multiples, without a shift.
part::Part placed_source(const part::Part& part) {
    part::Part out = part.stretched->source;
    out.local_to_build = product(part.local_to_build, Affine3d{part.stretched->by, {}});
    return out;
}

/// As part::make_frame, for a map that is not orthogonal.
std::array<float, OPENFAB_FRAME_COUNT> frame_of_source(const part::Part& part,
                                                       const part::Grid& grid,
                                                       const Stretch& stretch) {
    std::array<float, OPENFAB_FRAME_COUNT> frame = part::make_frame(part, grid);
    const std::array<double, 9>& r = part.local_to_build.m;
    const Vec3i base = part::part_base_voxel(part, grid);
    Vec3d origin;
    for (int axis = 0; axis < 3; ++axis) {
        const auto row = static_cast<size_t>(3 * axis);
        const Vec3d step = Vec3d{r[row], r[row + 1], r[row + 2]} * grid.pitch_mm[axis];
        const double corner =
            grid.origin_mm[axis] + static_cast<double>(base[axis]) * grid.pitch_mm[axis];
        origin =
            origin + Vec3d{r[row], r[row + 1], r[row + 2]} * (corner - part.local_to_build.t[axis]);
        const Vec3d to = stretch.back(step);
        for (size_t a = 0; a < 3; ++a)
            frame[row + a] = static_cast<float>(to[static_cast<int>(a)]);
    }
    const Vec3d to = stretch.back(origin);
    for (size_t a = 0; a < 3; ++a)
        frame[OPENFAB_FRAME_ORIGIN + a] = static_cast<float>(to[static_cast<int>(a)]);
    return frame;
}
static_assert(OPENFAB_FRAME_STEP_I == 0 && OPENFAB_FRAME_STEP_J == 3 && OPENFAB_FRAME_STEP_K == 6);

class PlacedStretched final : public Placed {
  public:
    PlacedStretched(const Solid& solid, const Stretch& stretch, const Place& where)
        : stretch_(stretch),
          part_(placed_source(where.part)),
          grid_(where.grid),
          frame_(frame_of_source(where.part, where.grid, stretch)),
          source_(solid.place({part_, grid_, frame_, where.waiting_bytes})) {}

    Box3i voxel_box() const override { return source_->voxel_box(); }
    void coverage(int32_t slab, voxel::SlabMask* out, const std::atomic<bool>* stop,
                  double* seconds) const override {
        source_->coverage(slab, out, stop, seconds);
    }
    void forget_slabs() const override { source_->forget_slabs(); }
    void raise_tops(const Columns& columns, TopRows* rows) const override {
        source_->raise_tops(columns, rows);
    }
    void begin_queries() override {
        source_->begin_queries();
        if (engine_ == nullptr && source_->engine() != nullptr)
            engine_ = make_stretched_engine(*source_->engine(), stretch_);
    }
    std::unique_ptr<Scratch> make_scratch() const override {
        auto scratch = std::make_unique<StretchedScratch>();
        scratch->source = source_->make_scratch();
        scratch->engine = make_stretched_scratch(scratch->source->engine.get());
        return scratch;
    }
    void read(const nearest::BlockAnswer& answer, const uint8_t* active,
              const nearest::AttributeTargets& targets, Scratch* scratch) const override {
        source_->read(answer, active, targets, source_of(scratch));
    }
    void read_points(const nearest::PointAnswer& answer, const nearest::PointTargets& targets,
                     Scratch* scratch) const override {
        nearest::PointTargets to = targets;
        float places[3][8], normals[3][8];
        for (size_t a = 0; a < 3; ++a) {
            to.position[a] = places[a];
            to.normal[a] = normals[a];
        }
        source_->read_points(answer, to, source_of(scratch));
        const auto write = [&](float* const* out, const Vec3f& v, size_t lane) {
            for (int a = 0; a < 3; ++a)
                if (out[a] != nullptr) out[a][lane] = v[a];
        };
        for (size_t l = 0; l < 8; ++l) {
            write(targets.position, stretch_.to({places[0][l], places[1][l], places[2][l]}), l);
            const Vec3d n = stretch_.back(Vec3d{normals[0][l], normals[1][l], normals[2][l]});
            const double size = length(n);
            write(targets.normal, size > 0 ? vec_cast<float>(n * (1 / size)) : Vec3f{}, l);
        }
    }
    uint32_t inside(const nearest::PointPacket& packet, const nearest::PointAnswer& answers,
                    const KnownInside& /*known*/, Scratch* scratch) const override {
        return source_->inside(stretch_.back(packet), answers, {}, source_of(scratch));
    }

  private:
    const Stretch stretch_;
    const part::Part part_;
    const part::Grid grid_;
    const std::array<float, OPENFAB_FRAME_COUNT> frame_;
    const std::unique_ptr<Placed> source_;
};

class StretchedSolid final : public Solid {
  public:
    StretchedSolid(const part::Part& part, std::shared_ptr<Solid> solid)
        : stretch_(part.stretched->by), solid_(std::move(solid)) {}

    Box3d exact_box(const Affine3d& local_to_other) const override {
        return solid_->exact_box(product(local_to_other, stretch_.map()));
    }
    Box3d box_on_sides(const Affine3d& local_to_other,
                       std::span<const pieces::Side> sides) const override {
        std::vector<pieces::Side> of_source(sides.begin(), sides.end());
        const std::array<double, 9>& m = stretch_.map().m;
        for (pieces::Side& side : of_source) {
            const Vec3d n = side.normal;
            side.normal = {n.x * m[0] + n.y * m[3] + n.z * m[6],
                           n.x * m[1] + n.y * m[4] + n.z * m[7],
                           n.x * m[2] + n.y * m[5] + n.z * m[8]};
        }
        return solid_->box_on_sides(product(local_to_other, stretch_.map()), of_source);
    }
    Box3f bounds() const override {
        const Box3d box = surface::transform_box(stretch_.map(), solid_->bounds());
        Box3f out;
        for (int a = 0; a < 3; ++a) {
            out.lo[a] = std::nextafter(static_cast<float>(box.lo[a]), -kInfinity);
            out.hi[a] = std::nextafter(static_cast<float>(box.hi[a]), kInfinity);
        }
        return out;
    }
    const Dicing* dicing() const override { return solid_->dicing(); }
    int64_t query_bytes() const override { return solid_->query_bytes(); }
    int64_t body_bytes() const override { return solid_->body_bytes(); }
    Result<void> status() const override { return solid_->status(); }
    void set_stop(const std::atomic<bool>* stop) const override { solid_->set_stop(stop); }
    void prepare(const Asked& asked, const QuerySetUp& queries) override {
        solid_->prepare(asked, queries);
    }
    std::unique_ptr<Placed> place(const Place& where) const override {
        return std::make_unique<PlacedStretched>(*solid_, stretch_, where);
    }

  private:
    const Stretch stretch_;
    const std::shared_ptr<Solid> solid_;
};

}  // namespace

std::shared_ptr<Solid> make_stretched_solid(const part::Part& part, std::shared_ptr<Solid> solid) {
    return std::make_shared<StretchedSolid>(part, std::move(solid));
}

}  // namespace openfab::solid
