// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/load/jailed.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/input_file.h"
#include "base/messages.h"
#include "mesh/read/beside_files.h"

namespace openfab {

namespace mesh {

// Of each type one function for both ends (base/jail_line.h). What is not named here keeps its first value: checks, which
// come later.

void pass(JailLine* line, MeshAttribute* a) {
    pass(line, &a->name);
    pass(line, &a->is_int);
    pass(line, &a->components);
    pass(line, &a->values);
    pass(line, &a->corners);
    pass(line, &a->faces);
}

void pass(JailLine* line, FaceGroup* group) {
    pass(line, &group->names);
    pass(line, &group->material);
    pass(line, &group->look);
    pass(line, &group->body);
}

void pass(JailLine* line, PictureUse* use) {
    pass(line, &use->source);
    pass(line, &use->name);
    pass(line, &use->wrap);
    pass(line, &use->alpha);
    pass(line, &use->mask_from);
    pass(line, &use->nearest);
    pass(line, &use->space);
}

void pass(JailLine* line, Look* look) {
    pass(line, &look->name);
    pass(line, &look->color);
    pass(line, &look->alpha);
    pass(line, &look->vertex_colors);
    pass(line, &look->picture);
    pass(line, &look->tinted);
    pass(line, &look->mixture);
    pass(line, &look->is_material);
}

void pass(JailLine* line, Body* body) {
    pass(line, &body->name);
    pass(line, &body->role);
    pass(line, &body->assembly);
}

void pass(JailLine* line, LeftOut* left_out) {
    pass(line, &left_out->what);
    pass(line, &left_out->place);
    pass(line, &left_out->remedy);
    pass(line, &left_out->count);
    pass(line, &left_out->kind);
}

void pass(JailLine* line, MeshSource* source) {
    pass(line, &source->mesh.name);
    pass(line, &source->mesh.positions);
    pass(line, &source->mesh.triangles);
    pass(line, &source->mesh.attributes);
    pass(line, &source->origin.file);
    pass(line, &source->origin.lines);
    pass(line, &source->unit_mm);
    std::vector<FaceGroup> groups = source->groups;
    pass(line, &groups);
    // No two are equal: each gets its own index again.
    for (const FaceGroup& group : groups)
        if (!line->sends()) (void)source->group_index(group);
    pass(line, &source->face_groups);
    pass(line, &source->part_of_vertex);
    pass(line, &source->files);
    pass(line, &source->warnings);
    pass(line, &source->looks);
    pass(line, &source->bodies);
    pass(line, &source->left_out);
    pass(line, &source->corners_joined);
    if (!line->sends() && line->fine() && !makes_sense(*source)) line->fail();
}

void pass(JailLine* line, BeamAttribute* a) {
    pass(line, &a->name);
    pass(line, &a->is_int);
    pass(line, &a->components);
    pass(line, &a->values);
    pass(line, &a->ints);
}

void pass(JailLine* line, LoadedBeams* read) {
    pass(line, &read->beams.nodes);
    pass(line, &read->beams.beams);
    pass(line, &read->beams.attributes);
    pass(line, &read->warnings);
    if (!line->sends() && line->fine() && !makes_sense(read->beams)) line->fail();
}

void pass(JailLine* line, LatticeInfo* lattice) {
    pass(line, &lattice->name);
    pass(line, &lattice->sets);
    pass(line, &lattice->box_mm);
    pass(line, &lattice->beams);
}

void pass(JailLine* line, LoadedLattices* read) {
    pass(line, &read->lattices);
    pass(line, &read->has_meshes);
    pass(line, &read->unit_mm);
    pass(line, &read->left_out);
}

/// The bytes of a picture, or why there are none.
struct TakenPicture {
    std::string bytes;
    std::optional<Error> error;
};

void pass(JailLine* line, TakenPicture* picture) {
    pass(line, &picture->bytes);
    pass(line, &picture->error);
}

namespace {

/// Whether all numbers are below a count; -1, too, where `none` may be meant.
template <size_t n>
bool all_below(const std::vector<std::array<int32_t, n>>& lists, size_t count, bool none) {
    // One comparison for each: as unsigned numbers negative ones are large.
    const uint32_t shift = none ? 1 : 0;
    const uint64_t end = count + shift;
    uint32_t largest = 0;
    for (const std::array<int32_t, n>& list : lists) {
        for (const int32_t i : list)
            largest = std::max(largest, static_cast<uint32_t>(i) + shift);
    }
    return lists.empty() || largest < end;
}

bool all_below(const std::vector<int32_t>& list, size_t count) {
    return std::all_of(list.begin(), list.end(),
                       [&](int32_t i) { return i >= 0 && static_cast<size_t>(i) < count; });
}

/// A list for each triangle or vertex may be missing.
bool is_whole(size_t size, size_t count) {
    return size == 0 || size == count;
}

template <typename Enum>
bool is_one_of(Enum value, Enum last) {
    return static_cast<int>(value) >= 0 && static_cast<int>(value) <= static_cast<int>(last);
}

bool makes_sense(const MeshAttribute& a, size_t triangles) {
    constexpr int32_t kMostComponents = 16;
    if (a.components < 1 || a.components > kMostComponents) return false;
    const auto components = static_cast<size_t>(a.components);
    if (a.is_int) return a.faces.size() == components * triangles;
    return a.values.size() % components == 0 && a.corners.size() == triangles &&
           all_below(a.corners, a.values.size() / components, true);
}

bool makes_sense(const Look& look, size_t looks) {
    for (const auto& [other, share] : look.mixture) {
        if (other < 0 || static_cast<size_t>(other) >= looks) return false;
    }
    return !look.picture || (is_one_of(look.picture->wrap[0], PictureWrap::kNone) &&
                             is_one_of(look.picture->wrap[1], PictureWrap::kNone) &&
                             is_one_of(look.picture->alpha, PictureUse::Alpha::kMask) &&
                             is_one_of(look.picture->space, PictureUse::Space::kLinear));
}

}  // namespace

bool makes_sense(const MeshSource& source) {
    const Mesh& mesh = source.mesh;
    const size_t triangles = mesh.triangles.size();
    if (!all_below(mesh.triangles, mesh.positions.size(), false)) return false;
    if (!is_whole(source.origin.lines.size(), triangles) ||
        !is_whole(source.face_groups.size(), triangles) ||
        !is_whole(source.part_of_vertex.size(), mesh.positions.size()))
        return false;
    if (!all_below(source.face_groups, source.groups.size())) return false;
    for (const MeshAttribute& a : mesh.attributes) {
        if (!makes_sense(a, triangles)) return false;
    }
    for (const FaceGroup& group : source.groups) {
        if (group.look < -1 || group.look >= static_cast<int64_t>(source.looks.size()) ||
            group.body < 0 ||
            static_cast<size_t>(group.body) >= std::max<size_t>(1, source.bodies.size()))
            return false;
    }
    return std::all_of(source.looks.begin(), source.looks.end(),
                       [&](const Look& look) { return makes_sense(look, source.looks.size()); }) &&
           std::all_of(source.bodies.begin(), source.bodies.end(),
                       [](const Body& b) { return is_one_of(b.role, BodyRole::kNotPrinted); }) &&
           std::all_of(source.left_out.begin(), source.left_out.end(), [](const LeftOut& l) {
               return is_one_of(l.kind, LeftOutKind::kDisplacements);
           });
}

bool makes_sense(const Beams& beams) {
    for (const Beam& beam : beams.beams) {
        for (const int32_t node : beam.nodes)
            if (node < 0 || static_cast<size_t>(node) >= beams.nodes.size()) return false;
        for (const BeamEnd end : beam.ends)
            if (!is_one_of(end, BeamEnd::kDome)) return false;
    }
    return std::all_of(beams.attributes.begin(), beams.attributes.end(),
                       [&](const BeamAttribute& a) {
                           if (a.components < 1 || a.components > 16) return false;
                           const auto components = static_cast<size_t>(a.components);
                           return a.is_int ? a.ints.size() == components * beams.beams.size()
                                           : a.values.size() == components * beams.nodes.size();
                       });
}

JailLimits reading_limits(const std::filesystem::path& file, int64_t memory_bytes) {
    JailLimits limits;
    limits.memory_bytes = memory_bytes;
    limits.reads = {without_links(file), without_links(folder_of(file))};
    return limits;
}

Result<MeshSource> mesh_from_jail(const std::filesystem::path& file, int64_t memory_bytes,
                                  const std::function<Result<MeshSource>()>& read) {
    return read_in_jail<MeshSource>(file, reading_limits(file, memory_bytes), read);
}

Result<LoadedBeams> beams_from_jail(const std::filesystem::path& file, int64_t memory_bytes,
                                    const std::function<Result<LoadedBeams>()>& read) {
    return read_in_jail<LoadedBeams>(file, reading_limits(file, memory_bytes), read);
}

Result<LoadedLattices> lattices_from_jail(const std::filesystem::path& file, int64_t memory_bytes,
                                          const std::function<Result<LoadedLattices>()>& read) {
    return read_in_jail<LoadedLattices>(file, reading_limits(file, memory_bytes), read);
}

Result<void> pictures_from_jail(const std::filesystem::path& file, int64_t memory_bytes,
                                size_t count, const TakePicture& take,
                                const std::function<Result<void>(const TakePicture&)>& read) {
    const auto collect = [&]() -> Result<std::vector<TakenPicture>> {
        std::vector<TakenPicture> pictures(count);
        const Result<void> done = read([&](size_t i, Result<std::string> bytes) {
            if (bytes)
                pictures[i].bytes = std::move(*bytes);
            else
                pictures[i].error = bytes.error();
        });
        if (!done) return done.error();
        return pictures;
    };
    Result<std::vector<TakenPicture>> pictures =
        read_in_jail<std::vector<TakenPicture>>(file, reading_limits(file, memory_bytes), collect);
    if (!pictures) return pictures.error();
    if (pictures->size() != count)
        return user_error(fmt::format(openfab::messages::kReaderNonsense, file.string()));
    for (size_t i = 0; i < count; ++i) {
        TakenPicture& one = (*pictures)[i];
        take(i, one.error ? Result<std::string>(*one.error)
                          : Result<std::string>(std::move(one.bytes)));
    }
    return {};
}

}  // namespace mesh
}  // namespace openfab
