// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/model/mesh_source.h"

#include <fmt/format.h>

#include "mesh/model/messages.h"

namespace openfab::mesh {

SourceLocation MeshOrigin::location(int32_t triangle) const {
    if (triangle < 0 || static_cast<size_t>(triangle) >= lines.size()) return {file, 0, 0};
    return {file, lines[triangle], 1};
}

std::string MeshSource::location(const Vec3d& mm) const {
    std::string text = fmt::format("({:.6g}, {:.6g}, {:.6g}) mm", mm.x, mm.y, mm.z);
    if (unit_mm <= 0 || unit_mm == 1) return text;
    const Vec3d file = mm * (1 / unit_mm);
    return text + fmt::format(messages::kPlaceInFile, file.x, file.y, file.z);
}

std::string describe(const LeftOut& left_out) {
    std::string where;
    if (left_out.count > 1) where = fmt::format("{} times", left_out.count);
    if (!left_out.place.empty()) {
        where +=
            fmt::format("{}{}", left_out.count > 1 ? messages::kFirstAt : "at ", left_out.place);
    }
    return fmt::format(messages::kLeftOut, left_out.what,
                       where.empty() ? "" : fmt::format(" ({})", where),
                       left_out.remedy.empty() ? "" : "; " + left_out.remedy);
}

void MeshSource::leave_out(const std::string& what, const std::string& place,
                           const std::string& remedy) {
    for (LeftOut& known : left_out) {
        if (known.what != what) continue;
        ++known.count;
        return;
    }
    // Names from the file may make each one different.
    constexpr size_t kMost = 200;
    if (left_out.size() < kMost) left_out.push_back({what, place, remedy, 1});
}

int32_t MeshSource::group_index(const FaceGroup& group) {
    const auto [it, fresh] = group_indices_.emplace(group, static_cast<int32_t>(groups.size()));
    if (fresh) {
        groups.push_back(group);
        constexpr size_t kNode = 64;  // of the map
        size_t bytes = 2 * sizeof(FaceGroup) + kNode + 2 * group.material.size();
        for (const std::string& name : group.names)
            bytes += 2 * (sizeof name + name.size());
        group_bytes_ += static_cast<int64_t>(bytes);
    }
    return it->second;
}

}  // namespace openfab::mesh
