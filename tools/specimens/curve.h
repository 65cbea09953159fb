// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a testing machine wrote of one specimen: its stress over its strain.

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"

namespace openfab::specimens {

struct CurveOptions {
    std::string strain, stress;  ///< a column's name or number, from 1; empty: as their names say
    double area_mm2 = 1;         ///< by which forces are divided
    double length_mm = 1;        ///< by which extensions are divided
    double from = 0.0005,
           to = 0.0025;  ///< strains between which the modulus is the slope; ISO 527-1's
};

struct Curve {
    std::vector<double> strain, stress_MPa;
    bool extension = false;  ///< the strain is an extension by CurveOptions::length_mm
};

/// Reads columns of strain or extension and of stress or force, with their units in the header or in the row below it.
/// Compression is turned to be positive. Errors name the file and the line.
Result<Curve> read_curve(const std::filesystem::path& file, const CurveOptions& options);

struct Properties {
    double modulus_MPa = 0, strength_MPa = 0, strain_at_break = 0;
};

/// The modulus is the slope of the least squares between the strains of the options, of the rise before the greatest
/// stress; the strength is the greatest stress; the break is the last strain with a tenth of that.
Result<Properties> properties_of(const Curve& curve, const std::string& file,
                                 const CurveOptions& options);

}  // namespace openfab::specimens
