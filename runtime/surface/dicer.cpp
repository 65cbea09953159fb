// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/dicer.h"

#include <algorithm>

#include "base/check.h"
#include "runtime/surface/lattice.h"
#include "runtime/surface/strip_fold.h"

namespace openfab::surface {

Dicer::Dicer(const part::Part& part, const BaseMesh& base, const PatchTable& table,
             const StaticArgs& args, const NearestLayout& nearest, openfab_isa isa)
    : base_(base), table_(table), nearest_(nearest), batch_(part, base, args, nearest, isa) {}

abi::KernelStatus Dicer::dice(int32_t index, MicroMesh* out) {
    out->positions.clear();
    out->triangles.clear();
    out->vertex_attributes.clear();
    out->triangle_attributes.clear();
    batch_.clear();
    batch_.not_finite = batch_.cut_to_bound = 0;
    OPENFAB_CHECK_LT(static_cast<size_t>(index), table_.patches.size());
    const Patch& patch = table_.patches[index];
    const Seam* seam = nullptr;
    switch (patch.kind) {
        case PatchKind::kIdentity:
            dice_identity(patch.triangle, out);
            return {};
        case PatchKind::kFan:
            dice_fan(patch, out);
            return {};
        case PatchKind::kLattice:
            batch_.add_tile(patch.triangle, {patch.lattice[0], patch.lattice[1], patch.lattice[2],
                                             patch.lattice[3]});
            break;
        case PatchKind::kSeam:
            seam = &table_.seams[static_cast<size_t>(index - table_.first_seam)];
            if (seam->side >= 0) {
                // The kernel wants displaced runs first; dice_strip finds the two by their order
                // here.
                const int32_t forward = seam->side, backward = base_.partner[forward];
                const bool swap =
                    base_.classes[static_cast<size_t>(forward / 3)] == TriangleClass::kIdentity;
                batch_.add_side(swap ? backward : forward, seam->i0, seam->i1);
                batch_.add_side(swap ? forward : backward, seam->i0, seam->i1);
            } else {
                const size_t v = static_cast<size_t>(seam->vertex);
                for (const TriangleClass c :
                     {TriangleClass::kDisplaced, TriangleClass::kIdentity}) {
                    for (int32_t i = base_.vertex_first[v]; i < base_.vertex_first[v + 1]; ++i) {
                        const int32_t corner = base_.vertex_corners[i];
                        if (base_.classes[static_cast<size_t>(corner / 3)] == c)
                            batch_.add_corner(corner);
                    }
                }
            }
            break;
    }
    if (const abi::KernelStatus error = batch_.evaluate(); !error.ok()) return error;
    if (patch.kind == PatchKind::kLattice) {
        dice_tile(patch, 0, batch_.size(), out);
    } else if (seam->side >= 0) {
        dice_strip(*seam, out);
    } else {
        dice_vertex(*seam, out);
    }
    return {};
}

abi::KernelStatus Dicer::dice_lattices(std::span<const int32_t> patches,
                                       std::vector<MicroMesh>* out) {
    out->assign(patches.size(), {});
    batch_.clear();
    batch_.not_finite = batch_.cut_to_bound = 0;
    firsts_.clear();
    for (const int32_t index : patches) {
        const Patch& patch = table_.patches[static_cast<size_t>(index)];
        OPENFAB_CHECK(patch.kind == PatchKind::kLattice);
        firsts_.push_back(batch_.add_tile(patch.triangle, {patch.lattice[0], patch.lattice[1],
                                                           patch.lattice[2], patch.lattice[3]}));
    }
    firsts_.push_back(batch_.size());
    if (const abi::KernelStatus error = batch_.evaluate(); !error.ok()) return error;
    for (size_t i = 0; i < patches.size(); ++i) {
        dice_tile(table_.patches[static_cast<size_t>(patches[i])], firsts_[i],
                  firsts_[i + 1] - firsts_[i], &(*out)[i]);
    }
    return {};
}

void Dicer::dice_identity(int32_t triangle, MicroMesh* out) const {
    const part::PartMesh& mesh = base_.mesh();
    const auto attribute = [&](const NearestComponent& from) -> const part::PartAttribute& {
        const auto& all =
            from.from == NearestComponent::From::kMesh ? mesh.nearest_attributes : mesh.inputs;
        return all[from.index];
    };
    std::array<Vec3f, 3> corners;
    const bool any = base_.rounded_corners(triangle, &corners);
    for (int32_t c = 0; c < 3; ++c) {
        out->positions.push_back(corners[c]);
        for (const NearestComponent& from : nearest_.floats) {
            const part::PartAttribute& a = attribute(from);
            out->vertex_attributes.push_back(a.corner_values[static_cast<size_t>(
                (3 * triangle + c) * a.components + from.component)]);
        }
    }
    if (!any) return;
    out->triangles.push_back({0, 1, 2});
    for (const NearestComponent& from : nearest_.ints) {
        const part::PartAttribute& a = attribute(from);
        out->triangle_attributes.push_back(
            a.face_values[static_cast<size_t>(triangle * a.components + from.component)]);
    }
}

/// Only the voxeliser sees fans, so they carry no attributes.
void Dicer::dice_fan(const Patch& patch, MicroMesh* out) const {
    const int32_t t = patch.triangle;
    const FanShape shape = fan_shape(base_, t);
    const Vec3d &p0 = base_.position(3 * t), &p1 = base_.position(3 * t + 1),
                &p2 = base_.position(3 * t + 2);
    Vec3d apex;
    if (shape.apex_corner >= 0) {
        apex = base_.position(3 * t + shape.apex_corner);
    } else {
        for (int axis = 0; axis < 3; ++axis) {
            const double lo = std::min({p0[axis], p1[axis], p2[axis]}),
                         hi = std::max({p0[axis], p1[axis], p2[axis]});
            apex[axis] =
                clamp_to(((p1[axis] - p0[axis]) + (p2[axis] - p0[axis])) / 3 + p0[axis], lo, hi);
        }
    }
    out->positions.push_back(round_position(apex));
    const int32_t begin = patch.lattice[0], end = patch.lattice[2];
    int32_t before = 0;  // pieces of earlier sides
    for (int32_t e = 0; e < 3; ++e) {
        const int32_t side = 3 * t + e, pieces = shape.pieces[e];
        const int32_t from = std::max(begin - before, 0), to = std::min(end - before, pieces);
        before += pieces;
        if (from >= to) continue;
        const Vec3d &lo = base_.position(base_.lower_corner(side)),
                    &hi = base_.position(base_.upper_corner(side));
        for (int32_t j = from; j <= to; ++j) {
            const int32_t i = base_.forward(side) ? j : pieces - j;
            out->positions.push_back(round_position(edge_position(lo, hi, i, pieces)));
            if (j == from) continue;
            const int32_t last = static_cast<int32_t>(out->positions.size()) - 1;
            const auto& p = out->positions;
            if (degenerate(p[0], p[static_cast<size_t>(last) - 1], p[last])) continue;
            out->triangles.push_back({0, last - 1, last});
        }
    }
}

void Dicer::append_vertices(int32_t first, int32_t count, MicroMesh* out) const {
    const size_t floats = nearest_.floats.size(), at = out->positions.size();
    out->positions.resize(at + static_cast<size_t>(count));
    for (int32_t i = 0; i < count; ++i)
        out->positions[at + static_cast<size_t>(i)] = batch_.position(first + i);
    out->vertex_attributes.resize((at + static_cast<size_t>(count)) * floats);
    for (size_t k = 0; k < floats; ++k) {
        batch_.float_attribute(k, first, count, out->vertex_attributes.data() + at * floats + k,
                               floats);
    }
}

void Dicer::append_ints(int32_t vertex, MicroMesh* out) const {
    for (size_t k = 0; k < nearest_.ints.size(); ++k) {
        out->triangle_attributes.push_back(batch_.int_attribute(k, vertex));
    }
}

/// `int_vertex` is the vertex of the batch that the triangle's ints come from.
void Dicer::add_triangle(int32_t a, int32_t b, int32_t c, int32_t int_vertex,
                         MicroMesh* out) const {
    const std::vector<Vec3f>& p = out->positions;
    if (degenerate(p[a], p[b], p[c])) return;
    out->triangles.push_back({a, b, c});
    append_ints(int_vertex, out);
}

/// Takes the patch's points, `count` from `first` on in the batch.
void Dicer::dice_tile(const Patch& patch, int32_t first, int32_t count, MicroMesh* out) {
    const auto [a0, b0, a1, b1] = patch.lattice;
    const int32_t n = base_.lattice_factor(patch.triangle);
    append_vertices(first, count, out);
    int32_t most = 0;
    for (int32_t b = b0; b < b1; ++b)
        most += 2 * (std::min(a1, n - b) - a0) - (n - b <= a1 ? 1 : 0);
    out->triangles.reserve(static_cast<size_t>(most));
    const std::vector<Vec3f>& p = out->positions;
    const auto place = [&](int32_t a, int32_t b, int32_t c) {
        if (!degenerate(p[a], p[b], p[c])) {
            out->triangles.push_back({a, b, c});
        }
    };
    int32_t row = 0;
    for (int32_t b = b0; b < b1; ++b) {
        const int32_t end = std::min(a1, n - b), next_end = std::min(a1, n - b - 1);
        const int32_t next_row = row + end - a0 + 1;
        for (int32_t a = a0; a < end; ++a) {
            const int32_t here = row + a - a0, over = next_row + a - a0;
            place(here, here + 1, over);
            if (a + 1 <= next_end) place(here + 1, over + 1, over);
        }
        row = next_row;
    }
    // A triangle's ints are those of its first corner.
    const size_t ints = nearest_.ints.size();
    out->triangle_attributes.resize(out->triangles.size() * ints);
    for (size_t k = 0; k < ints; ++k) {
        const uint32_t flat = batch_.int_is_flat(k) ? batch_.int_attribute(k, first) : 0;
        for (size_t i = 0; i < out->triangles.size(); ++i) {
            out->triangle_attributes[i * ints + k] =
                batch_.int_is_flat(k) ? flat
                                      : batch_.int_attribute(k, first + out->triangles[i][0]);
        }
    }
}

void Dicer::dice_strip(const Seam& seam, MicroMesh* out) {
    const int32_t forward = seam.side, backward = base_.partner[forward];
    const int32_t points = seam.i1 - seam.i0 + 1;
    const bool swap = base_.classes[static_cast<size_t>(forward / 3)] == TriangleClass::kIdentity;
    // Order in the mesh: the forward side's points, then the backward side's.
    const int32_t forward_at = swap ? points : 0, backward_at = swap ? 0 : points;
    append_vertices(forward_at, points, out);
    append_vertices(backward_at, points, out);
    if (seam.folds && find_folds(seam, forward_at, backward_at)) {
        dice_folded_strip(seam, forward_at, backward_at, out);
        return;
    }
    const int32_t ints_at = forward / 3 < backward / 3 ? forward_at : backward_at;
    for (int32_t i = 0; i + 1 < points; ++i) {
        const int32_t t = i, u = points + i;
        add_triangle(t + 1, t, u, ints_at + i, out);
        add_triangle(t + 1, u, u + 1, ints_at + i, out);
    }
    if (out->triangles.empty()) out->positions.clear(), out->vertex_attributes.clear();
}

/// Sets edge_ and folded_; returns whether the strip is folded anywhere.
bool Dicer::find_folds(const Seam& seam, int32_t forward_at, int32_t backward_at) {
    const int32_t points = seam.i1 - seam.i0 + 1;
    const Vec3d &lo = base_.position(base_.lower_corner(seam.side)),
                &hi = base_.position(base_.upper_corner(seam.side));
    const StripFold fold(base_, seam.side);
    edge_.resize(static_cast<size_t>(points));
    folded_.resize(static_cast<size_t>(points));
    bool any = false;
    for (int32_t i = 0; i < points; ++i) {
        const Vec3f e = round_position(edge_position(lo, hi, seam.i0 + i, base_.factor[seam.side]));
        const bool folded =
            fold.at(e, batch_.position(forward_at + i), batch_.position(backward_at + i));
        edge_[i] = e;
        folded_[i] = folded ? 1 : 0;
        any |= folded;
    }
    return any;
}

/// After the points of both sides in `out` stand those of the edge, with the attributes of the
/// forward side and again with those of the other.
void Dicer::dice_folded_strip(const Seam& seam, int32_t forward_at, int32_t backward_at,
                              MicroMesh* out) {
    const int32_t points = seam.i1 - seam.i0 + 1;
    for (int32_t copy = 0; copy < 2; ++copy)
        out->positions.insert(out->positions.end(), edge_.begin(), edge_.end());
    const auto attributes = out->vertex_attributes.size();
    out->vertex_attributes.resize(2 * attributes);
    std::copy_n(out->vertex_attributes.begin(), attributes,
                out->vertex_attributes.begin() + static_cast<ptrdiff_t>(attributes));
    const int32_t ints_at = seam.side / 3 < base_.partner[seam.side] / 3 ? forward_at : backward_at;
    const auto folded = [&](int32_t i) { return folded_[i] != 0; };
    const auto t = [&](int32_t i) { return i; };
    const auto u = [&](int32_t i) { return points + i; };
    const auto et = [&](int32_t i) { return 2 * points + i; };
    const auto eu = [&](int32_t i) { return 3 * points + i; };
    const int32_t last = points - 1;
    // The fans at the vertices go from T to U.
    if (seam.i0 == 0 && folded(0)) add_triangle(t(0), u(0), et(0), ints_at, out);
    for (int32_t i = 0; i < last; ++i) {
        const int32_t n = i + 1, t_ints = forward_at + i, u_ints = backward_at + i;
        if (folded(i)) {
            add_triangle(t(n), t(i), et(i), t_ints, out);
            if (folded(n)) {
                add_triangle(t(n), et(i), et(n), t_ints, out);
                add_triangle(eu(n), eu(i), u(i), u_ints, out);
                add_triangle(eu(n), u(i), u(n), u_ints, out);
            } else {
                add_triangle(t(n), et(i), u(n), ints_at + i, out);
                add_triangle(u(n), eu(i), u(i), u_ints, out);
            }
        } else if (folded(n)) {
            add_triangle(t(n), t(i), et(n), t_ints, out);
            add_triangle(et(n), t(i), u(i), ints_at + i, out);
            add_triangle(eu(n), u(i), u(n), u_ints, out);
        } else {
            add_triangle(t(n), t(i), u(i), ints_at + i, out);
            add_triangle(t(n), u(i), u(n), ints_at + i, out);
        }
    }
    if (seam.i1 == base_.factor[seam.side] && folded(last))
        add_triangle(u(last), t(last), et(last), ints_at + last, out);
}

/// The ends of the strips at a vertex form closed loops through the positions that its triangles
/// give it. A fan from the place of the first triangle closes them: (first, partner's place, own
/// place) for each side that leaves the vertex.
void Dicer::dice_vertex(const Seam& seam, MicroMesh* out) {
    const size_t v = static_cast<size_t>(seam.vertex);
    const auto begin = base_.vertex_corners.begin() + base_.vertex_first[v];
    const auto end = base_.vertex_corners.begin() + base_.vertex_first[v + 1];
    // Indices in the batch, displaced corners before identities; the mesh keeps the order of
    // corners.
    std::vector<int32_t> batch_at(static_cast<size_t>(end - begin));
    int32_t next = 0;
    for (const TriangleClass c : {TriangleClass::kDisplaced, TriangleClass::kIdentity}) {
        for (auto it = begin; it != end; ++it) {
            if (base_.classes[static_cast<size_t>(*it / 3)] == c)
                batch_at[static_cast<size_t>(it - begin)] = next++;
        }
    }
    for (const int32_t at : batch_at)
        append_vertices(at, 1, out);
    for (auto it = begin; it != end; ++it) {
        const int32_t side = *it, other = base_.partner[side];
        if (other < 0) continue;
        const int32_t corner = BaseMesh::next_corner(other);
        const auto found = std::lower_bound(begin, end, corner);
        add_triangle(0, static_cast<int32_t>(found - begin), static_cast<int32_t>(it - begin),
                     batch_at[0], out);
    }
    if (out->triangles.empty()) out->positions.clear(), out->vertex_attributes.clear();
}

}  // namespace openfab::surface
