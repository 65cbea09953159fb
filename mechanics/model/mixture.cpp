// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/model/mixture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mechanics/messages.h"

namespace openfab::mechanics {

HsBounds hs_bounds(std::span<const double> shares, std::span<const double> bulk,
                   std::span<const double> shear) {
    // Of the softest and the stiffest that are there.
    double k_min = 0, k_max = 0, g_min = 0, g_max = 0;
    bool first = true;
    for (size_t i = 0; i < shares.size(); ++i) {
        if (!(shares[i] > 0)) continue;
        k_min = first ? bulk[i] : std::min(k_min, bulk[i]);
        k_max = first ? bulk[i] : std::max(k_max, bulk[i]);
        g_min = first ? shear[i] : std::min(g_min, shear[i]);
        g_max = first ? shear[i] : std::max(g_max, shear[i]);
        first = false;
    }
    const auto mean = [&](std::span<const double> modulus, double shift) {
        double sum = 0;
        for (size_t i = 0; i < shares.size(); ++i) {
            if (!(shares[i] > 0)) continue;
            if (!(modulus[i] + shift > 0)) return 0.0;
            sum += shares[i] / (modulus[i] + shift);
        }
        return sum > 0 ? 1 / sum - shift : 0;
    };
    const auto zeta = [](double k, double g) {
        return k + 2 * g > 0 ? g / 6 * (9 * k + 8 * g) / (k + 2 * g) : 0;
    };
    return {mean(bulk, 4.0 / 3 * g_min), mean(bulk, 4.0 / 3 * g_max),
            mean(shear, zeta(k_min, g_min)), mean(shear, zeta(k_max, g_max))};
}

Mixture::Mixture(std::vector<Material> materials, const Properties& properties)
    : materials_(std::move(materials)),
      law_(properties.law),
      table_(properties.table ? &*properties.table : nullptr) {
    for (const Material& m : materials_) {
        int column = -1;
        if (table_) {
            const auto at =
                std::ranges::find(table_->materials, m.called.empty() ? m.name : m.called);
            if (at != table_->materials.end())
                column = static_cast<int>(at - table_->materials.begin());
        }
        column_.push_back(column);
    }
}

std::string Mixture::complaint() const {
    if (law_ != Law::kTable) return {};
    for (size_t i = 0; i < materials_.size(); ++i)
        if (column_[i] < 0 && materials_[i].used)
            return fmt::format(messages::kTableLacksMaterial, materials_[i].name,
                               table_->materials.front());
    return {};
}

double Mixture::table_modulus(std::span<const double> shares) const {
    // The nearest point of the rows' polyline: of two materials the very mixture.
    std::vector<double> p(table_->materials.size());
    for (size_t i = 0; i < shares.size(); ++i)
        if (column_[i] >= 0) p[static_cast<size_t>(column_[i])] += shares[i];
    double best = 1e30, value = 0;
    for (size_t r = 0; r + 1 < table_->rows.size(); ++r) {
        const PropertyTable::Row& a = table_->rows[r];
        const PropertyTable::Row& b = table_->rows[r + 1];
        double along = 0, length = 0;
        for (size_t i = 0; i < p.size(); ++i) {
            along += (p[i] - a.mixture[i]) * (b.mixture[i] - a.mixture[i]);
            length += (b.mixture[i] - a.mixture[i]) * (b.mixture[i] - a.mixture[i]);
        }
        const double t = length > 0 ? std::clamp(along / length, 0.0, 1.0) : 0;
        double away = 0;
        for (size_t i = 0; i < p.size(); ++i) {
            const double d = p[i] - (a.mixture[i] + t * (b.mixture[i] - a.mixture[i]));
            away += d * d;
        }
        if (away < best) {
            best = away;
            value = a.value + t * (b.value - a.value);
        }
    }
    return value;
}

ElementProperties Mixture::of(std::span<const float> shares) const {
    constexpr double kVoid = 1e-6;
    double solid = 0;
    for (const float s : shares)
        solid += static_cast<double>(s);
    ElementProperties out;
    if (solid < kVoid) return out;
    std::vector<double> f(shares.size());
    double strength = 0;
    bool known = true;
    size_t alone = 0, number = 0;
    for (size_t i = 0; i < shares.size(); ++i) {
        f[i] = static_cast<double>(shares[i]) / solid;
        if (!(f[i] > 1e-9)) continue;
        const Material& m = materials_[i];
        ++number;
        alone = i;
        known = known && m.strength_MPa.has_value();
        strength += f[i] * m.strength_MPa.value_or(0);
        out.density += f[i] * m.density_g_cm3.value_or(0);
    }
    double lambda = 0, mu = 0;
    if (number == 1) {
        lambda = materials_[alone].lambda();
        mu = materials_[alone].mu();
        out.conductivity = materials_[alone].conductivity.value_or(0);
    } else {
        std::vector<double> bulk, shear;
        double poisson = 0, k_mean = 0, g_mean = 0, k_soft = 0, g_soft = 0, conduct = 0, resist = 0;
        for (size_t i = 0; i < f.size(); ++i) {
            const Material& m = materials_[i];
            bulk.push_back(m.bulk());
            shear.push_back(m.mu());
            poisson += f[i] * m.poisson;
            k_mean += f[i] * m.bulk();
            g_mean += f[i] * m.mu();
            k_soft += f[i] / m.bulk();
            g_soft += f[i] / m.mu();
            conduct += f[i] * m.conductivity.value_or(0);
            if (f[i] > 1e-9) resist += f[i] / std::max(m.conductivity.value_or(0), 1e-30);
        }
        double k = k_mean, g = g_mean;
        out.conductivity = conduct;
        if (law_ == Law::kReuss) {
            k = 1 / k_soft;
            g = 1 / g_soft;
            out.conductivity = 1 / resist;
        } else if (law_ == Law::kTable) {
            const double e = table_modulus(f);
            k = e / (3 * (1 - 2 * poisson));
            g = e / (2 * (1 + poisson));
        } else if (law_ != Law::kVoigt) {
            const HsBounds b = hs_bounds(f, bulk, shear);
            std::vector<double> c;
            for (const Material& m : materials_)
                c.push_back(m.conductivity.value_or(0));
            // Hashin and Shtrikman's of conductivities: shifted by 2 of the least or the greatest.
            const auto shifted = [&](double by) {
                double sum = 0;
                for (size_t i = 0; i < f.size(); ++i)
                    if (f[i] > 1e-9) sum += f[i] / std::max(c[i] + by, 1e-30);
                return 1 / sum - by;
            };
            double least = 1e300, most = 0;
            for (size_t i = 0; i < f.size(); ++i)
                if (f[i] > 1e-9) {
                    least = std::min(least, c[i]);
                    most = std::max(most, c[i]);
                }
            const double part = law_ == Law::kHsLower ? 0 : law_ == Law::kHsUpper ? 1 : 0.5;
            k = b.bulk_lower + part * (b.bulk_upper - b.bulk_lower);
            g = b.shear_lower + part * (b.shear_upper - b.shear_lower);
            out.conductivity = shifted(2 * least) + part * (shifted(2 * most) - shifted(2 * least));
        }
        mu = g;
        lambda = k - 2.0 / 3 * g;
    }
    out.lambda = solid * lambda;
    out.mu = solid * mu;
    out.density *= solid;
    out.conductivity *= solid;
    out.strength = known ? strength : 0;
    return out;
}

}  // namespace openfab::mechanics
