// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/vtk_image.h"

#include <fmt/format.h>

#include <cmath>

#include "tools/texture/messages.h"

namespace openfab::tools {

Result<Vec3i> image_size(const VtkImage& image, bool of_points, double unit, GridFrame* frame) {
    Vec3i size;
    const auto& d = image.direction;
    Vec3d first{image.origin[0] * unit, image.origin[1] * unit, image.origin[2] * unit};
    for (int a = 0; a < 3; ++a) {
        const auto i = static_cast<size_t>(a);
        const double low = image.extent[2 * i], high = image.extent[2 * i + 1];
        // A layer of cells may be as thin as its points.
        const bool between = !of_points && high > low;
        const double count = high - low + (between ? 0 : 1);
        if (!(count >= 1 && count <= 16384 && low == std::floor(low) && high == std::floor(high)))
            return user_error(fmt::format(messages::kExtentNotPossible, low, high));
        if (!(std::abs(image.spacing[i]) > 0)) return user_error(messages::kSpacingIsZero);
        size[a] = static_cast<int32_t>(count);
        const Vec3d step = Vec3d{d[i], d[3 + i], d[6 + i]} * (image.spacing[i] * unit);
        frame->steps[i] = step;
        first = first + step * (low + (between ? 0.5 : 0));
    }
    frame->first = first;
    return size;
}

}  // namespace openfab::tools
