// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/solver/stiff_bodies.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mechanics/solver/parallel.h"

namespace openfab::mechanics {

namespace {

/// What is stiff has more than such a share of the largest modulus; coarser grids follow contrasts below.
constexpr float kStiff = 1.F / 30;
/// Smaller ones, of the nodes of all, are left to the grids; and there are at most so many.
constexpr double kLeastShare = 0.005;
constexpr size_t kMostBodies = 32;

/// Sets of nodes, of which the least node is the name.
class NodeSets {
  public:
    explicit NodeSets(int64_t nodes) : parent_(static_cast<size_t>(nodes), -1) {}
    int32_t root(int32_t n) {
        while (parent_[at(n)] != n) {
            parent_[at(n)] = parent_[at(parent_[at(n)])];
            n = parent_[at(n)];
        }
        return n;
    }
    void join(int32_t a, int32_t b) {
        for (const int32_t n : {a, b})
            if (parent_[at(n)] < 0) parent_[at(n)] = n;
        a = root(a);
        b = root(b);
        parent_[at(std::max(a, b))] = std::min(a, b);
    }
    bool has(int32_t n) const { return parent_[at(n)] >= 0; }

  private:
    static size_t at(int32_t n) { return static_cast<size_t>(n); }
    std::vector<int32_t> parent_;
};

}  // namespace

template <int C>
StiffBodies<C>::StiffBodies(const ElementOperator<C>& a)
    : a_(a), motions_(C == 1 ? 1 : (a.grid().periodic ? 3 : 6)) {
    const std::vector<float>& modulus = C == 3 ? a.values().second : a.values().first;
    float largest = 0;
    for (const float m : modulus)
        largest = std::max(largest, m);
    const float stiff = kStiff * largest;
    constexpr int64_t kMostNodes = INT32_MAX;
    if (a.grid().node_count() > kMostNodes ||
        std::ranges::none_of(modulus, [&](float m) { return m > 0 && m < stiff; }))
        return;
    find_bodies(stiff);
    if (bodies_.empty()) return;
    first_ = ElementOperator<C>::element_matrix(a.grid().pitch_mm, 0, a.values().full);
    second_ = ElementOperator<C>::element_matrix(a.grid().pitch_mm, 1, a.values().full);
    measure();
    find_joints();
    factor();
}

template <int C>
auto StiffBodies<C>::corners_of(int64_t element) const -> Corners {
    const Grid& g = a_.grid();
    const auto x = static_cast<int32_t>(element % g.elements[0]),
               y = static_cast<int32_t>(element / g.elements[0] % g.elements[1]),
               z = static_cast<int32_t>(element / g.elements[0] / g.elements[1]);
    Corners out;
    for (int32_t k = 0; k < 8; ++k)
        out[static_cast<size_t>(k)] = {(x + (k & 1)) % g.nodes[0], (y + (k >> 1 & 1)) % g.nodes[1],
                                       (z + (k >> 2)) % g.nodes[2]};
    return out;
}

template <int C>
uint8_t StiffBodies<C>::label(const std::array<int32_t, 3>& node) const {
    const Grid& g = a_.grid();
    return labels_[(static_cast<size_t>(node[2]) * static_cast<size_t>(g.nodes[1]) +
                    static_cast<size_t>(node[1])) *
                       static_cast<size_t>(g.nodes[0]) +
                   static_cast<size_t>(node[0])];
}

template <int C>
void StiffBodies<C>::find_bodies(float stiff) {
    const Grid& g = a_.grid();
    const std::vector<float>& modulus = C == 3 ? a_.values().second : a_.values().first;
    NodeSets sets(g.node_count());
    const auto number = [&](const std::array<int32_t, 3>& n) {
        return (n[2] * g.nodes[1] + n[1]) * g.nodes[0] + n[0];
    };
    for (int64_t e = 0; e < g.element_count(); ++e) {
        if (modulus[static_cast<size_t>(e)] < stiff) continue;
        const Corners corners = corners_of(e);
        const int32_t first = number(corners[0]);
        for (size_t k = 1; k < 8; ++k)
            sets.join(first, number(corners[k]));
    }
    // How many nodes a set has, and which of its components are held, at the set's least node.
    struct Found {
        int32_t root;
        int64_t nodes = 0, held_nodes = 0;
        uint32_t held = 0;
    };
    std::vector<Found> found;
    const auto nodes = static_cast<int32_t>(g.node_count());
    int64_t all = 0;
    for (int32_t n = 0; n < nodes; ++n)
        if (sets.has(n)) {
            ++all;
            if (sets.root(n) == n) found.push_back({n});
        }
    const auto of = [&](int32_t n) -> Found* {
        const int32_t root = sets.root(n);
        return &*std::ranges::lower_bound(found, root, {}, &Found::root);
    };
    for (int32_t n = 0; n < nodes; ++n)
        if (sets.has(n)) ++of(n)->nodes;
    for (const int64_t dof : a_.fixed()) {
        const auto n = static_cast<int32_t>(dof / C);
        if (!sets.has(n)) continue;
        Found* f = of(n);
        f->held |= 1U << dof % C;
        ++f->held_nodes;
    }
    std::ranges::stable_sort(found, std::ranges::greater(), &Found::nodes);
    // All of a periodic cell may move as one, so that the largest may stay.
    if (g.periodic && !found.empty()) found.erase(found.begin());
    std::erase_if(found, [&](const Found& f) {
        const bool whole = f.held == (1U << C) - 1;
        return static_cast<double>(f.nodes) < kLeastShare * static_cast<double>(all) ||
               (whole && f.held_nodes >= 3 * C);
    });
    if (found.size() > kMostBodies) found.resize(kMostBodies);
    bodies_.resize(found.size());
    if (found.empty()) return;
    labels_.resize(static_cast<size_t>(nodes));
    for (int32_t n = 0; n < nodes; ++n) {
        if (!sets.has(n)) continue;
        const auto at = std::ranges::find(found, sets.root(n), &Found::root);
        if (at != found.end())
            labels_[static_cast<size_t>(n)] = static_cast<uint8_t>(at - found.begin() + 1);
    }
}

template <int C>
template <typename F>
void StiffBodies<C>::for_nodes(int32_t z, const F& f) const {
    const Grid& g = a_.grid();
    const uint8_t* at = labels_.data() + static_cast<size_t>(z) * static_cast<size_t>(g.nodes[1]) *
                                             static_cast<size_t>(g.nodes[0]);
    for (int32_t y = 0; y < g.nodes[1]; ++y)
        for (int32_t x = 0; x < g.nodes[0]; ++x, ++at)
            if (*at != 0) f(size_t{*at} - 1, std::array<int32_t, 3>{x, y, z});
}

template <int C>
void StiffBodies<C>::measure() {
    if (motions_ < 6) return;
    const Grid& g = a_.grid();
    std::vector<double> count(bodies_.size());
    for (int32_t z = 0; z < g.nodes[2]; ++z)
        for_nodes(z, [&](size_t b, const std::array<int32_t, 3>& n) {
            ++count[b];
            for (size_t a = 0; a < 3; ++a)
                bodies_[b].middle[a] += n[a];
        });
    for (size_t b = 0; b < bodies_.size(); ++b)
        for (double& m : bodies_[b].middle)
            m /= count[b];
    for (int32_t z = 0; z < g.nodes[2]; ++z)
        for_nodes(z, [&](size_t b, const std::array<int32_t, 3>& n) {
            for (size_t a = 0; a < 3; ++a)
                bodies_[b].radius_mm = std::max(
                    bodies_[b].radius_mm, std::abs(n[a] - bodies_[b].middle[a]) * g.pitch_mm[a]);
        });
}

template <int C>
std::array<double, C> StiffBodies<C>::moved(const Body& body, size_t m,
                                            const std::array<int32_t, 3>& node) const {
    std::array<double, C> out{};
    if (m < C) {
        out[m] = 1;
        return out;
    }
    if constexpr (C == 3) {
        // Of a turn about axis a: b moves against c, and c with b.
        const size_t a = m - 3, b = (a + 1) % 3, c = (a + 2) % 3;
        const auto at = [&](size_t axis) {
            return (node[axis] - body.middle[axis]) * a_.grid().pitch_mm[axis] / body.radius_mm;
        };
        out[b] = -at(c);
        out[c] = at(b);
    }
    return out;
}

template <int C>
void StiffBodies<C>::find_joints() {
    const Grid& g = a_.grid();
    const ElementValues& v = a_.values();
    std::vector<uint8_t> held(labels_.size());
    for (const int64_t dof : a_.fixed())
        held[static_cast<size_t>(dof / C)] = 1;
    const auto held_at = [&](const std::array<int32_t, 3>& n) {
        return held[static_cast<size_t>((int64_t{n[2]} * g.nodes[1] + n[1]) * g.nodes[0] + n[0])] !=
               0;
    };
    const int64_t layer = int64_t{g.elements[0]} * g.elements[1];
    for (int64_t e = 0; e < g.element_count(); ++e) {
        if (e % layer == 0) begin_.push_back(joints_.size());
        const auto at = static_cast<size_t>(e);
        if (v.first[at] == 0 && (C == 1 || v.second[at] == 0)) continue;
        const Corners corners = corners_of(e);
        const uint8_t one = label(corners[0]);
        bool some = false, alike = true;
        for (const std::array<int32_t, 3>& n : corners) {
            const uint8_t l = label(n);
            some = some || l != 0;
            alike = alike && l == one && !(l != 0 && held_at(n));
        }
        if (some && !alike) joints_.push_back(e);
    }
    begin_.push_back(joints_.size());
}

template <int C>
std::array<double, size_t{8} * C> StiffBodies<C>::forces_of(
    int64_t element, const std::array<double, size_t{8} * C>& u) const {
    constexpr size_t n = size_t{8} * C;
    const auto e = static_cast<size_t>(element);
    const auto first = static_cast<double>(a_.values().first[e]);
    const double second = C == 3 ? static_cast<double>(a_.values().second[e]) : 0;
    std::array<double, n> out;
    for (size_t i = 0; i < n; ++i) {
        double a = 0, b = 0;
        for (size_t j = 0; j < n; ++j) {
            a += first_[i * n + j] * u[j];
            if constexpr (C == 3) b += second_[i * n + j] * u[j];
        }
        out[i] = first * a + second * b;
    }
    return out;
}

template <int C>
void StiffBodies<C>::add_work(const Corners& corners,
                              const std::array<double, size_t{8} * C>& forces, double* sums) const {
    for (size_t k = 0; k < 8; ++k) {
        const uint8_t l = label(corners[k]);
        if (l == 0) continue;
        const uint8_t held = a_.fixed().empty()
                                 ? uint8_t{0}
                                 : a_.fixed_at(corners[k][0], corners[k][1], corners[k][2]);
        const size_t body = size_t{l} - 1;
        for (size_t m = 0; m < motions_; ++m) {
            const std::array<double, C> d = moved(bodies_[body], m, corners[k]);
            for (size_t c = 0; c < C; ++c)
                if ((held >> c & 1) == 0) sums[body * motions_ + m] += d[c] * forces[k * C + c];
        }
    }
}

template <int C>
void StiffBodies<C>::factor() {
    // In parts of joints that their number alone decides, so that sums are the same for any threads.
    constexpr size_t kParts = 16;
    const size_t n = size();
    std::vector<std::vector<double>> parts(kParts);
    for_each_index(static_cast<int32_t>(kParts), [&](int32_t part) {
        const auto at = static_cast<size_t>(part);
        std::vector<double>& sum = parts[at];
        sum.resize(n * n);
        for (size_t j = at * joints_.size() / kParts; j < (at + 1) * joints_.size() / kParts; ++j) {
            const Corners corners = corners_of(joints_[j]);
            uint32_t done = 0;
            for (size_t k = 0; k < 8; ++k) {
                const uint8_t l = label(corners[k]);
                if (l == 0 || (done >> (l - 1) & 1U) != 0) continue;
                done |= 1U << (l - 1);
                const size_t body = size_t{l} - 1;
                for (size_t m = 0; m < motions_; ++m) {
                    std::array<double, size_t{8} * C> u{};
                    for (size_t i = k; i < 8; ++i) {
                        if (label(corners[i]) != l) continue;
                        const uint8_t held =
                            a_.fixed().empty()
                                ? uint8_t{0}
                                : a_.fixed_at(corners[i][0], corners[i][1], corners[i][2]);
                        const std::array<double, C> d = moved(bodies_[body], m, corners[i]);
                        for (size_t c = 0; c < C; ++c)
                            if ((held >> c & 1) == 0) u[i * C + c] = d[c];
                    }
                    add_work(corners, forces_of(joints_[j], u),
                             sum.data() + (body * motions_ + m) * n);
                }
            }
        }
    });
    std::vector<double> matrix(n * n);
    for (const std::vector<double>& part : parts)
        for (size_t i = 0; i < n * n; ++i)
            matrix[i] += part[i];
    constexpr double kVanishes = 1e-10;
    solver_ = DenseSolver(std::move(matrix), n, kVanishes);
}

template <int C>
std::vector<double> StiffBodies<C>::summed(const std::vector<double>& planes) const {
    std::vector<double> out(size());
    for (size_t at = 0; at < planes.size(); at += out.size())
        for (size_t i = 0; i < out.size(); ++i)
            out[i] += planes[at + i];
    solver_.solve(out.data());
    return out;
}

template <int C>
std::vector<double> StiffBodies<C>::motions_of(const Field<double, C>& r) const {
    const Grid& g = a_.grid();
    std::vector<double> planes(size() * static_cast<size_t>(g.nodes[2]));
    for_each_index(g.nodes[2], [&](int32_t z) {
        double* sum = planes.data() + size() * static_cast<size_t>(z);
        // What is held has no residual.
        for_nodes(z, [&](size_t b, const std::array<int32_t, 3>& n) {
            for (size_t m = 0; m < motions_; ++m) {
                const std::array<double, C> d = moved(bodies_[b], m, n);
                for (int c = 0; c < C; ++c)
                    sum[b * motions_ + m] += d[static_cast<size_t>(c)] * r.row(c, n[1], z)[n[0]];
            }
        });
    });
    return summed(planes);
}

template <int C>
std::vector<double> StiffBodies<C>::motions_in(const Field<float, C>& field) const {
    const Grid& g = a_.grid();
    std::vector<double> planes(size() * static_cast<size_t>(g.elements[2]));
    for_each_index(g.elements[2], [&](int32_t z) {
        double* sum = planes.data() + size() * static_cast<size_t>(z);
        for (size_t j = begin_[static_cast<size_t>(z)]; j < begin_[static_cast<size_t>(z) + 1];
             ++j) {
            const Corners corners = corners_of(joints_[j]);
            std::array<double, size_t{8} * C> u;
            for (size_t k = 0; k < 8; ++k)
                for (size_t c = 0; c < C; ++c)
                    u[k * C + c] = static_cast<double>(field.row(static_cast<int>(c), corners[k][1],
                                                                 corners[k][2])[corners[k][0]]);
            add_work(corners, forces_of(joints_[j], u), sum);
        }
    });
    return summed(planes);
}

template <int C>
void StiffBodies<C>::take_forces(std::span<const double> motions, Field<float, C>* b) const {
    const Grid& g = a_.grid();
    for_layer_blocks(g.elements[2], g.periodic, [&](int32_t begin, int32_t end) {
        for (size_t j = begin_[static_cast<size_t>(begin)]; j < begin_[static_cast<size_t>(end)];
             ++j) {
            const Corners corners = corners_of(joints_[j]);
            std::array<double, size_t{8} * C> u{};
            std::array<uint8_t, 8> held{};
            for (size_t k = 0; k < 8; ++k) {
                if (!a_.fixed().empty())
                    held[k] = a_.fixed_at(corners[k][0], corners[k][1], corners[k][2]);
                const uint8_t l = label(corners[k]);
                if (l == 0) continue;
                const size_t body = size_t{l} - 1;
                for (size_t m = 0; m < motions_; ++m) {
                    const std::array<double, C> d = moved(bodies_[body], m, corners[k]);
                    for (size_t c = 0; c < C; ++c)
                        if ((held[k] >> c & 1) == 0)
                            u[k * C + c] += d[c] * motions[body * motions_ + m];
                }
            }
            const std::array<double, size_t{8}* C> forces = forces_of(joints_[j], u);
            for (size_t k = 0; k < 8; ++k)
                for (size_t c = 0; c < C; ++c)
                    if ((held[k] >> c & 1) == 0)
                        b->row(static_cast<int>(c), corners[k][1], corners[k][2])[corners[k][0]] -=
                            static_cast<float>(forces[k * C + c]);
        }
    });
}

template <int C>
void StiffBodies<C>::add(std::span<const double> motions, Field<float, C>* field) const {
    const Grid& g = a_.grid();
    for_each_index(g.nodes[2], [&](int32_t z) {
        for_nodes(z, [&](size_t b, const std::array<int32_t, 3>& n) {
            std::array<double, C> sum{};
            for (size_t m = 0; m < motions_; ++m) {
                const std::array<double, C> d = moved(bodies_[b], m, n);
                for (size_t c = 0; c < C; ++c)
                    sum[c] += d[c] * motions[b * motions_ + m];
            }
            for (size_t c = 0; c < C; ++c)
                field->row(static_cast<int>(c), n[1], z)[n[0]] += static_cast<float>(sum[c]);
        });
        a_.fix(field, z);
    });
}

template class StiffBodies<kElastic>;
template class StiffBodies<kScalar>;

}  // namespace openfab::mechanics
