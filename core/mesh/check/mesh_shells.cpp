// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/check/mesh_shells.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>

#include "base/large_pages.h"
#include "mesh/check/disjoint_sets.h"
#include "mesh/check/nesting.h"
#include "mesh/check/triangle_tree.h"
#include "mesh/check/winding.h"
#include "mesh/model/messages.h"

namespace openfab::mesh {
namespace {

/// Limit of the triangles that rays of all shells meet: seconds.
constexpr int64_t kMostMet = 300'000'000;

const Vec3d& at(const Mesh& mesh, int32_t vertex) {
    return mesh.positions[vertex];
}

/// Returns the shell of each triangle: triangles that share an edge are in one shell, which is
/// numbered by its lowest triangle.
std::vector<int32_t> find_shells(size_t triangles, const std::vector<Edge>& edges) {
    DisjointSets shells(triangles);
    for_each_edge(edges, [&](const Edge* first, const Edge* last) {
        for (const Edge* e = first + 1; e < last; ++e)
            shells.join(first->triangle, e->triangle);
    });
    std::vector<int32_t> shell_of = large_vector<int32_t>(triangles);
    for (size_t t = 0; t < triangles; ++t)
        shell_of[t] = shells.find(static_cast<int32_t>(t));
    return shell_of;
}

/// Returns the winding number at p of all triangles outside `shell`, by a ray along +x. Decreases
/// `*effort` by the triangles whose boxes the ray meets; stops at 0.
int winding_of_others(const Mesh& mesh, const TriangleTree& tree,
                      const std::vector<int32_t>& shells, int32_t shell, const Vec3d& p,
                      int64_t* effort) {
    int winding = 0;
    for_each_crossing(
        mesh, tree, p, effort, [&](int32_t t) { return shells[t] == shell; },
        [&](int32_t, int sign) { winding += sign; });
    return winding;
}

/// Flips the triangles of shells whose lowest triangle is marked.
void flip_shells(Mesh* mesh, const std::vector<int32_t>& shell_of,
                 const std::vector<bool>& marked) {
    for (size_t t = 0; t < mesh->triangles.size(); ++t) {
        if (!marked[shell_of[t]]) continue;
        std::swap(mesh->triangles[t][1], mesh->triangles[t][2]);
        for (MeshAttribute& a : mesh->attributes) {
            if (!a.is_int) std::swap(a.corners[t][1], a.corners[t][2]);
        }
    }
}

/// A shell, by its lowest triangle.
struct Shell {
    int32_t triangle = 0;
    double volume = 0;
    int winding = 0;  ///< of the other shells around it
};

/// Empty where that takes too long.
std::optional<std::vector<Shell>> measure_shells(const Mesh& mesh,
                                                 const std::vector<int32_t>& shell_of) {
    std::vector<double> volume = large_vector<double>(shell_of.size());
    for (size_t t = 0; t < shell_of.size(); ++t) {
        const auto& v = mesh.triangles[t];
        volume[shell_of[t]] += dot(at(mesh, v[0]), cross(at(mesh, v[1]), at(mesh, v[2])));
    }
    std::vector<Shell> shells;
    for (size_t t = 0; t < shell_of.size(); ++t) {
        if (shell_of[t] == static_cast<int32_t>(t))
            shells.push_back({static_cast<int32_t>(t), volume[t], 0});
    }
    if (shells.size() < 2) return shells;
    const TriangleTree tree(mesh);
    int64_t effort = kMostMet;
    for (Shell& shell : shells) {
        const auto first = static_cast<size_t>(shell.triangle);
        shell.winding = winding_of_others(mesh, tree, shell_of, shell.triangle,
                                          at(mesh, mesh.triangles[first][0]), &effort);
        if (effort < 0) return std::nullopt;
    }
    return shells;
}

/// Finds the pairs of solid shells that overlap, also where their sides are coplanar, so that no triangles cross. Empty
/// where there are too many shells to look.
std::vector<std::pair<int32_t, int32_t>> find_overlaps(const Mesh& mesh,
                                                       const std::vector<int32_t>& shell_of,
                                                       const std::vector<Shell>& shells) {
    constexpr size_t kMostShells = 2000;
    if (shells.size() < 2 || shells.size() > kMostShells) return {};
    std::vector<int32_t> number_of(shell_of.size(), -1), pieces(shell_of.size());
    for (size_t i = 0; i < shells.size(); ++i)
        number_of[shells[i].triangle] = static_cast<int32_t>(i);
    for (size_t t = 0; t < shell_of.size(); ++t)
        pieces[t] = number_of[shell_of[t]];
    const std::optional<Nesting> nesting =
        find_nesting(mesh, pieces, static_cast<int32_t>(shells.size()));
    if (!nesting) return {};
    std::vector<std::pair<int32_t, int32_t>> out;
    for (const auto& [one, other] : nesting->overlaps) {
        if (shells[one].volume > 0 && shells[other].volume > 0) out.emplace_back(one, other);
    }
    return out;
}

std::string count_of(int64_t n, const char* what) {
    return n == 1 ? fmt::format("a {}", what) : fmt::format("{} {}s", n, what);
}

}  // namespace

Result<void> orient_shells(MeshSource* source, const std::vector<Edge>& edges) {
    Mesh& mesh = source->mesh;
    MeshChecks& checks = source->checks;
    const std::vector<int32_t> shell_of = find_shells(mesh.triangles.size(), edges);
    std::optional<std::vector<Shell>> measured = measure_shells(mesh, shell_of);
    if (!measured) {
        return user_error(fmt::format(messages::kTooManyShells, source->origin.file, mesh.name));
    }
    std::vector<Shell>& shells = *measured;
    const auto outermost = [](const Shell& s) { return s.winding == 0; };
    const bool all = std::any_of(shells.begin(), shells.end(), outermost) &&
                     std::all_of(shells.begin(), shells.end(),
                                 [&](const Shell& s) { return !outermost(s) || s.volume < 0; });
    std::vector<bool> flip(mesh.triangles.size());
    int32_t turned = -1;
    for (Shell& shell : shells) {
        if (all || (outermost(shell) && shell.volume < 0)) {
            flip[shell.triangle] = true;
            shell.volume = 0 - shell.volume;
            shell.winding = all ? 0 - shell.winding : 0;
            ++checks.turned;
            if (turned < 0) turned = shell.triangle;
        }
    }
    if (turned >= 0) flip_shells(&mesh, shell_of, flip);
    const std::vector<std::pair<int32_t, int32_t>> overlaps = find_overlaps(mesh, shell_of, shells);
    int32_t nested = -1;
    for (size_t i = 0; i < shells.size(); ++i) {
        const Shell& shell = shells[i];
        if (shell.winding <= 0) continue;
        const auto is_it = [&](const auto& pair) {
            return pair.first == static_cast<int32_t>(i) || pair.second == static_cast<int32_t>(i);
        };
        if (shell.volume < 0) {
            ++checks.cavities;
        } else if (std::none_of(overlaps.begin(), overlaps.end(), is_it)) {
            ++checks.nested;
            if (nested < 0) nested = shell.triangle;
        }
    }
    checks.shells = static_cast<int64_t>(shells.size());
    checks.overlapping = static_cast<int64_t>(overlaps.size());
    if (turned >= 0) {
        source->warnings.push_back(fmt::format(messages::kShellsInsideOut,
                                               source->origin.str(turned), mesh.name,
                                               count_of(checks.turned, "shell")));
    }
    if (!overlaps.empty()) {
        const int32_t triangle = shells[overlaps[0].second].triangle;
        source->warnings.push_back(
            fmt::format(messages::kShellsOverlap, source->origin.str(triangle), mesh.name,
                        count_of(checks.overlapping, "pair"),
                        source->location(at(mesh, mesh.triangles[triangle][0]))));
    }
    if (nested >= 0) {
        const Vec3d& p = at(mesh, mesh.triangles[nested][0]);
        source->warnings.push_back(
            fmt::format(messages::kShellsInsideShells, source->origin.str(nested), mesh.name,
                        count_of(checks.nested, "shell"), source->location(p)));
    }
    return Ok{};
}

}  // namespace openfab::mesh
