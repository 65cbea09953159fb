// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/part/bind_beams.h"

#include "pieces/region.h"
#include "runtime/part/messages.h"
#include "runtime/part/stretch.h"

namespace openfab::part {

Result<void> check_beams(const openfab_fablet& fablet, const std::array<double, 9>& stretch) {
    if (fablet.has_surface != 0) {
        return user_error(messages::kBeamsNotDisplaced, messages::kBeamsNotDisplacedHelp);
    }
    return check_uneven_stretch(stretch, messages::kBeamsUnevenScaleHelp);
}

bool BeamGeometry::stretches_whole(const StretchBy& by) {
    return pieces::uniform_scale(by) == 0;
}

std::shared_ptr<const PartBeams> make_part_beams(std::shared_ptr<const mesh::Beams> beams,
                                                 const openfab_fablet& fablet,
                                                 const std::array<double, 9>& stretch,
                                                 const PartMesh& mesh) {
    auto out = std::make_shared<PartBeams>();
    out->scale = pieces::uniform_scale(stretch);
    out->center_part_mm = mesh.center_part_mm;
    for (int32_t i = 0; i < fablet.nearest_count; ++i) {
        int32_t found = -1;
        for (size_t k = 0; k < beams->attributes.size(); ++k) {
            if (beams->attributes[k].name == fablet.nearest[i].name)
                found = static_cast<int32_t>(k);
        }
        out->attributes.push_back(found);
    }
    out->beams = std::move(beams);
    return out;
}

}  // namespace openfab::part
