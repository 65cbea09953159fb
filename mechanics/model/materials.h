// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What materials are like: a JSON file beside the world,
//
//   {"materials": {"soft": {"E_MPa": 0.6, "nu": 0.48, "strength_MPa": 1, "density_g_cm3": 1.14,
//                           "conductivity_W_mK": 0.2,
//                           "conductivity_S_m": 1e-12, "source": "who measured it"}, ...},
//    "law": "hs-lower", "table": "modulus.json"}
//
// A modulus may be a list of rows at temperatures and rates (base/conditions.h); of a single one, "T_C" and "rate_1_s" say at
// which it was measured.
//
// A table of other names, as those of a fablet's uniforms: "in_table": "soft" of a material says its name there.

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/conditions.h"
#include "base/json.h"
#include "base/result.h"

namespace openfab::mechanics {

struct Material {
    std::string name;
    double young_MPa = 0;
    bool conditioned = false;  ///< at a temperature and a rate that the file says
    double poisson = 0;
    std::optional<double> strength_MPa;  ///< von Mises stress at which it yields or breaks
    std::optional<double> density_g_cm3;
    std::optional<double> conductivity;      ///< of heat, W/(m K)
    std::optional<double> conductivity_S_m;  ///< of current
    std::string source;
    std::string called;  ///< by the table of mixtures; empty: as it is named
    bool used = true;    ///< something is made of it; else what it is like may not be known

    double lambda() const { return young_MPa * poisson / ((1 + poisson) * (1 - 2 * poisson)); }
    double mu() const { return young_MPa / (2 * (1 + poisson)); }
    double bulk() const { return young_MPa / (3 * (1 - 2 * poisson)); }
};

/// How a mixture is as stiff as its materials say.
enum class Law {
    kTable,    ///< measured mixtures, linear between them
    kVoigt,    ///< mean of stiffnesses: no mixture is stiffer
    kReuss,    ///< mean of compliances: none is softer
    kHsLower,  ///< Hashin-Shtrikman's bounds of isotropic mixtures
    kHsUpper,
    kHsMean,
};
inline constexpr const char* kLawNames[] = {"table",    "voigt",    "reuss",
                                            "hs-lower", "hs-upper", "hs-mean"};
std::optional<Law> law_of(const std::string& name);

/// A table of `openfab property`: Young's modulus of mixtures.
struct PropertyTable {
    std::vector<std::string> materials;
    struct Row {
        std::vector<double> mixture;
        double value = 0;
        double deviation = 0;  ///< the standard deviation of its specimens; 0: unknown
    };
    std::vector<Row> rows;
};

struct Properties {
    std::string file;
    std::vector<Material> materials;
    Law law = Law::kHsLower;
    std::optional<PropertyTable> table;
    Conditions asked;  ///< at which moduli are

    const Material* find(const std::string& name) const;
    /// Those of a print, in its order; an error names the first that is used and missing, and what the file
    /// has, or that has no modulus where one is `stiff`.
    Result<std::vector<Material>> of(const std::vector<std::string>& names,
                                     std::span<const uint8_t> used, bool stiff = true) const;
};

Result<Properties> read_properties(const std::filesystem::path& file, const Conditions& asked = {});
Result<PropertyTable> read_property_table(const std::filesystem::path& file,
                                          const Conditions& asked = {});
/// The file that belongs to a world or fablet: NAME.mechanics.json, else mechanics.json beside it.
std::filesystem::path properties_beside(const std::filesystem::path& input);

}  // namespace openfab::mechanics
