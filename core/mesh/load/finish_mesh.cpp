// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/load/finish_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "mesh/check/mesh_check.h"
#include "mesh/check/mesh_intersections.h"
#include "mesh/load/face_numbers.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/model/messages.h"

namespace openfab::mesh {
namespace {

/// Triangles up to which each load looks for crossing ones.
constexpr size_t kMaxChecked = 200'000;

/// y up, z to the viewer -> z up, y away; as glTF is read.
void stand_up(Mesh* mesh) {
    for (Vec3d& p : mesh->positions)
        p = {p.x, 0 - p.z, p.y};
    for (MeshAttribute& a : mesh->attributes) {
        if (a.name != "n" || a.components != 3) continue;
        for (size_t i = 0; i + 2 < a.values.size(); i += 3) {
            const float y = a.values[i + 1];
            a.values[i + 1] = 0 - a.values[i + 2];
            a.values[i + 2] = y;
        }
    }
}

void look_for_intersections(MeshSource* source) {
    const Intersections found = find_intersections(source->mesh);
    source->checks.intersections = found.pairs;
    source->checks.all_intersections = found.all;
    if (found.pairs == 0 || source->checks.overlapping > 0) return;  // which says the same
    source->warnings.push_back(
        fmt::format(messages::kIntersectsItself, source->origin.str(found.first), source->mesh.name,
                    found.all ? "" : messages::kAtLeast, found.pairs, found.pairs == 1 ? "" : "s",
                    source->location(found.point)));
}

}  // namespace

Unit unit_of(MeshSource* source, const MeshOptions& options) {
    if (options.unit_mm) return {*options.unit_mm, messages::kUnitAsAsked};
    if (source->unit_mm > 0) return {source->unit_mm, messages::kUnitOfFile};
    Box3d box;
    for (const auto& t : source->mesh.triangles) {
        for (int32_t v : t)
            box.add(source->mesh.positions[v]);
    }
    const Vec3d size = box.empty() ? Vec3d{} : box.size();
    const double largest = std::max({size.x, size.y, size.z});
    // Nobody prints a part below a millimetre, and many programs write metres.
    if (!(largest > 0 && largest < 1)) return {1, messages::kUnitAssumed};
    source->warnings.push_back(fmt::format(messages::kUnitGuessed, source->origin.file,
                                           options.name, size.x, size.y, size.z));
    source->of_size.push_back(source->warnings.back());
    return {1000, messages::kUnitFromSize};
}

Result<LoadedMesh> finish_mesh(MeshSource source, const std::vector<Look>& looks, const Unit& unit,
                               const MeshOptions& options, bool tolerant) {
    LoadedMesh out;
    source.mesh.name = options.name;
    out.files = std::move(source.files);
    complete_attributes(looks, &source);
    const MeshCounts counts = counts_of(source);
    out.peak_bytes = preparing_bytes(counts);
    if (out.peak_bytes > options.memory_bytes) {
        return too_large_to_read(source.origin.file, counts.triangles, out.peak_bytes,
                                 options.memory_bytes);
    }
    Result<FaceNumbers> numbers = number_faces(&source, options);
    if (!numbers) return numbers.error();
    out.groups = std::move(numbers->groups);
    out.look_of = std::move(numbers->look_of);
    out.unit_mm = source.unit_mm = unit.mm;
    out.unit_note = unit.note;
    for (Vec3d& p : source.mesh.positions)
        p = p * unit.mm;
    source.corners_apart = source.corners_joined && unit.mm == 1 && options.origin_mm == Vec3d{};
    if (options.y_up) stand_up(&source.mesh);
    if (options.origin_mm != Vec3d{}) {
        for (Vec3d& p : source.mesh.positions)
            p = p - options.origin_mm;
    }
    Result<void> fine = prepare_mesh(&source, options.repair);
    if (!fine) {
        if (!tolerant) return fine.error();
        out.refusal = fine.error().text();
    }
    if (tolerant || source.mesh.triangles.size() <= kMaxChecked) look_for_intersections(&source);
    std::move(source.warnings.begin(), source.warnings.end(), std::back_inserter(out.warnings));
    out.of_size = std::move(source.of_size);
    out.checks = source.checks;
    out.mesh = std::move(source.mesh);
    return out;
}

}  // namespace openfab::mesh
