// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Calls the kernels of a shape (openfab_shape in abi/fablet_table.h) on lists of points and of boxes.
// One a thread.

#include <array>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "abi/fablet_table.h"
#include "runtime/part/shape_stage.h"
#include "runtime/solid/shape/shape_bodies.h"
#include "runtime/solid/stage_calls.h"

namespace openfab::solid {

/// Points, part-local mm, by axis. Rooms are whole groups of segments::kLanes.
struct ShapePoints {
    std::array<std::vector<float>, 3> at;

    void resize(size_t n) {
        for (auto& axis : at)
            axis.resize(n);
    }
    size_t size() const { return at[0].size(); }
    Vec3f point(size_t i) const { return {at[0][i], at[1][i], at[2][i]}; }
    void set(size_t i, const Vec3f& p) { at[0][i] = p.x, at[1][i] = p.y, at[2][i] = p.z; }
    void push_back(const Vec3f& p) {
        for (int a = 0; a < 3; ++a)
            at[static_cast<size_t>(a)].push_back(p[a]);
    }
    void clear() { resize(0); }
};

class ShapeCalls final : public StageCalls {
  public:
    /// `stage`: the part of Part::shape, which must outlive it, as `fixed`, its arguments, and what it
    /// asks must. Points, boxes and values are those of the part, of which the stage's may be a scaled
    /// copy.
    ShapeCalls(const part::ShapeStage& stage, const surface::StaticArgs& fixed,
               const ShapeBodies& bodies, openfab_isa isa);

    /// Returns whether bounds ask for those of distances to bodies: then signs are cheaper than values.
    bool asks() const { return asks_; }
    /// Computes the values at the points; negative is inside.
    abi::KernelStatus values(const ShapePoints& points, std::vector<float>* out);
    /// Computes the same of points that are dense, some to a cell: not all take distances to bodies.
    abi::KernelStatus dense_values(const ShapePoints& points, std::vector<float>* out);
    /// Computes numbers of the values' signs, NaN where they are: values, or bounds where these tell and are cheaper.
    abi::KernelStatus signs(const ShapePoints& points, std::vector<float>* out);
    /// Computes the same of points that are dense.
    abi::KernelStatus dense_signs(const ShapePoints& points, std::vector<float>* out);
    /// Computes bounds of the values, of their signs, where these tell; elsewhere NaN. They are cheaper if it asks.
    abi::KernelStatus cheap_signs(const ShapePoints& points, std::vector<float>* out);
    /// Computes bounds of the values of all points of boxes; NaN, both, where nothing is known.
    abi::KernelStatus bounds(const ShapePoints& lo, const ShapePoints& hi,
                             std::vector<float>* out_lo, std::vector<float>* out_hi);
    /// Computes bounds that tell as much of signs as those of `bounds`, but may be wider.
    abi::KernelStatus sign_bounds(const ShapePoints& lo, const ShapePoints& hi,
                                  std::vector<float>* out_lo, std::vector<float>* out_hi);
    /// Computes bounds that tell less of them, but take no micropolygons of bodies that are bounded without.
    abi::KernelStatus cheap_bounds(const ShapePoints& lo, const ShapePoints& hi,
                                   std::vector<float>* out_lo, std::vector<float>* out_hi);
    /// Computes the outputs at the points: [output component][point], bits; of an empty list none.
    abi::KernelStatus attributes(const ShapePoints& points,
                                 std::vector<std::vector<uint32_t>>* out);

  private:
    void* data(const openfab_arg& arg) override;
    void begin_piece() override;
    abi::KernelStatus query(const openfab_query& query, std::span<const int32_t> groups,
                            const segments::States& states) override;

    using Axes = std::array<const float*, 3>;
    void set_points(const ShapePoints& from, std::array<std::vector<float>, 3>* moved, Axes* to);
    void scale(std::vector<float>* values) const;
    abi::KernelStatus bounds_by(std::initializer_list<Effort> efforts, const ShapePoints& lo,
                                const ShapePoints& hi, std::vector<float>* out_lo,
                                std::vector<float>* out_hi);
    abi::KernelStatus signs_by(std::initializer_list<Effort> efforts, const ShapePoints& points,
                               std::vector<float>* out);
    abi::KernelStatus fill_rest(const ShapePoints& points, std::vector<float>* out);
    float* distances(const openfab_arg& arg);

    const ShapeBodies& bodies_;
    ShapeBodies::Tools tools_;
    bool stretched_ = false;
    std::array<float, 3> shrink_{};  ///< from the part's space to the stage's
    float scale_ = 1;                ///< of values
    bool asks_ = false;              ///< bounds ask for those of distances
    bool looks_ = false;             ///< and say whether the value follows from more
    Effort effort_ = Effort::kExact;
    std::array<std::vector<float>, 3> moved_, moved_lo_, moved_hi_;
    // Of the current call.
    Axes points_{}, lo_{}, hi_{};
    /// By object, of the piece: the distances at its points, or their bounds.
    struct Distances {
        bool known = false;
        std::vector<float> at, lo, hi;
        std::vector<float> all;  ///< at all points of a call, where some need not be the true ones
    };
    std::vector<Distances> distances_;
    bool keep_ = false;                        ///< lower bounds, in Distances::all
    bool use_ = false;                         ///< Distances::all
    std::array<std::vector<float>, 3> asked_;  ///< by a query
    std::vector<float> answered_;
    float *value_ = nullptr, *value_lo_ = nullptr, *value_hi_ = nullptr;
    std::vector<float> value_looks_;
    std::vector<std::vector<uint32_t>>* outputs_ = nullptr;
};

}  // namespace openfab::solid
