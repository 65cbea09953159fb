// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/grow_solid.h"

#include <algorithm>

#include "runtime/part/shape_stage.h"
#include "runtime/solid/grow/grow_coverage.h"
#include "runtime/solid/grow/grow_engine.h"
#include "runtime/solid/grow/program_source.h"
#include "runtime/solid/grow/rule_source.h"
#include "runtime/solid/messages.h"
#include "runtime/solid/placed_tiles.h"
#include "runtime/surface/transform_box.h"

namespace openfab::solid {

namespace {

std::unique_ptr<const ClumpSource> make_source(const part::Part& of,
                                               const surface::SurfaceOptions& options,
                                               const Bodies& bodies) {
    const auto& grown = std::get<part::GrownGeometry>(of.geometry);
    if (grown.program != nullptr) return make_program_source(grown, *of.fablet, bodies, options);
    return make_rule_source(*grown.stage, *of.fablet, bodies, options.isa);
}

/// What placements share.
struct SharedGrown {
    SharedGrown(const part::Part& of, const surface::SurfaceOptions& options, const Bodies& bodies)
        : part(of),
          grown(make_source(of, options, bodies), of.mesh->center_part_mm, options.cache_bytes) {}

    const part::Part& part;
    Grown grown;
    bool asked = false, attributes = false;
};

const GrowScratch& of_engine(const Scratch* scratch) {
    return static_cast<const GrowScratch&>(*scratch->engine);
}

class PlacedGrown final : public PlacedTiles<GrowCoverage> {
  public:
    PlacedGrown(const SharedGrown& shared, const Place& where)
        : PlacedTiles(shared.grown, where), shared_(shared) {}

    void begin_queries() override {
        if (engine_ == nullptr && shared_.asked)
            engine_ = make_grow_engine(shared_.grown, frame_,
                                       shared_.attributes ? shared_.part.fablet : nullptr);
    }
    void read(const nearest::BlockAnswer& answer, const uint8_t* active,
              const nearest::AttributeTargets& targets, Scratch* scratch) const override {
        const GrowScratch::Region* region = of_engine(scratch).asked;
        static const GrowScratch::Region kNone;
        if (region == nullptr) region = &kNone;
        const LocalBeams& beams = region->beams;
        if (!region->bodies.empty()) return read_both(*region, answer, active, targets);
        if (!beams.empty()) beams.attributes()->read(beams.tree(), frame_, answer, active, targets);
    }
    void read_points(const nearest::PointAnswer& answer, const nearest::PointTargets& targets,
                     Scratch* scratch) const override {
        const LocalBeams& beams = of_engine(scratch).of_points;
        const LocalBodies& bodies = of_engine(scratch).bodies_of_points;
        const auto first_body = static_cast<int32_t>(beams.size());
        nearest::PointAnswer of_beams = answer;
        for (int32_t& item : of_beams.item)
            item = item < first_body ? item : -1;
        if (beams.empty()) {
            clear(targets, 8, bodies.floats(), bodies.ints());
        } else {
            beams.attributes()->read_points(beams.tree(), of_beams, targets);
        }
        for (size_t l = 0; l < 8; ++l) {
            if (answer.item[l] < first_body) continue;
            const auto body = static_cast<size_t>(answer.item[l] - first_body);
            bodies.read(body, l, {targets.values, nullptr, targets.flat});
            const Vec3f position = answer.point_at(l);
            for (int a = 0; a < 3; ++a) {
                if (targets.position[a] != nullptr) targets.position[a][l] = position[a];
                if (targets.normal[a] != nullptr)
                    targets.normal[a][l] = bodies.bodies()[body].normal[a];
            }
        }
    }
    uint32_t inside(const nearest::PointPacket& packet, const nearest::PointAnswer& answers,
                    const KnownInside& /*known*/, Scratch* scratch) const override {
        const LocalBeams& beams = of_engine(scratch).of_points;
        const LocalBodies& bodies = of_engine(scratch).bodies_of_points;
        const auto first_body = static_cast<int32_t>(beams.size());
        uint32_t inside = 0;
        for (size_t l = 0; l < 8; ++l) {
            if ((packet.mask >> l & 1) == 0 || answers.item[l] < 0) continue;
            const Vec3f p = packet.point(l);
            const auto place = static_cast<size_t>(answers.item[l]);
            const float d = answers.item[l] < first_body
                                ? beam_distance(beams.tree().beams()[place], p)
                                : bodies.bodies()[place - beams.size()].body.distance(
                                      vec_cast<double>(p) + shared_.grown.center());
            inside |= (d < 0 ? 1u : 0u) << l;
        }
        return inside;
    }

  private:
    /// Writes 0 to what has `places` values a component.
    template <typename Targets>
    static void clear(const Targets& targets, size_t places, size_t floats, size_t ints) {
        const auto fill = [&](auto* const* arrays, size_t count) {
            for (size_t i = 0; arrays != nullptr && i < count; ++i) {
                if (arrays[i] != nullptr) std::fill_n(arrays[i], places, 0);
            }
        };
        fill(targets.values, floats);
        fill(targets.flat, ints);
        if constexpr (requires { targets.gradients; }) {
            fill(targets.gradients, 3 * floats);
        } else {
            fill(targets.position, 3);
            fill(targets.normal, 3);
        }
    }
    void read_both(const GrowScratch::Region& region, const nearest::BlockAnswer& answer,
                   const uint8_t* active, const nearest::AttributeTargets& targets) const {
        const auto first_body = static_cast<int32_t>(region.beams.size());
        if (region.beams.empty()) {
            clear(targets, nearest::kBlockVoxels, region.bodies.floats(), region.bodies.ints());
        } else {
            nearest::BlockAnswer of_beams = answer;
            for (int32_t& item : of_beams.item)
                item = item < first_body ? item : -1;
            region.beams.attributes()->read(region.beams.tree(), frame_, of_beams, active, targets);
        }
        for (size_t v = 0; v < nearest::kBlockVoxels; ++v) {
            const bool on = active == nullptr || (active[v >> 3] >> (v & 7) & 1) != 0;
            if (on && answer.item[v] >= first_body)
                region.bodies.read(static_cast<size_t>(answer.item[v] - first_body), v, targets);
        }
    }

    const SharedGrown& shared_;
};

class GrowSolid final : public Solid, Dicing {
  public:
    GrowSolid(const part::Part& part, const surface::SurfaceOptions& options, const Bodies& bodies)
        : shared_(part, options, bodies) {
        shared_.grown.set_stop(options.stop);
    }

    /// Returns an error of the first nodes.
    Result<void> check() const {
        shared_.grown.begin();
        return status();
    }

    Box3d exact_box(const Affine3d& local_to_other) const override {
        return surface::transform_box(local_to_other, bounds());
    }
    Box3d box_on_sides(const Affine3d& local_to_other,
                       std::span<const pieces::Side> /*sides*/) const override {
        return exact_box(local_to_other);
    }
    Box3f bounds() const override { return shared_.grown.bounds(); }
    const Dicing* dicing() const override { return this; }
    void set_cache_bytes(size_t bytes) const override { shared_.grown.set_bytes(bytes); }
    Result<void> status() const override { return shared_.grown.status(); }
    void set_stop(const std::atomic<bool>* stop) const override { shared_.grown.set_stop(stop); }
    void prepare(const Asked& asked, const QuerySetUp& /*queries*/) override {
        shared_.asked = shared_.asked || asked.nearest;
        if (asked.nearest) shared_.grown.keep_all();
        shared_.attributes = shared_.attributes || asked.attributes || asked.geometry;
    }
    std::unique_ptr<Placed> place(const Place& where) const override {
        return std::make_unique<PlacedGrown>(shared_, where);
    }

  private:
    SharedGrown shared_;
};

}  // namespace

const Kind kGrowKind{
    // Values are of the fablet's @nearest inputs.
    .alike = [](const part::Part& a, const part::Part& b) { return a.fablet == b.fablet; },
    .refine = [](const surface::SurfaceOptions& /*options*/, const Bodies& /*bodies*/,
                 part::Part* part) -> Result<void> {
        if (part->fablet->has_surface == 0) return {};
        return error_at(part::stage_of(*part)->location, messages::kBeamsNotDisplaced,
                        messages::kBeamsNotDisplacedHelp);
    },
    .make = [](const part::Part& part, const surface::SurfaceOptions& options,
               const Bodies& bodies) -> Result<std::shared_ptr<Solid>> {
        auto made = std::make_shared<GrowSolid>(part, options, bodies);
        if (Result<void> fine = made->check(); !fine) return fine.error();
        return std::shared_ptr<Solid>(std::move(made));
    },
};

}  // namespace openfab::solid
