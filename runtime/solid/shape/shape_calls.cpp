// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/shape_calls.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "abi/looks.h"
#include "abi/shape_distance.h"

namespace openfab::solid {

namespace {

/// Points of one call: their buffers stay in the second-level cache.
constexpr size_t kMost = 4096;

}  // namespace

ShapeCalls::ShapeCalls(const part::ShapeStage& stage, const surface::StaticArgs& fixed,
                       const ShapeBodies& bodies, openfab_isa isa)
    : StageCalls(*stage.fablet->shape, fixed, isa, kMost),
      bodies_(bodies),
      distances_(stage.bodies.size()) {
    for (size_t a = 0; a < 3; ++a) {
        const double stretch = stage.stretch[a];
        stretched_ = stretched_ || stretch != 1;
        shrink_[a] = static_cast<float>(1 / stretch);
    }
    if (const float scale = part::scale_of_values(stage); scale != 0) scale_ = scale;
    const openfab_kernel& kernel = shape_.bounds;
    asks_ = std::any_of(kernel.args, kernel.args + kernel.arg_count, [](const openfab_arg& arg) {
        return arg.kind == abi::kShapeDistanceLo || arg.kind == abi::kShapeDistanceHi;
    });
    looks_ = asks_ && std::any_of(kernel.args, kernel.args + kernel.arg_count, abi::is_looks);
}

abi::KernelStatus ShapeCalls::values(const ShapePoints& points, std::vector<float>* out) {
    out->resize(whole_lanes(points.size()));
    set_points(points, &moved_, &points_);
    value_ = out->data();
    const abi::KernelStatus status = run(shape_.values, shape_.value_segments, points.size());
    scale(out);
    return status;
}

abi::KernelStatus ShapeCalls::bounds(const ShapePoints& lo, const ShapePoints& hi,
                                     std::vector<float>* out_lo, std::vector<float>* out_hi) {
    out_lo->resize(lo.size());
    out_hi->resize(lo.size());
    if (shape_.bounds.arg_count == 0) {
        std::fill(out_lo->begin(), out_lo->end(), std::numeric_limits<float>::quiet_NaN());
        *out_hi = *out_lo;
        return {};
    }
    set_points(lo, &moved_lo_, &lo_);
    set_points(hi, &moved_hi_, &hi_);
    if (looks_) value_looks_.resize(lo.size());
    value_lo_ = out_lo->data();
    value_hi_ = out_hi->data();
    const abi::KernelStatus status = run(shape_.bounds, {}, lo.size());
    scale(out_lo);
    scale(out_hi);
    return status;
}

/// Step by step: those boxes whose signs are open take more.
abi::KernelStatus ShapeCalls::bounds_by(std::initializer_list<Effort> efforts,
                                        const ShapePoints& lo, const ShapePoints& hi,
                                        std::vector<float>* out_lo, std::vector<float>* out_hi) {
    std::vector<size_t> open(lo.size());
    std::iota(open.begin(), open.end(), size_t{0});
    out_lo->resize(lo.size());
    out_hi->resize(lo.size());
    ShapePoints some_lo, some_hi;
    std::vector<float> found_lo, found_hi;
    abi::KernelStatus status;
    for (const Effort effort : efforts) {
        if (open.empty() || !status.ok()) break;
        if (effort == Effort::kNear && !bodies_.any_quick()) continue;
        some_lo.clear();
        some_hi.clear();
        for (const size_t i : open) {
            some_lo.push_back(lo.point(i));
            some_hi.push_back(hi.point(i));
        }
        effort_ = effort;
        status = bounds(some_lo, some_hi, &found_lo, &found_hi);
        effort_ = Effort::kExact;
        size_t left = 0;
        for (size_t k = 0; k < open.size(); ++k) {
            (*out_lo)[open[k]] = found_lo[k];
            (*out_hi)[open[k]] = found_hi[k];
            if (!(found_lo[k] >= 0) && !(found_hi[k] < 0)) open[left++] = open[k];
        }
        open.resize(left);
    }
    return status;
}

abi::KernelStatus ShapeCalls::sign_bounds(const ShapePoints& lo, const ShapePoints& hi,
                                          std::vector<float>* out_lo, std::vector<float>* out_hi) {
    if (!asks_) return bounds(lo, hi, out_lo, out_hi);
    return bounds_by({Effort::kBox, Effort::kNear, Effort::kExact}, lo, hi, out_lo, out_hi);
}

abi::KernelStatus ShapeCalls::cheap_bounds(const ShapePoints& lo, const ShapePoints& hi,
                                           std::vector<float>* out_lo, std::vector<float>* out_hi) {
    if (!asks_ || !bodies_.any_quick()) return sign_bounds(lo, hi, out_lo, out_hi);
    return bounds_by({Effort::kBox, Effort::kNear}, lo, hi, out_lo, out_hi);
}

abi::KernelStatus ShapeCalls::signs_by(std::initializer_list<Effort> efforts,
                                       const ShapePoints& points, std::vector<float>* out) {
    std::vector<float> hi;
    const abi::KernelStatus status = bounds_by(efforts, points, points, out, &hi);
    for (size_t i = 0; i < points.size(); ++i) {
        float& lo = (*out)[i];
        lo = lo >= 0 ? lo : hi[i] < 0 ? hi[i] : std::numeric_limits<float>::quiet_NaN();
    }
    return status;
}

/// Computes the values at points at which `out` is NaN.
abi::KernelStatus ShapeCalls::fill_rest(const ShapePoints& points, std::vector<float>* out) {
    ShapePoints open;
    for (size_t i = 0; i < points.size(); ++i) {
        if (std::isnan((*out)[i])) open.push_back(points.point(i));
    }
    if (open.size() == 0) return {};
    std::vector<float> rest;
    const abi::KernelStatus status = values(open, &rest);
    size_t next = 0;
    for (size_t i = 0; i < points.size(); ++i) {
        if (std::isnan((*out)[i])) (*out)[i] = rest[next++];
    }
    return status;
}

abi::KernelStatus ShapeCalls::cheap_signs(const ShapePoints& points, std::vector<float>* out) {
    return signs_by({Effort::kBox, Effort::kNear}, points, out);
}

abi::KernelStatus ShapeCalls::signs(const ShapePoints& points, std::vector<float>* out) {
    if (!asks_) return values(points, out);
    const abi::KernelStatus status = cheap_signs(points, out);
    return status.ok() ? fill_rest(points, out) : status;
}

abi::KernelStatus ShapeCalls::dense_signs(const ShapePoints& points, std::vector<float>* out) {
    if (!asks_) return values(points, out);
    const abi::KernelStatus status = signs_by({Effort::kBox, Effort::kGrid}, points, out);
    return status.ok() ? fill_rest(points, out) : status;
}

abi::KernelStatus ShapeCalls::dense_values(const ShapePoints& points, std::vector<float>* out) {
    if (!looks_ || points.size() == 0) return values(points, out);
    std::vector<float> lo, hi;
    for (Distances& of_object : distances_)
        of_object.all.clear();
    effort_ = Effort::kGrid;
    keep_ = true;
    abi::KernelStatus status = bounds(points, points, &lo, &hi);
    keep_ = false;
    effort_ = Effort::kExact;
    if (!status.ok()) return status;
    // The others have the same value with any distance within bounds.
    std::vector<size_t> asked;
    for (size_t i = 0; i < points.size(); ++i) {
        const bool open = std::any_of(
            distances_.begin(), distances_.end(),
            [&](const Distances& of) { return !of.all.empty() && std::isnan(of.all[i]); });
        if (open || value_looks_[i] != 0) asked.push_back(i);
    }
    set_points(points, &moved_, &points_);
    for (size_t object = 0; object < distances_.size(); ++object) {
        std::vector<float>& all = distances_[object].all;
        if (all.empty()) continue;
        all.resize(whole_lanes(points.size()));
        if (asked.empty()) continue;
        std::array<std::vector<float>, 3> at;
        for (size_t a = 0; a < 3; ++a) {
            for (const size_t i : asked)
                at[a].push_back(points_[a][i]);
        }
        std::vector<float> found(asked.size());
        bodies_.distances(object, {at[0].data(), at[1].data(), at[2].data()}, asked.size(), &tools_,
                          found.data());
        for (size_t k = 0; k < asked.size(); ++k)
            all[asked[k]] = found[k];
    }
    use_ = true;
    status = values(points, out);
    use_ = false;
    return status;
}

abi::KernelStatus ShapeCalls::attributes(const ShapePoints& points,
                                         std::vector<std::vector<uint32_t>>* out) {
    out->resize(components());
    for (auto& component : *out)
        component.assign(whole_lanes(points.size()), 0);
    set_points(points, &moved_, &points_);
    outputs_ = out;
    return run(shape_.attributes, shape_.attribute_segments, points.size());
}

/// Points of the part, in the stage's space: each coordinate is one product, so that points of a box
/// stay in the box that is moved.
void ShapeCalls::set_points(const ShapePoints& from, std::array<std::vector<float>, 3>* moved,
                            Axes* to) {
    for (size_t a = 0; a < 3; ++a) {
        (*to)[a] = from.at[a].data();
        if (!stretched_) continue;
        std::vector<float>& axis = (*moved)[a];
        axis.resize(whole_lanes(from.size()));
        for (size_t i = 0; i < from.size(); ++i)
            axis[i] = from.at[a][i] * shrink_[a];
        (*to)[a] = axis.data();
    }
}

void ShapeCalls::scale(std::vector<float>* values) const {
    if (scale_ == 1) return;
    for (float& value : *values)
        value *= scale_;
}

/// Returns the distances to an object at the piece's points, or their bounds over its boxes.
float* ShapeCalls::distances(const openfab_arg& arg) {
    const auto object = static_cast<size_t>(arg.a);
    Distances& mine = distances_[object];
    const auto at = [&](const Axes& axes) {
        return Axes{axes[0] + first_, axes[1] + first_, axes[2] + first_};
    };
    const bool boxes = arg.kind != abi::kShapeDistance;
    if (use_ && !boxes && !mine.all.empty()) return mine.all.data() + first_;
    if (!mine.known) {
        for (std::vector<float>* list : {&mine.at, &mine.lo, &mine.hi})
            list->resize(whole_lanes(in_piece_));
        if (boxes) {
            bodies_.bounds(object, at(lo_), at(hi_), in_piece_, effort_, &tools_, mine.lo.data(),
                           mine.hi.data());
            if (keep_) mine.all.insert(mine.all.end(), mine.lo.data(), mine.lo.data() + in_piece_);
        } else {
            bodies_.distances(object, at(points_), in_piece_, &tools_, mine.at.data());
        }
        mine.known = true;
    }
    if (!boxes) return mine.at.data();
    return arg.kind == abi::kShapeDistanceLo ? mine.lo.data() : mine.hi.data();
}

void ShapeCalls::begin_piece() {
    for (Distances& of_object : distances_)
        of_object.known = false;
}

void* ShapeCalls::data(const openfab_arg& arg) {
    if (arg.kind >= abi::kShapeDistance && arg.kind <= abi::kShapeDistanceHi) return distances(arg);
    const auto from = [&](const float* list) { return const_cast<float*>(list) + first_; };
    switch (arg.kind) {
        case OPENFAB_ARG_SHAPE_POINT:
            return from(points_[static_cast<size_t>(arg.a)]);
        case OPENFAB_ARG_SHAPE_POINT_LO:
            return from(lo_[static_cast<size_t>(arg.a)]);
        case OPENFAB_ARG_SHAPE_POINT_HI:
            return from(hi_[static_cast<size_t>(arg.a)]);
        case OPENFAB_ARG_SHAPE_VALUE:
            return from(value_);
        case OPENFAB_ARG_SHAPE_VALUE_LO:
            return from(value_lo_);
        case OPENFAB_ARG_SHAPE_VALUE_HI:
            return from(abi::is_looks(arg) ? value_looks_.data() : value_hi_);
        case OPENFAB_ARG_SHAPE_OUT:
            return (*outputs_)[first_component(arg.a) + static_cast<size_t>(arg.b)].data() + first_;
        default:
            return nullptr;
    }
}

/// The distance to an object at points that are computed.
abi::KernelStatus ShapeCalls::query(const openfab_query& query, std::span<const int32_t> groups,
                                    const segments::States& states) {
    if (query.object < 0 || static_cast<size_t>(query.object) >= distances_.size())
        return abi::KernelStatus::of_code(halide_error_code_generic_error);
    const size_t n = segments::kLanes * groups.size();
    for (std::vector<float>& axis : asked_)
        axis.resize(n);
    answered_.resize(n);
    for (size_t g = 0; g < groups.size(); ++g) {
        for (size_t a = 0; a < 3; ++a) {
            const float* from = reinterpret_cast<const float*>(states[query.point[a]]);
            std::copy_n(from + segments::kLanes * groups[g], segments::kLanes,
                        asked_[a].data() + segments::kLanes * g);
        }
    }
    bodies_.distances(static_cast<size_t>(query.object),
                      {asked_[0].data(), asked_[1].data(), asked_[2].data()}, n, &tools_,
                      answered_.data());
    for (size_t g = 0; g < groups.size(); ++g) {
        const ptrdiff_t first = segments::kLanes * groups[g];
        const uint32_t* guard = states[query.guard] + first;
        for (int32_t i = 0; i < query.output_count; ++i) {
            float* to = reinterpret_cast<float*>(states[query.outputs[i].state]) + first;
            for (size_t l = 0; l < segments::kLanes; ++l)
                to[l] = guard[l] != 0 ? answered_[segments::kLanes * g + l] : 0.0f;
        }
    }
    return {};
}

}  // namespace openfab::solid
