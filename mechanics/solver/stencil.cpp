// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/solver/stencil.h"

#include <array>
#include <cmath>

#include "mechanics/solver/parallel.h"

namespace openfab::mechanics {

Grid coarser(const Grid& fine) {
    Grid out = fine;
    for (size_t a = 0; a < 3; ++a) {
        out.nodes[a] = fine.periodic ? (fine.nodes[a] + 1) / 2 : fine.nodes[a] / 2 + 1;
        out.elements[a] = fine.periodic ? out.nodes[a] : out.nodes[a] - 1;
        out.pitch_mm[a] = 2 * fine.pitch_mm[a];
    }
    return out;
}

template <int C>
float Stencil<C>::at(int32_t x, int32_t y, int32_t z, int o, int c, int d) const {
    if (o >= kSelf) return block(x, y, z, o)[static_cast<size_t>(c * C + d) * stride()];
    int32_t to[3] = {x + o % 3 - 1, y + o / 3 % 3 - 1, z + o / 9 - 1};
    for (size_t a = 0; a < 3; ++a) {
        if (grid.periodic) to[a] = (to[a] + grid.nodes[a]) % grid.nodes[a];
        if (to[a] < 0 || to[a] >= grid.nodes[a]) return 0;
    }
    return block(to[0], to[1], to[2], 26 - o)[static_cast<size_t>(d * C + c) * stride()];
}

template <int C>
void Stencil<C>::fill_ghosts() {
    if (!grid.periodic) return;
    const size_t last = stride() - 2;
    for_each_index(grid.nodes[2], [&](int32_t z) {
        float* row = blocks.data() + row_at(0, z);
        const size_t rows = size_t{kKept} * C * C * static_cast<size_t>(grid.nodes[1]);
        for (size_t r = 0; r < rows; ++r, row += stride()) {
            row[0] = row[last];
            row[last + 1] = row[1];
        }
    });
}

template <int C>
void Stencil<C>::apply(Field<float, C>* x, Field<float, C>* y, const PlaneDone& done) const {
    for_each_index(grid.nodes[2], [&](int32_t z) { x->fill_ghosts(z); });
    for_each_index(grid.nodes[2], [&](int32_t z) {
        for (int32_t row = 0; row < grid.nodes[1]; ++row) {
            const float* in[27 * C];
            const float* from[27];
            float* out[C];
            for (int o = 0; o < 27; ++o) {
                int32_t ny = row + o / 3 % 3 - 1, nz = z + o / 9 - 1;
                if (grid.periodic) {
                    ny = (ny + grid.nodes[1]) % grid.nodes[1];
                    nz = (nz + grid.nodes[2]) % grid.nodes[2];
                }
                from[o] = nullptr;
                if (ny < 0 || ny >= grid.nodes[1] || nz < 0 || nz >= grid.nodes[2]) continue;
                const int32_t dx = o % 3 - 1;
                from[o] = o < kSelf ? block(dx, ny, nz, 26 - o) : block(0, row, z, o);
                for (int c = 0; c < C; ++c)
                    in[o * C + c] = x->row(c, ny, nz) + dx;
            }
            for (int c = 0; c < C; ++c)
                out[c] = y->row(c, row, z);
            const RowKernels& k = row_kernels();
            (C == 3 ? k.stencil3 : k.stencil1)(grid.nodes[0], stride(), from, in, out);
        }
    });
    if (done) for_each_index(grid.nodes[2], done);
}

template <int C>
void Stencil<C>::inverse_diagonal(Field<float, C>* out) const {
    for_each_index(grid.nodes[2], [&](int32_t z) {
        for (int32_t y = 0; y < grid.nodes[1]; ++y)
            for (int c = 0; c < C; ++c)
                for (int32_t x = 0; x < grid.nodes[0]; ++x) {
                    // On the smallest periodic grids a node is its own neighbour.
                    float d = at(x, y, z, kSelf, c, c);
                    if (grid.periodic) {
                        d = 0;
                        for (int o = 0; o < 27; ++o) {
                            const int32_t s[3] = {o % 3 - 1, o / 3 % 3 - 1, o / 9 - 1};
                            bool self = true;
                            for (size_t a = 0; a < 3; ++a)
                                self = self && s[a] % grid.nodes[a] == 0;
                            if (self) d += at(x, y, z, o, c, c);
                        }
                    }
                    out->row(c, y, z)[x] = d > 0 ? 1 / d : 0;
                }
    });
}

namespace {

/// Where a child element lies in its coarse element along an axis: the lower half, the upper half, or
/// all of it, the last of an odd number in a periodic grid.
enum { kLower, kUpper, kWhole };

/// Weight of coarse corner I (0, 1) at fine corner i (0, 1) of such a child.
double weight(int kind, int i, int corner) {
    const double at = kind == kWhole ? i : 0.5 * (i + (kind == kUpper ? 1 : 0));
    return corner == 1 ? at : 1 - at;
}

/// P^T K P of a child, [8 C][8 C].
template <int C>
std::vector<double> lifted(const std::vector<double>& k, int kx, int ky, int kz) {
    constexpr size_t n = 8 * C;
    double p[8][8];
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j)
            p[i][j] = weight(kx, i & 1, j & 1) * weight(ky, i >> 1 & 1, j >> 1 & 1) *
                      weight(kz, i >> 2, j >> 2);
    std::vector<double> half(n * n), out(n * n);
    for (size_t i = 0; i < n; ++i)
        for (size_t node = 0; node < 8; ++node)
            for (size_t b = 0; b < 8; ++b)
                for (size_t d = 0; d < C; ++d)
                    half[i * n + b * C + d] += k[i * n + node * C + d] * p[node][b];
    for (size_t node = 0; node < 8; ++node)
        for (size_t a = 0; a < 8; ++a)
            if (p[node][a] != 0)
                for (size_t c = 0; c < C; ++c)
                    for (size_t j = 0; j < n; ++j)
                        out[(a * C + c) * n + j] += p[node][a] * half[(node * C + c) * n + j];
    return out;
}

template <int C>
class ElementCoarsener {
  public:
    explicit ElementCoarsener(const ElementOperator<C>& fine)
        : fine_(fine),
          first_(ElementOperator<C>::element_matrix(fine.grid().pitch_mm, 0, fine.values().full)),
          second_(ElementOperator<C>::element_matrix(fine.grid().pitch_mm, 1, fine.values().full)) {
        for (int k = 0; k < 27; ++k) {
            for (const int which : {0, 1}) {
                const std::vector<double> all =
                    lifted<C>(which == 0 ? first_ : second_, k % 3, k / 3 % 3, k / 9);
                std::copy(all.begin(), all.end(),
                          std::back_inserter(lifted_[static_cast<size_t>(2 * k + which)]));
            }
        }
    }

    /// Adds the child at (x, y, z) to its coarse element.
    void add_child(int32_t x, int32_t y, int32_t z, float* out) const {
        const Grid& g = fine_.grid();
        const size_t e = g.element(x, y, z);
        const float first = fine_.values().first[e], second = C == 3 ? fine_.values().second[e] : 0;
        if (first == 0 && second == 0) return;
        const int kind[3] = {kind_of(x, 0), kind_of(y, 1), kind_of(z, 2)};
        uint32_t fixed = 0;
        if (!fine_.fixed().empty())
            for (int k = 0; k < 8; ++k)
                fixed |= static_cast<uint32_t>(fine_.fixed_at((x + (k & 1)) % g.nodes[0],
                                                              (y + (k >> 1 & 1)) % g.nodes[1],
                                                              (z + (k >> 2)) % g.nodes[2]))
                         << C * k;
        if (fixed != 0) return add_fixed(kind, first, second, fixed, out);
        const auto at = static_cast<size_t>(2 * (kind[0] + 3 * kind[1] + 9 * kind[2]));
        const float* a = lifted_[at].data();
        const float* b = lifted_[at + 1].data();
        for (size_t i = 0; i < kSize * kSize; ++i)
            out[i] += first * a[i] + second * b[i];
    }

    static constexpr size_t kSize = 8 * C;

  private:
    int kind_of(int32_t i, size_t axis) const {
        if (i % 2 == 1) return kUpper;
        return fine_.grid().periodic && i + 1 == fine_.grid().elements[axis] ? kWhole : kLower;
    }
    void add_fixed(const int* kind, float first, float second, uint32_t fixed, float* out) const {
        std::vector<double> k(kSize * kSize);
        for (size_t i = 0; i < kSize; ++i)
            for (size_t j = 0; j < kSize; ++j)
                if ((fixed >> i & 1U) == 0 && (fixed >> j & 1U) == 0)
                    k[i * kSize + j] = static_cast<double>(first) * first_[i * kSize + j] +
                                       static_cast<double>(second) * second_[i * kSize + j];
        const std::vector<double> up = lifted<C>(k, kind[0], kind[1], kind[2]);
        for (size_t i = 0; i < kSize * kSize; ++i)
            out[i] += static_cast<float>(up[i]);
    }

    const ElementOperator<C>& fine_;
    std::vector<double> first_, second_;
    std::array<std::vector<float>, 54> lifted_;
};

/// Adds a coarse element's matrix to the stencils of its corners.
template <int C>
void scatter(const float* k, int32_t x, int32_t y, int32_t z, Stencil<C>* out) {
    const Grid& g = out->grid;
    constexpr size_t n = 8 * C;
    for (int a = 0; a < 8; ++a) {
        const int32_t px = (x + (a & 1)) % g.nodes[0], py = (y + (a >> 1 & 1)) % g.nodes[1],
                      pz = (z + (a >> 2)) % g.nodes[2];
        float* row = out->blocks.data() + out->row_at(py, pz) + px + 1;
        for (int b = 0; b < 8; ++b) {
            const int o = 13 + ((b & 1) - (a & 1)) + 3 * ((b >> 1 & 1) - (a >> 1 & 1)) +
                          9 * ((b >> 2) - (a >> 2)) - Stencil<C>::kSelf;
            if (o < 0) continue;
            for (int c = 0; c < C; ++c)
                for (int d = 0; d < C; ++d)
                    row[static_cast<size_t>((o * C + c) * C + d) * out->stride()] +=
                        k[static_cast<size_t>(a * C + c) * n + static_cast<size_t>(b * C + d)];
        }
    }
}

/// One way from a coarse node over a fine one and its neighbour to a coarse neighbour, along an axis.
struct Way {
    int32_t fine;  ///< node, wrapped
    int step;      ///< of the fine stencil, -1 ... 1
    int coarse;    ///< offset of the coarse neighbour, -1 ... 1
    float weight;
};

std::vector<std::vector<Way>> ways(int32_t fine, int32_t coarse, bool periodic) {
    std::vector<std::vector<Way>> out(static_cast<size_t>(coarse));
    // Coarse nodes, not wrapped, that a fine one, not wrapped, is interpolated from.
    const auto from = [&](int32_t j) -> std::vector<std::pair<int32_t, float>> {
        if (periodic && fine % 2 == 1) {
            if (j < 0) return {{-1, 1.F}};
            if (j >= fine) return {{coarse, 1.F}};
        }
        if (j % 2 == 0) return {{j / 2, 1.F}};
        const int32_t low = j < 0 ? -1 : j / 2;
        return {{low, 0.5F}, {low + 1, 0.5F}};
    };
    for (int32_t c = 0; c < coarse; ++c)
        for (int32_t i = 2 * c - 1; i <= 2 * c + 1; ++i) {
            if (!periodic && (i < 0 || i >= fine)) continue;
            if (periodic && fine % 2 == 1 && (i < 0 || i >= fine)) continue;
            for (int s = -1; s <= 1; ++s) {
                const int32_t j = i + s;
                if (!periodic && (j < 0 || j >= fine)) continue;
                for (const auto& [to, w] : from(j))
                    out[static_cast<size_t>(c)].push_back(
                        {(i + fine) % fine, s, to - c, w * (i == 2 * c ? 1.F : 0.5F)});
            }
        }
    return out;
}

}  // namespace

template <int C>
Stencil<C> coarsen(const ElementOperator<C>& fine) {
    const Grid& g = fine.grid();
    Stencil<C> out;
    out.grid = coarser(g);
    out.blocks.resize(out.row_size() * static_cast<size_t>(out.grid.nodes[1]) *
                      static_cast<size_t>(out.grid.nodes[2]));
    const ElementCoarsener<C> children(fine);
    std::array<int32_t, 3> count;
    for (size_t a = 0; a < 3; ++a)
        count[a] = (g.elements[a] + 1) / 2;
    for_layer_blocks(count[2], g.periodic, [&](int32_t begin, int32_t end) {
        constexpr size_t n = ElementCoarsener<C>::kSize;
        std::vector<float> k(n * n);
        for (int32_t z = begin; z < end; ++z)
            for (int32_t y = 0; y < count[1]; ++y)
                for (int32_t x = 0; x < count[0]; ++x) {
                    std::fill(k.begin(), k.end(), 0.F);
                    for (int child = 0; child < 8; ++child) {
                        const int32_t cx = 2 * x + (child & 1), cy = 2 * y + (child >> 1 & 1),
                                      cz = 2 * z + (child >> 2);
                        if (cx < g.elements[0] && cy < g.elements[1] && cz < g.elements[2])
                            children.add_child(cx, cy, cz, k.data());
                    }
                    scatter<C>(k.data(), x, y, z, &out);
                }
    });
    out.fill_ghosts();
    return out;
}

template <int C>
Stencil<C> coarsen(const Stencil<C>& fine) {
    const Grid& g = fine.grid;
    Stencil<C> out;
    out.grid = coarser(g);
    out.blocks.resize(out.row_size() * static_cast<size_t>(out.grid.nodes[1]) *
                      static_cast<size_t>(out.grid.nodes[2]));
    std::array<std::vector<std::vector<Way>>, 3> along;
    for (size_t a = 0; a < 3; ++a)
        along[a] = ways(g.nodes[a], out.grid.nodes[a], g.periodic);
    const size_t fine_x = fine.stride(), coarse_x = out.stride();
    const auto stepped = [&](int32_t i, int step, size_t axis) {
        return (i + step + g.nodes[axis]) % g.nodes[axis];
    };
    for_each_index(out.grid.nodes[2], [&](int32_t z) {
        for (int32_t y = 0; y < out.grid.nodes[1]; ++y) {
            float* row = out.blocks.data() + out.row_at(y, z);
            for (const Way& wz : along[2][static_cast<size_t>(z)])
                for (const Way& wy : along[1][static_cast<size_t>(y)]) {
                    const float w = wz.weight * wy.weight;
                    // Only the neighbours that are kept.
                    const int most = 1 + 3 * wy.coarse + 9 * wz.coarse;
                    if (most < 0) continue;
                    for (int32_t x = 0; x < out.grid.nodes[0]; ++x)
                        for (const Way& wx : along[0][static_cast<size_t>(x)]) {
                            const int q = wx.coarse + 3 * wy.coarse + 9 * wz.coarse;
                            if (q < 0) continue;
                            const int o = Stencil<C>::kSelf + wx.step + 3 * wy.step + 9 * wz.step;
                            const float f = w * wx.weight;
                            const bool kept = o >= Stencil<C>::kSelf;
                            const float* a = kept
                                                 ? fine.block(wx.fine, wy.fine, wz.fine, o)
                                                 : fine.block(stepped(wx.fine, wx.step, 0),
                                                              stepped(wy.fine, wy.step, 1),
                                                              stepped(wz.fine, wz.step, 2), 26 - o);
                            const size_t down = kept ? C * fine_x : fine_x,
                                         across = kept ? fine_x : C * fine_x;
                            float* b = row + static_cast<size_t>(q * C * C) * coarse_x +
                                       static_cast<size_t>(x + 1);
                            for (size_t c = 0; c < C; ++c)
                                for (size_t d = 0; d < C; ++d)
                                    b[(c * C + d) * coarse_x] += f * a[c * down + d * across];
                        }
                }
        }
    });
    out.fill_ghosts();
    return out;
}

namespace {

/// The coarse nodes that a fine one is interpolated from, wrapped: one twice where the node is both.
std::pair<int32_t, int32_t> sources(int32_t i, int32_t coarse, bool periodic) {
    if (i % 2 == 0) return {i / 2, i / 2};
    const int32_t up = i / 2 + 1;
    return {i / 2, periodic && up == coarse ? 0 : up};
}

}  // namespace

template <int C>
void restrict_to(const Field<float, C>& fine, const Grid& g, Field<float, C>* coarse) {
    const Grid to = coarser(g);
    for_each_index(to.nodes[2], [&](int32_t z) {
        std::fill_n(coarse->plane(z), coarse->plane_size(), 0.F);
        std::vector<float> sum(static_cast<size_t>(g.nodes[0]));
        for (int32_t y = 0; y < to.nodes[1]; ++y)
            for (int c = 0; c < C; ++c) {
                std::fill(sum.begin(), sum.end(), 0.F);
                for (int32_t k = 0; k < 9; ++k) {
                    int32_t fy = 2 * y + k % 3 - 1, fz = 2 * z + k / 3 - 1;
                    const bool wraps = g.periodic;
                    if (wraps && g.nodes[1] % 2 == 0) fy = (fy + g.nodes[1]) % g.nodes[1];
                    if (wraps && g.nodes[2] % 2 == 0) fz = (fz + g.nodes[2]) % g.nodes[2];
                    if (fy < 0 || fz < 0 || fy >= g.nodes[1] || fz >= g.nodes[2]) continue;
                    const float w = (k % 3 == 1 ? 1.F : 0.5F) * (k / 3 == 1 ? 1.F : 0.5F);
                    const float* p = fine.row(c, fy, fz);
                    for (int32_t x = 0; x < g.nodes[0]; ++x)
                        sum[static_cast<size_t>(x)] += w * p[x];
                }
                float* out = coarse->row(c, y, z);
                for (int32_t x = 0; x < g.nodes[0]; ++x) {
                    const auto [low, high] = sources(x, to.nodes[0], g.periodic);
                    const float half = 0.5F * sum[static_cast<size_t>(x)];
                    out[low] += half;
                    out[high] += half;
                }
            }
    });
}

template <int C>
void add_prolonged(Field<float, C>* coarse, const Grid& g, Field<float, C>* fine) {
    const Grid from = coarser(g);
    for_each_index(g.nodes[2], [&](int32_t z) {
        std::vector<float> sum(static_cast<size_t>(from.nodes[0]));
        const auto [z0, z1] = sources(z, from.nodes[2], g.periodic);
        for (int32_t y = 0; y < g.nodes[1]; ++y) {
            const auto [y0, y1] = sources(y, from.nodes[1], g.periodic);
            for (int c = 0; c < C; ++c) {
                const float* a = coarse->row(c, y0, z0);
                const float* b = coarse->row(c, y1, z0);
                const float* d = coarse->row(c, y0, z1);
                const float* e = coarse->row(c, y1, z1);
                for (int32_t x = 0; x < from.nodes[0]; ++x)
                    sum[static_cast<size_t>(x)] = 0.25F * ((a[x] + b[x]) + (d[x] + e[x]));
                float* out = fine->row(c, y, z);
                for (int32_t x = 0; x < g.nodes[0]; ++x) {
                    const auto [low, high] = sources(x, from.nodes[0], g.periodic);
                    out[x] +=
                        0.5F * (sum[static_cast<size_t>(low)] + sum[static_cast<size_t>(high)]);
                }
            }
        }
    });
}

#define OPENFAB_FOR(C)                                                                \
    template struct Stencil<C>;                                                       \
    template Stencil<C> coarsen(const ElementOperator<C>&);                           \
    template Stencil<C> coarsen(const Stencil<C>&);                                   \
    template void restrict_to(const Field<float, C>&, const Grid&, Field<float, C>*); \
    template void add_prolonged(Field<float, C>*, const Grid&, Field<float, C>*);
OPENFAB_FOR(3)
OPENFAB_FOR(1)
#undef OPENFAB_FOR

}  // namespace openfab::mechanics
