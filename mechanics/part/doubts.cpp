// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/doubts.h"

#include <fmt/format.h>

#include <algorithm>

#include "mechanics/messages.h"

namespace openfab::mechanics {

std::vector<std::string> condition_doubts(std::span<const Material> materials,
                                          const Properties& properties) {
    if (properties.law == Law::kTable) return {};
    const Conditions& asked = properties.asked;
    constexpr double kSoftMPa = 50;  // rubbers; a rigid resin's modulus varies by tens of percent
    std::vector<std::string> out;
    for (const Material& m : materials) {
        if (m.conditioned || !m.used || !(m.young_MPa > 0)) continue;
        if (asked.temperature_C || asked.rate_1_s) {
            out.push_back(fmt::format(messages::kUnconditioned, m.name));
        } else if (m.young_MPa < kSoftMPa) {
            out.push_back(fmt::format(messages::kSoftUnconditioned, m.name));
        }
    }
    return out;
}

std::vector<std::string> table_doubts(const Properties& properties) {
    if (properties.law != Law::kTable || !properties.table) return {};
    double most = 0;
    for (const PropertyTable::Row& row : properties.table->rows)
        most = std::max(most, row.deviation / row.value);
    if (!(most > 0)) return {};
    return {fmt::format(messages::kTableScatters, 100 * most)};
}

std::vector<std::string> unit_doubts(std::span<const Material> materials) {
    std::vector<std::string> out;
    for (const Material& m : materials) {
        const auto most = [&](const char* key, double value, double limit, const char* of,
                              const char* unit) {
            if (value > limit)
                out.push_back(
                    fmt::format(messages::kMoreThanAnySolid, m.name, key, value, of, limit, unit));
        };
        const auto least = [&](const char* key, double value, double limit, const char* of,
                               const char* unit) {
            if (value > 0 && value < limit)
                out.push_back(
                    fmt::format(messages::kLessThanAnySolid, m.name, key, value, of, limit, unit));
        };
        const double strength = m.strength_MPa.value_or(0);
        most("E_MPa", m.young_MPa, 1.3e6, "diamond", "MPa, not Pa");
        least("E_MPa", m.young_MPa, 1e-4, "a gel", "MPa, not GPa");
        most("strength_MPa", strength, 2e4, "a whisker of carbon", "MPa, not Pa");
        // Rubber stretches to many times its length, so that its strength is above its modulus; what is rigid
        // breaks at a few hundredths of it.
        constexpr double kRigid = 500, kBreaks = 0.5, kWeak = 5e-5;
        if (m.young_MPa > kRigid && strength > kBreaks * m.young_MPa && strength <= 2e4)
            out.push_back(
                fmt::format(messages::kStrengthAsStiffness, m.name, strength, m.young_MPa));
        if (strength > 0 && strength < kWeak * m.young_MPa && m.young_MPa <= 1.3e6)
            out.push_back(fmt::format(messages::kStrengthTiny, m.name, strength, m.young_MPa));
        const double density = m.density_g_cm3.value_or(0);
        most("density_g_cm3", density, 22.7, "osmium", "g/cm3, not kg/m3");
        least("density_g_cm3", density, 1e-4, "an aerogel", "g/cm3, not t/mm3");
        most("conductivity_W_mK", m.conductivity.value_or(0), 5000, "graphene", "W/(m K)");
        least("conductivity_W_mK", m.conductivity.value_or(0), 0.003, "an aerogel", "W/(m K)");
        most("conductivity_S_m", m.conductivity_S_m.value_or(0), 7e7, "silver", "S/m");
    }
    return out;
}

}  // namespace openfab::mechanics
