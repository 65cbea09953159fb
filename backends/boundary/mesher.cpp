// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/boundary/mesher.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "backends/boundary/fans.h"
#include "base/check.h"

namespace openfab::boundary {

namespace {

constexpr size_t kPiece = 2048;  // vertices or triangles passed on at once

/// Calls visit(bit) for each bit that is set, lowest first.
template <typename Visit>
void for_each_bit(uint64_t word, Visit visit) {
    for (; word != 0; word &= word - 1)
        visit(std::countr_zero(word));
}

/// Calls visit(code) for each code but 0, once.
template <size_t Size, typename Visit>
void for_each_code(const std::array<uint8_t, Size>& codes, Visit visit) {
    for (size_t i = 0; i < Size; ++i) {
        bool seen = codes[i] == 0;
        for (size_t j = 0; j < i && !seen; ++j)
            seen = codes[j] == codes[i];
        if (!seen) visit(codes[i]);
    }
}

/// Collects points and midpoints of a row from x0 to x1, in half voxels.
void collect_row(const BitPlane& points, const BitPlane& midpoints, int32_t y, int32_t x0,
                 int32_t x1, std::vector<int32_t>* out) {
    for (int32_t base = x0 & ~63; base <= x1; base += 64) {
        const auto w = static_cast<size_t>(base >> 6);
        for_each_bit(points.word(w, y) | midpoints.word(w, y), [&](int32_t bit) {
            const int32_t x = base + bit;
            if (x < x0 || x > x1) return;
            if (points.get(x, y)) out->push_back(2 * x);
            if (x < x1 && midpoints.get(x, y)) out->push_back(2 * x + 1);
        });
    }
}

/// Collects points and midpoints of a column from y0 to y1, in half voxels; `ends` with those at y0
/// and y1.
void collect_column(const BitPlane& points, const BitPlane& midpoints, int32_t x, int32_t y0,
                    int32_t y1, bool ends, std::vector<int32_t>* out) {
    for (int32_t y = y0; y <= y1; ++y) {
        if ((ends || (y != y0 && y != y1)) && points.get(x, y)) out->push_back(2 * y);
        if (y < y1 && midpoints.get(x, y)) out->push_back(2 * y + 1);
    }
}

/// Returns whether an octant and the opposite one are alone inside one material.
bool is_amid_another(const std::array<uint8_t, 8>& codes, int32_t octant) {
    const auto around = codes[static_cast<size_t>(octant ^ 1)];
    if (around == 0) return false;
    for (int32_t o = 0; o < 8; ++o) {
        const bool one_of_two = o == octant || o == (octant ^ 7);
        if ((codes[o] == around) == one_of_two) return false;
    }
    return true;
}

}  // namespace

Mesher::Mesher(int32_t width, int32_t height, int32_t first_slice, MeshReceiver* receiver)
    : width_(width),
      height_(height),
      first_slice_(first_slice),
      receiver_(receiver),
      by_position_(receiver->identifies_by_position()),
      together_(receiver->numbers_together()),
      layers_(3, Layer(width, height)),
      planes_(3, Plane(width, height)),
      midpoints_z_(width, height),
      finder_(width, height),
      pending_(256) {
    if (receiver->has_colors()) colors_ = std::make_unique<ColorLayers>(width, height);
}

Result<void> Mesher::add(const pipeline::SliceView& slice, int32_t bits, const uint32_t* colors) {
    OPENFAB_CHECK_EQ(slice.z, first_slice_ + z_);
    if (colors_ != nullptr) colors_->fill(z_, colors);
    layer(z_).fill(slice, bits);
    return step();
}

Result<void> Mesher::finish() {
    layer(z_).clear();
    Result<void> done = step();
    for (size_t code = 0; code < pending_.size(); ++code)
        flush(code);
    return done ? error_ : done;
}

/// Slice z_ completes the neighbourhood of its lower plane and of the slice below, which are meshed
/// now.
Result<void> Mesher::step() {
    plane(z_ + 1).points.clear();
    plane(z_).midpoints_x.clear();
    plane(z_).midpoints_y.clear();
    const auto marks = [this](const Rectangle& r) {
        split(r, [this](const Rectangle& part) { mark(part); });
    };
    finder_.across_z(layer(z_ - 1), layer(z_), z_, marks);
    finder_.across_xy(layer(z_), z_, marks);
    mark_crossings();
    find_midpoints_z();
    number_midpoints(midpoints_z_, 2, z_ - 1, &z_table_);
    number_points();
    number_midpoints(plane(z_).midpoints_x, 0, z_, &plane(z_).x_table);
    number_midpoints(plane(z_).midpoints_y, 1, z_, &plane(z_).y_table);
    const auto emits = [this](const Rectangle& r) {
        split(r, [this](const Rectangle& part) { emit(part); });
    };
    finder_.across_xy(layer(z_ - 1), z_ - 1, emits);
    finder_.across_z(layer(z_ - 1), layer(z_), z_, emits);
    ++z_;
    return error_;
}

void Mesher::mark(const Rectangle& r) {
    for (int32_t u : {r.u0, r.u1}) {
        for (int32_t v : {r.v0, r.v1}) {
            if (r.axis == 2) {
                plane(r.plane).points.set(u, v);
            } else if (r.axis == 1) {
                plane(v).points.set(u, r.plane);
            } else {
                plane(v).points.set(r.plane, u);
            }
        }
    }
}

/// Marks points and midpoints along the edges in the plane z_ and points of those across slice z_.
void Mesher::mark_crossings() {
    const Layer &below = layer(z_ - 1), &above = layer(z_);
    Plane &low = plane(z_), &high = plane(z_ + 1);
    const auto around = [&](int32_t x, int32_t y) { return octants(below, above, x, y); };
    for (int32_t y = 0; y <= height_; ++y) {
        for_each_crossing(below.row(y - 1), below.row(y), above.row(y), above.row(y - 1), width_,
                          [&](int32_t x) {
                              low.points.set(x, y);
                              low.points.set(x + 1, y);
                              if (needs_midpoint(0, around(x, y), around(x + 1, y)))
                                  low.midpoints_x.set(x, y);
                          });
        for_each_crossing(above.row(y - 1) - 1, above.row(y - 1), above.row(y), above.row(y) - 1,
                          width_ + 1, [&](int32_t x) {
                              low.points.set(x, y);
                              high.points.set(x, y);
                          });
        if (y == height_) break;
        for_each_crossing(below.row(y) - 1, below.row(y), above.row(y), above.row(y) - 1,
                          width_ + 1, [&](int32_t x) {
                              low.points.set(x, y);
                              low.points.set(x, y + 1);
                              if (needs_midpoint(1, around(x, y), around(x, y + 1)))
                                  low.midpoints_y.set(x, y);
                          });
    }
}

/// Returns whether two sheets along an edge have the same vertices at both ends, given the voxels
/// around these.
bool Mesher::needs_midpoint(int32_t axis, const std::array<uint8_t, 8>& low_end,
                            const std::array<uint8_t, 8>& high_end) const {
    const int32_t p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    const auto together = [&](const std::array<uint8_t, 8>& codes, int32_t a, int32_t b) {
        const Fans& fans = kFans[mask_of(codes, codes[a])];
        return fans.of[a][p] == fans.of[b][p];
    };
    const auto meet = [&](int32_t a, int32_t b, int32_t beside_a, int32_t beside_b) {
        const auto code = [&](int32_t octant) { return high_end[octant]; };
        if (code(a) == 0 || code(a) != code(b) || code(a) == code(beside_a) ||
            code(a) == code(beside_b))
            return false;
        const int32_t at_low = 1 << axis;  // the edge is on the far side of its lower end
        return together(low_end, a | at_low, b | at_low) && together(high_end, a, b);
    };
    const int32_t bp = 1 << p, bq = 1 << q;
    return meet(0, bp | bq, bp, bq) || meet(bp, bq, 0, bp | bq);
}

/// Midpoints of the edges across slice z_ - 1, whose upper ends are known only now.
void Mesher::find_midpoints_z() {
    midpoints_z_.clear();
    const Layer &below = layer(z_ - 2), &middle = layer(z_ - 1), &above = layer(z_);
    for (int32_t y = 0; y <= height_; ++y) {
        for_each_crossing(
            middle.row(y - 1) - 1, middle.row(y - 1), middle.row(y), middle.row(y) - 1, width_ + 1,
            [&](int32_t x) {
                if (needs_midpoint(2, octants(below, middle, x, y), octants(middle, above, x, y)))
                    midpoints_z_.set(x, y);
            });
    }
}

void Mesher::add_vertices(VertexTable* table, uint8_t code, int32_t bit, int32_t count,
                          Vec3i point) {
    Pending& pending = pending_[code];
    table->add(code, bit, count, pending.vertices);
    if (together_) return;  // end_word numbers them
    pending.vertices += static_cast<uint32_t>(count);
    point.z += 2 * first_slice_;
    pending.points.insert(pending.points.end(), static_cast<size_t>(count), point);
    if (pending.points.size() >= kPiece) flush(code);
}

/// Numbers the vertices of a word of points, the first of which is given, where those of all materials are in
/// one sequence.
void Mesher::end_word(VertexTable* table, Vec3i first_point) {
    if (!together_) return;
    Pending& pending = pending_[0];
    first_point.z += 2 * first_slice_;
    pending.vertices = table->number_word(pending.vertices, [&](int32_t bit, uint32_t count) {
        Vec3i point = first_point;
        point.x += 2 * bit;
        pending.points.insert(pending.points.end(), count, point);
    });
    if (pending.points.size() >= kPiece) flush(0);
}

void Mesher::number_points() {
    const Layer &below = layer(z_ - 1), &above = layer(z_);
    const BitPlane& points = plane(z_).points;
    VertexTable* table = &plane(z_).point_table;
    table->begin();
    for (int32_t y = 0; y <= height_; ++y) {
        for (size_t w = 0; w < points.words(); ++w) {
            table->begin_word();
            for_each_bit(points.word(w, y), [&](int32_t bit) {
                const int32_t x = static_cast<int32_t>(w) * 64 + bit;
                const std::array<uint8_t, 8> codes = octants(below, above, x, y);
                for_each_code(codes, [&](uint8_t code) {
                    add_vertices(table, code, bit, kFans[mask_of(codes, code)].count,
                                 {2 * x, 2 * y, 2 * z_});
                });
            });
            end_word(table, {static_cast<int32_t>(w) * 128, 2 * y, 2 * z_});
        }
    }
}

/// One vertex for each sheet, which is for each voxel of a material around the edge.
void Mesher::number_midpoints(const BitPlane& midpoints, int32_t axis, int32_t z,
                              VertexTable* table) {
    const int32_t p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    table->begin();
    for (int32_t y = 0; y <= height_; ++y) {
        for (size_t w = 0; w < midpoints.words(); ++w) {
            table->begin_word();
            for_each_bit(midpoints.word(w, y), [&](int32_t bit) {
                const int32_t x = static_cast<int32_t>(w) * 64 + bit;
                std::array<uint8_t, 4> codes{};
                for (int32_t i = 0; i < 4; ++i) {
                    Vec3i voxel{x, y, z};
                    voxel[p] -= i & 1;
                    voxel[q] -= i >> 1;
                    codes[i] = code_at(voxel);
                }
                Vec3i point{2 * x, 2 * y, 2 * z};
                ++point[axis];
                for_each_code(codes, [&](uint8_t code) {
                    const auto sheets = std::count(codes.begin(), codes.end(), code);
                    add_vertices(table, code, bit, static_cast<int32_t>(sheets), point);
                });
            });
            Vec3i first_point{static_cast<int32_t>(w) * 128, 2 * y, 2 * z};
            ++first_point[axis];
            end_word(table, first_point);
        }
    }
}

void Mesher::outline(const Rectangle& r) {
    outline_.clear();
    if (r.axis == 2) {
        const Plane& p = plane(r.plane);
        collect_row(p.points, p.midpoints_x, r.v0, r.u0, r.u1, &outline_.bottom);
        collect_row(p.points, p.midpoints_x, r.v1, r.u0, r.u1, &outline_.top);
        collect_column(p.points, p.midpoints_y, r.u0, r.v0, r.v1, false, &outline_.left);
        collect_column(p.points, p.midpoints_y, r.u1, r.v0, r.v1, false, &outline_.right);
        return;
    }
    const Plane &low = plane(r.v0), &high = plane(r.v1);
    const auto side = [&](int32_t u, std::vector<int32_t>* out) {
        const bool middle =
            r.axis == 1 ? midpoints_z_.get(u, r.plane) : midpoints_z_.get(r.plane, u);
        if (middle) out->push_back(2 * r.v0 + 1);
    };
    if (r.axis == 1) {
        collect_row(low.points, low.midpoints_x, r.plane, r.u0, r.u1, &outline_.bottom);
        collect_row(high.points, high.midpoints_x, r.plane, r.u0, r.u1, &outline_.top);
    } else {
        collect_column(low.points, low.midpoints_y, r.plane, r.u0, r.u1, true, &outline_.bottom);
        collect_column(high.points, high.midpoints_y, r.plane, r.u0, r.u1, true, &outline_.top);
    }
    side(r.u0, &outline_.left);
    side(r.u1, &outline_.right);
}

void Mesher::emit(const Rectangle& rectangle) {
    outline(rectangle);
    list_points(rectangle, outline_, &points_);
    triangulate(outline_, &triangles_);
    bool moved = false;
    for (const bool high : {false, true}) {
        std::vector<MeshCorner>& corners = corners_[high ? 1 : 0];
        corners.clear();
        if ((high ? rectangle.high : rectangle.low) == 0) continue;
        for (const Vec3i& point : points_) {
            corners.push_back(corner(rectangle, high, point));
            moved = moved || corners.back().off != decltype(MeshCorner::off){};
        }
    }
    if (by_position_ && moved && would_flip(rectangle)) add_rim(rectangle);
    for (const bool high : {false, true}) {
        if ((high ? rectangle.high : rectangle.low) != 0) emit_side(rectangle, high);
    }
}

void Mesher::emit_side(const Rectangle& rectangle, bool high) {
    std::vector<MeshCorner>& corners = corners_[high ? 1 : 0];
    for (MeshCorner& c : corners)
        c.point.z += 2 * first_slice_;
    const uint8_t code = high ? rectangle.high : rectangle.low;
    Pending& pending = pending_[code];
    // Faces of the material below point up.
    const bool turned = high == rectangle.right_handed();
    for (std::array<int32_t, 3> t : triangles_) {
        if (turned) std::swap(t[1], t[2]);
        MeshTriangle& out = pending.triangles.emplace_back();
        for (size_t i = 0; i < 3; ++i)
            out[i] = corners[t[i]];
        out.color = high ? rectangle.high_color : rectangle.low_color;
    }
    if (pending.triangles.size() >= kPiece) flush(code);
}

/// Returns whether a triangle of the rectangle is so thin that it might flip once each of its
/// corners moves by a few steps: the intended one, and the rounding to single precision.
bool Mesher::would_flip(const Rectangle& rectangle) const {
    constexpr int64_t kFourSteps = kSteps / 2 / 4;  // that often in half a voxel
    const int32_t u = rectangle.u_axis(), v = rectangle.v_axis();
    return std::any_of(triangles_.begin(), triangles_.end(), [&](const std::array<int32_t, 3>& t) {
        const Vec3i& a = points_[t[0]];
        const auto b = vec_cast<int64_t>(points_[t[1]] - a);
        const auto c = vec_cast<int64_t>(points_[t[2]] - a);
        const int64_t area = b[u] * c[v] - b[v] * c[u];
        int64_t extent = 1;  // bounds the product of the moves
        for (const int32_t axis : {u, v}) {
            const auto [lo, hi] = std::minmax({int64_t{0}, b[axis], c[axis]});
            extent += hi - lo;
        }
        return area * kFourSteps <= 2 * extent;
    });
}

/// Adds an inner outline to the rectangle; the triangles are moved inside it.
void Mesher::add_rim(const Rectangle& rectangle) {
    const auto count = static_cast<int32_t>(points_.size());
    const auto bottoms = static_cast<int32_t>(outline_.bottom.size());
    const auto tops = static_cast<int32_t>(outline_.top.size());
    const auto lefts = static_cast<int32_t>(outline_.left.size());
    const std::array<int32_t, 2> axes{rectangle.u_axis(), rectangle.v_axis()};
    const std::array<std::array<int32_t, 2>, 2> ends{
        {{2 * rectangle.u0, 2 * rectangle.u1}, {2 * rectangle.v0, 2 * rectangle.v1}}};
    for (const Vec3i& point : points_) {
        MeshCorner inner{point};
        for (size_t i = 0; i < 2; ++i) {
            const auto axis = static_cast<size_t>(axes[i]);
            if (point[axes[i]] == ends[i][0]) inner.off[axis] = kSteps / 4;
            if (point[axes[i]] == ends[i][1]) inner.off[axis] = -kSteps / 4;
        }
        for (std::vector<MeshCorner>& corners : corners_)
            corners.push_back(inner);
    }
    for (std::array<int32_t, 3>& t : triangles_) {
        for (int32_t& i : t)
            i += count;
    }
    // Counter-clockwise along the outline.
    int32_t last = 0;
    const auto go_to = [&](int32_t next) {
        triangles_.push_back({last, next, last + count});
        triangles_.push_back({next, next + count, last + count});
        last = next;
    };
    for (int32_t i = 1; i < bottoms; ++i)
        go_to(i);
    for (int32_t i = bottoms + tops + lefts; i < count; ++i)
        go_to(i);
    for (int32_t i = bottoms + tops - 1; i >= bottoms; --i)
        go_to(i);
    for (int32_t i = bottoms + tops + lefts - 1; i >= bottoms + tops; --i)
        go_to(i);
    go_to(0);
}

/// A point of the outline in the mesh on one side of the rectangle.
MeshCorner Mesher::corner(const Rectangle& r, bool high, const Vec3i& point) {
    for (int32_t axis = 0; axis < 3; ++axis) {
        if ((point[axis] & 1) != 0) return midpoint_corner(r, high, point, axis);
    }
    const int32_t x = point.x / 2, y = point.y / 2, z = point.z / 2;
    // Returns a face of the rectangle with the point as a corner; where there are two, they belong
    // to one fan.
    const int32_t octant = (high ? 1 << r.axis : 0) |
                           (point[r.u_axis()] < 2 * r.u1 ? 1 << r.u_axis() : 0) |
                           (point[r.v_axis()] < 2 * r.v1 ? 1 << r.v_axis() : 0);
    const uint8_t code = high ? r.high : r.low;
    const std::array<uint8_t, 8> codes = octants(layer(z - 1), layer(z), x, y);
    const Fans& fans = kFans[mask_of(codes, code)];
    const int8_t fan = fans.of[octant][r.axis];
    const Plane& p = plane(z);
    const size_t word = static_cast<size_t>(y) * p.points.words() + static_cast<size_t>(x >> 6);
    MeshCorner out{point, p.point_table.first(word, x & 63, code) + static_cast<uint32_t>(fan)};
    // The material around a voxel has moved its own vertex into it.
    const bool follows = fans.count == 1 && is_amid_another(codes, octant);
    for (int32_t axis = 0; axis < 3; ++axis) {
        const int16_t alone = (octant >> axis & 1) != 0 ? 1 : -1;
        out.off[axis] = follows ? alone : fans.apart[fan][axis];
    }
    return out;
}

MeshCorner Mesher::midpoint_corner(const Rectangle& r, bool high, const Vec3i& point,
                                   int32_t axis) {
    const int32_t side = axis == r.u_axis() ? r.v_axis() : r.u_axis();
    const int32_t side_end = 2 * (side == r.u_axis() ? r.u1 : r.v1);
    // The voxels on this side of the rectangle and across the edge.
    Vec3i voxel{point.x >> 1, point.y >> 1, point.z >> 1}, opposite = voxel;
    const bool above = high, beyond = point[side] < side_end;
    voxel[r.axis] -= above ? 0 : 1;
    opposite[r.axis] -= above ? 1 : 0;
    voxel[side] -= beyond ? 0 : 1;
    opposite[side] -= beyond ? 1 : 0;
    const uint8_t code = high ? r.high : r.low;
    const bool first_of_two = r.axis < side ? !above : !beyond;
    const bool two = code_at(opposite) == code;
    const int32_t x = point.x >> 1, y = point.y >> 1, z = point.z >> 1;
    const Plane& p = plane(z);
    const VertexTable& table = axis == 0 ? p.x_table : axis == 1 ? p.y_table : z_table_;
    const size_t word = static_cast<size_t>(y) * p.points.words() + static_cast<size_t>(x >> 6);
    MeshCorner out{point, table.first(word, x & 63, code) + (two && !first_of_two ? 1 : 0)};
    if (two) {
        out.off[r.axis] = above ? 1 : -1;
        out.off[side] = beyond ? 1 : -1;
    }
    return out;
}

void Mesher::flush(size_t code) {
    Pending& pending = pending_[code];
    if (error_ && !pending.points.empty())
        error_ = receiver_->take_vertices(static_cast<uint8_t>(code), pending.points);
    if (error_ && !pending.triangles.empty())
        error_ = receiver_->take_triangles(static_cast<uint8_t>(code), pending.triangles);
    pending.points.clear();
    pending.triangles.clear();
}

}  // namespace openfab::boundary
