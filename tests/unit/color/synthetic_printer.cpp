// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/color/synthetic_printer.h"
#include "tests/support/places/places.h"

#include <cstdlib>

namespace openfab::testing {

color::NominalInks SyntheticPrinter::inks() {
    const Result<color::NominalInks> read =
        color::NominalInks::read(source_dir() / "gallery/ink_profile/vero.csv");
    if (!read) std::abort();
    return *read;
}

}  // namespace openfab::testing
