// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Collects the half-spaces of one leaf before they are rounded to 16 bits (tree/leaf_features.h),
// the same for all kinds of features.

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "base/vec.h"
#include "runtime/nearest/tree/features.h"
#include "runtime/nearest/tree/leaf_features.h"

namespace openfab::nearest {

/// Widest read of the kernels, in lanes; the last ones may be unused.
constexpr size_t kHalfSpaceLanes = 16;
constexpr size_t kMaxLeafFeatures = 64;

/// The half-spaces of one leaf, feature after feature.
class LeafHalfSpaces {
  public:
    static constexpr float kMaxValue = 32767;  ///< of a half-space

    explicit LeafHalfSpaces(const float* origin) : origin_{origin[0], origin[1], origin[2]} {}

    /// Adds the feature's next half-space: up to `at` along the unit vector `outwards`, or a
    /// shorter one. A longer one, from an underflow of squared lengths, is left empty.
    void add(const Vec3f& outwards, const Vec3f& at) {
        const bool usable = dot(outwards, outwards) < 1.00001f;
        const Vec3f from_origin = at - origin_;
        for (int c = 0; c < 3; ++c) {
            outwards_[half_space_][c][feature_] = usable ? outwards[c] : 0;
            at_[half_space_][c][feature_] = from_origin[c];
        }
        ++half_space_;
    }
    void next_feature() {
        for (; half_space_ < kHalfSpaces;)
            add({0, 0, 0}, origin_);
        half_space_ = 0;
        ++feature_;
    }

    /// Adds a face.
    void add_face(const TriangleFrame& face, const TriangleDetail& detail) {
        const float* v[3] = {face.v0, detail.v1, detail.v2};
        for (int i = 0; i < 3; ++i)
            add({-face.m[i][0], -face.m[i][1], -face.m[i][2]}, {v[i][0], v[i][1], v[i][2]});
        next_feature();
    }
    /// Adds an edge; `along` is its unit vector.
    void add_edge(const EdgeFeature& edge, const Vec3f& along, const float (*wing)[3]) {
        const Vec3f a{edge.a[0], edge.a[1], edge.a[2]}, ab{edge.ab[0], edge.ab[1], edge.ab[2]};
        for (int i = 0; i < 2; ++i)
            add({wing[i][0], wing[i][1], wing[i][2]}, a);
        add(along * -1.0f, a);
        add(along, a + ab);
        next_feature();
    }

    /// Writes the values row after row, and a few more beyond the end.
    void write(float step, int16_t* values) {
        const size_t features = feature_;
        while (feature_ % kTogether != 0)
            next_feature();
        const float per_step = step > 0 ? 1 / step : 0;
        for (size_t half_space = 0; half_space < kHalfSpaces; ++half_space) {
            float offset[kMaxLeafFeatures];
            std::fill_n(offset, feature_, 0.0f);
            for (size_t c = 0; c < 3; ++c, values += features) {
                for (size_t l = 0; l < feature_; l += kTogether)
                    round(outwards_[half_space][c] + l, at_[half_space][c] + l, offset + l,
                          values + l);
            }
            for (size_t l = 0; l < feature_; l += kTogether)
                round_offsets(offset + l, per_step, values + l);
            values += features;
        }
    }

  private:
    static constexpr size_t kTogether = 4;

    /// Rounds down a value in the range of a half-space, or 2^-8 beyond it.
    static int32_t floor_of(float x) { return static_cast<int32_t>(x + 0x1p15f) - 0x8000; }
    static void round(const float* outwards, const float* at, float* offset, int16_t* values) {
        for (size_t l = 0; l < kTogether; ++l) {
            const int32_t v = floor_of(outwards[l] * kMaxValue + 0.5f);
            values[l] = static_cast<int16_t>(v);
            offset[l] -= static_cast<float>(v) * (1 / HalfSpaces::kUnit) * at[l];
        }
    }
    /// Rounds down, so that half-spaces do not grow.
    static void round_offsets(const float* offset, float per_step, int16_t* values) {
        for (size_t l = 0; l < kTogether; ++l)
            values[l] = static_cast<int16_t>(floor_of(offset[l] * per_step));
    }

    Vec3f origin_;
    size_t feature_ = 0, half_space_ = 0;
    float outwards_[kHalfSpaces][3][kMaxLeafFeatures], at_[kHalfSpaces][3][kMaxLeafFeatures];
};

}  // namespace openfab::nearest
