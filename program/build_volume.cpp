// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/build_volume.h"

#include <fmt/format.h>

#include <algorithm>

#include "program/messages.h"
#include "runtime/solid/kinds/kinds.h"

namespace openfab::program {

namespace {

std::string room_of(const world::Printer& printer) {
    const Vec3d& room = printer.build_volume_mm;
    return fmt::format(messages::kRoomOfPrinter, printer.name, room.x, room.y, room.z);
}

/// The part whose mesh extends farthest along an axis, up or down.
const part::Part* farthest(const std::vector<part::Part>& parts, int axis, bool up) {
    const part::Part* found = nullptr;
    double most = 0;
    for (const part::Part& part : parts) {
        for (const Vec3d& p : part.mesh->positions) {
            const double at = part.local_to_build.apply(p)[axis] * (up ? 1 : -1);
            if (found != nullptr && at <= most) continue;
            most = at;
            found = &part;
        }
    }
    return found;
}

}  // namespace

Box3d tray_box(const world::Printer& printer, world::Tray tray) {
    const Vec3d& room = printer.build_volume_mm;
    Box3d box{{0, 0, 0}, room};
    for (int a = 0; a < 2 && tray == world::Tray::kCenter; ++a) {
        box.lo[a] = -room[a] / 2;
        box.hi[a] = room[a] / 2;
    }
    return box;
}

Result<void> check_build_volume(const pipeline::PrintInfo& info, const world::Printer& printer,
                                const std::vector<part::Part>& parts, world::Tray tray) {
    if (!printer.knows_build_volume()) return {};
    const Vec3d& room = printer.build_volume_mm;
    for (int a = 0; a < 3; ++a) {
        const double size = info.size[a] * info.pitch_mm[a];
        // The grid is rounded out to whole voxels.
        if (size <= room[a] + 2 * info.pitch_mm[a]) continue;
        return user_error(fmt::format(messages::kPrintTooLarge, size, "xyz"[a], size - room[a],
                                      room_of(printer)));
    }
    if (tray == world::Tray::kAnywhere) return {};
    const Box3d box = tray_box(printer, tray);
    for (int a = 0; a < 3; ++a) {
        const double from = box.lo[a];
        const double lo = info.origin_mm[a], hi = lo + info.size[a] * info.pitch_mm[a];
        const double below = from - lo, above = hi - box.hi[a];
        if (std::max(below, above) <= info.pitch_mm[a]) continue;
        const bool up = above > below;
        const part::Part* part = farthest(parts, a, up);
        const char* const outside =
            solid::reach_is_known(*part) ? messages::kPartOutsideTray : messages::kBoxOutsideTray;
        return user_error(fmt::format(fmt::runtime(outside), part->name, part->instance,
                                      std::max(below, above), up ? '+' : '-', "xyz"[a],
                                      room_of(printer), from, box.hi[a]));
    }
    return {};
}

}  // namespace openfab::program
