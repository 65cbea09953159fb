// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/loads.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "mechanics/messages.h"

namespace openfab::mechanics {

namespace {

/// x of M x = b, by Cramer's rule; nothing where M is singular.
std::optional<Vec3> solve3(const std::array<Vec3, 3>& m, const Vec3& b) {
    const auto det = [](const std::array<Vec3, 3>& a) {
        return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
               a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
               a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
    };
    const double all = det(m), size = m[0][0] + m[1][1] + m[2][2];
    if (!(std::abs(all) > 1e-12 * size * size * size)) return std::nullopt;
    Vec3 x;
    for (size_t c = 0; c < 3; ++c) {
        std::array<Vec3, 3> replaced = m;
        for (size_t r = 0; r < 3; ++r)
            replaced[r][c] = b[r];
        x[c] = det(replaced) / all;
    }
    return x;
}

}  // namespace

void LoadAssembler::add_to(int64_t node, const Vec3& force) {
    const int64_t row = node / grid_.nodes[0];
    for (int c = 0; c < 3; ++c)
        forces_.row(c, static_cast<int32_t>(row % grid_.nodes[1]),
                    static_cast<int32_t>(row / grid_.nodes[1]))[node % grid_.nodes[0]] +=
            force[static_cast<size_t>(c)];
    for (size_t c = 0; c < 3; ++c)
        total_[c] += force[c];
}

void LoadAssembler::count(int64_t node, const Vec3& force) {
    for (size_t c = 0; c < 3; ++c) {
        const int64_t dof = node * 3 + static_cast<int64_t>(c);
        acts_ += std::abs(force[c]);
        const auto at = std::ranges::lower_bound(held_, dof, {}, &Held::dof);
        if (at == held_.end() || at->dof != dof) free_ += std::abs(force[c]);
    }
}

Result<void> LoadAssembler::add(const Load& load, std::span<const LoadedFace> faces) {
    acts_ = free_ = most_MPa_ = 0;
    double area = 0;
    for (const LoadedFace& f : faces)
        area += f.area;
    for (const auto& [f, own] : faces) {
        Vec3 force{};
        if (load.force_N)
            for (size_t c = 0; c < 3; ++c)
                force[c] += (*load.force_N)[c] * own / area;
        if (load.pressure_MPa)
            force[f.direction / 2U] += (f.direction % 2 == 1 ? -1 : 1) * *load.pressure_MPa * own;
        most_MPa_ = std::max(most_MPa_, std::hypot(force[0], force[1], force[2]) / own);
        for (const int64_t node : nodes_of(grid_, f)) {
            const Vec3 quarter{force[0] / 4, force[1] / 4, force[2] / 4};
            add_to(node, quarter);
            count(node, quarter);
            nodes_.push_back(node);
        }
    }
    if (!load.torque_Nmm) return {};
    const auto place = [&](int64_t node) {
        return Vec3{
            static_cast<double>(node % grid_.nodes[0]) * grid_.pitch_mm[0],
            static_cast<double>(node / grid_.nodes[0] % grid_.nodes[1]) * grid_.pitch_mm[1],
            static_cast<double>(node / grid_.nodes[0] / grid_.nodes[1]) * grid_.pitch_mm[2]};
    };
    Vec3 middle{};
    for (const auto& [f, own] : faces)
        for (const int64_t node : nodes_of(grid_, f))
            for (size_t c = 0; c < 3; ++c)
                middle[c] += place(node)[c] * own / (4 * area);
    std::array<Vec3, 3> inertia{};
    for (const auto& [f, own] : faces)
        for (const int64_t node : nodes_of(grid_, f)) {
            Vec3 r = place(node);
            for (size_t c = 0; c < 3; ++c)
                r[c] -= middle[c];
            const double square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
            for (size_t i = 0; i < 3; ++i)
                for (size_t j = 0; j < 3; ++j)
                    inertia[i][j] += own / 4 * ((i == j ? square : 0) - r[i] * r[j]);
        }
    const std::optional<Vec3> w = solve3(inertia, *load.torque_Nmm);
    if (!w) return user_error(messages::kTorqueOnLine, messages::kTorqueOnLineHelp);
    for (const auto& [f, own] : faces)
        for (const int64_t node : nodes_of(grid_, f)) {
            Vec3 r = place(node);
            for (size_t c = 0; c < 3; ++c)
                r[c] = (r[c] - middle[c]) * own / 4;
            const Vec3 force{(*w)[1] * r[2] - (*w)[2] * r[1], (*w)[2] * r[0] - (*w)[0] * r[2],
                             (*w)[0] * r[1] - (*w)[1] * r[0]};
            add_to(node, force);
            count(node, force);
        }
    return {};
}

void LoadAssembler::add_gravity(const Vec3& g, const Voxels& voxels) {
    // g/cm3 times mm3 is 1e-6 kg.
    const double volume = grid_.pitch_mm[0] * grid_.pitch_mm[1] * grid_.pitch_mm[2];
    for (int64_t e = 0; e < grid_.element_count(); ++e) {
        const auto at = static_cast<size_t>(e);
        if (!(voxels.mu[at] > 0)) continue;
        const double mass = static_cast<double>(voxels.density[at]) * volume * 1e-6;
        const Vec3 force{mass * g[0] / 8, mass * g[1] / 8, mass * g[2] / 8};
        for (const uint8_t d : {uint8_t{4}, uint8_t{5}})
            for (const int64_t node : nodes_of(grid_, {e, d}))
                add_to(node, force);
    }
}

std::vector<int64_t> LoadAssembler::nodes() {
    std::ranges::sort(nodes_);
    nodes_.erase(std::ranges::unique(nodes_).begin(), nodes_.end());
    return std::move(nodes_);
}

}  // namespace openfab::mechanics
