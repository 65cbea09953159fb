// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether something stands: its centre of mass over the hull of what it stands on.

#include <array>
#include <vector>

#include "mechanics/part/surface.h"
#include "mechanics/stand/foot.h"

namespace openfab::mechanics {

struct Stand {
    double mass_g = 0, volume_mm3 = 0;
    Vec3 centre_mm{};                            ///< of mass
    std::vector<std::array<double, 2>> hull_mm;  ///< of the contact, against the clock
    double contact_mm2 = 0;
    double floor_mm = 0;  ///< height of the contact
    Foot foot;
    /// By how much it may be tilted, over the weakest edge of what is flat of the foot; below 0 it falls by itself.
    double margin_deg = 0;
    /// Of a part in several, each of which has to stand by itself: `foot` and `margin_deg` are of the one that stands least,
    /// and so is its centre of mass.
    size_t pieces = 1;
    Vec3 of_piece_mm{};

    bool stands() const {
        return foot.kind == Foot::Kind::kStands || foot.kind == Foot::Kind::kRocks;
    }
    /// Looks at the contact and the foot again, in voxels of another size.
    void look_at(const FootLayers& layers);
    /// The same of each piece of what is solid.
    void look_at_pieces(const Grid& grid, const Voxels& voxels, const PartElements& elements,
                        bool known, const FootLayers& layers);

  private:
    /// The lowest layer that is not void.
    void look_at_contact(const FootLayers& layers);
};

/// Densities of `voxels` count, 1 g/cm3 where `known` is false. The contact are the lowest solid elements.
Stand stand_of(const Grid& grid, const Voxels& voxels, const PartElements& elements, bool known);

}  // namespace openfab::mechanics
