// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the interpreter sees of a part in each of its stages, by brute force.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "abi/voxel_hash.h"
#include "compiler/interp/evaluate.h"
#include "runtime/part/part.h"
#include "tests/support/reference/blue_noise.h"
#include "tests/support/reference/dice.h"

namespace openfab::reference {

inline uint32_t bits(float value) {
    return std::bit_cast<uint32_t>(value);
}

/// The inputs of every stage of a part: uniforms, frame, textures.
class PartEnvironment : public interp::Environment {
  public:
    PartEnvironment(const part::Part& part, const std::array<float, OPENFAB_FRAME_COUNT>& frame)
        : part_(part), frame_(frame) {}

    uint32_t input(int32_t kind, int32_t a, int32_t b) const final {
        const auto index = static_cast<size_t>(a);
        switch (kind) {
            case OPENFAB_ARG_UNIFORM:
                return part_.uniform_values[index];
            case OPENFAB_ARG_FRAME:
                return bits(frame_[index]);
            case OPENFAB_ARG_INSTANCE:
                return static_cast<uint32_t>(part_.instance);
            default:
                return varying(kind, index, static_cast<size_t>(b));
        }
    }
    interp::TextureView texture(int32_t index) const final {
        const texture::Pyramid& pyramid = *part_.textures[index];
        return {pyramid.texels(), pyramid.info()};
    }

  protected:
    virtual uint32_t varying(int32_t kind, size_t a, size_t b) const = 0;

    const part::Part& part_;
    const std::array<float, OPENFAB_FRAME_COUNT>& frame_;
};

class SurfaceEnvironment final : public PartEnvironment {
  public:
    SurfaceEnvironment(const part::Part& part, const std::array<float, OPENFAB_FRAME_COUNT>& frame,
                       const MicroInputs& in)
        : PartEnvironment(part, frame), in_(in) {}

  private:
    uint32_t varying(int32_t kind, size_t a, size_t b) const override {
        const auto c = static_cast<int>(b);
        switch (kind) {
            case OPENFAB_ARG_SURFACE_IN:
                return in_.flats[a].empty() ? bits(in_.floats[a][b]) : in_.flats[a][b];
            case OPENFAB_ARG_SURFACE_IN_GRAD:
                return bits(in_.gradients[a][b / 2][b % 2]);
            case OPENFAB_ARG_SURFACE_ATTR:
                switch (a) {
                    case OPENFAB_SURFACE_P:
                        return bits(in_.p[c]);
                    case OPENFAB_SURFACE_N:
                        return bits(in_.n[c]);
                    case OPENFAB_SURFACE_NG:
                        return bits(in_.ng[c]);
                    case OPENFAB_SURFACE_UV:
                        return bits(in_.uv[b]);
                    case OPENFAB_SURFACE_DPDU:
                        return bits(in_.dpdu[c]);
                    default:
                        return bits(in_.dpdv[c]);
                }
            case OPENFAB_ARG_SURFACE_ATTR_GRAD:
                switch (a) {
                    case OPENFAB_SURFACE_P:
                        return bits(in_.p_gradient[b / 2][b % 2]);
                    case OPENFAB_SURFACE_N:
                        return bits(in_.n_gradient[b / 2][b % 2]);
                    case OPENFAB_SURFACE_UV:
                        return bits(in_.uv_gradient[b / 2][b % 2]);
                    default:
                        return 0;
                }
            default:
                return 0;
        }
    }
    const MicroInputs& in_;
};

/// One base triangle as a box of inputs: its displacement interval decides whether it is an
/// identity.
class TriangleBoundsEnvironment final : public PartEnvironment {
  public:
    TriangleBoundsEnvironment(const part::Part& part,
                              const std::array<float, OPENFAB_FRAME_COUNT>& frame, size_t triangle)
        : PartEnvironment(part, frame), triangle_(triangle) {}

  private:
    uint32_t varying(int32_t kind, size_t a, size_t b) const override {
        const bool low = kind == OPENFAB_ARG_SURFACE_IN_LO;
        if (!low && kind != OPENFAB_ARG_SURFACE_IN_HI)
            return bits(std::numeric_limits<float>::quiet_NaN());
        const part::PartAttribute& attribute = part_.mesh->inputs[a];
        const auto components = static_cast<size_t>(attribute.components);
        if (attribute.scalar != OPENFAB_FLOAT)
            return attribute.face_values[triangle_ * components + b];
        float value = attribute.corner_values[triangle_ * 3 * components + b];
        for (size_t corner = 1; corner < 3; ++corner) {
            const float other = attribute.corner_values[(triangle_ * 3 + corner) * components + b];
            value = low ? std::min(value, other) : std::max(value, other);
        }
        const float beyond =
            low ? -std::numeric_limits<float>::infinity() : std::numeric_limits<float>::infinity();
        return bits(std::nextafter(value, beyond));
    }
    const size_t triangle_;
};

struct NearestPoint {
    float distance2 = std::numeric_limits<float>::infinity();
    float bary1 = 0, bary2 = 0;
    const DicedTriangle* triangle = nullptr;
};

/// Answers the queries of a volume stage: object (-1: the part's own surface), point in part-local
/// mm, and which result; the bits of a component.
using Ask =
    std::function<uint32_t(const ir::Instr& query, const ir::Instr& result, const Vec3f& p)>;

class VolumeEnvironment final : public PartEnvironment {
  public:
    VolumeEnvironment(const part::Part& part, const std::array<float, OPENFAB_FRAME_COUNT>& frame,
                      const Vec3i& voxel, const NearestPoint& nearest, const Ask& ask)
        : PartEnvironment(part, frame), voxel_(voxel), nearest_(nearest), ask_(ask) {}
    uint32_t query(const ir::Instr& query, const ir::Instr& result,
                   std::span<const uint32_t> args) const override {
        Vec3f p;
        for (int a = 0; a < 3; ++a)
            p[a] = std::bit_cast<float>(args[static_cast<size_t>(1 + a)]);
        return ask_(query, result, p);
    }

    static uint32_t attribute_at(const part::Part& part, const NearestPoint& at, size_t input,
                                 size_t component) {
        const size_t c = place(part, input, component);
        const DicedTriangle& t = *at.triangle;
        if (part.fablet->nearest[input].scalar != OPENFAB_FLOAT) return t.ints[c];
        const float a0 = t.floats[0][c], d1 = t.floats[1][c] - a0, d2 = t.floats[2][c] - a0;
        return bits((a0 + at.bary1 * d1) + at.bary2 * d2);
    }

  private:
    uint32_t varying(int32_t kind, size_t a, size_t b) const override {
        switch (kind) {
            case ir::kVoxelCoord:
                return bits(static_cast<float>(voxel_[static_cast<int>(a)]) + 0.5f);
            // Only voxels inside are evaluated, so the sign is always negative.
            case OPENFAB_ARG_DISTANCE:
                return bits(-std::sqrt(nearest_.distance2));
            case OPENFAB_ARG_NEAREST:
                return attribute_at(part_, nearest_, a, b);
            case OPENFAB_ARG_NEAREST_GRAD:
                return gradient(a, b / 3, b % 3);
            default:
                return 0;
        }
    }
    /// Returns the index of a component among all float (or all other) components of the fablet's
    /// @nearest inputs.
    static size_t place(const part::Part& part, size_t input, size_t component) {
        const bool is_float = part.fablet->nearest[input].scalar == OPENFAB_FLOAT;
        for (size_t k = 0; k < input; ++k) {
            if ((part.fablet->nearest[k].scalar == OPENFAB_FLOAT) == is_float) {
                component += static_cast<size_t>(part.fablet->nearest[k].components);
            }
        }
        return component;
    }
    /// Change per voxel step of the linear interpolant in the triangle's plane.
    uint32_t gradient(size_t input, size_t component, size_t axis) const {
        const size_t c = place(part_, input, component);
        const DicedTriangle& t = *nearest_.triangle;
        const Vec3d v0 = vec_cast<double>(t.positions[0]);
        const Vec3d e1 = vec_cast<double>(t.positions[1]) - v0,
                    e2 = vec_cast<double>(t.positions[2]) - v0;
        const Vec3d n = cross(e1, e2);
        const double n2 = dot(n, n);
        if (!(n2 > 0)) return 0;
        const size_t first = OPENFAB_FRAME_STEP_I + 3 * axis;
        const Vec3d step{frame_[first], frame_[first + 1], frame_[first + 2]};
        const auto s1 = static_cast<float>(dot(cross(e2, n) * (1.0 / n2), step));
        const auto s2 = static_cast<float>(dot(cross(n, e1) * (1.0 / n2), step));
        const float d1 = t.floats[1][c] - t.floats[0][c], d2 = t.floats[2][c] - t.floats[0][c];
        return bits(s1 * d1 + s2 * d2);
    }

    const Vec3i voxel_;
    const NearestPoint& nearest_;
    const Ask& ask_;
};

/// What a dither rule sees of a voxel: fractions in the order of its part's slots by material, void
/// first; of slots of one material the last has them.
class RuleEnvironment final : public PartEnvironment {
  public:
    RuleEnvironment(const part::Part& part, const std::array<float, OPENFAB_FRAME_COUNT>& frame,
                    const Vec3i& voxel, const std::vector<uint16_t>& fractions, uint64_t seed)
        : PartEnvironment(part, frame), voxel_(voxel), fractions_(fractions), seed_(seed) {
        codes_.insert(codes_.end(), part.slot_material.begin(), part.slot_material.end());
        std::sort(codes_.begin(), codes_.end());
    }
    /// Returns the code of a fraction, or -1 if the rule must not choose it.
    int32_t choice(int32_t number) const {
        if (number < 0 || number >= static_cast<int32_t>(codes_.size())) return -1;
        return fraction(static_cast<size_t>(number)) > 0 ? codes_[static_cast<size_t>(number)] : -1;
    }

  private:
    uint16_t fraction(size_t number) const {
        const bool last = number + 1 == codes_.size() || codes_[number + 1] != codes_[number];
        return last ? fractions_[static_cast<size_t>(codes_[number])] : 0;
    }
    uint32_t varying(int32_t kind, size_t a, size_t /*b*/) const override {
        switch (kind) {
            case ir::kVoxelIndex:
                return static_cast<uint32_t>(voxel_[static_cast<int>(a)]);
            case OPENFAB_ARG_FRACTION:
                return fraction(a);
            case OPENFAB_ARG_GRID:
                return abi::fold_seed(seed_);
            case OPENFAB_ARG_BLUE_NOISE:
                return static_cast<uint32_t>(blue_noise_threshold(
                    voxel_, static_cast<dither::BlueNoiseFace>(a), abi::fold_seed(seed_)));
            default:
                return 0;
        }
    }

    const Vec3i voxel_;
    const std::vector<uint16_t>& fractions_;
    const uint64_t seed_;
    std::vector<int32_t> codes_ = {0};
};

}  // namespace openfab::reference
