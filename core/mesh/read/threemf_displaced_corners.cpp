// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_displaced_corners.h"

#include <fmt/format.h>

#include <array>
#include <iterator>
#include <optional>

#include "mesh/read/messages.h"

namespace openfab::mesh {

Complaint ThreemfDisplacedCorners::set(const ThreemfDisplacements& all, const ThreemfObject& object,
                                       const Affine3d& transform, size_t t, bool mirrored) {
    const std::optional<size_t> where = mesh_.attribute("displace", 4);
    const std::optional<size_t> along = mesh_.attribute("displace_n", 3);
    if (!where || !along) return {};
    std::array<int32_t, 3> places{}, ways{};
    if (object.displaced == nullptr || object.displaced->triangles[t].points[0] < 0) {
        const auto [none, fresh] = values_.try_emplace({-1, -1}, -1, -1);
        const double zeros[] = {0, 0, 0, 0}, up[] = {0, 0, 1};
        if (fresh) none->second = {mesh_.add_value(*where, zeros), mesh_.add_value(*along, up)};
        places.fill(none->second.first);
        ways.fill(none->second.second);
    } else {
        const ThreemfDisplaced::Triangle& of = object.displaced->triangles[t];
        const int64_t named = of.group >= 0 ? of.group : object.displaced->group;
        const auto group = all.groups.find(all.group_of(named));
        if (group == all.groups.end())
            return fmt::format(messages::kNoSuchDisplacement, object.name, named);
        const auto directions = all.directions.find(group->second.directions);
        const double number = static_cast<double>(std::distance(all.groups.begin(), group) + 1);
        for (size_t c = 0; c < 3; ++c) {
            const auto point = static_cast<size_t>(of.points[c]);
            const bool known = point < group->second.points.size() &&
                               directions != all.directions.end() &&
                               static_cast<size_t>(group->second.points[point].direction) <
                                   directions->second.size();
            if (!known)
                return fmt::format(messages::kNoSuchDisplacedPoint, object.name, point,
                                   group->first);
            const auto [values, fresh] =
                values_.try_emplace({group->first, static_cast<int64_t>(point)}, -1, -1);
            if (fresh) {
                const ThreemfDisplacementPoint& p = group->second.points[point];
                const Vec3d n =
                    transform.apply_vector(directions->second[static_cast<size_t>(p.direction)]);
                const double four[] = {p.u, p.v, p.factor, number};
                const double three[] = {n.x, n.y, n.z};
                values->second = {mesh_.add_value(*where, four), mesh_.add_value(*along, three)};
            }
            places[c] = values->second.first;
            ways[c] = values->second.second;
        }
    }
    if (mirrored) {
        std::swap(places[1], places[2]);
        std::swap(ways[1], ways[2]);
    }
    mesh_.set_corners(*where, places);
    mesh_.set_corners(*along, ways);
    return {};
}

}  // namespace openfab::mesh
