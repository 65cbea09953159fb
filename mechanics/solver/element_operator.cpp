// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/solver/element_operator.h"

#include <cmath>

#include "mechanics/solver/parallel.h"

namespace openfab::mechanics {

void ElementValues::normalise() {
    float largest = 0;
    for (const std::vector<float>* all : {&first, &second})
        for (const float v : *all)
            largest = std::max(largest, std::abs(v));
    if (largest <= 0) return;
    unit = largest;
    for (std::vector<float>* all : {&first, &second})
        for (float& v : *all)
            v = static_cast<float>(static_cast<double>(v) / unit);
}

void ElementValues::restore() {
    const auto by = static_cast<float>(unit);
    for (std::vector<float>* all : {&first, &second})
        for (float& v : *all)
            v *= by;
    unit = 1;
}

template <int C>
ElementOperator<C>::ElementOperator(const Grid& grid, const ElementValues* values,
                                    const FixedNodes* fixed)
    : grid_(grid), values_(values), fixed_(fixed) {
    const int64_t plane = int64_t{grid.nodes[0]} * grid.nodes[1] * C;
    for (int32_t z = 0; z <= grid.nodes[2]; ++z)
        fixed_begin_.push_back(std::lower_bound(fixed->begin(), fixed->end(), z * plane) -
                               fixed->begin());
}

template <int C>
template <typename T>
void ElementOperator<C>::fix(Field<T, C>* x, int32_t z) const {
    const auto at = static_cast<size_t>(z);
    for (int64_t i = fixed_begin_[at]; i < fixed_begin_[at + 1]; ++i) {
        const int64_t dof = (*fixed_)[static_cast<size_t>(i)];
        const int64_t node = dof / C;
        const int64_t row = node / grid_.nodes[0];
        x->row(static_cast<int>(dof % C), static_cast<int32_t>(row % grid_.nodes[1]),
               z)[node % grid_.nodes[0]] = T(0);
    }
}

template <int C>
template <typename T>
void ElementOperator<C>::fix(Field<T, C>* x) const {
    for (int32_t z = 0; z < grid_.nodes[2]; ++z)
        fix(x, z);
}

template <int C>
uint8_t ElementOperator<C>::fixed_at(int32_t x, int32_t y, int32_t z) const {
    const int64_t first = ((int64_t{z} * grid_.nodes[1] + y) * grid_.nodes[0] + x) * C;
    const auto at = static_cast<size_t>(z);
    const auto begin = fixed_->begin() + fixed_begin_[at],
               end = fixed_->begin() + fixed_begin_[at + 1];
    uint8_t bits = 0;
    for (auto i = std::lower_bound(begin, end, first); i != end && *i < first + C; ++i)
        bits = static_cast<uint8_t>(bits | 1U << (*i - first));
    return bits;
}

template <int C>
template <typename T>
void ElementOperator<C>::add_row(int32_t y, int32_t z, const Field<T, C>& x, Field<T, C>* out,
                                 const T* mean, T* scratch) const {
    const int32_t y1 = y + 1 == grid_.nodes[1] ? 0 : y + 1;
    const int32_t z1 = z + 1 == grid_.nodes[2] ? 0 : z + 1;
    const T* in[4 * C];
    T* to[4 * C];
    const int32_t ys[4] = {y, y1, y, y1}, zs[4] = {z, z, z1, z1};
    for (int r = 0; r < 4; ++r)
        for (int c = 0; c < C; ++c) {
            in[r * C + c] = x.row(c, ys[r], zs[r]);
            to[r * C + c] = out->row(c, ys[r], zs[r]);
        }
    const size_t at = grid_.element(0, y, z);
    const bool scalar = values_->second.empty();
    element_row<T, C>()(element_shape<T>(grid_.pitch_mm, values_->full), grid_.elements[0],
                        values_->first.data() + at, scalar ? nullptr : values_->second.data() + at,
                        in, to, mean, scratch);
}

template <int C>
template <typename T>
void ElementOperator<C>::finish(Field<T, C>* y, int32_t z) const {
    for (int32_t row = 0; row < grid_.nodes[1]; ++row)
        for (int c = 0; c < C; ++c) {
            T* p = y->row(c, row, z);
            if (grid_.periodic) p[0] += p[grid_.nodes[0]];
            p[grid_.nodes[0]] = T(0);
        }
    fix(y, z);
}

template <int C>
template <typename T>
void ElementOperator<C>::apply(Field<T, C>* x, Field<T, C>* y, const double* mean,
                               const PlaneDone& done) const {
    const int32_t layers = grid_.elements[2], planes = grid_.nodes[2];
    const auto begin_plane = [&](int32_t z) {
        x->fill_ghosts(z);
        std::fill_n(y->plane(z), y->plane_size(), T(0));
    };
    const auto end_plane = [&](int32_t z) {
        finish(y, z);
        if (done) done(z);
    };
    // Planes between blocks of layers begin before all and end after all, others while they are in the cache.
    const auto for_shared = [&](const auto& f) {
        for_each_index((planes + kLayerBlock - 1) / kLayerBlock,
                       [&](int32_t i) { f(i * kLayerBlock); });
        if (layers < planes && layers % kLayerBlock != 0) f(layers);
    };
    T strain[6] = {};
    if (mean)
        for (int i = 0; i < 2 * C && i < (C == 3 ? 6 : 3); ++i)
            strain[i] = static_cast<T>(8 * mean[i]);
    if (mean && C == 1)
        for (int i = 0; i < 3; ++i)
            strain[i] = static_cast<T>(8 * mean[i]);
    for_shared(begin_plane);
    for_layer_blocks(layers, grid_.periodic, [&](int32_t begin, int32_t end) {
        std::vector<T> scratch(static_cast<size_t>(12 * C) *
                               (static_cast<size_t>(grid_.elements[0]) + 1));
        for (int32_t z = begin; z < end; ++z) {
            if (z + 1 < end) begin_plane(z + 1);
            for (int32_t row = 0; row < grid_.elements[1]; ++row)
                add_row(row, z, *x, y, mean ? strain : nullptr, scratch.data());
            if (z > begin) end_plane(z);
        }
    });
    for_shared(end_plane);
}

template <int C>
std::vector<double> ElementOperator<C>::element_matrix(const std::array<double, 3>& pitch_mm,
                                                       int which, bool full) {
    constexpr size_t kSize = 8 * C;
    std::vector<double> matrix(kSize * kSize);
    const ElementShape<double> shape = element_shape<double>(pitch_mm, full);
    const float first = which == 0 ? 1 : 0, second = which == 1 ? 1 : 0;
    for (size_t j = 0; j < kSize; ++j) {
        double in[kSize] = {}, out[kSize] = {}, scratch[24 * C];
        const double* from[4 * C];
        double* to[4 * C];
        // Corner k: x = k & 1, row k >> 1; rows of two nodes.
        for (size_t r = 0; r < 4; ++r)
            for (size_t c = 0; c < C; ++c) {
                from[r * C + c] = in + (r * C + c) * 2;
                to[r * C + c] = out + (r * C + c) * 2;
            }
        const auto place = [](size_t dof) {
            return (dof / C / 2 * C + dof % C) * 2 + (dof / C & 1);
        };
        in[place(j)] = 1;
        element_row<double, C>()(shape, 1, &first, &second, from, to, nullptr, scratch);
        for (size_t i = 0; i < kSize; ++i)
            matrix[i * kSize + j] = out[place(i)];
    }
    return matrix;
}

template <int C>
void ElementOperator<C>::inverse_diagonal(Field<float, C>* out) const {
    const std::vector<double> a = element_matrix(grid_.pitch_mm, 0, values_->full),
                              b = element_matrix(grid_.pitch_mm, 1, values_->full);
    float first[C], second[C];
    for (size_t c = 0; c < C; ++c) {
        // All corners have the same, by symmetry.
        first[c] = static_cast<float>(a[c * (8 * C) + c]);
        second[c] = static_cast<float>(b[c * (8 * C) + c]);
    }
    const auto wrap = [&](int32_t i, int axis) {
        const int32_t n = grid_.elements[static_cast<size_t>(axis)];
        return grid_.periodic ? (i + n) % n : (i >= 0 && i < n ? i : -1);
    };
    for_each_index(grid_.nodes[2], [&](int32_t z) {
        for (int32_t y = 0; y < grid_.nodes[1]; ++y)
            for (int32_t x = 0; x < grid_.nodes[0]; ++x) {
                float sum_first = 0, sum_second = 0;
                for (int k = 0; k < 8; ++k) {
                    const int32_t ex = wrap(x - (k & 1), 0), ey = wrap(y - (k >> 1 & 1), 1),
                                  ez = wrap(z - (k >> 2), 2);
                    if (ex < 0 || ey < 0 || ez < 0) continue;
                    const size_t e = grid_.element(ex, ey, ez);
                    sum_first += values_->first[e];
                    if (C == 3) sum_second += values_->second[e];
                }
                for (int c = 0; c < C; ++c) {
                    const float d = first[c] * sum_first + second[c] * sum_second;
                    out->row(c, y, z)[x] = d > 0 ? 1 / d : 0;
                }
            }
        fix(out, z);
    });
}

template <typename A, typename B, int C>
double dot(const Field<A, C>& a, const Field<B, C>& b, int32_t z) {
    const RowKernels& k = row_kernels();
    const auto n = static_cast<size_t>(a.nodes(0));
    double sum = 0;
    for (int32_t y = 0; y < a.nodes(1); ++y)
        for (int c = 0; c < C; ++c) {
            if constexpr (sizeof(A) == 8)
                sum += k.dot_double(n, a.row(c, y, z), b.row(c, y, z));
            else if constexpr (sizeof(B) == 8)
                sum += k.dot_float_double(n, a.row(c, y, z), b.row(c, y, z));
            else
                sum += k.dot_float(n, a.row(c, y, z), b.row(c, y, z));
        }
    return sum;
}

template <typename A, typename B, int C>
double dot(const Field<A, C>& a, const Field<B, C>& b) {
    return sum_over(a.nodes(2), [&](int32_t z) { return dot(a, b, z); });
}

template class ElementOperator<kElastic>;
template class ElementOperator<kScalar>;
#define OPENFAB_FOR(T, C)                                                              \
    template void ElementOperator<C>::apply(Field<T, C>*, Field<T, C>*, const double*, \
                                            const PlaneDone&) const;                   \
    template void ElementOperator<C>::fix(Field<T, C>*) const;                         \
    template void ElementOperator<C>::fix(Field<T, C>*, int32_t) const;
OPENFAB_FOR(float, 3)
OPENFAB_FOR(double, 3)
OPENFAB_FOR(float, 1)
OPENFAB_FOR(double, 1)
#undef OPENFAB_FOR
#define OPENFAB_FOR(C)                                                             \
    template double dot(const Field<float, C>&, const Field<float, C>&);           \
    template double dot(const Field<float, C>&, const Field<double, C>&);          \
    template double dot(const Field<double, C>&, const Field<double, C>&);         \
    template double dot(const Field<float, C>&, const Field<double, C>&, int32_t); \
    template double dot(const Field<double, C>&, const Field<double, C>&, int32_t);
OPENFAB_FOR(3)
OPENFAB_FOR(1)
#undef OPENFAB_FOR

}  // namespace openfab::mechanics
