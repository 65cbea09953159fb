// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Interval forms of texture lookups, and of the distance of a point from the part's own surface.

#include "compiler/passes/interval.h"

namespace openfab::passes {

using ir::Instr;

namespace {

constexpr size_t kMaxPictureArgs = 10;
constexpr size_t kPlainPictureArgs = 4;
constexpr size_t kPlainVolumeArgs = 5;

// Slack of a distance: that of positions (a few roundings to float), of the distances themselves
// (1e-5 of each, rule 16), and of the coverage that the sign at a voxel's centre
// comes from (vertices snapped to 1/256 of a voxel).
constexpr float kPositionSlack = 0x1p-20f;
constexpr float kDistanceSlack = 0x1p-14f;
constexpr float kVoxelSlack = 0x1p-7f;

}  // namespace

/// Includes 0, the result of an instruction that did not run, if its guard may be false.
Interval IntervalForm::or_zero(const Interval& guard, const Interval& value) {
    const Id zero = b_.constant(0.0f);
    const Id lo = b_.select(emit(Op::kGt, value.lo, zero), zero, value.lo);
    const Id hi = b_.select(emit(Op::kLt, value.hi, zero), zero, value.hi);
    return {b_.select(guard.lo, lo, value.lo), b_.select(guard.lo, hi, value.hi), ir::kNoValue};
}

Interval IntervalForm::sample_interval(const Instr& instr) {
    const size_t count = instr.args.size();
    const bool volume = count == kPlainVolumeArgs || count > kMaxPictureArgs;
    const size_t plain = volume ? kPlainVolumeArgs : kPlainPictureArgs;
    const size_t axes = plain - 2;
    const Interval guard = values_[instr.args[0]];
    Instr bound;
    bound.op = Op::kSampleBound;
    bound.type = Type::kFloat;
    bound.a = instr.a;
    bound.b = instr.b;
    bound.args = {guard.hi};
    for (size_t k = 1; k <= axes; ++k) {
        bound.args.push_back(values_[instr.args[k]].lo);
        bound.args.push_back(values_[instr.args[k]].hi);
    }
    bound.args.push_back(values_[instr.args[axes + 1]].hi);
    for (size_t k = 0; k < 3 * axes; ++k) {
        const bool given = count > plain;
        bound.args.push_back(given ? magnitude(instr.args[plain + k]) : b_.constant(0.0f));
    }
    const Id lo = b_.append(bound);
    bound.bits = 1;
    const Id hi = b_.append(bound);
    return or_zero(guard, finish(lo, hi));
}

/// The signed distance changes no faster than the point moves: it is bounded from that of the
/// voxel's centre, for which the runtime gives an interval. Other results are unknown.
Interval IntervalForm::query_result_interval(const Instr& instr) {
    const Instr& query = from_.instrs[instr.args[0]];
    const auto kinds = kinds_(OPENFAB_ARG_DISTANCE);
    if (query.a >= 0 || instr.kind != OPENFAB_QUERY_DISTANCE || !kinds) return unknown(instr.type);
    const Id d_lo = b_.input(Type::kFloat, (*kinds)[0], 0, 0);
    const Id d_hi = b_.input(Type::kFloat, (*kinds)[1], 0, 0);
    const Id away = distance_from_centre(query);
    Id size = emit(Op::kAdd, away, emit(Op::kMax, emit(Op::kAbs, d_lo), emit(Op::kAbs, d_hi)));
    Id voxel = b_.constant(0.0f);
    for (int32_t axis = 0; axis < 3; ++axis) {
        size = emit(Op::kAdd, size, magnitude(query.args[static_cast<size_t>(1 + axis)]));
        voxel = emit(Op::kAdd, voxel, frame(OPENFAB_FRAME_VOXEL_SIZE + axis));
    }
    const Id slack = emit(Op::kAdd, emit(Op::kMul, size, b_.constant(kDistanceSlack)),
                          emit(Op::kMul, voxel, b_.constant(kVoxelSlack)));
    const Id reach = emit(Op::kAdd, away, slack);
    const Interval d = finish(emit(Op::kSub, d_lo, reach), emit(Op::kAdd, d_hi, reach));
    return or_zero(values_[query.args[0]], d);
}

/// Returns the largest distance of the query's point from the centre of its voxel.
ir::ValueId IntervalForm::distance_from_centre(const Instr& query) {
    Id square = b_.constant(0.0f);
    for (int32_t axis = 0; axis < 3; ++axis) {
        const Id off = offset_from_centre(query.args[static_cast<size_t>(1 + axis)], axis);
        square = emit(Op::kAdd, square, emit(Op::kMul, off, off));
    }
    return emit(Op::kMul, emit(Op::kSqrt, square), b_.constant(1.0f + kPositionSlack));
}

/// Returns the offset along one axis, rounding included. For a point written as the voxel's centre
/// plus or minus a term it is that term; for others the farthest ends are used, which adds the size
/// of the box.
ir::ValueId IntervalForm::offset_from_centre(Id coordinate, int32_t axis) {
    const Instr& local = from_.instrs[coordinate];
    Id size =
        emit(Op::kAdd, magnitude(coordinate), emit(Op::kAbs, frame(OPENFAB_FRAME_CENTER + axis)));
    Id off = ir::kNoValue;
    if (local.op == Op::kSub && is_frame(local.args[1], OPENFAB_FRAME_CENTER + axis)) {
        const Instr& point = from_.instrs[local.args[0]];
        size = emit(Op::kAdd, size, magnitude(local.args[0]));
        const bool sum = point.op == Op::kAdd;
        if (is_centre(local.args[0], axis)) {
            off = b_.constant(0.0f);
        } else if ((sum || point.op == Op::kSub) && is_centre(point.args[0], axis)) {
            off = magnitude(point.args[1]);
        } else if (sum && is_centre(point.args[1], axis)) {
            off = magnitude(point.args[0]);
        }
    }
    if (off == ir::kNoValue) {
        const Interval p = values_[coordinate], c = voxel_centre(axis);
        off = emit(Op::kMax, emit(Op::kAbs, emit(Op::kSub, p.hi, c.lo)),
                   emit(Op::kAbs, emit(Op::kSub, c.hi, p.lo)));
    }
    return emit(Op::kAdd, off, emit(Op::kMul, size, b_.constant(kPositionSlack)));
}

/// Returns the voxel centre in part-local mm, as in abi/fablet_table.h.
Interval IntervalForm::voxel_centre(int32_t axis) {
    Id lo = frame(OPENFAB_FRAME_ORIGIN + axis), hi = lo;
    for (int32_t k = 0; k < 3; ++k) {
        const Id step = frame(OPENFAB_FRAME_STEP_I + 3 * k + axis);
        const Id a = emit(Op::kMul, b_.input(Type::kFloat, ir::kVoxelCoordLo, k, 0), step);
        const Id b = emit(Op::kMul, b_.input(Type::kFloat, ir::kVoxelCoordHi, k, 0), step);
        lo = emit(Op::kAdd, lo, emit(Op::kMin, a, b));
        hi = emit(Op::kAdd, hi, emit(Op::kMax, a, b));
    }
    return {lo, hi, ir::kNoValue};
}

ir::ValueId IntervalForm::frame(int32_t index) {
    return b_.input(Type::kFloat, OPENFAB_ARG_FRAME, index, 0);
}

bool IntervalForm::is_frame(Id value, int32_t index) const {
    const Instr& instr = from_.instrs[value];
    return instr.op == Op::kInput && instr.kind == OPENFAB_ARG_FRAME && instr.a == index;
}

/// attr.voxelCenter: nothing else in a stage reads the frame's ORIGIN.
bool IntervalForm::is_centre(Id value, int32_t axis) const {
    const Instr& sum = from_.instrs[value];
    if (sum.op != Op::kAdd || !is_frame(sum.args[1], OPENFAB_FRAME_CENTER + axis)) return false;
    const Instr& local = from_.instrs[sum.args[0]];
    return local.op == Op::kAdd && is_frame(local.args[1], OPENFAB_FRAME_ORIGIN + axis);
}

}  // namespace openfab::passes
