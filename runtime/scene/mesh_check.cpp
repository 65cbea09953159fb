// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/mesh_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <tuple>

namespace openfab::scene {
namespace {

struct Edge {
    int32_t a = 0, b = 0;  ///< a < b
    int32_t triangle = 0;
    bool forward = false;  ///< the triangle runs from a to b
    auto key() const { return std::tie(a, b, triangle); }
};

std::vector<Edge> sorted_edges(const Mesh& mesh) {
    std::vector<Edge> edges;
    edges.reserve(mesh.triangles.size() * 3);
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (size_t i = 0; i < 3; ++i) {
            const int32_t from = mesh.triangles[t][i];
            const int32_t to = mesh.triangles[t][(i + 1) % 3];
            edges.push_back(
                {std::min(from, to), std::max(from, to), static_cast<int32_t>(t), from < to});
        }
    }
    std::sort(edges.begin(), edges.end(),
              [](const Edge& x, const Edge& y) { return x.key() < y.key(); });
    return edges;
}

/// Calls visit(first, last) for each run of uses of one undirected edge.
template <typename Visit>
void for_each_edge(const std::vector<Edge>& edges, Visit visit) {
    for (size_t i = 0; i < edges.size();) {
        size_t end = i + 1;
        while (end < edges.size() && edges[end].a == edges[i].a && edges[end].b == edges[i].b)
            ++end;
        visit(&edges[i], &edges[0] + end);
        i = end;
    }
}

const Vec3d& at(const Mesh& mesh, int32_t vertex) {
    return mesh.positions[static_cast<size_t>(vertex)];
}

/// Keeps the vertices that triangles use, in order, under new numbers.
void renumber(Mesh* mesh, const std::vector<int32_t>& same_as) {
    std::vector<int32_t> number(mesh->positions.size(), -1);
    for (auto& triangle : mesh->triangles) {
        for (int32_t& v : triangle) {
            v = same_as.empty() ? v : same_as[static_cast<size_t>(v)];
            number[static_cast<size_t>(v)] = 0;
        }
    }
    std::vector<Vec3d> kept;
    for (size_t v = 0; v < number.size(); ++v) {
        if (number[v] < 0) continue;
        number[v] = static_cast<int32_t>(kept.size());
        kept.push_back(mesh->positions[v]);
    }
    mesh->positions = std::move(kept);
    for (auto& triangle : mesh->triangles) {
        for (int32_t& v : triangle)
            v = number[static_cast<size_t>(v)];
    }
}

/// The lowest vertex with the same position in the same part, for each vertex.
std::vector<int32_t> lowest_equal(const std::vector<Vec3d>& positions,
                                  const std::vector<int32_t>& parts) {
    std::vector<int32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](int32_t v) {
        const Vec3d& p = positions[static_cast<size_t>(v)];
        return std::tuple(parts.empty() ? 0 : parts[static_cast<size_t>(v)], p.x, p.y, p.z);
    };
    std::sort(order.begin(), order.end(),
              [&](int32_t x, int32_t y) { return key(x) != key(y) ? key(x) < key(y) : x < y; });
    std::vector<int32_t> lowest(positions.size());
    for (size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
        lowest[static_cast<size_t>(order[i])] =
            same ? lowest[static_cast<size_t>(order[i - 1])] : order[i];
    }
    return lowest;
}

/// Drops triangles that have two equal corners; neighbours close up over them by themselves.
size_t drop_degenerate(Mesh* mesh, MeshOrigin* origin) {
    size_t kept = 0;
    for (size_t t = 0; t < mesh->triangles.size(); ++t) {
        const auto& v = mesh->triangles[t];
        if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
        mesh->triangles[kept] = v;
        for (MeshAttribute& a : mesh->attributes) {
            if (a.is_int) {
                const auto n = static_cast<size_t>(a.components);
                for (size_t c = 0; c < n; ++c)
                    a.faces[kept * n + c] = a.faces[t * n + c];
            } else {
                a.corners[kept] = a.corners[t];
            }
        }
        if (!origin->lines.empty()) origin->lines[kept] = origin->lines[t];
        ++kept;
    }
    const size_t dropped = mesh->triangles.size() - kept;
    mesh->triangles.resize(kept);
    for (MeshAttribute& a : mesh->attributes) {
        if (a.is_int) {
            a.faces.resize(kept * static_cast<size_t>(a.components));
        } else {
            a.corners.resize(kept);
        }
    }
    if (!origin->lines.empty()) origin->lines.resize(kept);
    return dropped;
}

/// Shell of each triangle: triangles that share an edge are of one shell, numbered by their lowest
/// triangle.
std::vector<int32_t> find_shells(const Mesh& mesh) {
    std::vector<int32_t> parent(mesh.triangles.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int32_t t) {
        while (parent[static_cast<size_t>(t)] != t) {
            parent[static_cast<size_t>(t)] =
                parent[static_cast<size_t>(parent[static_cast<size_t>(t)])];
            t = parent[static_cast<size_t>(t)];
        }
        return t;
    };
    const std::vector<Edge> edges = sorted_edges(mesh);
    for_each_edge(edges, [&](const Edge* first, const Edge* last) {
        for (const Edge* e = first + 1; e < last; ++e) {
            const int32_t a = root(first->triangle);
            const int32_t b = root(e->triangle);
            parent[static_cast<size_t>(std::max(a, b))] = std::min(a, b);
        }
    });
    for (size_t t = 0; t < parent.size(); ++t)
        parent[t] = root(static_cast<int32_t>(t));
    return parent;
}

double six_volumes(const Mesh& mesh, const std::array<int32_t, 3>& t) {
    return dot(at(mesh, t[0]), cross(at(mesh, t[1]), at(mesh, t[2])));
}

/// Side of p from the line a b in the y z plane, p being moved by (e, e^2): never 0 unless a and b
/// coincide there. Equal for both triangles at an edge, since it is worked out from the lower end.
int side_yz(const Vec3d& a, const Vec3d& b, const Vec3d& p) {
    const bool swapped = std::tie(b.y, b.z) < std::tie(a.y, a.z);
    const Vec3d& lo = swapped ? b : a;
    const Vec3d& hi = swapped ? a : b;
    const double dy = hi.y - lo.y;
    const double dz = hi.z - lo.z;
    double side = dy * (p.z - lo.z) - dz * (p.y - lo.y);
    if (side == 0) side = 0 - dz;
    if (side == 0) side = dy;
    return side == 0 ? 0 : (side > 0) != swapped ? 1 : -1;
}

/// Winding number at p of all triangles outside `shell`, by a ray along +x.
int winding_of_others(const Mesh& mesh, const std::vector<int32_t>& shells, int32_t shell,
                      const Vec3d& p) {
    int winding = 0;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (shells[t] == shell) continue;
        const Vec3d& a = at(mesh, mesh.triangles[t][0]);
        const Vec3d& b = at(mesh, mesh.triangles[t][1]);
        const Vec3d& c = at(mesh, mesh.triangles[t][2]);
        const int side = side_yz(a, b, p);
        if (side == 0 || side_yz(b, c, p) != side || side_yz(c, a, p) != side) continue;
        const Vec3d n = cross(b - a, c - a);
        // The plane's x over p is a.x - (n.y dy + n.z dz) / n.x.
        if (n.x != 0 && a.x - (n.y * (p.y - a.y) + n.z * (p.z - a.z)) / n.x > p.x) winding += side;
    }
    return winding;
}

void flip_shell(Mesh* mesh, const std::vector<int32_t>& shells, int32_t shell) {
    for (size_t t = 0; t < mesh->triangles.size(); ++t) {
        if (shells[t] != shell) continue;
        std::swap(mesh->triangles[t][1], mesh->triangles[t][2]);
        for (MeshAttribute& a : mesh->attributes) {
            if (!a.is_int) std::swap(a.corners[t][1], a.corners[t][2]);
        }
    }
}

void flip_inside_out_shells(Mesh* mesh, const MeshOrigin& origin,
                            std::vector<std::string>* warnings) {
    const std::vector<int32_t> shells = find_shells(*mesh);
    std::vector<double> volume(shells.size());
    for (size_t t = 0; t < shells.size(); ++t) {
        volume[static_cast<size_t>(shells[t])] += six_volumes(*mesh, mesh->triangles[t]);
    }
    std::vector<int32_t> inside_out;
    for (size_t t = 0; t < shells.size(); ++t) {
        const auto shell = static_cast<int32_t>(t);
        if (shells[t] != shell || volume[t] >= 0) continue;
        if (winding_of_others(*mesh, shells, shell, at(*mesh, mesh->triangles[t][0])) == 0) {
            inside_out.push_back(shell);
        }
    }
    for (int32_t shell : inside_out)
        flip_shell(mesh, shells, shell);
    if (!inside_out.empty()) {
        warnings->push_back(fmt::format(
            "{}: mesh `{}` has {} inside out (clockwise seen from outside); turned",
            origin.str(inside_out[0]), mesh->name,
            inside_out.size() == 1 ? "a shell" : fmt::format("{} shells", inside_out.size())));
    }
}

Result<void> check_size(const Mesh& mesh, const MeshOrigin& origin,
                        std::vector<std::string>* warnings) {
    Box3d box;
    for (const Vec3d& p : mesh.positions)
        box.add(p);
    const Vec3d size = box.size();
    const double largest = std::max({size.x, size.y, size.z});
    constexpr double kMost = 1e5;
    if (!(largest < kMost) || !(length(box.center()) < kMost)) {
        return user_error(fmt::format(
            "{}: mesh `{}` is {:.4g} x {:.4g} x {:.4g} mm or lies as far from its origin; at "
            "most 100 m are possible, check its `unit`",
            origin.str(0), mesh.name, size.x, size.y, size.z));
    }
    if (largest < 1 || largest > 1000) {
        warnings->push_back(
            fmt::format("{}: mesh `{}` is {:.4g} x {:.4g} x {:.4g} mm; check its `unit`",
                        origin.str(0), mesh.name, size.x, size.y, size.z));
    }
    return Ok{};
}

Error not_closed(const Mesh& mesh, const EdgeCounts& counts, const MeshOrigin& origin) {
    std::string what;
    const auto add = [&](int64_t n, const char* kind) {
        if (n > 0)
            what +=
                fmt::format("{}{} {} edge{}", what.empty() ? "" : ", ", n, kind, n == 1 ? "" : "s");
    };
    add(counts.open, "open");
    add(counts.non_manifold, "non-manifold");
    add(counts.inconsistent, "inconsistently oriented");
    return user_error(fmt::format(
        "{}: mesh `{}` is not a closed surface: {}, one from ({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, "
        "{:.6g}, {:.6g}) mm; "
        "close it so that each edge has two triangles that run along it in opposite directions",
        origin.str(counts.triangle), mesh.name, what, counts.from.x, counts.from.y, counts.from.z,
        counts.to.x, counts.to.y, counts.to.z));
}

}  // namespace

std::string MeshOrigin::str(int32_t triangle) const {
    if (triangle < 0 || static_cast<size_t>(triangle) >= lines.size()) return file;
    return fmt::format("{}:{}:1", file, lines[static_cast<size_t>(triangle)]);
}

EdgeCounts count_edges(const Mesh& mesh) {
    EdgeCounts counts;
    const std::vector<Edge> edges = sorted_edges(mesh);
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

Result<void> prepare_mesh(Mesh* mesh, MeshOrigin* origin, std::vector<std::string>* warnings,
                          const std::vector<int32_t>& parts) {
    if (mesh->triangles.empty()) {
        return user_error(fmt::format("{}: mesh `{}` has no faces", origin->file, mesh->name));
    }
    const EdgeCounts as_read = count_edges(*mesh);
    renumber(mesh, as_read.fine() ? std::vector<int32_t>() : lowest_equal(mesh->positions, parts));
    const size_t dropped = drop_degenerate(mesh, origin);
    if (dropped > 0) {
        warnings->push_back(
            fmt::format("{}: mesh `{}` has {} triangle{} with two equal corners; left out",
                        origin->file, mesh->name, dropped, dropped == 1 ? "" : "s"));
        if (mesh->triangles.empty()) {
            return user_error(
                fmt::format("{}: mesh `{}` has no face with an area", origin->file, mesh->name));
        }
        renumber(mesh, {});
    }
    if (const EdgeCounts welded = count_edges(*mesh); !welded.fine()) {
        // Told of the form that is nearer to closed. A place in the form as read still has its
        // line, unless triangles went.
        const bool keep = dropped > 0 || welded.bad() < as_read.bad();
        return not_closed(*mesh, keep ? welded : as_read, *origin);
    }
    if (Result<void> size = check_size(*mesh, *origin, warnings); !size) return size;
    flip_inside_out_shells(mesh, *origin, warnings);
    double volume = 0;
    Box3d box;
    for (const auto& t : mesh->triangles)
        volume += six_volumes(*mesh, t) / 6;
    for (const Vec3d& p : mesh->positions)
        box.add(p);
    const double diagonal = length(box.size());
    // Rounding alone gives a flat, closed sheet up to this volume.
    if (!(volume > 1e-12 * diagonal * diagonal * diagonal)) {
        return user_error(fmt::format("{}: mesh `{}` encloses no volume ({:.3g} mm3); it is flat",
                                      origin->file, mesh->name, volume));
    }
    return Ok{};
}

}  // namespace openfab::scene
