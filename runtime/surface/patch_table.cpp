// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/patch_table.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>

#include "runtime/surface/bounds_batch.h"
#include "runtime/surface/displacement_bounds.h"
#include "runtime/surface/lattice.h"
#include "runtime/surface/messages.h"
#include "runtime/surface/strip_fold.h"
#include "runtime/surface/tile_span.h"

namespace openfab::surface {

namespace {

constexpr int32_t kBoundsBatch = 512;  // patches a call of surface_bounds

bool is_finite(const Box3f& box) {
    for (int axis = 0; axis < 3; ++axis) {
        if (!(std::isfinite(box.lo[axis]) && std::isfinite(box.hi[axis]))) return false;
    }
    return true;
}

class TableBuilder {
  public:
    TableBuilder(const part::Part& part, const SurfaceOptions& options, const StaticArgs& args,
                 const NearestLayout& nearest, BaseMesh* base)
        : part_(part), options_(options), args_(args), nearest_(nearest), base_(*base) {}

    Result<PatchTable> build();

  private:
    Result<void> check_factors() const;
    void list_triangles();
    void list_seams();
    void add_strip(int32_t side);
    void add_vertex(int32_t vertex);
    Result<void> bound_tiles();
    void bound_identities();
    void bound_seams();
    void add_to_seam(int32_t seam_patch, int32_t patch);
    void add_side_to_seam(int32_t seam_patch, int32_t side, int32_t i0, int32_t i1);
    void add_corner_to_seam(int32_t seam_patch, int32_t corner);
    bool may_fold(const Seam& seam) const;
    bool displaced(int32_t triangle) const {
        return base_.classes[triangle] == TriangleClass::kDisplaced;
    }
    void size_ranges();
    Error no_bound(int32_t triangle) const;

    const part::Part& part_;
    const SurfaceOptions& options_;
    const StaticArgs& args_;
    const NearestLayout& nearest_;
    BaseMesh& base_;
    PatchTable table_;
};

Result<void> TableBuilder::check_factors() const {
    int32_t longest = -1;
    double longest_mm = 0;
    for (int32_t side = 0; side < 3 * base_.triangle_count(); ++side) {
        if (!displaced(side / 3) || base_.factor[side] <= kMaxEdgeFactor) {
            continue;
        }
        const double mm =
            length(base_.position(BaseMesh::next_corner(side)) - base_.position(side));
        if (mm > longest_mm) longest = side, longest_mm = mm;
    }
    if (longest < 0) return {};
    return user_error(fmt::format(messages::kEdgeTooLong, part_.name, longest / 3, longest_mm,
                                  kMaxEdgeFactor, options_.micro_edge_mm,
                                  kMaxEdgeFactor * options_.micro_edge_mm));
}

void TableBuilder::list_triangles() {
    std::vector<Patch>& patches = table_.patches;
    table_.first_patch.resize(base_.classes.size());
    patches.reserve(base_.classes.size());
    for (int32_t t = 0; t < base_.triangle_count(); ++t) {
        table_.first_patch[t] = static_cast<int32_t>(patches.size());
        if (base_.classes[t] == TriangleClass::kDropped) continue;
        Patch patch;
        patch.triangle = t;
        if (!displaced(t)) {
            const int32_t fan = table_.identity ? 0 : fan_shape(base_, t).total();
            if (fan > 0) patch.use = kForQuery;
            patches.push_back(patch);
            patch.kind = PatchKind::kFan;
            patch.use = kForCoverage;
            for (int32_t first = 0; first < fan; first += kFanTriangles) {
                patch.lattice = {first, 0, std::min(first + kFanTriangles, fan), 0};
                patches.push_back(patch);
            }
            continue;
        }
        patch.kind = PatchKind::kLattice;
        const int32_t n = base_.lattice_factor(t);
        patch.factor = static_cast<uint16_t>(n);  // check_factors
        for (int32_t row = 0; row < tile_rows(n); ++row) {
            for (int32_t column = 0; column + row < tile_rows(n); ++column) {
                const Tile tile = tile_at(n, column, row);
                patch.lattice = {tile.a0, tile.b0, tile.a1, tile.b1};
                patches.push_back(patch);
            }
        }
    }
    table_.first_seam = static_cast<int32_t>(patches.size());
}

void TableBuilder::add_strip(int32_t side) {
    Patch patch;
    patch.kind = PatchKind::kSeam;
    const int32_t n = base_.factor[side];
    for (int32_t i = 0; i < n; i += kSeamQuads) {
        table_.patches.push_back(patch);
        table_.seams.push_back({side, i, std::min(i + kSeamQuads, n), -1});
    }
}

/// Strips wherever the two sides of an edge may differ, in order of the pair's first triangle; then
/// vertices.
void TableBuilder::list_seams() {
    for (int32_t side = 0; side < 3 * base_.triangle_count(); ++side) {
        const int32_t other = base_.partner[side];
        // Each pair once, from its lower triangle.
        if (other < side) continue;
        if (!displaced(side / 3) && !displaced(other / 3)) continue;
        const int32_t forward = base_.forward(side) ? side : other,
                      backward = forward == side ? other : side;
        const auto same = [&](int32_t a, int32_t b) {
            return base_.corner_class[a] == base_.corner_class[b];
        };
        if (displaced(side / 3) && displaced(other / 3) &&
            same(base_.lower_corner(forward), base_.lower_corner(backward)) &&
            same(base_.upper_corner(forward), base_.upper_corner(backward))) {
            continue;
        }
        add_strip(forward);
    }
    // Vertices in order of their first corner.
    for (int32_t corner = 0; corner < 3 * base_.triangle_count(); ++corner) {
        if (base_.classes[static_cast<size_t>(corner / 3)] == TriangleClass::kDropped) continue;
        const int32_t v = base_.vertex[corner];
        if (base_.vertex_corners[static_cast<size_t>(base_.vertex_first[v])] == corner) {
            add_vertex(v);
        }
    }
}

void TableBuilder::add_vertex(int32_t vertex) {
    const auto begin = base_.vertex_corners.begin() + base_.vertex_first[vertex];
    const auto end =
        base_.vertex_corners.begin() + base_.vertex_first[static_cast<size_t>(vertex) + 1];
    // Identity corners have class -1, so this holds both for "all identities" and for "all
    // displaced alike".
    const bool alike = std::all_of(begin, end, [&](int32_t corner) {
        return base_.corner_class[corner] == base_.corner_class[static_cast<size_t>(*begin)];
    });
    if (alike) return;
    Patch patch;
    patch.kind = PatchKind::kSeam;
    table_.patches.push_back(patch);
    table_.seams.push_back({-1, 0, 0, vertex});
}

void TableBuilder::size_ranges() {
    PatchRanges& r = table_.ranges;
    r.float_components = static_cast<int32_t>(nearest_.floats.size());
    r.int_components = static_cast<int32_t>(nearest_.ints.size());
    const size_t floats = table_.patches.size() * nearest_.floats.size();
    const size_t ints = table_.patches.size() * nearest_.ints.size();
    r.float_lo.assign(floats, std::numeric_limits<float>::infinity());
    r.float_hi.assign(floats, -std::numeric_limits<float>::infinity());
    r.int_lo.assign(ints, std::numeric_limits<int32_t>::max());
    r.int_hi.assign(ints, std::numeric_limits<int32_t>::min());
}

Error TableBuilder::no_bound(int32_t triangle) const {
    return user_error(fmt::format(messages::kUnbounded, part_.name, part_.fablet->name, triangle));
}

Result<void> TableBuilder::bound_tiles() {
    std::vector<int32_t> tiles;
    for (int32_t p = 0; p < table_.first_seam; ++p) {
        if (table_.patches[p].kind == PatchKind::kLattice) tiles.push_back(p);
    }
    std::atomic<abi::KernelStatus> error{abi::KernelStatus{}};
    std::atomic<int32_t> unbounded{std::numeric_limits<int32_t>::max()};
    const size_t floats = nearest_.floats.size(), ints = nearest_.ints.size();
    tbb::parallel_for(tbb::blocked_range<size_t>(0, tiles.size(), kBoundsBatch),
                      [&](const auto& range) {
                          if (options_.stopped()) return;
                          BoundsBatch batch(part_, base_, args_, nearest_, options_.isa);
                          for (size_t k = range.begin(); k < range.end(); ++k) {
                              const Patch& patch = table_.patches[tiles[k]];
                              batch.add_tile(patch.triangle, {patch.lattice[0], patch.lattice[1],
                                                              patch.lattice[2], patch.lattice[3]});
                          }
                          if (const abi::KernelStatus status = batch.evaluate(); !status.ok()) {
                              error.store(status);
                              return;
                          }
                          for (size_t k = range.begin(); k < range.end(); ++k) {
                              const int32_t item = static_cast<int32_t>(k - range.begin());
                              const size_t p = static_cast<size_t>(tiles[k]);
                              const Box3f box = batch.box(item);
                              if (!is_finite(box)) {
                                  // Reports the lowest triangle, whichever thread finds it.
                                  int32_t seen = unbounded;
                                  const int32_t t = table_.patches[p].triangle;
                                  while (t < seen && !unbounded.compare_exchange_weak(seen, t)) {
                                  }
                              }
                              table_.patches[p].bounds = box;
                              for (size_t c = 0; c < floats; ++c) {
                                  const Range<float> r = batch.float_range(c, item);
                                  table_.ranges.float_lo[p * floats + c] = r.lo;
                                  table_.ranges.float_hi[p * floats + c] = r.hi;
                              }
                              for (size_t c = 0; c < ints; ++c) {
                                  const Range<int32_t> r = batch.int_range(c, item);
                                  table_.ranges.int_lo[p * ints + c] = r.lo;
                                  table_.ranges.int_hi[p * ints + c] = r.hi;
                              }
                          }
                      });
    if (!error.load().ok()) {
        return internal_error(
            fmt::format(messages::kBoundsFailed, part_.fablet->name, error.load().code()));
    }
    if (unbounded != std::numeric_limits<int32_t>::max()) return no_bound(unbounded);
    return {};
}

void TableBuilder::bound_identities() {
    const size_t floats = nearest_.floats.size(), ints = nearest_.ints.size();
    const part::PartMesh& mesh = base_.mesh();
    tbb::parallel_for(
        tbb::blocked_range<int32_t>(0, table_.first_seam, 4096), [&](const auto& range) {
            for (int32_t at = range.begin(); at < range.end(); ++at) {
                const size_t p = static_cast<size_t>(at);
                Patch& patch = table_.patches[p];
                if (patch.kind == PatchKind::kLattice) continue;
                const int32_t t = patch.triangle;
                for (int32_t c = 0; c < 3; ++c)
                    patch.bounds.add(round_position(base_.position(3 * t + c)));
                for (size_t c = 0; c < floats; ++c) {
                    const NearestComponent& from = nearest_.floats[c];
                    const auto& all = from.from == NearestComponent::From::kMesh
                                          ? mesh.nearest_attributes
                                          : mesh.inputs;
                    const Range<float> r = corner_range(all[from.index], t, from.component);
                    table_.ranges.float_lo[p * floats + c] = r.lo;
                    table_.ranges.float_hi[p * floats + c] = r.hi;
                }
                for (size_t c = 0; c < ints; ++c) {
                    const NearestComponent& from = nearest_.ints[c];
                    const auto& all = from.from == NearestComponent::From::kMesh
                                          ? mesh.nearest_attributes
                                          : mesh.inputs;
                    const part::PartAttribute& attribute = all[from.index];
                    const int32_t value =
                        std::bit_cast<int32_t>(attribute.face_values[static_cast<size_t>(
                            t * attribute.components + from.component)]);
                    table_.ranges.int_lo[p * ints + c] = table_.ranges.int_hi[p * ints + c] = value;
                }
            }
        });
}

void TableBuilder::add_to_seam(int32_t seam_patch, int32_t patch) {
    const size_t to = static_cast<size_t>(seam_patch), from = static_cast<size_t>(patch);
    table_.patches[to].bounds.add(table_.patches[from].bounds);
    PatchRanges& r = table_.ranges;
    const size_t floats = nearest_.floats.size(), ints = nearest_.ints.size();
    for (size_t c = 0; c < floats; ++c) {
        r.float_lo[to * floats + c] =
            std::min(r.float_lo[to * floats + c], r.float_lo[from * floats + c]);
        r.float_hi[to * floats + c] =
            std::max(r.float_hi[to * floats + c], r.float_hi[from * floats + c]);
    }
    for (size_t c = 0; c < ints; ++c) {
        r.int_lo[to * ints + c] = std::min(r.int_lo[to * ints + c], r.int_lo[from * ints + c]);
        r.int_hi[to * ints + c] = std::max(r.int_hi[to * ints + c], r.int_hi[from * ints + c]);
    }
}

void TableBuilder::add_side_to_seam(int32_t seam_patch, int32_t side, int32_t i0, int32_t i1) {
    const int32_t t = side / 3, first = table_.first_patch[t];
    if (!displaced(t)) {
        add_to_seam(seam_patch, first);
        return;
    }
    visit_side_tiles(base_, side, i0, i1,
                     [&](int32_t tile) { add_to_seam(seam_patch, first + tile); });
}

void TableBuilder::add_corner_to_seam(int32_t seam_patch, int32_t corner) {
    const int32_t t = corner / 3, first = table_.first_patch[t];
    if (!displaced(t)) {
        add_to_seam(seam_patch, first);
        return;
    }
    add_to_seam(seam_patch, first + corner_tile(base_, corner));
}

/// Returns whether a strip may be folded, as far as the bounds of its sides' tiles tell.
bool TableBuilder::may_fold(const Seam& seam) const {
    const int32_t other = base_.partner[seam.side];
    if (!displaced(seam.side / 3) || !displaced(other / 3)) return false;
    const auto displacements = [&](int32_t side) {
        Box3d box;
        visit_side_tiles(base_, side, seam.i0, seam.i1, [&](int32_t tile) {
            box.add(tile_displacements(base_, table_, table_.first_patch[side / 3] + tile));
        });
        return box;
    };
    const StripFold fold(base_, seam.side);
    return fold.possible(displacements(seam.side), displacements(other));
}

void TableBuilder::bound_seams() {
    const int32_t count = static_cast<int32_t>(table_.seams.size());
    tbb::parallel_for(tbb::blocked_range<int32_t>(0, count, 256), [&](const auto& range) {
        for (int32_t i = range.begin(); i < range.end(); ++i) {
            Seam& seam = table_.seams[i];
            const int32_t patch = table_.first_seam + i;
            if (seam.side >= 0) {
                add_side_to_seam(patch, seam.side, seam.i0, seam.i1);
                add_side_to_seam(patch, base_.partner[seam.side], seam.i0, seam.i1);
                seam.folds = may_fold(seam);
                if (!seam.folds) continue;
                const Vec3d &lo = base_.position(base_.lower_corner(seam.side)),
                            &hi = base_.position(base_.upper_corner(seam.side));
                for (const int32_t point : {seam.i0, seam.i1}) {
                    table_.patches[patch].bounds.add(
                        round_position(edge_position(lo, hi, point, base_.factor[seam.side])));
                }
                continue;
            }
            const size_t v = static_cast<size_t>(seam.vertex);
            for (int32_t c = base_.vertex_first[v]; c < base_.vertex_first[v + 1]; ++c) {
                add_corner_to_seam(patch, base_.vertex_corners[c]);
            }
        }
    });
}

Result<PatchTable> TableBuilder::build() {
    if (Result<void> done = classify(part_, options_, args_, nearest_, &base_); !done)
        return done.error();
    const auto moved = [](TriangleClass c) { return c == TriangleClass::kDisplaced; };
    table_.identity = std::none_of(base_.classes.begin(), base_.classes.end(), moved);
    if (!table_.identity) {
        if (Result<void> done = check_factors(); !done) return done.error();
        base_.connect();
    }
    list_triangles();
    if (!table_.identity) list_seams();
    size_ranges();
    bound_identities();
    if (!table_.identity) {
        if (Result<void> done = bound_tiles(); !done) return done.error();
        bound_seams();
    }
    return std::move(table_);
}

}  // namespace

FanShape fan_shape(const BaseMesh& base, int32_t triangle) {
    FanShape shape;
    int32_t divided = 0, last = 0;
    for (int32_t e = 0; e < 3; ++e) {
        const size_t side = static_cast<size_t>(3 * triangle + e);
        const bool split = base.divided[side] != 0 && base.factor[side] > 1;
        shape.pieces[e] = split ? base.factor[side] : 1;
        if (split) ++divided, last = e;
    }
    if (divided == 0) {
        shape.pieces = {};
    } else if (divided == 1) {
        shape.apex_corner = (last + 2) % 3;
        for (int32_t e = 0; e < 3; ++e) {
            if (e != last) shape.pieces[e] = 0;
        }
    }
    return shape;
}

Result<void> classify(const part::Part& part, const SurfaceOptions& options, const StaticArgs& args,
                      const NearestLayout& nearest, BaseMesh* base) {
    const openfab_fablet& fablet = *part.fablet;
    bool copies = true;
    for (int32_t i = 0; i < fablet.surface_output_count; ++i)
        copies &= fablet.surface_outputs[i].source >= 0;
    if (fablet.has_surface == 0) {
        for (auto& c : base->classes) {
            if (c == TriangleClass::kDisplaced) c = TriangleClass::kIdentity;
        }
        return {};
    }
    base->set_factors(options.micro_edge_mm);
    if (!copies || !options.infer_identity) return {};
    std::atomic<abi::KernelStatus> error{abi::KernelStatus{}};
    tbb::parallel_for(
        tbb::blocked_range<int32_t>(0, base->triangle_count(), kBoundsBatch),
        [&](const auto& range) {
            if (options.stopped()) return;
            BoundsBatch batch(part, *base, args, nearest, options.isa);
            for (int32_t t = range.begin(); t < range.end(); ++t)
                batch.add_triangle(t);
            if (const abi::KernelStatus status = batch.evaluate(); !status.ok()) {
                error.store(status);
                return;
            }
            for (int32_t t = range.begin(); t < range.end(); ++t) {
                TriangleClass& c = base->classes[t];
                if (c == TriangleClass::kDisplaced && batch.is_zero(t - range.begin()))
                    c = TriangleClass::kIdentity;
            }
        });
    if (!error.load().ok()) {
        return internal_error(
            fmt::format(messages::kBoundsFailed, fablet.name, error.load().code()));
    }
    return {};
}

Result<PatchTable> make_patch_table(const part::Part& part, const SurfaceOptions& options,
                                    const StaticArgs& args, const NearestLayout& nearest,
                                    BaseMesh* base) {
    return TableBuilder(part, options, args, nearest, base).build();
}

}  // namespace openfab::surface
