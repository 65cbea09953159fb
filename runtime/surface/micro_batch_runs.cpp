// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The vertices of a batch: lattice points of tiles, points of sides, corners.
#include <algorithm>

#include "base/check.h"
#include "runtime/surface/micro_batch.h"

namespace openfab::surface {

void MicroBatch::clear() {
    size_ = evaluated_ = 0;
    runs_.clear();
    edge_points_.clear();
}

void MicroBatch::grow(int32_t count) {
    const size_t n = static_cast<size_t>(size_ + count);
    if (n <= weight_a_.size()) return;
    // Rounded up so that a kernel's last vector has room.
    const size_t room = (n + 63) & ~size_t{63};
    for (auto* v : {&weight_a_, &weight_b_})
        v->resize(room);
    for (auto* v : {&wide_a_, &wide_b_})
        v->resize(room);
    for (auto* axes : {&place_, &normal_, &result_}) {
        for (auto& v : *axes)
            v.resize(room);
    }
    for (size_t i = 0; i < batched_.size(); ++i) {
        if (batched_[i] == 0) continue;
        if (kernel_.args[i].scalar == OPENFAB_FLOAT) {
            floats_[i].resize(room);
        } else {
            ints_[i].resize(room);
        }
    }
}

void MicroBatch::push_edge_point(const Run& run, int32_t index, int32_t side, int32_t i,
                                 bool stands) {
    const int32_t n = base_.factor[side];
    const int32_t lo = base_.lower_corner(side), hi = base_.upper_corner(side);
    EdgePoint point{index, lo % 3, hi % 3, i, n, run.triangle, stands};
    if (i == 0 || i == n) {
        // A corner is its own point on either of its sides.
        const int32_t corner = i == 0 ? lo : hi;
        point.lo = point.hi = corner % 3;
        point.i = 0, point.n = 1;
        if (run.displaced) point.evaluator = base_.corner_class[corner] / 3;
    } else if (run.displaced) {
        point.evaluator = base_.side_evaluator[side];
    }
    edge_points_.push_back(point);
}

void MicroBatch::finish_run(Run run) {
    // The kernel runs on the displaced ones, which come first.
    OPENFAB_CHECK(!run.displaced || evaluated_ == size_);
    run.edge_end = static_cast<int32_t>(edge_points_.size());
    size_ += run.count;
    if (run.displaced) evaluated_ = size_;
    runs_.push_back(run);
}

int32_t MicroBatch::add_tile(int32_t triangle, const Tile& tile) {
    const int32_t n = base_.lattice_factor(triangle);
    const int32_t first = size_;
    grow((tile.a1 - tile.a0 + 1) * (tile.b1 - tile.b0 + 1));
    Run run{triangle, first, 0, static_cast<int32_t>(edge_points_.size()), 0, true, true};
    int32_t index = first;
    for (int32_t b = tile.b0; b <= tile.b1; ++b) {
        const int32_t end = std::min(tile.a1, n - b);
        const double wide_b = static_cast<double>(b) / n;
        const float weight_b = static_cast<float>(b) / static_cast<float>(n);
        for (int32_t a = tile.a0; a <= end; ++a, ++index) {
            const size_t i = static_cast<size_t>(index);
            wide_a_[i] = static_cast<double>(a) / n;
            wide_b_[i] = wide_b;
            weight_a_[i] = static_cast<float>(a) / static_cast<float>(n);
            weight_b_[i] = weight_b;
        }
        const int32_t row = index - (end - tile.a0 + 1);
        const auto on_side = [&](int32_t side, int32_t at, int32_t l) {
            const int32_t s = 3 * triangle + side;
            const int32_t from_lower = base_.forward(s) ? l : n - l, factor = base_.factor[s];
            const int32_t i = snap_to_edge(from_lower, factor, n);
            // A corner stands for itself, another edge point in the first lattice point it is at.
            const bool stands =
                from_lower == 0 || from_lower == n ||
                (i > 0 && i < factor && i != snap_to_edge(from_lower - 1, factor, n));
            push_edge_point(run, at, s, i, stands);
        };
        if (b == 0) {
            for (int32_t a = tile.a0; a <= end; ++a)
                on_side(0, row + a - tile.a0, a);
        }
        if (tile.a0 == 0 && b > 0) on_side(2, row, n - b);
        if (end == n - b && b > 0 && (end > 0 || tile.a0 > 0)) on_side(1, index - 1, b);
    }
    run.count = index - first;
    finish_run(run);
    return first;
}

int32_t MicroBatch::add_side(int32_t side, int32_t i0, int32_t i1) {
    const int32_t first = size_, triangle = side / 3;
    grow(i1 - i0 + 1);
    Run run{triangle,
            first,
            i1 - i0 + 1,
            static_cast<int32_t>(edge_points_.size()),
            0,
            false,
            base_.classes[triangle] == TriangleClass::kDisplaced};
    for (int32_t i = i0; i <= i1; ++i)
        push_edge_point(run, first + i - i0, side, i);
    finish_run(run);
    return first;
}

int32_t MicroBatch::add_corner(int32_t corner) {
    const int32_t first = size_, triangle = corner / 3;
    grow(1);
    Run run{triangle,
            first,
            1,
            static_cast<int32_t>(edge_points_.size()),
            0,
            false,
            base_.classes[triangle] == TriangleClass::kDisplaced};
    push_edge_point(run, first, corner, base_.forward(corner) ? 0 : base_.factor[corner]);
    finish_run(run);
    return first;
}

}  // namespace openfab::surface
