// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What makes a shape impossible: it is open, empty, or no number.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "runtime/part/shape_stage.h"
#include "runtime/solid/messages.h"
#include "runtime/solid/shape/shape_field.h"

namespace openfab::solid {

std::string ShapeField::place(const Vec3f& p) const {
    Vec3d at = vec_cast<double>(p);
    for (int a = 0; a < 3; ++a)
        at[a] = at[a] / part::shape_stage(stage_).stretch[static_cast<size_t>(a)] +
                stage_.mesh->center_part_mm[a];
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", at.x, at.y, at.z);
}

Error ShapeField::error(const std::string& what, const std::string& help) const {
    return error_at(stage_.location,
                    fmt::format(messages::kShapeBefore, stage_.fablet->name, stage_.name, what),
                    help);
}

Result<void> ShapeField::check() const {
    if (Result<void> closed = check_border(); !closed) return closed;
    if (!exact_box({}).empty()) return status();
    if (Result<void> fine = status(); !fine) return fine;
    return error(messages::kNowhereNegative, messages::kNowhereNegativeHelp);
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

/// A side of the lattice, by squares of vertices; those that intervals decide are left out.
Result<void> ShapeField::check_side(int axis, bool high, ShapeCalls* calls) const {
    struct Square {
        Vec3i lo, hi;
    };
    Square all{{0, 0, 0}, cells_};
    all.lo[axis] = all.hi[axis] = high ? cells_[axis] : 0;
    std::vector<Square> open{all};
    while (!open.empty()) {
        ShapePoints lo, hi;
        for (const Square& square : open) {
            lo.push_back(position(square.lo));
            hi.push_back(position(square.hi));
        }
        std::vector<float> value_lo, value_hi;
        if (const abi::KernelStatus status = calls->bounds(lo, hi, &value_lo, &value_hi);
            !status.ok()) {
            note(status);
            return status_of();
        }
        std::vector<Square> next;
        for (size_t i = 0; i < open.size(); ++i) {
            if (value_lo[i] >= 0) continue;
            const Square& square = open[i];
            const Vec3i size = square.hi - square.lo;
            const int longest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
            if (size[longest] > kPatchCells) {
                Square low = square, rest = square;
                low.hi[longest] = rest.lo[longest] = square.lo[longest] + size[longest] / 2;
                next.push_back(low);
                next.push_back(rest);
                continue;
            }
            ShapePoints points;
            for (int32_t z = square.lo.z; z <= square.hi.z; ++z) {
                for (int32_t y = square.lo.y; y <= square.hi.y; ++y) {
                    for (int32_t x = square.lo.x; x <= square.hi.x; ++x)
                        points.push_back(position({x, y, z}));
                }
            }
            std::vector<float> values;
            if (const abi::KernelStatus status = calls->values(points, &values); !status.ok()) {
                note(status);
                return status_of();
            }
            for (size_t k = 0; k < points.size(); ++k) {
                if (std::isnan(values[k])) note_nan(points.point(k));
                if (!(values[k] < 0)) continue;
                return error(fmt::format(messages::kShapeOpen, static_cast<double>(values[k]),
                                         place(points.point(k))),
                             messages::kShapeOpenHelp);
            }
        }
        open = std::move(next);
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
