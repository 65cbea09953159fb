// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/extents.h"

#include <array>
#include <map>
#include <tuple>
#include <vector>

#include "abi/kernel_call.h"
#include "backends/common/output_file.h"
#include "base/json_text.h"
#include "program/job.h"
#include "runtime/part/bind.h"
#include "runtime/solid/kinds/kinds.h"
#include "world/placed_box.h"

namespace openfab::program {

namespace {

void add_vector(const Vec3d& v, JsonText* out) {
    out->begin_array().value(v.x).value(v.y).value(v.z).end_array();
}

void add_box(const char* key, const Box3d& box, JsonText* out) {
    out->key(key).begin_array();
    add_vector(box.lo, out);
    add_vector(box.hi, out);
    out->end_array();
}

}  // namespace

Result<void> write_extents(const Options& options, const openfab_fablet_list& fablets) {
    const Result<world::World> world = load_whole_world(options, fablets);
    if (!world) return world.error();
    const Result<std::vector<part::Part>> parts =
        part::bind(*world, fablets, {options.settings, options.memory_bytes});
    if (!parts) return parts.error();
    const openfab_isa isa = abi::best_isa(options.isa.value_or(OPENFAB_ISA_AVX512));
    // Only for lookup, never iterated: the order of pointers must not affect results.
    std::map<std::tuple<const void*, const part::Piece*, std::array<double, 9>>, Box3d> known;
    JsonText out;
    out.begin_array();
    for (size_t i = 0; i < parts->size(); ++i) {
        part::Part part = (*parts)[i];
        if (!world::asks_solid(*world, world->build[i])) {
            out.null();
            continue;
        }
        const Vec3d at = world->build[i].transform.t;
        const std::array<double, 9> turn = part.local_to_build.m;
        const auto extent = [&](const std::array<double, 9>& m) -> Result<Box3d> {
            const auto [found, fresh] =
                known.try_emplace({part::shared_geometry(part), part.piece.get(), m});
            if (!fresh) return found->second;
            part.local_to_build.m = m;
            part.local_to_build.t = Affine3d{m, {}}.apply(part.mesh->center_part_mm);
            Result<Box3d> box = solid::extent_in_build(part, isa);
            if (box) found->second = *box;
            return box;
        };
        const Result<Box3d> turned = extent(turn), own = extent({1, 0, 0, 0, 1, 0, 0, 0, 1});
        if (!turned) return turned.error();
        if (!own) return own.error();
        out.begin_object().key("at_mm");
        add_vector(at, &out);
        add_box("extent_mm", *turned, &out);
        add_box("own_mm", *own, &out);
        out.end_object();
    }
    out.end_array();
    return backends::write_whole_file(options.extents_file, out.take());
}

}  // namespace openfab::program
