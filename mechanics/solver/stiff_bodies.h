// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bodies of stiff material that soft material joins, as two plates and a thin layer between. Soft
// material lets each move almost as a rigid body, which a coarser grid cannot follow: its elements are
// part stiff and part soft. So their motions are solved for by themselves.

#include <array>
#include <span>
#include <vector>

#include "mechanics/solver/dense_solver.h"
#include "mechanics/solver/element_operator.h"

namespace openfab::mechanics {

/// Z, the motions of bodies as rigid ones (of a scalar: a value for each), and Z^T A Z, factored.
template <int C>
class StiffBodies {
  public:
    /// Looks for bodies; finds none in most grids. `a` outlives it.
    explicit StiffBodies(const ElementOperator<C>& a);

    bool empty() const { return bodies_.empty(); }
    size_t bodies() const { return bodies_.size(); }

    /// (Z^T A Z)^-1 Z^T r
    std::vector<double> motions_of(const Field<double, C>& r) const;
    /// (Z^T A Z)^-1 Z^T A z
    std::vector<double> motions_in(const Field<float, C>& z) const;
    /// b -= A Z motions
    void take_forces(std::span<const double> motions, Field<float, C>* b) const;
    /// z += Z motions
    void add(std::span<const double> motions, Field<float, C>* z) const;

    /// What it takes of a grid, while it looks, too.
    static int64_t needed_bytes(const Grid& grid) { return 5 * grid.node_count(); }

  private:
    struct Body {
        std::array<double, 3> middle{};  ///< in nodes
        double radius_mm = 1;            ///< by which turns are divided
    };
    using Corners = std::array<std::array<int32_t, 3>, 8>;

    void find_bodies(float stiff);
    void measure();
    void find_joints();
    void factor();
    Corners corners_of(int64_t element) const;
    uint8_t label(const std::array<int32_t, 3>& node) const;
    /// What motion `m` of a body does to a node.
    std::array<double, C> moved(const Body& body, size_t m,
                                const std::array<int32_t, 3>& node) const;
    /// Adds to `sums` the work of forces at a joint's corners along the motions of the bodies there.
    void add_work(const Corners& corners, const std::array<double, size_t{8} * C>& forces,
                  double* sums) const;
    std::array<double, size_t{8} * C> forces_of(int64_t element,
                                                const std::array<double, size_t{8} * C>& u) const;
    /// Calls f(body number, node x, y, z) for the nodes of bodies of a plane.
    template <typename F>
    void for_nodes(int32_t z, const F& f) const;
    std::vector<double> summed(const std::vector<double>& planes) const;
    size_t size() const { return bodies_.size() * motions_; }

    const ElementOperator<C>& a_;
    size_t motions_;               ///< of a body
    std::vector<uint8_t> labels_;  ///< of nodes: number of the body + 1, or 0
    std::vector<Body> bodies_;
    std::vector<int64_t> joints_;  ///< elements that motions strain, in order
    std::vector<size_t> begin_;    ///< of each layer's joints
    std::vector<double> first_, second_;
    DenseSolver solver_;
};

}  // namespace openfab::mechanics
