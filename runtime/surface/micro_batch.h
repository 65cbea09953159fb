// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A batch of micro-vertices: interpolates their inputs and runs the surface kernel on them. One per
// thread.
//
// Vertices come in runs that belong to one base triangle each. Vertices of identity triangles are
// neither moved nor evaluated; runs of displaced triangles must be added before them, so that
// the kernel sees a dense batch.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "abi/kernel_call.h"
#include "runtime/part/part.h"
#include "runtime/segments/driver.h"
#include "runtime/segments/printf_log.h"
#include "runtime/surface/base_mesh.h"
#include "runtime/surface/kernel_args.h"
#include "runtime/surface/lattice.h"

namespace openfab::surface {

/// The batch of one thread.
class MicroBatch : private segments::Arguments, private segments::Handler {
  public:
    MicroBatch(const part::Part& part, const BaseMesh& base, const StaticArgs& args,
               const NearestLayout& nearest, openfab_isa isa);

    void clear();
    /// Adds the lattice points of a tile of a displaced triangle, row after row of b; point (a, b)
    /// has index first + sum of the row lengths before + a - a0. Returns the first index.
    int32_t add_tile(int32_t triangle, const Tile& tile);
    /// Adds points [i0, i1] of a side, counted from its lower end; returns the first index.
    int32_t add_side(int32_t side, int32_t i0, int32_t i1);
    int32_t add_corner(int32_t corner);
    /// Computes positions and, if something is displaced, runs the kernel.
    abi::KernelStatus evaluate();
    /// Logs what the stage prints in the next calls of `evaluate`, at lattice points of tiles: each
    /// point that it is evaluated for once, by the triangle and at the lattice point that stand for
    /// it (see surface.h), if tiles do not overlap.
    void set_log(segments::PrintfLog* log) { log_ = log; }

    int32_t size() const { return size_; }
    Vec3f position(int32_t i) const { return {result_[0][i], result_[1][i], result_[2][i]}; }
    /// Writes float @nearest component `k` of vertices [first, first + count) to out[j * stride].
    void float_attribute(size_t k, int32_t first, int32_t count, float* out, size_t stride) const;
    /// Returns the bits of int @nearest component `k` of vertex `i`.
    uint32_t int_attribute(size_t k, int32_t i) const;
    /// Returns whether `int_attribute(k, …)` is constant on each triangle.
    bool int_is_flat(size_t k) const {
        return nearest_.ints[k].from != NearestComponent::From::kSurfaceOutput;
    }

    int64_t not_finite = 0, cut_to_bound = 0;  ///< of the last evaluate()

  private:
    struct EdgePoint {
        int32_t index;
        int32_t lo, hi;  ///< corners of the triangle, 0..2
        int32_t i, n;
        int32_t evaluator;
        bool stands;  ///< for the lattice points that are the same edge point
    };
    struct Run {
        int32_t triangle, first, count;
        int32_t edge_first, edge_end;
        bool lattice;  ///< all vertices have weights; else all are edge points
        bool displaced;
    };
    /// Three corner values of an interpolated component.
    struct Corners {
        float v[3];
        float operator[](int32_t c) const { return v[c]; }
    };

    void grow(int32_t count);
    void push_edge_point(const Run& run, int32_t index, int32_t side, int32_t i,
                         bool stands = true);
    void finish_run(Run run);
    const Run& run_of(int32_t i) const;
    void interpolate(const Run& run, const Corners& corners, int32_t from, int32_t count,
                     float* out, size_t stride) const;
    void fill_positions(const Run& run);
    void fill_normals(const Run& run);
    void fill_argument(const Run& run, size_t index);
    float gradient(const openfab_arg& arg, int32_t triangle) const;
    float frame_value(const openfab_arg& arg, int32_t triangle) const;
    Corners input_corners(int32_t triangle, const part::PartAttribute& input,
                          int32_t component) const;
    Corners normal_corners(int32_t triangle, int32_t axis) const;
    Corners uv_corners(int32_t triangle, int32_t axis) const;
    void read_results();
    abi::KernelStatus run_segments();
    const void* input(const openfab_arg& arg) override;
    segments::OutputView output(const openfab_arg& arg) override;
    abi::KernelStatus query(const openfab_query& query, std::span<const int32_t> groups,
                            const segments::States& states) override;
    void printf(const openfab_printf& call, std::span<const int32_t> groups,
                const segments::States& states) override;
    bool stands(int32_t i) const;
    size_t argument_index(const openfab_arg& arg) const;

    const part::Part& part_;
    const BaseMesh& base_;
    const NearestLayout& nearest_;
    const openfab_kernel& kernel_;
    const StaticArgs& static_args_;
    const openfab_isa isa_;
    segments::Driver driver_;             ///< where the stage has segments
    segments::PrintfLog* log_ = nullptr;  ///< null: nothing is logged
    std::vector<uint8_t> wanted_;
    abi::KernelCall call_;
    std::unique_ptr<abi::KernelBuffer[]> buffers_;  ///< [argument]; unused for scalars and textures
    std::vector<uint8_t> batched_;            ///< [argument] the argument is a buffer of the batch
    std::vector<std::vector<float>> floats_;  ///< [argument]
    std::vector<std::vector<int32_t>> ints_;  ///< [argument]
    std::vector<int32_t> output_argument_;    ///< [surface output * 16 + component], -1 without
    std::array<int32_t, 3> position_argument_{-1, -1, -1};
    int32_t status_argument_ = -1;
    bool needs_normal_ = false;

    int32_t size_ = 0, evaluated_ = 0;
    std::vector<Run> runs_;
    std::vector<EdgePoint> edge_points_;
    std::vector<float> weight_a_, weight_b_;  ///< [vertex], in lattice runs
    std::vector<double> wide_a_, wide_b_;     ///< the same in double, for positions
    std::array<std::vector<float>, 3> place_, normal_, result_;
};

}  // namespace openfab::surface
