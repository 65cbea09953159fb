// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/split_seam.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "base/near_miss.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

Result<std::function<double(const Vec3d&)>> seam_of(const mesh::Mesh& mesh, const std::string& name,
                                                    const std::array<double, 9>& stretch) {
    const mesh::MeshAttribute* found = mesh.find(name);
    if (found == nullptr || found->is_int) {
        std::vector<std::string> names;
        for (const mesh::MeshAttribute& a : mesh.attributes) {
            if (!a.is_int) names.push_back(a.name);
        }
        return user_error(fmt::format(messages::kNoSeamAttribute, name, mesh.name),
                          names.empty() ? messages::kNoSeamAttributeHelp : suggest(name, names));
    }
    // A coarse table of corners: by cell the mean of their values.
    Box3d box;
    const Affine3d map{stretch, {}};
    for (const Vec3d& p : mesh.positions)
        box.add(map.apply(p));
    const double cell = std::max(box.longest_side() / 96, 1e-6);
    using Key = std::array<int32_t, 3>;
    auto sums = std::make_shared<std::map<Key, std::pair<double, int>>>();
    const auto key = [lo = box.lo, cell](const Vec3d& p) {
        return Key{static_cast<int32_t>((p.x - lo.x) / cell),
                   static_cast<int32_t>((p.y - lo.y) / cell),
                   static_cast<int32_t>((p.z - lo.z) / cell)};
    };
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (size_t c = 0; c < 3; ++c) {
            const auto at = static_cast<size_t>(mesh.triangles[t][c]);
            const auto value = static_cast<size_t>(found->corners[t][c]);
            auto& sum = (*sums)[key(map.apply(mesh.positions[at]))];
            sum.first += double{found->values[value * static_cast<size_t>(found->components)]};
            ++sum.second;
        }
    }
    return std::function<double(const Vec3d&)>([sums, key](const Vec3d& p) {
        const Key middle = key(p);
        for (int32_t r = 0; r < 4; ++r) {
            double sum = 0;
            int count = 0;
            for (int32_t x = -r; x <= r; ++x) {
                for (int32_t y = -r; y <= r; ++y) {
                    for (int32_t z = -r; z <= r; ++z) {
                        const auto at = sums->find({middle[0] + x, middle[1] + y, middle[2] + z});
                        if (at == sums->end()) continue;
                        sum += at->second.first, count += at->second.second;
                    }
                }
            }
            if (count > 0) return std::clamp(sum / count, 0.0, 1e3);
        }
        return 1.0;
    });
}

}  // namespace openfab::tools
