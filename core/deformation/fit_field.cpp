// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "deformation/fit_field.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace openfab::deformation {

namespace {

/// The eight nodes around a place, and their shares.
struct Sample {
    std::array<size_t, 8> nodes;
    std::array<double, 8> shares;
};

Sample sample_of(const Field& field, const Vec3d& p) {
    Sample out{};
    std::array<std::array<int32_t, 2>, 3> node{};
    std::array<double, 3> share{};
    for (int axis = 0; axis < 3; ++axis) {
        const int32_t nodes = field.nodes[axis];
        const double at = std::clamp((p[axis] - field.origin_mm[axis]) / field.spacing_mm[axis],
                                     0.0, static_cast<double>(nodes - 1));
        const auto a = static_cast<size_t>(axis);
        node[a][0] = std::min(static_cast<int32_t>(at), std::max(nodes - 2, 0));
        node[a][1] = std::min(node[a][0] + 1, nodes - 1);
        share[a] = at - node[a][0];
    }
    for (size_t i = 0; i < 8; ++i) {
        const size_t x = i & 1, y = i >> 1 & 1, z = i >> 2;
        out.nodes[i] = field.at(node[0][x], node[1][y], node[2][z]);
        out.shares[i] = (x != 0 ? share[0] : 1 - share[0]) * (y != 0 ? share[1] : 1 - share[1]) *
                        (z != 0 ? share[2] : 1 - share[2]);
    }
    return out;
}

using Values = std::vector<Vec3d>;

double dot(const Values& a, const Values& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i)
        sum += a[i].x * b[i].x + a[i].y * b[i].y + a[i].z * b[i].z;
    return sum;
}

/// The normal equations, applied.
class Equations {
  public:
    Equations(const Field& field, const std::vector<Pair>& pairs, double smoothness)
        : field_(field), weight_(smoothness) {
        for (const Pair& pair : pairs)
            samples_.push_back(sample_of(field, pair.nominal_mm));
    }

    Values right(const std::vector<Pair>& pairs) const {
        Values out(field_.u_mm.size());
        for (size_t i = 0; i < pairs.size(); ++i) {
            const Vec3d d = pairs[i].measured_mm - pairs[i].nominal_mm;
            for (size_t k = 0; k < 8; ++k)
                out[samples_[i].nodes[k]] = out[samples_[i].nodes[k]] + d * samples_[i].shares[k];
        }
        return out;
    }

    Values apply(const Values& u) const {
        Values out(u.size());
        for (const Sample& sample : samples_) {
            Vec3d here;
            for (size_t k = 0; k < 8; ++k)
                here = here + u[sample.nodes[k]] * sample.shares[k];
            for (size_t k = 0; k < 8; ++k)
                out[sample.nodes[k]] = out[sample.nodes[k]] + here * sample.shares[k];
        }
        const Vec3i& n = field_.nodes;
        const std::array<size_t, 3> step{1, static_cast<size_t>(n.x),
                                         static_cast<size_t>(n.x) * static_cast<size_t>(n.y)};
        for (int32_t z = 0; z < n.z; ++z) {
            for (int32_t y = 0; y < n.y; ++y) {
                for (int32_t x = 0; x < n.x; ++x) {
                    const size_t at = field_.at(x, y, z);
                    const std::array<int32_t, 3> left{n.x - x, n.y - y, n.z - z};
                    for (size_t a = 0; a < 3; ++a) {
                        if (left[a] > 2) second(u, at, step[a], step[a], 1, &out);
                        // Mixed ones, without which a field could twist for nothing.
                        const size_t b = (a + 1) % 3;
                        if (left[a] > 1 && left[b] > 1) mixed(u, at, step[a], step[b], &out);
                    }
                }
            }
        }
        return out;
    }

  private:
    void second(const Values& u, size_t at, size_t one, size_t two, double scale,
                Values* out) const {
        const size_t b = at + one, c = b + two;
        const Vec3d d = (u[at] - u[b] * 2.0 + u[c]) * (weight_ * scale);
        (*out)[at] = (*out)[at] + d;
        (*out)[b] = (*out)[b] - d * 2.0;
        (*out)[c] = (*out)[c] + d;
    }
    void mixed(const Values& u, size_t at, size_t one, size_t two, Values* out) const {
        const size_t b = at + one, c = at + two, both = at + one + two;
        const Vec3d d = (u[at] - u[b] - u[c] + u[both]) * (2 * weight_);
        (*out)[at] = (*out)[at] + d;
        (*out)[b] = (*out)[b] - d;
        (*out)[c] = (*out)[c] - d;
        (*out)[both] = (*out)[both] + d;
    }

    const Field& field_;
    const double weight_;
    std::vector<Sample> samples_;
};

}  // namespace

double fit_field(const std::vector<Pair>& pairs, double smoothness, Field* field) {
    field->u_mm.assign(field->at(0, 0, field->nodes.z), Vec3d{});
    const Equations equations(*field, pairs, smoothness);
    // Conjugate gradients.
    Values& u = field->u_mm;
    Values rest = equations.right(pairs), direction = rest;
    double size = dot(rest, rest);
    const double enough = size * 1e-18;
    const size_t most = std::min<size_t>(4000, 20 * u.size() + 100);
    for (size_t step = 0; step < most && size > enough; ++step) {
        const Values image = equations.apply(direction);
        const double bend = dot(direction, image);
        if (!(bend > 0)) break;
        const double length = size / bend;
        for (size_t i = 0; i < u.size(); ++i) {
            u[i] = u[i] + direction[i] * length;
            rest[i] = rest[i] - image[i] * length;
        }
        const double next = dot(rest, rest);
        for (size_t i = 0; i < u.size(); ++i)
            direction[i] = rest[i] + direction[i] * (next / size);
        size = next;
    }
    double sum = 0;
    for (const Pair& pair : pairs) {
        const Vec3d off = pair.measured_mm - field->moved(pair.nominal_mm);
        sum += off.x * off.x + off.y * off.y + off.z * off.z;
    }
    return pairs.empty() ? 0 : std::sqrt(sum / static_cast<double>(pairs.size()));
}

}  // namespace openfab::deformation
