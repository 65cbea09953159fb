// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Measurements as data that `openfab property` and `openfab mechanics` read.

#include <map>
#include <string>
#include <vector>

#include "base/conditions.h"
#include "base/result.h"
#include "tools/specimens/measured.h"

namespace openfab::specimens {

/// Who measured it, and at which temperature and rate: both, or neither where that is not known.
struct Origin {
    std::string source;
    Conditions conditions;
};

struct DataFile {
    std::string name, text;
};

struct Tables {
    std::vector<DataFile> files;
    std::vector<std::string> notes;  ///< what is left out, and why
};

/// Writes `modulus.json`, `strength.json` and `strain_at_break.json`, each where its means rise or fall from kind to kind
/// as tables must; and of mixtures `mechanics.json`, where each material has been measured alone and has a Poisson's
/// ratio in `poisson`. Rows carry their standard deviation and count.
Result<Tables> tables(const List& list, const Measurements& measured, const Origin& origin,
                      const std::map<std::string, double>& poisson);

}  // namespace openfab::specimens
