// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/shape_field.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <tuple>

#include "runtime/solid/shape/cell_triangles.h"

namespace openfab::solid {

namespace {

// Steps of the search for a zero. Most end after five; a value that jumps takes all of them.
constexpr int32_t kMostSteps = 40;
// Cells from one of the vertices that are looked at first to the next.
constexpr int32_t kSome = 4;
// Points that are worth a call of a kernel.
constexpr size_t kAtOnce = 1000;

int32_t round_to_power(int32_t n) {
    int32_t power = 1;
    while (power < n)
        power *= 2;
    return power;
}

}  // namespace

ShapeField::ShapeField(const part::ShapeStage& stage, const Bodies& bodies,
                       const openfab_fablet& fablet, double cell_mm, openfab_isa isa)
    : stage_(stage),
      fixed_(stage),
      bodies_(stage, bodies, cell_mm, isa),
      cell_mm_(cell_mm),
      isa_(isa) {
    Box3d box;
    const std::array<double, 3>& stretch = stage.stretch;
    for (const Vec3d& p : stage.mesh->positions)
        box.add(Vec3d{p.x * stretch[0], p.y * stretch[1], p.z * stretch[2]});
    for (int a = 0; a < 3; ++a) {
        box_.lo[a] = static_cast<float>(box.lo[a]);
        box_.hi[a] = static_cast<float>(box.hi[a]);
        first_[a] = static_cast<int32_t>(std::floor(box.lo[a] / cell_mm)) - 1;
        cells_[a] = static_cast<int32_t>(std::ceil(box.hi[a] / cell_mm)) + 1 - first_[a];
        for (int32_t vertex = 0; vertex <= cells_[a]; ++vertex) {
            const auto at = static_cast<float>(static_cast<double>(first_[a] + vertex) * cell_mm);
            places_[static_cast<size_t>(a)].push_back(std::clamp(at, box_.lo[a], box_.hi[a]));
        }
    }
    const openfab_shape& shape = *stage.fablet->shape;
    std::vector<size_t> places;
    size_t next = 0;
    for (int32_t i = 0; i < shape.output_count; ++i) {
        places.push_back(next);
        next += static_cast<size_t>(shape.outputs[i].components);
    }
    for (int32_t i = 0; i < fablet.nearest_count; ++i) {
        const openfab_varying& input = fablet.nearest[i];
        for (int32_t k = 0; k < shape.output_count; ++k) {
            if (std::strcmp(shape.outputs[k].name, input.name) != 0) continue;
            for (int32_t c = 0; c < input.components; ++c)
                (input.scalar == OPENFAB_FLOAT ? floats_ : ints_)
                    .push_back(places[static_cast<size_t>(k)] + static_cast<size_t>(c));
        }
    }
}

bool ShapeField::is_distance() const {
    return part::declared_scale(stage_) != 0;
}

Vec3f ShapeField::origin() const {
    Vec3f out;
    for (int a = 0; a < 3; ++a)
        out[a] = static_cast<float>(static_cast<double>(first_[a]) * cell_mm_);
    return out;
}

bool ShapeField::at_border(const Box3f& box) const {
    for (int a = 0; a < 3; ++a) {
        if (box.lo[a] <= box_.lo[a] || box.hi[a] >= box_.hi[a]) return true;
    }
    return false;
}

void ShapeField::close_border(const Box3f& around, const ShapePoints& points,
                              std::vector<float>* values) const {
    if (!at_border(around)) return;
    for (size_t i = 0; i < points.size(); ++i) {
        if ((*values)[i] < 0 && at_border({points.point(i), points.point(i)})) (*values)[i] = 0;
    }
}

Vec3i ShapeField::end_of(const Node& node) const {
    Vec3i end;
    for (int a = 0; a < 3; ++a)
        end[a] = std::min(node.lowest[a] + node.size, cells_[a]);
    return end;
}

void ShapeField::append_vertices(const Vec3i& first, const Vec3i& last, int32_t step,
                                 ShapePoints* to) const {
    const auto count = [&](int a) { return static_cast<size_t>((last[a] - first[a]) / step + 1); };
    const size_t begin = to->size(), row = count(0), rows = count(1) * count(2);
    to->resize(begin + row * rows);
    std::array<float*, 3> at{};
    for (size_t a = 0; a < 3; ++a)
        at[a] = to->at[a].data() + begin;
    for (int32_t z = first.z; z <= last.z; z += step) {
        for (int32_t y = first.y; y <= last.y; y += step) {
            for (size_t i = 0; i < row; ++i)
                at[0][i] = places_[0][static_cast<size_t>(first.x) + i * static_cast<size_t>(step)];
            std::fill_n(at[1], row, places_[1][static_cast<size_t>(y)]);
            std::fill_n(at[2], row, places_[2][static_cast<size_t>(z)]);
            for (float*& axis : at)
                axis += row;
        }
    }
}

Box3f ShapeField::box_of(const Node& node) const {
    return {position(node.lowest), position(end_of(node))};
}

Box3f ShapeField::block_box(const Vec3i& lowest) const {
    return box_of({lowest, kPatchCells});
}

ShapeField::Node ShapeField::root() const {
    return {
        {0, 0, 0},
        kPatchCells * round_to_power((std::max({cells_.x, cells_.y, cells_.z}) + kPatchCells - 1) /
                                     kPatchCells)};
}

Box3f ShapeField::common(const Box3f& a, const Box3f& b) {
    Box3f out;
    for (int k = 0; k < 3; ++k)
        out.lo[k] = std::max(a.lo[k], b.lo[k]), out.hi[k] = std::min(a.hi[k], b.hi[k]);
    return out;
}

void ShapeField::split(const Node& node, const Box3f& within, ShapeCalls* calls,
                       std::vector<Node>* out) const {
    const int32_t half = node.size / 2;
    std::vector<Node> parts;
    ShapePoints lo, hi;
    for (int32_t k = 0; k < 8; ++k) {
        const Node part{node.lowest + Vec3i{(k & 1) * half, (k >> 1 & 1) * half, (k >> 2) * half},
                        half};
        if (part.lowest.x >= cells_.x || part.lowest.y >= cells_.y || part.lowest.z >= cells_.z)
            continue;
        const Box3f box = common(box_of(part), within);
        if (box.empty()) continue;
        parts.push_back(part);
        lo.push_back(box.lo);
        hi.push_back(box.hi);
    }
    std::vector<float> value_lo, value_hi;
    if (const abi::KernelStatus status = calls->sign_bounds(lo, hi, &value_lo, &value_hi);
        !status.ok())
        return note(status);
    for (size_t i = 0; i < parts.size(); ++i) {
        const bool outside = value_lo[i] >= 0;
        const bool inside = value_hi[i] < 0 && !at_border({lo.point(i), hi.point(i)});
        if (!outside && !inside) out->push_back(parts[i]);
    }
}

/// A block's values and micro-vertices.
struct ShapeField::Diced {
    Vec3i lowest, cells;
    ShapePoints vertices;
    std::vector<float> values;
    /// [axis][vertex]: the micro-vertex on the edge that begins there, or -1.
    std::array<std::vector<int32_t>, 3> edge;
    std::vector<std::array<int32_t, 2>> ends;  ///< vertices of each micro-vertex's edge
    std::vector<int32_t> axis;
    ShapePoints zeros;

    int32_t number(int32_t x, int32_t y, int32_t z) const {
        return (z * (cells.y + 1) + y) * (cells.x + 1) + x;
    }
};

/// Returns whether some vertices are inside and some are not. Values are numbers of their signs.
bool ShapeField::fill_signs(const Vec3i& lowest, ShapeCalls* calls, Diced* diced) const {
    diced->lowest = lowest;
    diced->cells = end_of({lowest, kPatchCells}) - lowest;
    const Vec3i& n = diced->cells;
    append_vertices(lowest, lowest + n, 1, &diced->vertices);
    if (const abi::KernelStatus status = calls->dense_signs(diced->vertices, &diced->values);
        !status.ok()) {
        note(status);
        return false;
    }
    close_border(block_box(lowest), diced->vertices, &diced->values);
    bool inside = false, outside = false;
    for (size_t i = 0; i < diced->vertices.size(); ++i) {
        const bool in = diced->values[i] < 0;
        inside |= in;
        outside |= !in;
        if (std::isnan(diced->values[i])) note_nan(diced->vertices.point(i));
    }
    return inside && outside;
}

/// Returns what fill_signs does. Most blocks show it at every fourth vertex, others where bounds leave
/// it open.
bool ShapeField::crosses(const Node& block, ShapeCalls* calls) const {
    const Vec3i end = end_of(block);
    const Box3f around = box_of(block);
    bool inside = false, outside = false;
    ShapePoints points, lo, hi;
    std::vector<float> values, value_lo, value_hi;
    // Those of the points at which bounds do not tell: all, without a list of them, where bounds are no cheaper.
    ShapePoints open;
    const ShapePoints& rest = calls->asks() ? open : points;
    const auto guess = [&] {
        if (!calls->asks()) return true;
        const abi::KernelStatus status = calls->cheap_signs(points, &values);
        close_border(around, points, &values);
        open.clear();
        for (size_t i = 0; i < points.size(); ++i) {
            if (std::isnan(values[i])) {
                open.push_back(points.point(i));
            } else {
                (values[i] < 0 ? inside : outside) = true;
            }
        }
        if (!status.ok()) note(status);
        return status.ok();
    };
    const auto look = [&] {
        if ((inside && outside) || rest.size() == 0) return true;
        const abi::KernelStatus status = calls->values(rest, &values);
        close_border(around, rest, &values);
        for (size_t i = 0; i < rest.size(); ++i) {
            (values[i] < 0 ? inside : outside) = true;
            if (std::isnan(values[i])) note_nan(rest.point(i));
        }
        if (!status.ok()) note(status);
        return status.ok();
    };
    std::vector<Node> left;
    const auto decided = [&](size_t i) {
        const bool inside_all = value_hi[i] < 0 && !at_border({lo.point(i), hi.point(i)});
        if (!(value_lo[i] >= 0) && !inside_all) return false;
        (inside_all ? inside : outside) = true;
        return true;
    };
    append_vertices(block.lowest, end, kSome, &points);
    if (!guess() || (!calls->asks() && !look())) return false;
    if (inside && outside) return true;
    for (int32_t z = block.lowest.z; z < end.z; z += kSome) {
        for (int32_t y = block.lowest.y; y < end.y; y += kSome) {
            for (int32_t x = block.lowest.x; x < end.x; x += kSome) {
                left.push_back({{x, y, z}, kSome});
                const Box3f box = box_of(left.back());
                lo.push_back(box.lo);
                hi.push_back(box.hi);
            }
        }
    }
    // What is asked for distances makes no micropolygons as long as something else may tell.
    if (calls->asks()) {
        if (const abi::KernelStatus status = calls->cheap_bounds(lo, hi, &value_lo, &value_hi);
            !status.ok()) {
            note(status);
            return false;
        }
        for (size_t i = 0; i < left.size(); ++i)
            decided(i);
        if (!look()) return false;
        if (inside && outside) return true;
    }
    if (const abi::KernelStatus status = calls->sign_bounds(lo, hi, &value_lo, &value_hi);
        !status.ok()) {
        note(status);
        return false;
    }
    points.clear();
    for (size_t i = 0; i < left.size(); ++i) {
        if (!decided(i)) append_vertices(left[i].lowest, end_of(left[i]), 1, &points);
        // Many at a time, but not all: the first ones mostly tell.
        if (points.size() >= kAtOnce || (i + 1 == left.size() && points.size() > 0)) {
            if (!guess() || !look()) return false;
            points.clear();
        }
        if (inside && outside) return true;
    }
    return false;
}

/// Computes the values at the ends of edges, where signs are numbers of another kind.
abi::KernelStatus ShapeField::fill_ends(ShapeCalls* calls, Diced* diced) const {
    if (!calls->asks()) return {};
    std::vector<size_t> which;
    std::vector<uint8_t> taken(diced->vertices.size(), 0);
    ShapePoints points;
    for (const auto& ends : diced->ends) {
        for (const int32_t end : ends) {
            const auto vertex = static_cast<size_t>(end);
            if (std::exchange(taken[vertex], uint8_t{1}) != 0) continue;
            which.push_back(vertex);
            points.push_back(diced->vertices.point(vertex));
        }
    }
    std::vector<float> values;
    const abi::KernelStatus status = calls->dense_values(points, &values);
    close_border(block_box(diced->lowest), points, &values);
    for (size_t k = 0; k < which.size(); ++k)
        diced->values[which[k]] = values[k];
    return status;
}

/// Regula falsi with the Illinois rule, all edges at once. What an edge gives depends on nothing but
/// the edge: it ends by itself, when a step is below 2^-20 of it.
void ShapeField::find_zeros(ShapeCalls* calls, Diced* diced) const {
    if (const abi::KernelStatus status = fill_ends(calls, diced); !status.ok()) return note(status);
    const size_t n = diced->ends.size();
    struct Bracket {
        float a, fa, b, fb, x;
        int32_t kept;  ///< the end that stayed last: 1 a, 2 b
    };
    std::vector<Bracket> brackets(n);
    std::vector<size_t> open;
    diced->zeros.resize(n);
    for (size_t i = 0; i < n; ++i) {
        const auto [from, to] = diced->ends[i];
        const auto axis = static_cast<size_t>(diced->axis[i]);
        const auto f = static_cast<size_t>(from), t = static_cast<size_t>(to);
        diced->zeros.set(i, diced->vertices.point(f));
        const float a = diced->vertices.at[axis][f], b = diced->vertices.at[axis][t];
        brackets[i] = {a, diced->values[f], b, diced->values[t], a, 0};
        open.push_back(i);
    }
    ShapePoints points;
    std::vector<float> values;
    for (int32_t step = 0; step < kMostSteps && !open.empty(); ++step) {
        points.resize(open.size());
        for (size_t k = 0; k < open.size(); ++k) {
            Bracket& at = brackets[open[k]];
            const double way = static_cast<double>(at.b) - static_cast<double>(at.a);
            double share = static_cast<double>(at.fa) /
                           (static_cast<double>(at.fa) - static_cast<double>(at.fb));
            // Halves where the values say nothing, and where they converge badly.
            if (!(share >= 0 && share <= 1) || step % 8 == 7) share = 0.5;
            at.x = static_cast<float>(static_cast<double>(at.a) + share * way);
            Vec3f p = diced->zeros.point(open[k]);
            p[diced->axis[open[k]]] = at.x;
            points.set(k, p);
        }
        if (const abi::KernelStatus status = calls->dense_values(points, &values); !status.ok())
            return note(status);
        size_t left = 0;
        for (size_t k = 0; k < open.size(); ++k) {
            Bracket& at = brackets[open[k]];
            const float f = values[k];
            const auto axis = static_cast<size_t>(diced->axis[open[k]]);
            const float before = diced->zeros.at[axis][open[k]];
            diced->zeros.at[axis][open[k]] = at.x;
            const double size = cell_mm_ * 0x1p-20;
            if (f == 0 ||
                std::fabs(static_cast<double>(at.x) - static_cast<double>(before)) <= size)
                continue;
            if ((f < 0) == (at.fa < 0)) {
                at.a = at.x, at.fa = f;
                if (at.kept == 2) at.fb *= 0.5f;
                at.kept = 2;
            } else {
                at.b = at.x, at.fb = f;
                if (at.kept == 1) at.fa *= 0.5f;
                at.kept = 1;
            }
            open[left++] = open[k];
        }
        open.resize(left);
    }
}

void ShapeField::dice(const Vec3i& lowest, surface::MicroMesh* out) const {
    ShapeCalls* calls = take();
    Diced diced;
    if (!fill_signs(lowest, calls, &diced)) return give(calls);
    const Vec3i& n = diced.cells;
    for (auto& axis : diced.edge)
        axis.assign(diced.vertices.size(), -1);
    for (int32_t z = 0; z <= n.z; ++z) {
        for (int32_t y = 0; y <= n.y; ++y) {
            for (int32_t x = 0; x <= n.x; ++x) {
                const Vec3i at{x, y, z};
                const int32_t from = diced.number(x, y, z);
                for (int32_t axis = 0; axis < 3; ++axis) {
                    if (at[axis] == n[axis]) continue;
                    Vec3i next = at;
                    ++next[axis];
                    const int32_t to = diced.number(next.x, next.y, next.z);
                    if ((diced.values[from] < 0) == (diced.values[to] < 0)) continue;
                    diced.edge[static_cast<size_t>(axis)][static_cast<size_t>(from)] =
                        static_cast<int32_t>(diced.ends.size());
                    diced.ends.push_back({from, to});
                    diced.axis.push_back(axis);
                }
            }
        }
    }
    find_zeros(calls, &diced);
    for (size_t i = 0; i < diced.ends.size(); ++i)
        out->positions.push_back(diced.zeros.point(i));
    std::vector<std::vector<uint32_t>> outputs;
    if (!floats_.empty() || !ints_.empty()) {
        if (const abi::KernelStatus status = calls->attributes(diced.zeros, &outputs); !status.ok())
            note(status);
        for (size_t i = 0; i < diced.ends.size(); ++i) {
            for (const size_t component : floats_)
                out->vertex_attributes.push_back(std::bit_cast<float>(outputs[component][i]));
        }
    }
    const auto& table = cell_triangles();
    std::array<CellEdge, 12> edges;
    for (int32_t e = 0; e < 12; ++e)
        edges[static_cast<size_t>(e)] = cell_edge(e);
    for (int32_t z = 0; z < n.z; ++z) {
        for (int32_t y = 0; y < n.y; ++y) {
            for (int32_t x = 0; x < n.x; ++x) {
                const auto corner = [&](int32_t c) {
                    return diced.number(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2));
                };
                size_t pattern = 0;
                for (int32_t c = 0; c < 8; ++c)
                    pattern |= diced.values[corner(c)] < 0 ? size_t{1} << c : 0;
                for (const std::array<int32_t, 3>& triangle : table[pattern]) {
                    std::array<int32_t, 3> made;
                    for (size_t k = 0; k < 3; ++k) {
                        const auto e = static_cast<size_t>(triangle[k]);
                        made[k] = diced.edge[e / 4][static_cast<size_t>(corner(edges[e].from))];
                    }
                    const Vec3f &a = out->positions[static_cast<size_t>(made[0])],
                                &b = out->positions[static_cast<size_t>(made[1])],
                                &c = out->positions[static_cast<size_t>(made[2])];
                    if (a == b || b == c || c == a) continue;
                    out->triangles.push_back(made);
                    for (const size_t component : ints_)
                        out->triangle_attributes.push_back(
                            outputs[component][static_cast<size_t>(made[0])]);
                }
            }
        }
    }
    give(calls);
}

std::vector<Vec3i> ShapeField::find_blocks(const std::atomic<bool>* stop) const {
    // Level by level, each in parallel.
    std::vector<Node> open{root()};
    while (!open.empty() && open.front().size > kPatchCells) {
        std::vector<std::vector<Node>> parts(open.size());
        tbb::parallel_for(size_t{0}, open.size(), [&](size_t i) {
            if (stop != nullptr && stop->load(std::memory_order_relaxed)) return;
            ShapeCalls* calls = take();
            split(open[i], bounds(), calls, &parts[i]);
            give(calls);
        });
        open.clear();
        for (const auto& some : parts)
            open.insert(open.end(), some.begin(), some.end());
    }
    std::vector<uint8_t> has(open.size(), 0);
    tbb::parallel_for(size_t{0}, open.size(), [&](size_t i) {
        if (stop != nullptr && stop->load(std::memory_order_relaxed)) return;
        ShapeCalls* calls = take();
        has[i] = crosses(open[i], calls) ? 1 : 0;
        give(calls);
    });
    std::vector<Vec3i> out;
    for (size_t i = 0; i < open.size(); ++i) {
        if (has[i] != 0) out.push_back(open[i].lowest);
    }
    std::sort(out.begin(), out.end(), [](const Vec3i& a, const Vec3i& b) {
        return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
    });
    return out;
}

}  // namespace openfab::solid
