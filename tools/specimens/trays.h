// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Worlds with test pieces in rows, a world a tray.

#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "tools/specimens/list.h"

namespace openfab::specimens {

/// Values of uniforms are JSON.
using Uniforms = std::vector<std::pair<std::string, std::string>>;

struct Trays {
    const Piece* piece = nullptr;
    double thickness_mm = 0;
    char along = 'x';  ///< the axis of the tray along which pieces are pulled or pressed
    double gap_mm = 5;
    int copies = 5;
    Vec3d tray_mm;          ///< 0: unknown
    std::string printer;    ///< as a world names it
    std::string materials;  ///< of the world, JSON
    std::string label_material;
    std::string source, fablet;
    Uniforms uniforms;               ///< of all
    std::vector<Uniforms> variants;  ///< of each kind of piece
    /// What the list says of each kind.
    std::vector<std::string> columns;
    std::vector<std::vector<std::string>> values;
    bool mixtures = true;
};

struct MadeTrays {
    std::vector<std::string> worlds;
    List list;
};

/// Copies of one kind lie apart, so that a tray's corners do not decide for one of them: all kinds once, then all again.
/// Fails where not even one piece fits.
Result<MadeTrays> make_trays(const Trays& request);

}  // namespace openfab::specimens
