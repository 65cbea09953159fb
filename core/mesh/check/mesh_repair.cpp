// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/check/mesh_repair.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "mesh/check/disjoint_sets.h"
#include "mesh/check/mesh_edges.h"

namespace openfab::mesh {
namespace {

constexpr double kWeldOfDiagonal = 1e-5;

const Vec3d& at(const Mesh& mesh, int32_t vertex) {
    return mesh.positions[vertex];
}

size_t corner_of(const Mesh& mesh, int32_t triangle, int32_t vertex) {
    const auto& t = mesh.triangles[triangle];
    return t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2;
}

/// Uses of an edge from its lower to its higher vertex, minus those in the other direction.
int64_t surplus(const Edge* first, const Edge* last) {
    int64_t sum = 0;
    for (const Edge* e = first; e < last; ++e)
        sum += e->forward ? 1 : -1;
    return sum;
}

double area(const Mesh& mesh, size_t triangle) {
    const auto& t = mesh.triangles[triangle];
    return length(cross(at(mesh, t[1]) - at(mesh, t[0]), at(mesh, t[2]) - at(mesh, t[0])));
}

void turn(Mesh* mesh, size_t triangle) {
    std::swap(mesh->triangles[triangle][1], mesh->triangles[triangle][2]);
    for (MeshAttribute& a : mesh->attributes) {
        if (!a.is_int) std::swap(a.corners[triangle][1], a.corners[triangle][2]);
    }
}

/// Orients neighbours over edges of two triangles consistently, as far as possible, flipping the
/// smaller area of each connected piece.
int64_t agree(Mesh* mesh) {
    struct Neighbour {
        int32_t triangle;
        bool agrees;
    };
    const size_t count = mesh->triangles.size();
    std::vector<std::vector<Neighbour>> neighbours(count);
    bool needed = false;
    const std::vector<Edge> edges = sorted_edges(*mesh);
    for_each_edge(edges, [&](const Edge* first, const Edge* last) {
        if (last - first != 2) return;
        const bool agrees = first[0].forward != first[1].forward;
        needed = needed || !agrees;
        neighbours[first[0].triangle].push_back({first[1].triangle, agrees});
        neighbours[first[1].triangle].push_back({first[0].triangle, agrees});
    });
    if (!needed) return 0;
    int64_t turned = 0;
    std::vector<int8_t> state(count, -1);  // 1: turned
    std::vector<int32_t> piece;
    for (size_t start = 0; start < count; ++start) {
        if (state[start] >= 0) continue;
        piece.assign(1, static_cast<int32_t>(start));
        state[start] = 0;
        double balance = 0;
        for (size_t i = 0; i < piece.size(); ++i) {
            const auto t = static_cast<size_t>(piece[i]);
            balance += state[t] != 0 ? area(*mesh, t) : -area(*mesh, t);
            for (const Neighbour& n : neighbours[t]) {
                int8_t& other = state[n.triangle];
                if (other >= 0) continue;
                other = n.agrees ? state[t] : static_cast<int8_t>(1 - state[t]);
                piece.push_back(n.triangle);
            }
        }
        const int8_t away = balance > 0 ? 0 : 1;
        for (int32_t t : piece) {
            if (state[t] != away) continue;
            turn(mesh, static_cast<size_t>(t));
            ++turned;
        }
    }
    return turned;
}

/// An edge as a cap uses it, opposite to the triangle at the rim.
struct RimEdge {
    int32_t from = 0, to = 0;
    int32_t triangle = 0;
};
using Loop = std::vector<RimEdge>;

std::vector<RimEdge> rim_edges(const Mesh& mesh) {
    std::vector<RimEdge> rim;
    const std::vector<Edge> edges = sorted_edges(mesh);
    for_each_edge(edges, [&](const Edge* first, const Edge* last) {
        const int64_t more = surplus(first, last);
        const bool forward = more > 0;
        for (int64_t i = 0; i < std::abs(more); ++i) {
            const Edge* use =
                std::find_if(first, last, [&](const Edge& e) { return e.forward == forward; });
            rim.push_back(
                {forward ? first->b : first->a, forward ? first->a : first->b, use->triangle});
        }
    });
    std::sort(rim.begin(), rim.end(), [](const RimEdge& x, const RimEdge& y) {
        return std::tie(x.from, x.to, x.triangle) < std::tie(y.from, y.to, y.triangle);
    });
    return rim;
}

/// Splits the rim into simple loops. As many of its edges end at a vertex as begin there.
std::vector<Loop> loops_of(const std::vector<RimEdge>& rim, size_t vertices) {
    std::vector<size_t> next(vertices + 1, 0);  // the next edge that begins at a vertex
    for (const RimEdge& e : rim)
        ++next[static_cast<size_t>(e.from) + 1];
    for (size_t v = 0; v < vertices; ++v)
        next[v + 1] += next[v];
    const std::vector<size_t> begin = next;
    std::vector<int32_t> step(vertices, -1);  // position on the path of the edge that begins there
    std::vector<Loop> loops;
    for (size_t start = 0; start < vertices; ++start) {
        while (next[start] < begin[start + 1]) {
            Loop path;
            auto v = static_cast<int32_t>(start);
            do {
                const RimEdge& e = rim[next[v]++];
                step[v] = static_cast<int32_t>(path.size());
                path.push_back(e);
                v = e.to;
                const int32_t first = step[v];
                if (first < 0) continue;
                loops.emplace_back(path.begin() + first, path.end());
                for (const RimEdge& closed : loops.back())
                    step[closed.from] = -1;
                path.resize(static_cast<size_t>(first));
            } while (!path.empty() || v != static_cast<int32_t>(start));
        }
    }
    return loops;
}

/// The center of a loop, weighted by length, so that finely tessellated stretches do not pull it.
Vec3d middle_of(const Mesh& mesh, const Loop& loop) {
    Vec3d sum;
    double total = 0;
    for (const RimEdge& e : loop) {
        const double weight = length(at(mesh, e.to) - at(mesh, e.from));
        sum = sum + (at(mesh, e.from) + at(mesh, e.to)) * (0.5 * weight);
        total += weight;
    }
    return total > 0 ? sum * (1 / total) : at(mesh, loop[0].from);
}

/// Adds the triangles of caps, with attributes.
class Capper {
  public:
    explicit Capper(MeshSource* source) : source_(*source), mesh_(source->mesh) {}

    void close(const Loop& loop) {
        const bool single = loop.size() == 3;
        const Vec3d middle = middle_of(mesh_, loop);
        const auto tip = static_cast<int32_t>(mesh_.positions.size());
        if (!single) mesh_.positions.push_back(middle);
        std::vector<int32_t> tip_values;
        for (MeshAttribute& a : mesh_.attributes)
            tip_values.push_back(single || a.is_int ? -1 : add_mean(&a, loop));
        for (size_t i = 0; i < (single ? 1 : loop.size()); ++i) {
            const RimEdge& e = loop[i];
            const RimEdge& last = loop[2];
            mesh_.triangles.push_back({e.from, e.to, single ? last.from : tip});
            for (size_t a = 0; a < mesh_.attributes.size(); ++a) {
                MeshAttribute& attribute = mesh_.attributes[a];
                if (attribute.is_int) {
                    copy_face(&attribute, e.triangle);
                } else if (attribute.name == "n" && attribute.components == 3) {
                    add_normal(&attribute);
                } else {
                    attribute.corners.push_back(
                        {value(attribute, e.triangle, e.from), value(attribute, e.triangle, e.to),
                         single ? value(attribute, last.triangle, last.from) : tip_values[a]});
                }
            }
            std::vector<int32_t>& lines = source_.origin.lines;
            if (!lines.empty()) lines.push_back(lines[e.triangle]);
        }
    }

  private:
    int32_t value(const MeshAttribute& a, int32_t triangle, int32_t vertex) const {
        return a.corners[triangle][corner_of(mesh_, triangle, vertex)];
    }

    /// Averages the values along the rim.
    int32_t add_mean(MeshAttribute* a, const Loop& loop) const {
        const auto n = static_cast<size_t>(a->components);
        std::vector<double> sum(n);
        for (const RimEdge& e : loop) {
            const auto v = static_cast<size_t>(value(*a, e.triangle, e.from));
            for (size_t c = 0; c < n; ++c)
                sum[c] += a->values[v * n + c];
        }
        for (double s : sum)
            a->values.push_back(static_cast<float>(s / static_cast<double>(loop.size())));
        return static_cast<int32_t>(a->values.size() / n) - 1;
    }

    void copy_face(MeshAttribute* a, int32_t triangle) {
        const auto n = static_cast<size_t>(a->components);
        for (size_t c = 0; c < n; ++c)
            a->faces.push_back(a->faces[static_cast<size_t>(triangle) * n + c]);
    }

    /// Adds the normal of the last triangle.
    void add_normal(MeshAttribute* a) {
        const auto& t = mesh_.triangles.back();
        const Vec3d n = cross(at(mesh_, t[1]) - at(mesh_, t[0]), at(mesh_, t[2]) - at(mesh_, t[0]));
        const double size = length(n);
        for (int axis = 0; axis < 3; ++axis)
            a->values.push_back(static_cast<float>(size > 0 ? n[axis] / size : axis == 2));
        const auto index = static_cast<int32_t>(a->values.size() / 3) - 1;
        a->corners.push_back({index, index, index});
    }

    MeshSource& source_;
    Mesh& mesh_;
};

/// A monotone substitute for the angle from +x, 0 to 4; libm's atan2 differs between machines.
double turn_of(double x, double y) {
    const double sum = std::abs(x) + std::abs(y);
    if (!(sum > 0)) return 0;
    const double p = x / sum;
    return y < 0 ? 3 + p : 1 - p;
}

/// Pairs the uses of an edge in opposite directions: each with the next one around the edge through
/// the solid between them, so that touching sheets keep to their own solids.
template <typename Pair>
void pair_uses(const Mesh& mesh, const Edge* first, const Edge* last, Pair pair) {
    if (last - first == 2) return pair(first[0], first[1]);
    const Vec3d a = at(mesh, first->a), along = at(mesh, first->b) - a;
    Vec3d other{1, 0, 0};
    if (std::abs(along.x) > std::abs(along.y)) other = {0, 1, 0};
    const Vec3d u = cross(along, other);
    const Vec3d v = cross(along, u);
    const double scale = length(along);
    struct Use {
        double turn;
        const Edge* edge;
    };
    std::vector<Use> around;
    for (const Edge* e = first; e < last; ++e) {
        const auto& t = mesh.triangles[e->triangle];
        const int32_t third = t[0] + t[1] + t[2] - e->a - e->b;
        const Vec3d d = at(mesh, third) - a;
        around.push_back({turn_of(dot(d, u) * scale, dot(d, v)), e});
    }
    // The inside of a triangle along the edge is on the side of decreasing angles.
    std::sort(around.begin(), around.end(), [](const Use& x, const Use& y) {
        return x.turn != y.turn ? x.turn > y.turn : x.edge->triangle < y.edge->triangle;
    });
    std::vector<const Edge*> open;
    for (int round = 0; round < 2; ++round) {
        for (Use& use : around) {
            if (use.edge == nullptr) continue;
            if (use.edge->forward) {
                if (round == 0) open.push_back(use.edge), use.edge = nullptr;
            } else if (!open.empty()) {
                pair(*open.back(), *use.edge);
                open.pop_back();
                use.edge = nullptr;
            }
        }
    }
}

/// Gives each fan of triangles around a vertex a vertex of its own; the first keeps the old one.
void split_vertices(Mesh* mesh) {
    DisjointSets fans(mesh->triangles.size() * 3);  // of corners
    const auto join = [&](const Edge& x, const Edge& y, int32_t vertex) {
        const auto corner = [&](const Edge& e) {
            return e.triangle * 3 + static_cast<int32_t>(corner_of(*mesh, e.triangle, vertex));
        };
        fans.join(corner(x), corner(y));
    };
    const std::vector<Edge> edges = sorted_edges(*mesh);
    for_each_edge(edges, [&](const Edge* first, const Edge* last) {
        pair_uses(*mesh, first, last, [&](const Edge& x, const Edge& y) {
            join(x, y, x.a);
            join(x, y, x.b);
        });
    });
    std::vector<int32_t> number(fans.size(), -1);
    std::vector<bool> taken(mesh->positions.size());
    std::vector<std::array<int32_t, 3>> out = mesh->triangles;
    for (size_t c = 0; c < fans.size(); ++c) {
        const auto r = static_cast<size_t>(fans.find(static_cast<int32_t>(c)));
        const int32_t vertex = mesh->triangles[c / 3][c % 3];
        if (number[r] < 0) {
            number[r] = vertex;
            if (taken[vertex]) {
                number[r] = static_cast<int32_t>(mesh->positions.size());
                mesh->positions.push_back(at(*mesh, vertex));
            } else {
                taken[vertex] = true;
            }
        }
        out[c / 3][c % 3] = number[r];
    }
    mesh->triangles = std::move(out);
}

/// Inserts vertices at the midpoints of edges.
class EdgeCutter {
  public:
    explicit EdgeCutter(MeshSource* source) : source_(*source), mesh_(source->mesh) {}

    /// One vertex for both uses.
    void cut(const Edge& x, const Edge& y) {
        const auto middle = static_cast<int32_t>(mesh_.positions.size());
        mesh_.positions.push_back((at(mesh_, x.a) + at(mesh_, x.b)) * 0.5);
        cut_triangle(x, middle);
        cut_triangle(y, middle);
    }

  private:
    void cut_triangle(const Edge& e, int32_t middle) {
        const auto t = static_cast<size_t>(e.triangle);
        // The first half keeps the index and the edge's start, the second is appended.
        const size_t start = corner_of(mesh_, e.triangle, e.forward ? e.a : e.b);
        const size_t end = (start + 1) % 3;
        mesh_.triangles.push_back(mesh_.triangles[t]);
        mesh_.triangles[t][end] = middle;
        mesh_.triangles.back()[start] = middle;
        for (MeshAttribute& a : mesh_.attributes) {
            const auto n = static_cast<size_t>(a.components);
            if (a.is_int) {
                for (size_t c = 0; c < n; ++c)
                    a.faces.push_back(a.faces[t * n + c]);
                continue;
            }
            const auto from = static_cast<size_t>(a.corners[t][start]);
            const auto to = static_cast<size_t>(a.corners[t][end]);
            const auto value = static_cast<int32_t>(a.values.size() / n);
            for (size_t c = 0; c < n; ++c)
                a.values.push_back(0.5f * (a.values[from * n + c] + a.values[to * n + c]));
            a.corners.push_back(a.corners[t]);
            a.corners[t][end] = value;
            a.corners.back()[start] = value;
        }
        std::vector<int32_t>& lines = source_.origin.lines;
        if (!lines.empty()) lines.push_back(lines[t]);
    }

    MeshSource& source_;
    Mesh& mesh_;
};

/// Splits edges that are shared by touching sheets joined at both ends: splitting vertices would
/// leave four triangles at such an edge; a midpoint for each sheet does not.
void cut_shared_edges(MeshSource* source) {
    bool more = true;
    while (more) {
        more = false;
        EdgeCutter cutter(source);
        const std::vector<Edge> edges = sorted_edges(source->mesh);
        std::vector<bool> cut(source->mesh.triangles.size());
        for_each_edge(edges, [&](const Edge* first, const Edge* last) {
            if (last - first == 2) return;
            // A triangle that was split has other edges now and is handled in the next round.
            const bool stale =
                std::any_of(first, last, [&](const Edge& e) { return cut[e.triangle]; });
            if (stale) return;
            std::vector<std::pair<Edge, Edge>> pairs;
            pair_uses(source->mesh, first, last,
                      [&](const Edge& x, const Edge& y) { pairs.emplace_back(x, y); });
            for (const auto& [x, y] : pairs) {
                cut[x.triangle] = cut[y.triangle] = true;
                cutter.cut(x, y);
                more = true;
            }
        });
    }
}

}  // namespace

std::vector<int32_t> weld_open_edges(const Mesh& mesh) {
    std::vector<int32_t> same(mesh.positions.size());
    std::iota(same.begin(), same.end(), 0);
    std::vector<bool> open(mesh.positions.size());
    const std::vector<Edge> edges = sorted_edges(mesh);
    for_each_edge(edges, [&](const Edge* first, const Edge* last) {
        if (surplus(first, last) == 0) return;
        open[first->a] = open[first->b] = true;
    });
    Box3d box;
    for (const Vec3d& p : mesh.positions)
        box.add(p);
    const double reach = box.empty() ? 0 : length(box.size()) * kWeldOfDiagonal;
    if (!(reach > 0)) return same;
    // Cells as large as the tolerance: near vertices are in neighbouring cells.
    using Cell = std::tuple<int64_t, int64_t, int64_t>;
    std::map<Cell, std::vector<int32_t>> cells;
    const auto cell = [&](double x, double lo) {
        return static_cast<int64_t>(std::floor((x - lo) / reach));
    };
    for (size_t v = 0; v < open.size(); ++v) {
        if (!open[v]) continue;
        const Vec3d& p = mesh.positions[v];
        const int64_t x = cell(p.x, box.lo.x), y = cell(p.y, box.lo.y), z = cell(p.z, box.lo.z);
        int32_t found = -1;
        for (int64_t i = 0; i < 27; ++i) {
            const auto it = cells.find({x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1});
            if (it == cells.end()) continue;
            for (int32_t other : it->second) {
                if (length(at(mesh, other) - p) <= reach && (found < 0 || other < found))
                    found = other;
            }
        }
        if (found >= 0) {
            same[v] = found;
        } else {
            cells[{x, y, z}].push_back(static_cast<int32_t>(v));
        }
    }
    return same;
}

MeshRepair close_mesh(MeshSource* source) {
    Mesh& mesh = source->mesh;
    MeshRepair done;
    done.turned = agree(&mesh);
    const size_t triangles = mesh.triangles.size();
    const std::vector<Loop> loops = loops_of(rim_edges(mesh), mesh.positions.size());
    Capper capper(source);
    for (const Loop& loop : loops) {
        Box3d box;
        for (const RimEdge& e : loop)
            box.add(at(mesh, e.from));
        const double width = length(box.size());
        if (width > done.widest_mm) {
            done.widest_mm = width;
            done.center = box.center();
        }
        capper.close(loop);
    }
    done.holes = static_cast<int64_t>(loops.size());
    done.caps = static_cast<int64_t>(mesh.triangles.size() - triangles);
    split_vertices(&mesh);
    cut_shared_edges(source);
    return done;
}

}  // namespace openfab::mesh
