// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/beams/beam_solid.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "base/infinity.h"
#include "runtime/solid/beams/beam_coverage.h"
#include "runtime/solid/beams/beam_engine.h"
#include "runtime/solid/extent/extent_search.h"
#include "runtime/solid/placed_tiles.h"
#include "runtime/surface/transform_box.h"

namespace openfab::solid {

namespace {

/// What placements of beams share.
struct Shared {
    explicit Shared(const part::Part& of)
        : part(of), beams(*std::get<part::BeamGeometry>(of.geometry).beams), tree(beams) {}

    const part::Part& part;
    const part::PartBeams& beams;
    BeamTree tree;
    bool asked = false;
    std::unique_ptr<const BeamAttributes> attributes;  ///< null where nothing reads nearest points
};

/// Returns the box of all beams under a map of part-local space.
Box3d mapped_box(const part::PartBeams& of, const Affine3d& map) {
    const double s = of.scale;
    Affine3d whole = map;
    for (double& m : whole.m)
        m *= s;
    whole.t = map.apply(Vec3d{} - of.center_part_mm);
    const std::vector<mesh::Beam>& beams = of.beams->beams;
    return tbb::parallel_reduce(
        tbb::blocked_range<size_t>(0, beams.size(), 4096), Box3d{},
        [&](const auto& range, Box3d box) {
            for (size_t i = range.begin(); i < range.end(); ++i)
                mesh::add_beam_box(*of.beams, beams[i], whole, &box);
            return box;
        },
        [](Box3d a, const Box3d& b) {
            a.add(b);
            return a;
        });
}

class PlacedBeams final : public PlacedTiles<BeamCoverage> {
  public:
    PlacedBeams(const Shared& shared, const Place& where)
        : PlacedTiles(shared.tree, where), shared_(shared) {}

    void begin_queries() override {
        if (engine_ == nullptr && shared_.asked)
            engine_ = make_beam_engine(shared_.tree, voxels_, shared_.attributes.get());
    }
    void read(const nearest::BlockAnswer& answer, const uint8_t* active,
              const nearest::AttributeTargets& targets, Scratch* /*scratch*/) const override {
        shared_.attributes->read(shared_.tree, frame_, answer, active, targets);
    }
    void read_points(const nearest::PointAnswer& answer, const nearest::PointTargets& targets,
                     Scratch* /*scratch*/) const override {
        shared_.attributes->read_points(shared_.tree, answer, targets);
    }
    uint32_t inside(const nearest::PointPacket& packet, const nearest::PointAnswer& answers,
                    const KnownInside& /*known*/, Scratch* /*scratch*/) const override {
        uint32_t inside = 0;
        for (size_t l = 0; l < 8; ++l) {
            if ((packet.mask >> l & 1) == 0 || answers.item[l] < 0) continue;
            const BeamRecord& beam = shared_.tree.beams()[static_cast<size_t>(answers.item[l])];
            const float d = beam_distance(beam, packet.point(l));
            inside |= (d < 0 ? 1u : 0u) << l;
        }
        return inside;
    }

  private:
    const Shared& shared_;
};

/// Beams for the search of an extent: their distance never changes faster than the place.
class BeamsValue final : public SolidValue {
  public:
    explicit BeamsValue(const BeamTree& tree) : tree_(tree) {}

    Box3f box() const override { return tree_.bounds(); }
    void values(std::span<const Vec3f> points, float* out) const override {
        int32_t start = -1;
        for (const Vec3f& p : points) {
            const NearestBeam found = tree_.nearest(p, start);
            start = found.beam;
            *out++ = found.distance;
        }
    }
    void lower_bounds(std::span<const Box3f> boxes, float* out) const override {
        int32_t start = -1;
        for (const Box3f& box : boxes) {
            const Vec3f p = box.center();
            const NearestBeam found = tree_.nearest(p, start);
            start = found.beam;
            *out++ = found.distance - length(box.hi - p) - tree_.slack(p);
        }
    }

  private:
    const BeamTree& tree_;
};

class BeamSolid final : public Solid {
  public:
    explicit BeamSolid(const part::Part& part) : shared_(part) {}

    Box3d exact_box(const Affine3d& local_to_other) const override {
        return mapped_box(shared_.beams, local_to_other);
    }
    Box3d box_on_sides(const Affine3d& local_to_other,
                       std::span<const pieces::Side> sides) const override {
        const Extent found = find_extent(BeamsValue(shared_.tree), local_to_other.m, sides);
        Box3d box = found.box;
        if (!box.empty()) box = {box.lo + local_to_other.t, box.hi + local_to_other.t};
        // Where thousands of tips are level the search ends before all are decided: none is cut off.
        for (const Box3f& open : found.open)
            box.add(surface::transform_box(local_to_other, open));
        return box;
    }
    Box3f bounds() const override { return shared_.tree.bounds(); }
    void prepare(const Asked& asked, const QuerySetUp& /*queries*/) override {
        shared_.asked = shared_.asked || asked.nearest;
        if ((asked.attributes || asked.geometry) && shared_.attributes == nullptr) {
            shared_.attributes =
                std::make_unique<const BeamAttributes>(shared_.beams, *shared_.part.fablet);
        }
    }
    std::unique_ptr<Placed> place(const Place& where) const override {
        return std::make_unique<PlacedBeams>(shared_, where);
    }

  private:
    Shared shared_;
};

}  // namespace

const Kind kBeamKind{
    .bytes =
        [](const part::Part& part) {
            return BeamTree::bytes(static_cast<int64_t>(
                std::get<part::BeamGeometry>(part.geometry).beams->beams->beams.size()));
        },
    .make = [](const part::Part& part, const surface::SurfaceOptions& /*options*/,
               const Bodies& /*bodies*/) -> Result<std::shared_ptr<Solid>> {
        return std::shared_ptr<Solid>(std::make_shared<BeamSolid>(part));
    },
};

}  // namespace openfab::solid
