// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/reference/pipeline.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "compiler/interp/evaluate.h"
#include "compiler/passes/attach_footprints.h"
#include "compiler/passes/bound_displacement.h"
#include "compiler/passes/pipeline.h"
#include "runtime/nearest/engine.h"
#include "runtime/nearest/engine/exact.h"
#include "runtime/nearest/tree/triangle.h"
#include "tests/support/reference/dice.h"
#include "tests/support/reference/dither.h"
#include "tests/support/reference/environments.h"
#include "tests/support/reference/inside.h"

namespace openfab::reference {

namespace {

/// One part, set up to answer voxel by voxel.
class PlainPart {
  public:
    PlainPart(const ReferencePart& reference, const part::Grid& grid)
        : part_(*reference.part),
          frame_(part::make_frame(part_, grid)),
          base_(part::part_base_voxel(part_, grid)),
          surface_(reference.fablet->surface),
          volume_(reference.fablet->volume),
          dither_(reference.fablet->dither) {
        passes::attach_footprints(&volume_);
        std::vector<uint8_t> identity(part_.mesh->triangles.size(), 1);
        if (reference.fablet->has_surface) {
            passes::PipelineOptions options;
            options.disabled = {"hoist_uniforms"};
            const ir::Stage bounds =
                passes::run_pipeline(*reference.fablet, options).stages.surface_bounds;
            for (size_t t = 0; t < identity.size(); ++t)
                identity[t] = is_identity(bounds, t) ? 1 : 0;
            passes::attach_footprints(&surface_);
            passes::bound_displacement(&surface_);
        }
        const double s = std::cbrt(grid.pitch_mm.x * grid.pitch_mm.y * grid.pitch_mm.z);
        diced_ = dice(part_, s, identity,
                      [this](const MicroInputs& in) { return evaluate_surface(in); });
        cover(grid, std::find(identity.begin(), identity.end(), 0) == identity.end());
        prepare_queries();
    }

    bool inside(size_t voxel) const { return inside_[voxel] != 0; }
    int32_t priority() const { return part_.priority; }
    /// All parts of the world, by index in the build list, for distance_to.
    void set_world(const std::vector<std::unique_ptr<PlainPart>>* world) { world_ = world; }

    std::vector<uint16_t> fractions(const Vec3i& voxel, int32_t materials) const {
        const Vec3i relative = voxel - base_;
        const Vec3f center = voxel_center(relative);
        const NearestPoint nearest = find_nearest(center);
        const Ask ask = [&](const ir::Instr& query, const ir::Instr& result, const Vec3f& p) {
            return answer(query, result, p, center);
        };
        const VolumeEnvironment environment(part_, frame_, relative, nearest, ask);
        std::vector<float> weights;
        for (uint32_t w : interp::evaluate(volume_, environment))
            weights.push_back(std::bit_cast<float>(w));
        const std::vector<int32_t> slots(part_.slot_material.begin(), part_.slot_material.end());
        return normalise(weights, slots, materials, nullptr);
    }

    /// Lets the fablet's rule, if it has one, choose a material of a mixture.
    void choose(const Vec3i& voxel, uint64_t seed, std::vector<uint16_t>* fractions) const {
        if (dither_.outputs.empty()) return;
        const RuleEnvironment environment(part_, frame_, voxel, *fractions, seed);
        const auto number = static_cast<int32_t>(interp::evaluate(dither_, environment)[0]);
        const int32_t chosen = environment.choice(number);
        const auto largest = std::max_element(fractions->begin(), fractions->end());
        const auto code = chosen >= 0 ? static_cast<size_t>(chosen)
                                      : static_cast<size_t>(largest - fractions->begin());
        std::fill(fractions->begin(), fractions->end(), uint16_t{0});
        (*fractions)[code] = 65535;
    }

  private:
    bool is_identity(const ir::Stage& bounds, size_t triangle) const {
        for (int32_t k = 0; k < part_.fablet->surface_output_count; ++k) {
            if (part_.fablet->surface_outputs[k].source < 0) return false;
        }
        const TriangleBoundsEnvironment environment(part_, frame_, triangle);
        const std::vector<uint32_t> values = interp::evaluate(bounds, environment);
        for (size_t k = 0; k < values.size(); ++k) {
            const int32_t kind = bounds.outputs[k].kind;
            if (kind != OPENFAB_ARG_DISPLACEMENT_LO && kind != OPENFAB_ARG_DISPLACEMENT_HI)
                continue;
            if (!(std::bit_cast<float>(values[k]) == 0)) return false;
        }
        return true;
    }

    MicroOutputs evaluate_surface(const MicroInputs& in) const {
        const SurfaceEnvironment environment(part_, frame_, in);
        const std::vector<uint32_t> values = interp::evaluate(surface_, environment);
        MicroOutputs out;
        for (int32_t k = 0; k < part_.fablet->surface_output_count; ++k) {
            out.outputs.emplace_back(
                static_cast<size_t>(part_.fablet->surface_outputs[k].components));
        }
        for (size_t k = 0; k < values.size(); ++k) {
            const ir::Output& output = surface_.outputs[k];
            // The sum turns -0 into 0, so that equal positions have equal bits.
            if (output.kind == OPENFAB_ARG_POSITION)
                out.position[output.b] = std::bit_cast<float>(values[k]) + 0.0f;
            if (output.kind == OPENFAB_ARG_SURFACE_OUT) {
                out.outputs[output.a][output.b] = values[k];
            }
        }
        return out;
    }

    void cover(const part::Grid& grid, bool identity) {
        if (identity) {
            std::vector<std::array<Vec3d, 3>> exact;
            for (const auto& t : part_.mesh->triangles) {
                exact.push_back({part_.mesh->positions[t[0]], part_.mesh->positions[t[1]],
                                 part_.mesh->positions[t[2]]});
            }
            inside_ = reference::inside(snap_triangles(part::local_to_voxel(part_, grid), exact),
                                        grid.size);
            return;
        }
        std::vector<std::array<Vec3f, 3>> triangles;
        for (const DicedTriangle& t : diced_) {
            if (t.coverage) triangles.push_back(t.positions);
        }
        inside_ = reference::inside(snap_triangles(part::local_to_voxel(part_, grid), triangles),
                                    grid.size);
    }

    void prepare_queries() {
        for (const DicedTriangle& t : diced_) {
            if (!t.query) continue;
            query_.push_back(&t);
            nearest::make_triangle(t.positions[0], t.positions[1], t.positions[2], t.patch,
                                   t.in_patch, &frames_.emplace_back(), &details_.emplace_back());
        }
    }

    /// +1 where the ray from p along +x, p perturbed by (e, e², e³), leaves through the triangle.
    static int32_t crossing(const std::array<Vec3f, 3>& t, const Vec3f& p) {
        int side = 0;
        for (size_t e = 0; e < 3; ++e) {
            const Vec3f &a = t[e], &b = t[(e + 1) % 3];
            int left = nearest::area_sign(a, b, p);
            if (left == 0)
                left = a.z != b.z ? (b.z < a.z ? 1 : -1) : (b.y > a.y ? 1 : b.y < a.y ? -1 : 0);
            if (left == 0 || (e > 0 && left != side)) return 0;
            side = left;
        }
        return nearest::volume_sign(t[0], t[1], t[2], p) == -side ? side : 0;
    }

    /// Returns the signed distance of any point; infinite if it is not finite.
    float signed_distance(const Vec3f& p, const NearestPoint& nearest) const {
        if (nearest.triangle == nullptr) return std::numeric_limits<float>::infinity();
        int32_t winding = 0;
        for (const DicedTriangle& t : diced_) {
            if (t.coverage) winding += crossing(t.positions, p);
        }
        const float d = std::sqrt(nearest.distance2);
        return winding > 0 ? 0.0f - d : d;
    }

    uint32_t answer(const ir::Instr& query, const ir::Instr& result, const Vec3f& p,
                    const Vec3f& center) const {
        if (query.a >= 0) {
            float least = std::numeric_limits<float>::infinity();
            for (const int32_t place : part_.objects[query.a]) {
                const PlainPart& other = *(*world_)[place];
                const Vec3f q = vec_cast<float>(
                    part::local_to_local(part_, other.part_).apply(vec_cast<double>(p)));
                least = std::min(least, other.signed_distance(q, other.find_nearest(q)));
            }
            return bits(least);
        }
        const NearestPoint nearest = find_nearest(p);
        if (result.kind == OPENFAB_QUERY_DISTANCE) {
            // At the voxel's own center the part covers it.
            return bits(p == center ? 0.0f - std::sqrt(nearest.distance2)
                                    : signed_distance(p, nearest));
        }
        if (nearest.triangle == nullptr) return 0;
        if (result.kind == OPENFAB_QUERY_ATTRIBUTE) {
            return VolumeEnvironment::attribute_at(part_, nearest, static_cast<size_t>(result.a),
                                                   static_cast<size_t>(result.b));
        }
        const std::array<Vec3f, 3>& t = nearest.triangle->positions;
        if (result.kind == OPENFAB_QUERY_POSITION) {
            const float v0 = t[0][result.b];
            return bits(v0 + (nearest.bary1 * (t[1][result.b] - v0) +
                              nearest.bary2 * (t[2][result.b] - v0)));
        }
        const Vec3d v0 = vec_cast<double>(t[0]);
        const Vec3d n = cross(vec_cast<double>(t[1]) - v0, vec_cast<double>(t[2]) - v0);
        const double length2 = dot(n, n);
        return length2 > 0 ? bits(static_cast<float>((n * (1.0 / std::sqrt(length2)))[result.b]))
                           : 0;
    }

    Vec3f voxel_center(const Vec3i& voxel) const {
        Vec3f p;
        const float x = static_cast<float>(voxel.x) + 0.5f, y = static_cast<float>(voxel.y) + 0.5f,
                    z = static_cast<float>(voxel.z) + 0.5f;
        for (int c = 0; c < 3; ++c) {
            const auto k = static_cast<size_t>(c);
            p[c] = ((x * frame_[OPENFAB_FRAME_STEP_I + k] + y * frame_[OPENFAB_FRAME_STEP_J + k]) +
                    z * frame_[OPENFAB_FRAME_STEP_K + k]) +
                   frame_[OPENFAB_FRAME_ORIGIN + k];
        }
        return p;
    }

    NearestPoint find_nearest(const Vec3f& p) const {
        NearestPoint best;
        for (int a = 0; a < 3; ++a) {
            if (!(std::fabs(p[a]) < nearest::kMaxCoordinate)) return best;
        }
        for (size_t t = 0; t < query_.size(); ++t) {
            const nearest::Hit hit = nearest::closest_point(frames_[t], details_[t], p);
            const bool before = best.triangle != nullptr && hit.distance2 == best.distance2 &&
                                nearest::precedes(query_[t]->patch, query_[t]->in_patch,
                                                  best.triangle->patch, best.triangle->in_patch);
            if (hit.distance2 < best.distance2 || before)
                best = {hit.distance2, hit.bary1, hit.bary2, query_[t]};
        }
        return best;
    }

    const part::Part& part_;
    const std::array<float, OPENFAB_FRAME_COUNT> frame_;
    const Vec3i base_;
    ir::Stage surface_, volume_, dither_;
    std::vector<DicedTriangle> diced_;
    std::vector<uint8_t> inside_;
    std::vector<const DicedTriangle*> query_;
    std::vector<nearest::TriangleFrame> frames_;
    std::vector<nearest::TriangleDetail> details_;
    const std::vector<std::unique_ptr<PlainPart>>* world_ = nullptr;
};

}  // namespace

std::vector<uint8_t> print(const std::vector<ReferencePart>& parts, const part::Grid& grid,
                           int32_t materials, uint64_t seed) {
    std::vector<std::unique_ptr<PlainPart>> plain;
    for (const ReferencePart& part : parts)
        plain.push_back(std::make_unique<PlainPart>(part, grid));
    for (const auto& part : plain)
        part->set_world(&plain);
    FractionField field = make_field(grid.size, materials);
    size_t place = 0;
    for (int32_t z = 0; z < grid.size.z; ++z) {
        for (int32_t y = 0; y < grid.size.y; ++y) {
            for (int32_t x = 0; x < grid.size.x; ++x, ++place) {
                // Highest priority first; on ties the later one has the voxel.
                const PlainPart* owner = nullptr;
                for (const auto& part : plain) {
                    if (part->inside(place) &&
                        (owner == nullptr || part->priority() >= owner->priority()))
                        owner = part.get();
                }
                if (owner == nullptr) continue;
                std::vector<uint16_t> fractions = owner->fractions({x, y, z}, materials);
                if (is_mixed(fractions.data(), materials + 1))
                    owner->choose({x, y, z}, seed, &fractions);
                std::copy(fractions.begin(), fractions.end(), field.at(x, y, z));
            }
        }
    }
    return dither(field, seed);
}

}  // namespace openfab::reference
