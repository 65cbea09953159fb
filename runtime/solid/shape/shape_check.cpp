// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What makes a shape impossible: it is open, empty, or no number.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "runtime/solid/messages.h"
#include "runtime/solid/shape/shape_field.h"

namespace openfab::solid {

namespace {

// Of the longest side: squares of a side of the box that intervals leave open are halved to this, and
// the points in them are an eighth of it apart.
constexpr float kSmallestSquare = 1.0f / 64;
constexpr int32_t kPointsOfSquare = 8;
constexpr size_t kPointsAtOnce = 4096;
// Likewise: steps inwards, and how far a zero may lie beyond the border of a shape that touches it.
constexpr float kInwards[] = {0x1p-10f, 0x1p-14f, 0x1p-18f};
constexpr float kTouches = 0x1p-17f;

}  // namespace

std::string ShapeField::place(const Vec3f& p) const {
    Vec3d at = vec_cast<double>(p);
    for (int a = 0; a < 3; ++a)
        at[a] = at[a] / stage_.stretch[static_cast<size_t>(a)] + stage_.mesh->center_part_mm[a];
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", at.x, at.y, at.z);
}

Error ShapeField::error(const std::string& what, const std::string& help) const {
    return error_at(stage_.location,
                    fmt::format(messages::kShapeBefore, stage_.fablet->name, stage_.name, what),
                    help);
}

Result<void> ShapeField::check() const {
    if (Result<void> closed = check_border(); !closed) return closed;
    const Extent& found = extent({1, 0, 0, 0, 1, 0, 0, 0, 1}, {});
    if (Result<void> fine = status(); !fine) return fine;
    if (!found.box.empty()) return {};
    if (found.open.empty())
        return error(messages::kNowhereNegative, messages::kNowhereNegativeHelp);
    return error(fmt::format(messages::kNegativeAtNoPoint, found.spacing_mm),
                 messages::kNegativeAtNoPointHelp);
}

Result<void> ShapeField::check_border() const {
    ShapeCalls* calls = take();
    Result<void> out;
    for (int axis = 0; axis < 3 && out; ++axis) {
        for (const bool high : {false, true}) {
            out = check_side(axis, high, calls);
            if (!out) break;
        }
    }
    give(calls);
    return out;
}

/// A side of the box, by squares that are halved; those that intervals decide are left out, and in the
/// smallest points are looked at.
Result<void> ShapeField::check_side(int axis, bool high, ShapeCalls* calls) const {
    const float longest = box_.longest_side();
    Box3f all = box_;
    all.lo[axis] = all.hi[axis] = high ? box_.hi[axis] : box_.lo[axis];
    std::vector<Box3f> open{all};
    while (!open.empty()) {
        ShapePoints lo, hi;
        for (const Box3f& square : open)
            lo.push_back(square.lo), hi.push_back(square.hi);
        std::vector<float> value_lo, value_hi;
        if (const abi::KernelStatus status = calls->sign_bounds(lo, hi, &value_lo, &value_hi);
            !status.ok()) {
            note(status);
            return status_of();
        }
        std::vector<Box3f> next;
        ShapePoints points;
        for (size_t i = 0; i < open.size(); ++i) {
            if (value_lo[i] >= 0) continue;
            const Box3f& square = open[i];
            const Vec3f size = square.size();
            const int side = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
            if (size[side] > kSmallestSquare * longest) {
                const float middle = square.lo[side] + size[side] / 2;
                next.push_back(square);
                next.back().hi[side] = middle;
                next.push_back(square);
                next.back().lo[side] = middle;
                continue;
            }
            for (int32_t v = 0; v <= kPointsOfSquare; ++v) {
                for (int32_t u = 0; u <= kPointsOfSquare; ++u) {
                    Vec3f p = square.lo;
                    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
                    p[b] = u == kPointsOfSquare
                               ? square.hi[b]
                               : square.lo[b] + size[b] * static_cast<float>(u) / kPointsOfSquare;
                    p[c] = v == kPointsOfSquare
                               ? square.hi[c]
                               : square.lo[c] + size[c] * static_cast<float>(v) / kPointsOfSquare;
                    points.push_back(p);
                }
            }
            if (points.size() < kPointsAtOnce) continue;
            if (Result<void> fine = check_points(points, axis, high, calls); !fine) return fine;
            points.clear();
        }
        if (Result<void> fine = check_points(points, axis, high, calls); !fine) return fine;
        open = std::move(next);
    }
    return {};
}

/// Checks points of a side. A shape may touch its box: there a value may be below 0 by its rounding,
/// and how fast it falls on the way inwards tells how far the zero is.
Result<void> ShapeField::check_points(const ShapePoints& points, int axis, bool high,
                                      ShapeCalls* calls) const {
    if (points.size() == 0) return {};
    std::vector<float> values, inwards;
    abi::KernelStatus status = calls->signs(points, &values);
    ShapePoints negative;
    for (size_t k = 0; k < points.size() && status.ok(); ++k) {
        if (std::isnan(values[k])) note_nan(points.point(k));
        if (values[k] < 0) negative.push_back(points.point(k));
    }
    if (status.ok() && negative.size() == 0) return {};
    std::vector<float> at;
    if (status.ok()) status = calls->values(negative, &at);
    at.resize(negative.size());
    const float longest = box_.longest_side();
    std::vector<uint8_t> touches(at.size(), 0);
    for (const float share : kInwards) {
        ShapePoints moved = negative;
        const float by = share * longest;
        for (float& x : moved.at[static_cast<size_t>(axis)])
            x = high ? x - by : x + by;
        if (status.ok()) status = calls->values(moved, &inwards);
        for (size_t k = 0; k < at.size() && status.ok(); ++k) {
            const float falls = at[k] - inwards[k];
            if (falls > 0 && -at[k] / falls * by <= kTouches * longest) touches[k] = 1;
        }
    }
    if (!status.ok()) {
        note(status);
        return status_of();
    }
    for (size_t k = 0; k < at.size(); ++k) {
        if (touches[k] != 0) continue;
        return error(
            fmt::format(messages::kShapeOpen, static_cast<double>(at[k]), place(negative.point(k))),
            messages::kShapeOpenHelp);
    }
    return {};
}

void ShapeField::note(const abi::KernelStatus& failed) const {
    if (failed.is_stopped()) return;
    const std::lock_guard lock(mutex_);
    failed_ = failed;
}

void ShapeField::note_nan(const Vec3f& at) const {
    const std::lock_guard lock(mutex_);
    const auto key = [](const Vec3f& p) { return std::array{p.z, p.y, p.x}; };
    if (!nan_ || key(at) < key(*nan_)) nan_ = at;
}

Result<void> ShapeField::status() const {
    const std::lock_guard lock(mutex_);
    return status_of();
}

Result<void> ShapeField::status_of() const {
    if (failed_) {
        return internal_error(
            fmt::format(messages::kShapeKernelFailed, stage_.fablet->name, failed_->code()));
    }
    if (Result<void> fine = bodies_.status(); !fine) return fine;
    if (!nan_) return {};
    return error(fmt::format(messages::kShapeNaN, place(*nan_)), messages::kShapeNaNHelp);
}

}  // namespace openfab::solid
