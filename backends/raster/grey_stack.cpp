// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/grey_stack.h"

#include <fmt/format.h>

#include "backends/raster/folder_sink.h"
#include "backends/raster/grey_slice.h"
#include "backends/raster/messages.h"
#include "base/check.h"
#include "base/near_miss.h"

namespace openfab::raster {

Result<int32_t> GreyStack::open(const pipeline::PrintInfo& info, int32_t materials) {
    info_ = info;
    const int32_t material = grey_material(info, options_);
    if (material < 0 || material >= materials) {
        std::vector<std::string> names;
        for (int32_t m = 0; m < materials; ++m)
            names.push_back(info.materials[static_cast<size_t>(m)].name);
        return user_error(fmt::format(messages::kNoGreyPartMaterial, options_.grey_material,
                                      suggest(options_.grey_material, names)));
    }
    material_ = static_cast<size_t>(material);
    materials_ = static_cast<size_t>(materials);
    if (Result<void> begun = folder_->begin(info); !begun) return begun.error();
    return static_cast<FolderSink&>(*folder_).keep();
}

Result<void> GreyStack::begin(const pipeline::PrintInfo&, int32_t materials) {
    OPENFAB_CHECK_EQ(materials_, static_cast<size_t>(materials));
    return {};
}

void GreyStack::write(int32_t z, int32_t y, int32_t first_x, std::span<const float> fractions) {
    const auto width = static_cast<size_t>(info_.size.x);
    std::vector<float>& plane = planes_[z];
    if (plane.empty()) plane.resize(width * static_cast<size_t>(info_.size.y));
    float* to = plane.data() + static_cast<size_t>(y) * width + static_cast<size_t>(first_x);
    for (size_t at = material_; at < fractions.size(); at += materials_)
        *to++ = fractions[at];
}

Result<void> GreyStack::passed(int32_t z) {
    auto node = planes_.extract(z);
    std::vector<float> plane;
    if (!node.empty()) plane = std::move(node.mapped());
    plane.resize(static_cast<size_t>(info_.size.x) * static_cast<size_t>(info_.size.y));
    return folder_->commit(z, encode_grey(plane, info_, options_));
}

Result<void> GreyStack::finish(const pipeline::PrintTotals& totals) {
    // Its folder was begun only if the material is one of the print's.
    return materials_ == 0 ? Result<void>() : folder_->finish(totals);
}

}  // namespace openfab::raster
