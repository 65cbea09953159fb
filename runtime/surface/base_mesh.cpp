// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/base_mesh.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cstring>
#include <numeric>

#include "runtime/surface/lattice.h"

namespace openfab::surface {

BaseMesh::BaseMesh(const part::Part& part) : mesh_(*part.mesh) {
    classes.resize(mesh_.triangles.size(), TriangleClass::kDisplaced);
    tbb::parallel_for(tbb::blocked_range<int32_t>(0, triangle_count(), 16384),
                      [&](const auto& range) {
                          for (int32_t t = range.begin(); t < range.end(); ++t) {
                              const Vec3d &a = position(3 * t), &b = position(3 * t + 1),
                                          &c = position(3 * t + 2);
                              if (a == b || b == c || c == a) classes[t] = TriangleClass::kDropped;
                          }
                      });
}

void BaseMesh::set_factors(double micro_edge_mm) {
    micro_edge_mm_ = micro_edge_mm;
    factor.resize(3 * mesh_.triangles.size());
    tbb::parallel_for(
        tbb::blocked_range<int32_t>(0, triangle_count(), 4096), [&](const auto& range) {
            for (int32_t side = 3 * range.begin(); side < 3 * range.end(); ++side) {
                factor[side] =
                    edge_factor(position(side), position(next_corner(side)), micro_edge_mm);
            }
        });
}

bool BaseMesh::rounded_corners(int32_t triangle, std::array<Vec3f, 3>* out) const {
    for (int32_t c = 0; c < 3; ++c)
        (*out)[c] = round_position(position(3 * triangle + c));
    return !degenerate((*out)[0], (*out)[1], (*out)[2]);
}

int32_t BaseMesh::lattice_factor(int32_t triangle) const {
    const int32_t* n = factor.data() + 3 * static_cast<size_t>(triangle);
    return std::max({n[0], n[1], n[2]});
}

TangentFrame BaseMesh::frame(int32_t triangle) const {
    TangentFrame out;
    const Vec3d& p0 = position(3 * triangle);
    const Vec3d e1 = position(3 * triangle + 1) - p0, e2 = position(3 * triangle + 2) - p0;
    const Vec3d n = cross(e1, e2);
    const double area2 = length(n);
    if (area2 > 0) out.ng = vec_cast<float>(Vec3d{n.x / area2, n.y / area2, n.z / area2});
    if (mesh_.corner_uv.empty()) return out;
    const float* uv = mesh_.corner_uv.data() + 6 * static_cast<size_t>(triangle);
    const double u1 = static_cast<double>(uv[2]) - uv[0], v1 = static_cast<double>(uv[3]) - uv[1];
    const double u2 = static_cast<double>(uv[4]) - uv[0], v2 = static_cast<double>(uv[5]) - uv[1];
    const double det = u1 * v2 - v1 * u2;
    if (det != 0) {
        out.dpdu = vec_cast<float>((e1 * v2 - e2 * v1) * (1 / det));
        out.dpdv = vec_cast<float>((e2 * u1 - e1 * u2) * (1 / det));
    }
    return out;
}

void BaseMesh::connect() {
    weld();
    group_corners();
    pair_sides();
}

void BaseMesh::weld() {
    std::vector<int32_t> order(mesh_.positions.size());
    std::iota(order.begin(), order.end(), 0);
    const auto at = [&](int32_t i) -> const Vec3d& { return mesh_.positions[i]; };
    tbb::parallel_sort(order.begin(), order.end(), [&](int32_t a, int32_t b) {
        if (position_less(at(a), at(b))) return true;
        return !position_less(at(b), at(a)) && a < b;
    });
    std::vector<int32_t> rank(order.size());
    int32_t next = -1;
    for (size_t i = 0; i < order.size(); ++i) {
        if (i == 0 || position_less(at(order[i - 1]), at(order[i]))) ++next;
        rank[order[i]] = next;
    }
    vertex.resize(3 * mesh_.triangles.size());
    for (size_t corner = 0; corner < vertex.size(); ++corner) {
        vertex[corner] = rank[static_cast<size_t>(mesh_.triangles[corner / 3][corner % 3])];
    }
    vertex_first.assign(static_cast<size_t>(next) + 2, 0);
}

/// Orders corners by the bits of all inputs that the surface stage reads.
int BaseMesh::compare_inputs(int32_t corner_a, int32_t corner_b) const {
    const size_t a = static_cast<size_t>(corner_a), b = static_cast<size_t>(corner_b);
    if (!mesh_.corner_normals.empty()) {
        const int order =
            std::memcmp(&mesh_.corner_normals[a], &mesh_.corner_normals[b], sizeof(Vec3f));
        if (order != 0) return order;
    }
    if (!mesh_.corner_uv.empty()) {
        const int order =
            std::memcmp(&mesh_.corner_uv[2 * a], &mesh_.corner_uv[2 * b], 2 * sizeof(float));
        if (order != 0) return order;
    }
    for (const part::PartAttribute& input : mesh_.inputs) {
        const size_t components = static_cast<size_t>(input.components);
        const int order = input.scalar == OPENFAB_FLOAT
                              ? std::memcmp(&input.corner_values[a * components],
                                            &input.corner_values[b * components], 4 * components)
                              : std::memcmp(&input.face_values[a / 3 * components],
                                            &input.face_values[b / 3 * components], 4 * components);
        if (order != 0) return order;
    }
    return 0;
}

void BaseMesh::group_corners() {
    for (int32_t corner = 0; corner < 3 * triangle_count(); ++corner) {
        if (classes[static_cast<size_t>(corner / 3)] != TriangleClass::kDropped) {
            ++vertex_first[static_cast<size_t>(vertex[corner]) + 1];
        }
    }
    for (size_t v = 1; v < vertex_first.size(); ++v)
        vertex_first[v] += vertex_first[v - 1];
    std::vector<int32_t> fill(vertex_first.begin(), vertex_first.end() - 1);
    vertex_corners.resize(static_cast<size_t>(vertex_first.back()));
    for (int32_t corner = 0; corner < 3 * triangle_count(); ++corner) {
        if (classes[static_cast<size_t>(corner / 3)] == TriangleClass::kDropped) continue;
        const size_t v = static_cast<size_t>(vertex[corner]);
        vertex_corners[static_cast<size_t>(fill[v]++)] = corner;
    }
    corner_class.assign(vertex.size(), -1);
    const int32_t vertices = static_cast<int32_t>(vertex_first.size()) - 1;
    tbb::parallel_for(tbb::blocked_range<int32_t>(0, vertices, 4096), [&](const auto& range) {
        std::vector<int32_t> local;
        for (int32_t v = range.begin(); v < range.end(); ++v) {
            local.clear();
            for (int32_t i = vertex_first[v]; i < vertex_first[static_cast<size_t>(v) + 1]; ++i) {
                const int32_t corner = vertex_corners[i];
                if (classes[static_cast<size_t>(corner / 3)] == TriangleClass::kDisplaced)
                    local.push_back(corner);
            }
            std::sort(local.begin(), local.end(), [&](int32_t a, int32_t b) {
                const int order = compare_inputs(a, b);
                return order != 0 ? order < 0 : a < b;
            });
            for (size_t i = 0; i < local.size(); ++i) {
                const bool same = i > 0 && compare_inputs(local[i - 1], local[i]) == 0;
                corner_class[local[i]] =
                    same ? corner_class[static_cast<size_t>(local[i - 1])] : local[i];
            }
        }
    });
}

void BaseMesh::pair_sides() {
    struct Entry {
        uint64_t ends;  ///< lower and upper vertex
        int32_t side;
    };
    std::vector<Entry> entries;
    entries.reserve(vertex.size());
    for (int32_t side = 0; side < 3 * triangle_count(); ++side) {
        if (classes[static_cast<size_t>(side / 3)] == TriangleClass::kDropped) continue;
        const auto lower = static_cast<uint32_t>(vertex[static_cast<size_t>(lower_corner(side))]),
                   upper = static_cast<uint32_t>(vertex[static_cast<size_t>(upper_corner(side))]);
        entries.push_back({uint64_t{lower} << 32 | upper, side});
    }
    tbb::parallel_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
        return a.ends != b.ends ? a.ends < b.ends : a.side < b.side;
    });
    partner.assign(vertex.size(), -1);
    divided.assign(vertex.size(), 0);
    side_evaluator.assign(vertex.size(), -1);
    std::vector<int32_t> ways[2], displaced;
    for (size_t first = 0, end; first < entries.size(); first = end) {
        end = first + 1;
        while (end < entries.size() && entries[end].ends == entries[first].ends)
            ++end;
        ways[0].clear(), ways[1].clear(), displaced.clear();
        for (size_t i = first; i < end; ++i) {
            const int32_t side = entries[i].side;
            ways[forward(side) ? 0 : 1].push_back(side);
            if (classes[static_cast<size_t>(side / 3)] == TriangleClass::kDisplaced)
                displaced.push_back(side);
        }
        // If more than two triangles meet, the k-th of one direction is paired with the k-th of the
        // other: any such matching keeps the surface closed.
        for (size_t k = 0; k < std::min(ways[0].size(), ways[1].size()); ++k) {
            partner[static_cast<size_t>(ways[0][k])] = ways[1][k];
            partner[static_cast<size_t>(ways[1][k])] = ways[0][k];
        }
        for (size_t i = first; i < end; ++i) {
            divided[entries[i].side] = !displaced.empty();
        }
        const auto ends = [&](int32_t side) {
            return std::array<int32_t, 2>{corner_class[static_cast<size_t>(lower_corner(side))],
                                          corner_class[static_cast<size_t>(upper_corner(side))]};
        };
        std::sort(displaced.begin(), displaced.end(), [&](int32_t a, int32_t b) {
            return ends(a) != ends(b) ? ends(a) < ends(b) : a < b;
        });
        for (size_t i = 0; i < displaced.size(); ++i) {
            const bool same = i > 0 && ends(displaced[i - 1]) == ends(displaced[i]);
            side_evaluator[displaced[i]] =
                same ? side_evaluator[static_cast<size_t>(displaced[i - 1])] : displaced[i] / 3;
        }
    }
}

}  // namespace openfab::surface
