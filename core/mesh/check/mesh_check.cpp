// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/check/mesh_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <ranges>
#include <tuple>

#include "base/check.h"
#include "base/keyed_hash.h"
#include "base/large_pages.h"
#include "mesh/check/mesh_edges.h"
#include "mesh/check/mesh_repair.h"
#include "mesh/check/mesh_shells.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/model/messages.h"

namespace openfab::mesh {
namespace {

const Vec3d& at(const Mesh& mesh, int32_t vertex) {
    return mesh.positions[vertex];
}

double six_volumes(const Mesh& mesh, const std::array<int32_t, 3>& t) {
    return dot(at(mesh, t[0]), cross(at(mesh, t[1]), at(mesh, t[2])));
}

/// Drops unused vertices and renumbers the others in order.
void renumber(Mesh* mesh, const std::vector<int32_t>& same_as) {
    std::vector<int32_t> number = large_vector<int32_t>(mesh->positions.size(), -1);
    for (auto& triangle : mesh->triangles) {
        for (int32_t& v : triangle) {
            v = same_as.empty() ? v : same_as[v];
            number[v] = 0;
        }
    }
    std::vector<Vec3d> kept;
    reserve_large(&kept, static_cast<size_t>(std::count(number.begin(), number.end(), 0)));
    for (size_t v = 0; v < number.size(); ++v) {
        if (number[v] < 0) continue;
        number[v] = static_cast<int32_t>(kept.size());
        kept.push_back(mesh->positions[v]);
    }
    mesh->positions = std::move(kept);
    for (auto& triangle : mesh->triangles) {
        for (int32_t& v : triangle)
            v = number[v];
    }
}

/// Returns for each vertex the lowest one with the same position in the same part.
std::vector<int32_t> lowest_equal(const std::vector<Vec3d>& positions,
                                  const std::vector<int32_t>& parts) {
    const auto part = [&](size_t v) { return parts.empty() ? 0 : parts[v]; };
    const KeyedHash keyed;
    const auto hash = [&](size_t v) {
        uint64_t h = keyed.mix(keyed.start(), static_cast<uint64_t>(part(v)));
        // -0 and 0 are the same position.
        for (int a = 0; a < 3; ++a)
            h = keyed.mix(h, std::bit_cast<uint64_t>(positions[v][a] + 0.0));
        return static_cast<size_t>(h);
    };
    // A table with open addressing, never more than half full; vertices come in order.
    const size_t count = positions.size();
    const size_t mask = std::bit_ceil(2 * count + 1) - 1;
    std::vector<int32_t> table = large_vector<int32_t>(mask + 1, -1);
    std::vector<int32_t> lowest = large_vector<int32_t>(count);
    // Slots of the next vertices are on their way from memory meanwhile.
    constexpr size_t kAhead = 16;
    std::array<size_t, kAhead> slots{};
    const auto look_ahead = [&](size_t v) {
        slots[v % kAhead] = hash(v) & mask;
        __builtin_prefetch(&table[slots[v % kAhead]], 1);
    };
    for (size_t v = 0; v < std::min(kAhead, count); ++v)
        look_ahead(v);
    for (size_t v = 0; v < count; ++v) {
        size_t slot = slots[v % kAhead];
        if (v + kAhead < count) look_ahead(v + kAhead);
        if (v + kAhead / 2 < count) {
            const int32_t soon = table[slots[(v + kAhead / 2) % kAhead]];
            if (soon >= 0) __builtin_prefetch(&positions[soon]);
        }
        const auto other = [&] { return static_cast<size_t>(table[slot]); };
        while (table[slot] >= 0 &&
               !(positions[other()] == positions[v] && part(other()) == part(v)))
            slot = (slot + 1) & mask;
        if (table[slot] < 0) table[slot] = static_cast<int32_t>(v);
        lowest[v] = table[slot];
    }
    return lowest;
}

/// Drops the triangles without keep[t], with their data; returns their number.
int64_t drop_others(MeshSource* source, const std::vector<bool>& keep) {
    Mesh& mesh = source->mesh;
    std::vector<int32_t>& lines = source->origin.lines;
    OPENFAB_CHECK_EQ(keep.size(), mesh.triangles.size());
    OPENFAB_CHECK(lines.empty() || lines.size() == keep.size());
    size_t kept = 0;
    for (size_t t = 0; t < keep.size(); ++t) {
        if (!keep[t]) continue;
        mesh.triangles[kept] = mesh.triangles[t];
        for (MeshAttribute& a : mesh.attributes) {
            if (a.is_int) {
                const auto n = static_cast<size_t>(a.components);
                for (size_t c = 0; c < n; ++c)
                    a.faces[kept * n + c] = a.faces[t * n + c];
            } else {
                a.corners[kept] = a.corners[t];
            }
        }
        if (!lines.empty()) lines[kept] = lines[t];
        ++kept;
    }
    mesh.triangles.resize(kept);
    for (MeshAttribute& a : mesh.attributes) {
        if (a.is_int) {
            a.faces.resize(kept * static_cast<size_t>(a.components));
        } else {
            a.corners.resize(kept);
        }
    }
    if (!lines.empty()) lines.resize(kept);
    return static_cast<int64_t>(keep.size() - kept);
}

/// Drops triangles that have two equal corners; their neighbours stay connected.
void drop_equal_corners(MeshSource* source) {
    const std::vector<std::array<int32_t, 3>>& triangles = source->mesh.triangles;
    std::vector<bool> keep(triangles.size());
    for (size_t t = 0; t < keep.size(); ++t) {
        const auto& v = triangles[t];
        keep[t] = v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
    }
    const auto first = std::find(keep.begin(), keep.end(), false);
    if (first == keep.end()) return;
    const std::string where = source->origin.str(static_cast<int32_t>(first - keep.begin()));
    const int64_t dropped = drop_others(source, keep);
    source->checks.equal_corners = dropped;
    source->warnings.push_back(fmt::format(messages::kEqualCorners, where, source->mesh.name,
                                           dropped, dropped == 1 ? "" : "s"));
}

/// Drops duplicate triangles: of those with the same corners and direction one stays; of two with
/// opposite directions, which enclose nothing, none does.
void drop_duplicates(MeshSource* source) {
    struct Key {
        std::array<int32_t, 3> corners;
        int32_t triangle;
        bool even;  ///< orientation relative to its sorted corners
    };
    const std::vector<std::array<int32_t, 3>>& triangles = source->mesh.triangles;
    std::vector<Key> keys;
    keys.reserve(triangles.size());
    for (size_t t = 0; t < triangles.size(); ++t) {
        Key key{triangles[t], static_cast<int32_t>(t), true};
        const size_t lowest = static_cast<size_t>(
            std::min_element(key.corners.begin(), key.corners.end()) - key.corners.begin());
        std::rotate(key.corners.begin(), key.corners.begin() + static_cast<std::ptrdiff_t>(lowest),
                    key.corners.end());
        key.even = key.corners[1] < key.corners[2];
        if (!key.even) std::swap(key.corners[1], key.corners[2]);
        keys.push_back(key);
    }
    std::sort(keys.begin(), keys.end(), [](const Key& x, const Key& y) {
        return std::tie(x.corners, x.triangle) < std::tie(y.corners, y.triangle);
    });
    std::vector<bool> keep(triangles.size(), true);
    int32_t first = -1;
    for (size_t i = 0; i < keys.size();) {
        size_t end = i;
        int64_t sum = 0;
        for (; end < keys.size() && keys[end].corners == keys[i].corners; ++end)
            sum += keys[end].even ? 1 : -1;
        bool kept = end - i == 1;
        for (size_t k = i; k < end && end - i > 1; ++k) {
            const bool stays = !kept && (keys[k].even ? sum > 0 : sum < 0);
            keep[keys[k].triangle] = stays;
            kept = kept || stays;
            if (!stays && (first < 0 || keys[k].triangle < first)) first = keys[k].triangle;
        }
        i = end;
    }
    if (first < 0) return;
    const std::string where = source->origin.str(first);
    source->checks.duplicates = drop_others(source, keep);
    source->warnings.push_back(fmt::format(messages::kRepeatedTriangles, where, source->mesh.name,
                                           source->checks.duplicates,
                                           source->checks.duplicates == 1 ? "" : "s"));
}

void count_without_area(MeshSource* source) {
    const Mesh& mesh = source->mesh;
    int32_t first = -1;
    for (size_t t = mesh.triangles.size(); t-- > 0;) {
        const Vec3d& a = at(mesh, mesh.triangles[t][0]);
        const Vec3d n =
            cross(at(mesh, mesh.triangles[t][1]) - a, at(mesh, mesh.triangles[t][2]) - a);
        if (n == Vec3d{}) {
            ++source->checks.without_area;
            first = static_cast<int32_t>(t);
        }
    }
    if (first < 0) return;
    source->warnings.push_back(fmt::format(messages::kCornersInALine, source->origin.str(first),
                                           mesh.name, source->checks.without_area,
                                           source->checks.without_area == 1 ? "" : "s"));
}

Result<void> check_size(MeshSource* source) {
    const Mesh& mesh = source->mesh;
    const MeshOrigin& origin = source->origin;
    Box3d box;
    for (const Vec3d& p : mesh.positions)
        box.add(p);
    const Vec3d size = box.size();
    const double largest = std::max({size.x, size.y, size.z});
    constexpr double kMost = 1e5;
    if (!(largest < kMost) || !(length(box.center()) < kMost)) {
        return error_at(origin.location(0),
                        fmt::format(messages::kMeshTooLarge, mesh.name, size.x, size.y, size.z),
                        messages::kMeshTooLargeHelp);
    }
    if (largest < 1 || largest > 1000) {
        source->warnings.push_back(fmt::format(messages::kMeshSizeUnlikely, origin.str(0),
                                               mesh.name, size.x, size.y, size.z));
        source->of_size.push_back(source->warnings.back());
    }
    return Ok{};
}

/// "8 open, 2 non-manifold edges".
std::string list_edges(const EdgeCounts& counts) {
    std::string what;
    const auto add = [&](int64_t n, const char* kind) {
        if (n > 0)
            what +=
                fmt::format("{}{} {} edge{}", what.empty() ? "" : ", ", n, kind, n == 1 ? "" : "s");
    };
    add(counts.open, "open");
    add(counts.non_manifold, "non-manifold");
    add(counts.inconsistent, messages::kInconsistentlyOriented);
    return what;
}

Error not_closed(const MeshSource& source, const EdgeCounts& counts) {
    return error_at(source.origin.location(counts.triangle),
                    fmt::format(messages::kNotClosed, source.mesh.name, list_edges(counts),
                                source.location(counts.from), source.location(counts.to)),
                    messages::kNotClosedHelp);
}

/// Closes a mesh and reports what was done.
Result<void> repair_mesh(MeshSource* source) {
    Mesh* mesh = &source->mesh;
    const std::string where = source->origin.str(source->checks.edges.triangle);
    renumber(mesh, weld_open_edges(*mesh));
    drop_equal_corners(source);
    drop_duplicates(source);
    if (mesh->triangles.empty()) {
        return user_error(fmt::format(messages::kNoFaceWithArea, source->origin.file, mesh->name));
    }
    const MeshRepair done = close_mesh(source);
    if (const EdgeCounts left = count_edges(*mesh); !left.fine()) {
        return internal_error(fmt::format(messages::kOpenAfterRepair, source->origin.file,
                                          mesh->name, list_edges(left)));
    }
    std::string what = fmt::format(messages::kNotClosedRepaired, where, mesh->name,
                                   list_edges(source->checks.edges));
    if (done.turned > 0) what += fmt::format(messages::kTrianglesTurned, done.turned);
    if (done.holes > 0) {
        what += fmt::format(messages::kHolesClosed, done.holes, done.holes == 1 ? "" : "s",
                            done.widest_mm, source->location(done.center));
    }
    source->warnings.push_back(std::move(what));
    return Ok{};
}

}  // namespace

EdgeCounts count_edges(const Mesh& mesh) {
    return count_edges(mesh, sorted_edges(mesh));
}

EdgeCounts count_edges(const Mesh& mesh, const std::vector<Edge>& edges) {
    EdgeCounts counts;
    for_each_edge(edges, [&](const Edge* first, const Edge* last) {
        const int64_t uses = last - first;
        if (uses == 2 && first[0].forward != first[1].forward) return;
        ++(uses == 1 ? counts.open : uses == 2 ? counts.inconsistent : counts.non_manifold);
        if (counts.triangle < 0 || first->triangle < counts.triangle) {
            counts.triangle = first->triangle;
            counts.from = at(mesh, first->forward ? first->a : first->b);
            counts.to = at(mesh, first->forward ? first->b : first->a);
        }
    });
    return counts;
}

void join_corners(MeshSource* source, int64_t memory_bytes) {
    Mesh* mesh = &source->mesh;
    const size_t corners = mesh->positions.size();
    if (corners == 0 || corners != 3 * mesh->triangles.size() || !source->part_of_vertex.empty())
        return;
    const size_t table_bytes = 8 * std::bit_ceil(2 * corners + 1);
    // Without the memory they stay as they are, and prepare_mesh joins them.
    if (mesh_bytes(counts_of(*source)) + static_cast<int64_t>(table_bytes) > memory_bytes) return;
    int32_t next = 0;
    for (const std::array<int32_t, 3>& t : mesh->triangles) {
        for (const int32_t v : t)
            if (v != next++) return;
    }
    renumber(mesh, lowest_equal(mesh->positions, {}));
    source->corners_joined = true;
}

Result<void> prepare_mesh(MeshSource* source, bool repair) {
    Mesh* mesh = &source->mesh;
    const MeshOrigin& origin = source->origin;
    if (mesh->triangles.empty()) {
        return user_error(fmt::format(messages::kMeshNoFaces, origin.file, mesh->name));
    }
    std::vector<Edge> edges = sorted_edges(*mesh);
    const EdgeCounts as_read = count_edges(*mesh, edges);
    const bool look = source->corners_joined ? !source->corners_apart : !as_read.fine();
    const std::vector<int32_t> lowest =
        look ? lowest_equal(mesh->positions, source->part_of_vertex) : std::vector<int32_t>();
    const bool joins =
        !std::ranges::equal(lowest, std::views::iota(0, static_cast<int32_t>(lowest.size())));
    renumber(mesh, lowest);
    drop_equal_corners(source);
    // A mesh that was closed when read and lost no triangles is at most renumbered.
    EdgeCounts welded = as_read;
    const auto count_again = [&] {
        edges = {};
        edges = sorted_edges(*mesh);
        welded = count_edges(*mesh, edges);
    };
    if (joins || !as_read.fine() || source->checks.equal_corners > 0) count_again();
    if (!welded.fine()) {
        drop_duplicates(source);
        if (source->checks.duplicates > 0) count_again();
    }
    const bool dropped = source->checks.equal_corners + source->checks.duplicates > 0;
    if (mesh->triangles.empty()) {
        return user_error(fmt::format(messages::kNoFaceWithArea, origin.file, mesh->name));
    }
    if (!welded.fine()) {
        // Reports the variant, as read or welded, that is nearer to closed. In the former,
        // locations still have lines, unless triangles were dropped.
        const bool keep = dropped || source->corners_joined || welded.bad() < as_read.bad();
        source->checks.edges = keep ? welded : as_read;
        if (!repair) return not_closed(*source, source->checks.edges);
        if (Result<void> repaired = repair_mesh(source); !repaired) return repaired;
        edges = sorted_edges(*mesh);
    }
    if (dropped || repair) renumber(mesh, {});
    if (Result<void> size = check_size(source); !size) return size;
    count_without_area(source);
    if (Result<void> oriented = orient_shells(source, edges); !oriented) return oriented;
    edges = {};
    double volume = 0;
    Box3d box;
    for (const auto& t : mesh->triangles)
        volume += six_volumes(*mesh, t) / 6;
    for (const Vec3d& p : mesh->positions)
        box.add(p);
    const double diagonal = length(box.size());
    // Rounding alone may give a flat, closed sheet this volume.
    if (!(volume > 1e-12 * diagonal * diagonal * diagonal)) {
        return user_error(
            fmt::format(messages::kEnclosesNoVolume, origin.file, mesh->name, volume));
    }
    return Ok{};
}

}  // namespace openfab::mesh
