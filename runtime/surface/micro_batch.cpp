// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/micro_batch.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "abi/argument_group.h"
#include "base/check.h"

namespace openfab::surface {

namespace {

bool is_gradient(openfab_arg_kind kind) {
    return kind == OPENFAB_ARG_SURFACE_IN_GRAD || kind == OPENFAB_ARG_SURFACE_ATTR_GRAD;
}

}  // namespace

MicroBatch::MicroBatch(const part::Part& part, const BaseMesh& base, const StaticArgs& args,
                       const NearestLayout& nearest, openfab_isa isa)
    : part_(part),
      base_(base),
      nearest_(nearest),
      kernel_(part.fablet->surface),
      static_args_(args),
      isa_(isa),
      call_(part.fablet->surface, isa) {
    const size_t count = static_cast<size_t>(kernel_.arg_count);
    buffers_ = std::make_unique<abi::KernelBuffer[]>(count);
    batched_.assign(count, 0);
    floats_.resize(count);
    ints_.resize(count);
    output_argument_.assign(static_cast<size_t>(part.fablet->surface_output_count * kMaxComponents),
                            -1);
    for (size_t i = 0; i < count; ++i) {
        const openfab_arg& arg = kernel_.args[i];
        if (const void* fixed = args.find(arg)) {
            call_.set(static_cast<int32_t>(i), fixed);
            continue;
        }
        batched_[i] = 1;
        call_.set(static_cast<int32_t>(i), buffers_[i].raw());
        const int32_t index = static_cast<int32_t>(i);
        if (arg.kind == OPENFAB_ARG_POSITION) position_argument_[arg.b] = index;
        if (arg.kind == OPENFAB_ARG_SURFACE_STATUS) status_argument_ = index;
        if (arg.kind == OPENFAB_ARG_SURFACE_OUT) {
            output_argument_[static_cast<size_t>(arg.a * kMaxComponents + arg.b)] = index;
        }
        needs_normal_ |= arg.kind == OPENFAB_ARG_SURFACE_ATTR && arg.a == OPENFAB_SURFACE_N;
    }
}

const MicroBatch::Run& MicroBatch::run_of(int32_t i) const {
    const auto after =
        std::upper_bound(runs_.begin(), runs_.end(), i,
                         [](int32_t index, const Run& run) { return index < run.first; });
    return *(after - 1);
}

MicroBatch::Corners MicroBatch::input_corners(int32_t triangle, const part::PartAttribute& input,
                                              int32_t component) const {
    const size_t stride = static_cast<size_t>(input.components);
    const float* v =
        input.corner_values.data() + 3 * static_cast<size_t>(triangle) * stride + component;
    return {{v[0], v[stride], v[2 * stride]}};
}

MicroBatch::Corners MicroBatch::normal_corners(int32_t triangle, int32_t axis) const {
    if (base_.mesh().corner_normals.empty()) {
        const float ng = base_.frame(triangle).ng[axis];
        return {{ng, ng, ng}};
    }
    const Vec3f* n = base_.mesh().corner_normals.data() + 3 * static_cast<size_t>(triangle);
    return {{n[0][axis], n[1][axis], n[2][axis]}};
}

MicroBatch::Corners MicroBatch::uv_corners(int32_t triangle, int32_t axis) const {
    const float* uv = base_.mesh().corner_uv.data() + 6 * static_cast<size_t>(triangle) + axis;
    return {{uv[0], uv[2], uv[4]}};
}

/// Vertices [from, from + count) of the run, index within the run.
void MicroBatch::interpolate(const Run& run, const Corners& corners, int32_t from, int32_t count,
                             float* out, size_t stride) const {
    if (run.lattice) {
        const float* wa = weight_a_.data() + run.first + from;
        const float* wb = weight_b_.data() + run.first + from;
        if (stride == 1) {
            for (int32_t i = 0; i < count; ++i) {
                out[i] = lattice_value(corners[0], corners[1], corners[2], wa[i], wb[i]);
            }
        } else {
            for (int32_t i = 0; i < count; ++i) {
                out[static_cast<size_t>(i) * stride] =
                    lattice_value(corners[0], corners[1], corners[2], wa[i], wb[i]);
            }
        }
    }
    for (int32_t e = run.edge_first; e < run.edge_end; ++e) {
        const EdgePoint& point = edge_points_[e];
        const int32_t i = point.index - run.first - from;
        if (i < 0 || i >= count) continue;
        out[static_cast<size_t>(i) * stride] =
            edge_value(corners[point.lo], corners[point.hi], point.i, point.n);
    }
}

void MicroBatch::fill_positions(const Run& run) {
    const Vec3d* p[3] = {&base_.position(3 * run.triangle), &base_.position(3 * run.triangle + 1),
                         &base_.position(3 * run.triangle + 2)};
    for (int axis = 0; axis < 3; ++axis) {
        float* out = place_[axis].data();
        const double v0 = (*p[0])[axis], v1 = (*p[1])[axis], v2 = (*p[2])[axis];
        if (run.lattice) {
            const double lo = std::min({v0, v1, v2}), hi = std::max({v0, v1, v2});
            for (int32_t i = run.first; i < run.first + run.count; ++i) {
                const size_t k = static_cast<size_t>(i);
                out[k] = round_position(
                    clamp_to(lattice_coordinate(v0, v1, v2, wide_a_[k], wide_b_[k]), lo, hi));
            }
        }
    }
    for (int32_t e = run.edge_first; e < run.edge_end; ++e) {
        const EdgePoint& point = edge_points_[e];
        const Vec3f place =
            round_position(edge_position(*p[point.lo], *p[point.hi], point.i, point.n));
        for (int axis = 0; axis < 3; ++axis) {
            place_[axis][point.index] = place[axis];
        }
    }
}

void MicroBatch::fill_normals(const Run& run) {
    for (int axis = 0; axis < 3; ++axis) {
        interpolate(run, normal_corners(run.triangle, axis), 0, run.count,
                    normal_[axis].data() + run.first, 1);
    }
    const Vec3f ng = base_.frame(run.triangle).ng;
    float *x = normal_[0].data() + run.first, *y = normal_[1].data() + run.first,
          *z = normal_[2].data() + run.first;
    for (int32_t i = 0; i < run.count; ++i) {
        const Vec3f n = unit_normal({x[i], y[i], z[i]}, ng);
        x[i] = n.x, y[i] = n.y, z[i] = n.z;
    }
}

/// ng, dpdu, dpdv.
float MicroBatch::frame_value(const openfab_arg& arg, int32_t triangle) const {
    const TangentFrame frame = base_.frame(triangle);
    const Vec3f& v = arg.a == OPENFAB_SURFACE_NG     ? frame.ng
                     : arg.a == OPENFAB_SURFACE_DPDU ? frame.dpdu
                                                     : frame.dpdv;
    return v[arg.b];
}

float MicroBatch::gradient(const openfab_arg& arg, int32_t triangle) const {
    const int32_t n = base_.lattice_factor(triangle);
    const int32_t component = arg.b / 2, to = arg.b % 2 + 1;
    if (arg.kind == OPENFAB_ARG_SURFACE_IN_GRAD) {
        const part::PartAttribute& input = base_.mesh().inputs[arg.a];
        if (input.scalar != OPENFAB_FLOAT) return 0;
        const Corners v = input_corners(triangle, input, component);
        return lattice_gradient(v[0], v[to], n);
    }
    switch (arg.a) {
        case OPENFAB_SURFACE_P: {
            const double step = base_.position(3 * triangle + to)[component] -
                                base_.position(3 * triangle)[component];
            return static_cast<float>(step / n);
        }
        case OPENFAB_SURFACE_N: {
            const Corners v = normal_corners(triangle, component);
            return lattice_gradient(v[0], v[to], n);
        }
        case OPENFAB_SURFACE_UV: {
            const Corners v = uv_corners(triangle, component);
            return lattice_gradient(v[0], v[to], n);
        }
        default:
            return 0;  // constant on the base triangle
    }
}

void MicroBatch::fill_argument(const Run& run, size_t index) {
    const openfab_arg& arg = kernel_.args[index];
    float* out = floats_[index].empty() ? nullptr : floats_[index].data() + run.first;
    if (arg.kind == OPENFAB_ARG_SURFACE_IN) {
        const part::PartAttribute& input = base_.mesh().inputs[arg.a];
        if (input.scalar == OPENFAB_FLOAT) {
            interpolate(run, input_corners(run.triangle, input, arg.b), 0, run.count, out, 1);
        } else {
            const size_t at = static_cast<size_t>(run.triangle * input.components + arg.b);
            std::fill_n(ints_[index].begin() + run.first, run.count,
                        static_cast<int32_t>(input.face_values[at]));
        }
        return;
    }
    if (arg.kind == OPENFAB_ARG_SURFACE_ATTR && arg.a <= OPENFAB_SURFACE_N) {
        const auto& from = arg.a == OPENFAB_SURFACE_P ? place_ : normal_;
        std::copy_n(from[arg.b].begin() + run.first, run.count, out);
        return;
    }
    if (arg.kind == OPENFAB_ARG_SURFACE_ATTR && arg.a == OPENFAB_SURFACE_UV) {
        interpolate(run, uv_corners(run.triangle, arg.b), 0, run.count, out, 1);
        return;
    }
    // Values of the triangle, not of the vertex, come from the triangle that evaluates it.
    const auto value = [&](int32_t triangle) {
        return is_gradient(arg.kind) ? gradient(arg, triangle) : frame_value(arg, triangle);
    };
    if (run.lattice) std::fill_n(out, run.count, value(run.triangle));
    int32_t last = run.triangle;
    float last_value = value(last);
    for (int32_t e = run.edge_first; e < run.edge_end; ++e) {
        const EdgePoint& point = edge_points_[e];
        if (point.evaluator != last) {
            last = point.evaluator;
            last_value = value(last);
        }
        floats_[index][point.index] = last_value;
    }
}

abi::KernelStatus MicroBatch::evaluate() {
    not_finite = cut_to_bound = 0;
    for (const Run& run : runs_)
        fill_positions(run);
    for (int axis = 0; axis < 3; ++axis) {
        std::copy_n(place_[axis].begin(), size_, result_[axis].begin());
    }
    if (evaluated_ == 0) return {};
    for (const Run& run : runs_) {
        if (!run.displaced) break;
        if (needs_normal_) fill_normals(run);
        for (size_t i = 0; i < batched_.size(); ++i) {
            if (abi::group_of(kernel_.args[i].kind) == abi::ArgumentGroup::kSurfaceInput)
                fill_argument(run, i);
        }
    }
    for (size_t i = 0; i < batched_.size(); ++i) {
        if (batched_[i] == 0) continue;
        const openfab_scalar_type scalar = kernel_.args[i].scalar;
        const void* data =
            scalar == OPENFAB_FLOAT ? static_cast<const void*>(floats_[i].data()) : ints_[i].data();
        buffers_[i].set_dense(abi::halide_type(scalar), data, {evaluated_});
    }
    const bool segmented = part_.fablet->surface_segments.step_count > 0;
    const abi::KernelStatus error = segmented ? run_segments() : call_.run();
    if (error.ok()) read_results();
    return error;
}

/// The buffers of the batch have room for whole groups (see `grow`); lanes past the end are
/// inactive.
abi::KernelStatus MicroBatch::run_segments() {
    const int32_t groups = (evaluated_ + segments::kLanes - 1) / segments::kLanes;
    wanted_.assign(static_cast<size_t>(groups), 255);
    const int32_t rest = evaluated_ % segments::kLanes;
    if (rest != 0) wanted_.back() = static_cast<uint8_t>((1u << rest) - 1u);
    for (size_t i = 0; i < batched_.size(); ++i) {
        if (batched_[i] != 0) buffers_[i].set_dim(0, groups * segments::kLanes, 1);
    }
    const abi::KernelStatus status =
        driver_.run(part_.fablet->surface_segments, isa_, wanted_, this, this, static_args_.stop());
    if (log_ != nullptr) log_->end_batch();
    return status;
}

size_t MicroBatch::argument_index(const openfab_arg& arg) const {
    size_t i = 0;
    while (kernel_.args[i].kind != arg.kind || kernel_.args[i].a != arg.a ||
           kernel_.args[i].b != arg.b) {
        ++i;
    }
    return i;
}

const void* MicroBatch::input(const openfab_arg& arg) {
    if (const void* fixed = static_args_.find(arg)) return fixed;
    return buffers_[argument_index(arg)].raw();
}

segments::OutputView MicroBatch::output(const openfab_arg& arg) {
    const size_t i = argument_index(arg);
    if (arg.scalar != OPENFAB_FLOAT) return {reinterpret_cast<uint32_t*>(ints_[i].data())};
    return {reinterpret_cast<uint32_t*>(floats_[i].data())};
}

/// The language has queries in the volume stage only.
abi::KernelStatus MicroBatch::query(const openfab_query& /*query*/,
                                    std::span<const int32_t> /*groups*/,
                                    const segments::States& /*states*/) {
    return abi::KernelStatus::of_code(halide_error_code_generic_error);
}

/// Points on an edge are evaluated with each triangle at it.
bool MicroBatch::stands(int32_t i) const {
    const auto at =
        std::lower_bound(edge_points_.begin(), edge_points_.end(), i,
                         [](const EdgePoint& point, int32_t index) { return point.index < index; });
    if (at == edge_points_.end() || at->index != i) return true;
    return at->stands && at->evaluator == run_of(i).triangle;
}

/// Patches are evaluated as often as the cache needs them, which logs nothing.
void MicroBatch::printf(const openfab_printf& call, std::span<const int32_t> groups,
                        const segments::States& states) {
    if (log_ == nullptr) return;
    log_->add(part_.fablet->surface_segments, call, groups, states,
              [&](int32_t i) -> std::optional<std::array<float, 3>> {
                  if (!stands(i)) return std::nullopt;
                  std::array<float, 3> p{};  // attr.p
                  for (size_t axis = 0; axis < 3; ++axis)
                      p[axis] = place_[axis][i] + static_args_.center(axis);
                  return p;
              });
}

void MicroBatch::read_results() {
    for (size_t axis = 0; axis < 3; ++axis) {
        if (position_argument_[axis] < 0) continue;
        const float* from = floats_[position_argument_[axis]].data();
        for (int32_t i = 0; i < evaluated_; ++i)
            result_[axis][i] = from[i] + 0.0f;
    }
    // A finite displacement can still overflow the sum; such a vertex does not move.
    constexpr float kMax = std::numeric_limits<float>::max();
    for (int32_t i = 0; i < evaluated_; ++i) {
        const size_t k = static_cast<size_t>(i);
        const bool fine = std::fabs(result_[0][k]) <= kMax && std::fabs(result_[1][k]) <= kMax &&
                          std::fabs(result_[2][k]) <= kMax;
        if (fine) continue;
        for (size_t axis = 0; axis < 3; ++axis)
            result_[axis][k] = place_[axis][k];
        ++not_finite;
    }
    if (status_argument_ < 0) return;
    const int32_t* status = ints_[status_argument_].data();
    for (int32_t i = 0; i < evaluated_; ++i) {
        not_finite += status[i] == 1;
        cut_to_bound += status[i] == 2;
    }
}

void MicroBatch::float_attribute(size_t k, int32_t first, int32_t count, float* out,
                                 size_t stride) const {
    const NearestComponent& from = nearest_.floats[k];
    const part::PartMesh& mesh = base_.mesh();
    while (count > 0) {
        const Run& run = run_of(first);
        const int32_t here = std::min(count, run.first + run.count - first);
        if (from.from == NearestComponent::From::kSurfaceOutput) {
            const int32_t arg =
                output_argument_[static_cast<size_t>(from.index * kMaxComponents + from.component)];
            for (int32_t i = 0; i < here; ++i) {
                out[static_cast<size_t>(i) * stride] =
                    arg < 0 ? 0.0f : floats_[arg][static_cast<size_t>(first + i)];
            }
        } else {
            const auto& attributes =
                from.from == NearestComponent::From::kMesh ? mesh.nearest_attributes : mesh.inputs;
            interpolate(run, input_corners(run.triangle, attributes[from.index], from.component),
                        first - run.first, here, out, stride);
        }
        out += static_cast<size_t>(here) * stride;
        first += here;
        count -= here;
    }
}

uint32_t MicroBatch::int_attribute(size_t k, int32_t i) const {
    const NearestComponent& from = nearest_.ints[k];
    if (from.from == NearestComponent::From::kSurfaceOutput) {
        const int32_t arg =
            output_argument_[static_cast<size_t>(from.index * kMaxComponents + from.component)];
        return arg < 0 ? 0u : std::bit_cast<uint32_t>(ints_[arg][i]);
    }
    const part::PartMesh& mesh = base_.mesh();
    const auto& attributes =
        from.from == NearestComponent::From::kMesh ? mesh.nearest_attributes : mesh.inputs;
    const part::PartAttribute& attribute = attributes[from.index];
    return attribute.face_values[static_cast<size_t>(run_of(i).triangle * attribute.components +
                                                     from.component)];
}

}  // namespace openfab::surface
