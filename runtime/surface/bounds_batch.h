// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Conservative bounds of patches: computes the input ranges of tiles and runs the surface_bounds
// kernel on them. One per thread.
//
// A range holds what any micro-vertex of the tile is evaluated with: linear interpolants at the
// tile's corners (and at the edge points its corners snap to), widened by the rounding of the
// interpolation; and the gradients and frames of every triangle that evaluates a vertex on the
// tile's edges.

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "abi/kernel_call.h"
#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/surface/base_mesh.h"
#include "runtime/surface/kernel_args.h"
#include "runtime/surface/lattice.h"
#include "runtime/surface/tile_span.h"

namespace openfab::surface {

template <typename T>
struct Range {
    T lo, hi;
    void add(const Range& other) {
        lo = other.lo < lo ? other.lo : lo;
        hi = other.hi > hi ? other.hi : hi;
    }
};

/// A batch of tiles and triangles to bound.
class BoundsBatch {
  public:
    BoundsBatch(const part::Part& part, const BaseMesh& base, const StaticArgs& args,
                const NearestLayout& nearest, openfab_isa isa);

    void clear();
    /// Adds a tile of a displaced triangle; the mesh must be connected.
    void add_tile(int32_t triangle, const Tile& tile);
    /// Adds a whole triangle with its own gradients only, to decide whether it is an identity.
    void add_triangle(int32_t triangle);
    abi::KernelStatus evaluate();

    /// Returns whether the interval of the displacement is exactly zero.
    bool is_zero(int32_t i) const;
    /// Returns a box of all points; it is not finite where the displacement has no bound.
    Box3f box(int32_t i) const;
    Range<float> float_range(size_t k, int32_t i) const;
    Range<int32_t> int_range(size_t k, int32_t i) const;

  private:
    /// A tile's span and the triangles that evaluate its vertices.
    struct Item {
        int32_t triangle = 0;
        TileSpan span;
        int32_t evaluators = 0;
        std::array<int32_t, 7> evaluator{};
    };

    void add_evaluator(Item* item, int32_t triangle) const;
    Range<float> linear(const Item& item, const std::array<float, 3>& corners) const;
    Range<float> input_range(const Item& item, const openfab_arg& arg) const;
    Range<float> gradient_range(const Item& item, const openfab_arg& arg) const;
    Range<float> frame_range(const Item& item, const openfab_arg& arg) const;
    std::array<Range<float>, 3> normal_ranges(const Item& item) const;
    Range<float> position_range(const Item& item, int32_t axis) const;
    Range<float> float_argument(size_t i, const openfab_arg& arg) const;
    std::array<Range<float>, 3> displacement(int32_t i) const;
    void pair_inputs();
    void fill_floats(size_t i);
    Range<float> attribute_range(const part::PartAttribute& attribute, int32_t component,
                                 const Item& item) const;

    const part::Part& part_;
    const BaseMesh& base_;
    const NearestLayout& nearest_;
    const openfab_kernel& kernel_;
    abi::KernelCall call_;
    std::unique_ptr<abi::KernelBuffer[]> buffers_;
    std::vector<uint8_t> batched_;
    std::vector<std::vector<float>> floats_;  ///< [argument]
    std::vector<std::vector<int32_t>> ints_;  ///< [argument]
    /// [argument] the one with the other end of a range of floats; -1 without, and for that one
    std::vector<int32_t> high_of_;
    std::vector<std::array<Range<float>, 3>> normals_;  ///< [item], where the kernel reads them
    std::array<std::array<int32_t, 2>, 3> displacement_argument_;
    std::vector<std::array<int32_t, 2>>
        output_argument_;  ///< [surface output * 16 + component]: lo, hi
    std::vector<Item> items_;
};

/// Returns the range of an attribute over a whole base triangle that is not displaced.
Range<float> corner_range(const part::PartAttribute& attribute, int32_t triangle,
                          int32_t component);

}  // namespace openfab::surface
