// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Colours of spectra: how much of each wavelength a patch reflects, seen by the CIE 1931 observer of 2
// degrees under a light.

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "tools/color/lab.h"

namespace openfab::color {

/// What patches are looked at under.
enum class Light { kD50, kD65 };

/// Wavelengths at equal steps, in nm.
struct Wavelengths {
    double first = 0, step = 0;
    size_t count = 0;
    /// Fails for what is too coarse, or leaves out too much of what the eye sees: steps of up to 20 nm
    /// from 400 or less to 700 or more.
    Result<void> check() const;
};

/// Returns the colour of reflectances, 1 for all of the light; between wavelengths by cubics, beyond them as
/// at the last. Lab is relative to the light's own white.
Lab lab_of_spectrum(const Wavelengths& at, const std::vector<double>& reflected, Light light);

/// What the largest of some reflectances says of their unit: 1, or 100 for percent.
double unit_of_reflectances(double largest);

/// Finds the columns of spectra in a table: a wavelength, alone or behind a word that is in use for it
/// (`SPEC_380`, `SPECTRAL_NM380`, `nm380`, `380nm`, `R380`, …), in any case.
class SpectralColumns {
  public:
    /// Fails where they are not at equal steps, or one is there twice.
    static Result<SpectralColumns> find(const std::vector<std::string>& columns);

    bool there() const { return !columns_.empty(); }
    /// In the order of wavelengths.
    const std::vector<int>& columns() const { return columns_; }
    const Wavelengths& wavelengths() const { return wavelengths_; }
    /// What the names say of the unit, as unit_of_reflectances; nothing where they say nothing.
    const std::optional<double>& unit() const { return unit_; }

  private:
    std::vector<int> columns_;
    Wavelengths wavelengths_;
    std::optional<double> unit_;
};

}  // namespace openfab::color
