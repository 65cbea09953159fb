// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Structured grids of hexahedra and fields on their nodes.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace openfab::mechanics {

/// A box of equal hexahedra. Along each axis `elements` of them; a periodic grid has as many nodes, its
/// last element ends at its first node; another has one more.
struct Grid {
    std::array<int32_t, 3> elements{};
    std::array<double, 3> pitch_mm{1, 1, 1};
    bool periodic = false;
    /// Of a coarser grid: nodes, which are not `elements` + 1 where the finer grid's number is odd.
    std::array<int32_t, 3> nodes{};

    static Grid make(std::array<int32_t, 3> elements, std::array<double, 3> pitch_mm,
                     bool periodic) {
        Grid g{elements, pitch_mm, periodic, elements};
        if (!periodic)
            for (int32_t& n : g.nodes)
                ++n;
        return g;
    }
    int64_t element_count() const { return int64_t{elements[0]} * elements[1] * elements[2]; }
    int64_t node_count() const { return int64_t{nodes[0]} * nodes[1] * nodes[2]; }
    size_t element(int32_t x, int32_t y, int32_t z) const {
        return (static_cast<size_t>(z) * static_cast<size_t>(elements[1]) +
                static_cast<size_t>(y)) *
                   static_cast<size_t>(elements[0]) +
               static_cast<size_t>(x);
    }
};

/// Values of C components on the nodes of a grid: [z][y][component][x]. Each row has a ghost at either
/// end, which is the node at the other end of a periodic grid, else 0.
template <typename T, int C>
class Field {
  public:
    Field() = default;
    explicit Field(const Grid& grid)
        : nodes_(grid.nodes),
          periodic_(grid.periodic),
          stride_(static_cast<size_t>(grid.nodes[0]) + 2),
          values_(stride_ * C * static_cast<size_t>(grid.nodes[1]) *
                  static_cast<size_t>(grid.nodes[2])) {}

    /// The nodes of a row, from x = 0; ghosts at -1 and nodes(0).
    T* row(int c, int32_t y, int32_t z) { return values_.data() + at(c, y, z); }
    const T* row(int c, int32_t y, int32_t z) const { return values_.data() + at(c, y, z); }
    int32_t nodes(int axis) const { return nodes_[static_cast<size_t>(axis)]; }
    /// Of a plane of constant z.
    size_t plane_size() const { return stride_ * C * static_cast<size_t>(nodes_[1]); }
    T* plane(int32_t z) { return values_.data() + plane_size() * static_cast<size_t>(z); }
    const T* plane(int32_t z) const {
        return values_.data() + plane_size() * static_cast<size_t>(z);
    }
    /// Sets the ghosts of a plane to what they stand for.
    void fill_ghosts(int32_t z) {
        const size_t last = stride_ - 2;
        T* p = plane(z);
        for (size_t r = 0; r < C * static_cast<size_t>(nodes_[1]); ++r, p += stride_) {
            p[0] = periodic_ ? p[last] : T{};
            p[last + 1] = periodic_ ? p[1] : T{};
        }
    }
    bool empty() const { return values_.empty(); }
    size_t bytes() const { return values_.size() * sizeof(T); }

  private:
    size_t at(int c, int32_t y, int32_t z) const {
        return ((static_cast<size_t>(z) * static_cast<size_t>(nodes_[1]) + static_cast<size_t>(y)) *
                    C +
                static_cast<size_t>(c)) *
                   stride_ +
               1;
    }
    std::array<int32_t, 3> nodes_{};
    bool periodic_ = false;
    size_t stride_ = 0;
    std::vector<T> values_;
};

}  // namespace openfab::mechanics
