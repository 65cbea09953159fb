// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/bounds_batch.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "abi/argument_group.h"
#include "base/check.h"

namespace openfab::surface {

namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
// Interpolating in float takes seven roundings of values up to twice the largest corner: less than
// 2^-20 of it. Twice that.
constexpr float kFloatSlack = 0x1p-19f;

/// The next float up, as std::nextafter, which is a call.
float above(float x) {
    if (!(x < kInf)) return x;
    if (x == 0) return std::numeric_limits<float>::denorm_min();
    const auto bits = std::bit_cast<int32_t>(x);
    return std::bit_cast<float>(bits >= 0 ? bits + 1 : bits - 1);
}
float below(float x) {
    return -above(-x);
}

bool is_high(openfab_arg_kind kind) {
    switch (kind) {
        case OPENFAB_ARG_SURFACE_IN_HI:
        case OPENFAB_ARG_SURFACE_IN_GRAD_HI:
        case OPENFAB_ARG_SURFACE_ATTR_HI:
        case OPENFAB_ARG_SURFACE_ATTR_GRAD_HI:
            return true;
        default:
            return false;
    }
}

bool is_input(openfab_arg_kind kind) {
    return abi::group_of(kind) == abi::ArgumentGroup::kSurfaceBoundsInput;
}

}  // namespace

Range<float> corner_range(const part::PartAttribute& attribute, int32_t triangle,
                          int32_t component) {
    const size_t stride = static_cast<size_t>(attribute.components);
    const float* v =
        attribute.corner_values.data() + 3 * static_cast<size_t>(triangle) * stride + component;
    Range<float> out{v[0], v[0]};
    out.add({v[stride], v[stride]});
    out.add({v[2 * stride], v[2 * stride]});
    return out;
}

BoundsBatch::BoundsBatch(const part::Part& part, const BaseMesh& base, const StaticArgs& args,
                         const NearestLayout& nearest, openfab_isa isa)
    : part_(part),
      base_(base),
      nearest_(nearest),
      kernel_(part.fablet->surface_bounds),
      call_(part.fablet->surface_bounds, isa) {
    const size_t count = static_cast<size_t>(kernel_.arg_count);
    buffers_ = std::make_unique<abi::KernelBuffer[]>(count);
    batched_.assign(count, 0);
    floats_.resize(count);
    ints_.resize(count);
    high_of_.assign(count, -1);
    for (auto& pair : displacement_argument_)
        pair = {-1, -1};
    output_argument_.assign(static_cast<size_t>(part.fablet->surface_output_count * kMaxComponents),
                            {-1, -1});
    for (size_t i = 0; i < count; ++i) {
        const openfab_arg& arg = kernel_.args[i];
        const int32_t index = static_cast<int32_t>(i);
        if (const void* fixed = args.find(arg)) {
            call_.set(index, fixed);
            continue;
        }
        batched_[i] = 1;
        call_.set(index, buffers_[i].raw());
        const size_t output = static_cast<size_t>(arg.a * kMaxComponents + arg.b);
        switch (arg.kind) {
            case OPENFAB_ARG_DISPLACEMENT_LO:
                displacement_argument_[arg.b][0] = index;
                break;
            case OPENFAB_ARG_DISPLACEMENT_HI:
                displacement_argument_[arg.b][1] = index;
                break;
            case OPENFAB_ARG_SURFACE_OUT_LO:
                output_argument_[output][0] = index;
                break;
            case OPENFAB_ARG_SURFACE_OUT_HI:
                output_argument_[output][1] = index;
                break;
            default:
                break;
        }
    }
    pair_inputs();
}

/// Finds the other end of each range that the kernel reads both ends of.
void BoundsBatch::pair_inputs() {
    const auto count = static_cast<int32_t>(high_of_.size());
    for (int32_t i = 0; i < count; ++i) {
        const openfab_arg& low = kernel_.args[i];
        if (batched_[i] == 0 || low.scalar != OPENFAB_FLOAT || !is_input(low.kind) ||
            is_high(low.kind))
            continue;
        for (int32_t k = 0; k < count; ++k) {
            const openfab_arg& high = kernel_.args[k];
            if (batched_[k] != 0 && high.kind == low.kind + 1 && high.a == low.a &&
                high.b == low.b && is_high(high.kind))
                high_of_[i] = k;
        }
    }
}

void BoundsBatch::clear() {
    items_.clear();
}

void BoundsBatch::add_evaluator(Item* item, int32_t triangle) const {
    for (int32_t i = 0; i < item->evaluators; ++i) {
        if (item->evaluator[i] == triangle) return;
    }
    OPENFAB_CHECK_LT(static_cast<size_t>(item->evaluators), item->evaluator.size());
    item->evaluator[static_cast<size_t>(item->evaluators++)] = triangle;
}

void BoundsBatch::add_tile(int32_t triangle, const Tile& tile) {
    Item item;
    item.triangle = triangle;
    item.span = span_tile(base_, triangle, tile);
    const int32_t n = base_.lattice_factor(triangle);
    add_evaluator(&item, triangle);
    const bool touches[3] = {tile.b0 == 0, tile.a1 + tile.b1 >= n, tile.a0 == 0};
    for (int32_t e = 0; e < 3; ++e) {
        if (!touches[e]) continue;
        const size_t side = static_cast<size_t>(3 * triangle + e);
        add_evaluator(&item, base_.side_evaluator[side]);
        // Snapping may reach either end of the side from anywhere near it; taking both costs
        // nothing but tightness.
        add_evaluator(&item, base_.corner_class[side] / 3);
        add_evaluator(
            &item,
            base_.corner_class[static_cast<size_t>(BaseMesh::next_corner(3 * triangle + e))] / 3);
    }
    items_.push_back(item);
}

void BoundsBatch::add_triangle(int32_t triangle) {
    Item item;
    item.triangle = triangle;
    item.span.add(0, 0);
    item.span.add(1, 0);
    item.span.add(0, 1);
    add_evaluator(&item, triangle);
    items_.push_back(item);
}

Range<float> BoundsBatch::linear(const Item& item, const std::array<float, 3>& corners) const {
    const auto [v0, v1, v2] = corners;
    if (v0 == v1 && v0 == v2) return {v0, v0};
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    for (int32_t i = 0; i < item.span.points; ++i) {
        const size_t k = static_cast<size_t>(i);
        const double v = lattice_coordinate(v0, v1, v2, item.span.wa[k], item.span.wb[k]);
        lo = std::min(lo, v), hi = std::max(hi, v);
    }
    const float slack = kFloatSlack * std::max({std::fabs(v0), std::fabs(v1), std::fabs(v2)});
    if (!(slack < kInf)) return {-kInf, kInf};
    return {below(static_cast<float>(lo)) - slack, above(static_cast<float>(hi)) + slack};
}

Range<float> BoundsBatch::position_range(const Item& item, int32_t axis) const {
    const double v0 = base_.position(3 * item.triangle)[axis];
    const double v1 = base_.position(3 * item.triangle + 1)[axis];
    const double v2 = base_.position(3 * item.triangle + 2)[axis];
    const float least = round_position(std::min({v0, v1, v2})),
                greatest = round_position(std::max({v0, v1, v2}));
    float lo = kInf, hi = -kInf;
    for (int32_t i = 0; i < item.span.points; ++i) {
        const size_t k = static_cast<size_t>(i);
        const float v =
            round_position(lattice_coordinate(v0, v1, v2, item.span.wa[k], item.span.wb[k]));
        lo = std::min(lo, v), hi = std::max(hi, v);
    }
    // Points are held in the triangle's box, so that flat sides have exact bounds.
    return {std::max(below(lo), least), std::min(above(hi), greatest)};
}

std::array<Range<float>, 3> BoundsBatch::normal_ranges(const Item& item) const {
    const Vec3f ng = base_.frame(item.triangle).ng;
    std::array<Vec3f, 3> n;
    for (int32_t c = 0; c < 3; ++c)
        n[c] = base_.normal(3 * item.triangle + c, ng);
    std::array<Range<float>, 3> out;
    if (n[0] == n[1] && n[0] == n[2]) {
        const Vec3f v = unit_normal(n[0], ng);
        for (int32_t a = 0; a < 3; ++a)
            out[a] = {v[a], v[a]};
        return out;
    }
    Range<float> l[3];
    double least2 = 0, greatest2 = 0;
    for (int32_t a = 0; a < 3; ++a) {
        l[a] = linear(item, {n[0][a], n[1][a], n[2][a]});
        const double lo = l[a].lo, hi = l[a].hi;
        least2 += lo > 0 ? lo * lo : hi < 0 ? hi * hi : 0;
        greatest2 += std::max(lo * lo, hi * hi);
    }
    const double least = std::sqrt(least2), greatest = std::sqrt(greatest2);
    for (int32_t a = 0; a < 3; ++a) {
        out[a] = {-1.0f, 1.0f};
        if (least > 1e-3) {
            const double lo = l[a].lo, hi = l[a].hi;
            const double from = lo < 0 ? lo / least : lo / greatest,
                         to = hi < 0 ? hi / greatest : hi / least;
            out[a].lo = std::max(out[a].lo, static_cast<float>(from - kFloatSlack));
            out[a].hi = std::min(out[a].hi, static_cast<float>(to + kFloatSlack));
        }
        // A unit vector in float may exceed 1 by its rounding; where normals cancel the geometric
        // one stands in.
        out[a].lo -= kFloatSlack, out[a].hi += kFloatSlack;
        if (!(least > 1e-3)) out[a].add({ng[a], ng[a]});
    }
    return out;
}

Range<float> BoundsBatch::attribute_range(const part::PartAttribute& attribute, int32_t component,
                                          const Item& item) const {
    const size_t stride = static_cast<size_t>(attribute.components);
    const float* v = attribute.corner_values.data() +
                     3 * static_cast<size_t>(item.triangle) * stride + component;
    return linear(item, {v[0], v[stride], v[2 * stride]});
}

Range<float> BoundsBatch::input_range(const Item& item, const openfab_arg& arg) const {
    return attribute_range(base_.mesh().inputs[arg.a], arg.b, item);
}

Range<float> BoundsBatch::gradient_range(const Item& item, const openfab_arg& arg) const {
    const int32_t component = arg.b / 2, to = arg.b % 2 + 1;
    const bool of_input =
        arg.kind == OPENFAB_ARG_SURFACE_IN_GRAD_LO || arg.kind == OPENFAB_ARG_SURFACE_IN_GRAD_HI;
    Range<float> out{kInf, -kInf};
    for (int32_t i = 0; i < item.evaluators; ++i) {
        const int32_t t = item.evaluator[i];
        const int32_t n = base_.lattice_factor(t);
        float step = 0;
        if (of_input) {
            const part::PartAttribute& input = base_.mesh().inputs[arg.a];
            if (input.scalar == OPENFAB_FLOAT) {
                const size_t stride = static_cast<size_t>(input.components);
                const float* v =
                    input.corner_values.data() + 3 * static_cast<size_t>(t) * stride + component;
                step = lattice_gradient(v[0], v[static_cast<size_t>(to) * stride], n);
            }
        } else if (arg.a == OPENFAB_SURFACE_P) {
            step = static_cast<float>(
                (base_.position(3 * t + to)[component] - base_.position(3 * t)[component]) / n);
        } else if (arg.a == OPENFAB_SURFACE_N) {
            const Vec3f ng = base_.frame(t).ng;
            step = lattice_gradient(base_.normal(3 * t, ng)[component],
                                    base_.normal(3 * t + to, ng)[component], n);
        } else if (arg.a == OPENFAB_SURFACE_UV) {
            const float* uv =
                base_.mesh().corner_uv.data() + 6 * static_cast<size_t>(t) + component;
            step = lattice_gradient(uv[0], uv[2 * to], n);
        }
        out.add({step, step});
    }
    return out;
}

Range<float> BoundsBatch::frame_range(const Item& item, const openfab_arg& arg) const {
    Range<float> out{kInf, -kInf};
    for (int32_t i = 0; i < item.evaluators; ++i) {
        const TangentFrame frame = base_.frame(item.evaluator[i]);
        const Vec3f& v = arg.a == OPENFAB_SURFACE_NG     ? frame.ng
                         : arg.a == OPENFAB_SURFACE_DPDU ? frame.dpdu
                                                         : frame.dpdv;
        out.add({v[arg.b], v[arg.b]});
    }
    return out;
}

Range<float> BoundsBatch::float_argument(size_t i, const openfab_arg& arg) const {
    const Item& item = items_[i];
    switch (arg.kind) {
        case OPENFAB_ARG_SURFACE_IN_LO:
        case OPENFAB_ARG_SURFACE_IN_HI:
            return input_range(item, arg);
        case OPENFAB_ARG_SURFACE_ATTR_LO:
        case OPENFAB_ARG_SURFACE_ATTR_HI:
            break;
        default:
            return gradient_range(item, arg);
    }
    if (arg.a == OPENFAB_SURFACE_P) return position_range(item, arg.b);
    if (arg.a == OPENFAB_SURFACE_N) return normals_[i][static_cast<size_t>(arg.b)];
    if (arg.a != OPENFAB_SURFACE_UV) return frame_range(item, arg);
    const float* uv =
        base_.mesh().corner_uv.data() + 6 * static_cast<size_t>(item.triangle) + arg.b;
    return linear(item, {uv[0], uv[2], uv[4]});
}

/// Fills a float input; where the kernel reads both ends of its range, those.
void BoundsBatch::fill_floats(size_t i) {
    const openfab_arg& arg = kernel_.args[i];
    const bool high = is_high(arg.kind);
    float* other = high_of_[i] >= 0 ? floats_[static_cast<size_t>(high_of_[i])].data() : nullptr;
    for (size_t k = 0; k < items_.size(); ++k) {
        const Range<float> range = float_argument(k, arg);
        floats_[i][k] = high ? range.hi : range.lo;
        if (other != nullptr) other[k] = range.hi;
    }
}

abi::KernelStatus BoundsBatch::evaluate() {
    const size_t n = items_.size(), room = (n + 63) & ~size_t{63};
    if (n == 0) return {};
    bool normals = false;
    for (size_t i = 0; i < batched_.size(); ++i) {
        if (batched_[i] == 0) continue;
        const openfab_arg& arg = kernel_.args[i];
        const bool floats = arg.scalar == OPENFAB_FLOAT;
        if (floats) {
            floats_[i].resize(room);
        } else {
            ints_[i].resize(room);
        }
        const void* data = floats ? static_cast<const void*>(floats_[i].data()) : ints_[i].data();
        buffers_[i].set_dense(abi::halide_type(arg.scalar), data, {static_cast<int32_t>(n)});
        normals |=
            (arg.kind == OPENFAB_ARG_SURFACE_ATTR_LO || arg.kind == OPENFAB_ARG_SURFACE_ATTR_HI) &&
            arg.a == OPENFAB_SURFACE_N;
    }
    normals_.clear();
    for (size_t k = 0; k < n && normals; ++k)
        normals_.push_back(normal_ranges(items_[k]));
    for (size_t i = 0; i < batched_.size(); ++i) {
        const openfab_arg& arg = kernel_.args[i];
        if (batched_[i] == 0 || !is_input(arg.kind)) continue;
        if (arg.scalar != OPENFAB_FLOAT) {
            const part::PartAttribute& input = base_.mesh().inputs[arg.a];
            for (size_t k = 0; k < n; ++k) {
                ints_[i][k] = std::bit_cast<int32_t>(input.face_values[static_cast<size_t>(
                    items_[k].triangle * input.components + arg.b)]);
            }
        } else if (std::ranges::find(high_of_, static_cast<int32_t>(i)) == high_of_.end()) {
            fill_floats(i);
        }
    }
    return call_.run();
}

/// The kernel's intervals, cut to the user's bound: a displacement that is too long is scaled to it.
/// Returns the ranges of a displacement. If an interval is known, all displacements are finite.
std::array<Range<float>, 3> BoundsBatch::displacement(int32_t i) const {
    const float bound = part_.max_displacement_mm;
    std::array<Range<float>, 3> all;
    double length2 = 0;
    bool known = true;
    for (size_t a = 0; a < 3; ++a) {
        const auto [lo, hi] = displacement_argument_[a];
        all[a] = {lo < 0 ? 0.0f : floats_[lo][i], hi < 0 ? 0.0f : floats_[hi][i]};
        known = known && all[a].lo <= all[a].hi && all[a].lo > -kInf && all[a].hi < kInf;
        const double most = std::max(std::fabs(static_cast<double>(all[a].lo)),
                                     std::fabs(static_cast<double>(all[a].hi)));
        length2 += most * most;
    }
    if (!known) {
        all.fill({-bound, bound});
        return all;
    }
    const double length = std::sqrt(length2);
    if (!(length > bound * (1 - 0x1p-20))) return all;
    // A scaled displacement keeps at least this share, less kShrink (bound_displacement.h) and
    // rounding; none if the share or the length may be outside the range of floats.
    const double share = bound / length;
    const double kept = share > 0x1p-100 && length < 0x1p120 ? share * (1 - 0x1p-19) : 0;
    for (Range<float>& out : all) {
        out.lo = std::min(out.lo, below(static_cast<float>(out.lo * kept)));
        out.hi = std::max(out.hi, above(static_cast<float>(out.hi * kept)));
        out.lo = std::max(out.lo, -above(bound * (1 + 0x1p-20f)));
        out.hi = std::min(out.hi, above(bound * (1 + 0x1p-20f)));
    }
    return all;
}

bool BoundsBatch::is_zero(int32_t i) const {
    return std::ranges::all_of(displacement(i),
                               [](const Range<float>& d) { return d.lo == 0 && d.hi == 0; });
}

Box3f BoundsBatch::box(int32_t i) const {
    Box3f out;
    const std::array<Range<float>, 3> d = displacement(i);
    for (int32_t axis = 0; axis < 3; ++axis) {
        const Range<float> p = position_range(items_[i], axis);
        // Rounding is monotone, so the rounded sums bound the rounded sums.
        out.lo[axis] = p.lo + d[axis].lo;
        out.hi[axis] = p.hi + d[axis].hi;
    }
    return out;
}

Range<float> BoundsBatch::float_range(size_t k, int32_t i) const {
    const NearestComponent& from = nearest_.floats[k];
    const Item& item = items_[i];
    if (from.from == NearestComponent::From::kSurfaceOutput) {
        const auto [lo, hi] =
            output_argument_[static_cast<size_t>(from.index * kMaxComponents + from.component)];
        if (lo < 0 || hi < 0) return {-kInf, kInf};
        const Range<float> range{floats_[lo][i], floats_[hi][i]};
        return range.lo <= range.hi ? range : Range<float>{-kInf, kInf};
    }
    const auto& attributes = from.from == NearestComponent::From::kMesh
                                 ? base_.mesh().nearest_attributes
                                 : base_.mesh().inputs;
    return attribute_range(attributes[from.index], from.component, item);
}

Range<int32_t> BoundsBatch::int_range(size_t k, int32_t i) const {
    constexpr Range<int32_t> kAny{std::numeric_limits<int32_t>::min(),
                                  std::numeric_limits<int32_t>::max()};
    const NearestComponent& from = nearest_.ints[k];
    if (from.from == NearestComponent::From::kSurfaceOutput) {
        const auto [lo, hi] =
            output_argument_[static_cast<size_t>(from.index * kMaxComponents + from.component)];
        if (lo < 0 || hi < 0) return kAny;
        const Range<int32_t> range{ints_[lo][i], ints_[hi][i]};
        return range.lo <= range.hi ? range : kAny;
    }
    const auto& attributes = from.from == NearestComponent::From::kMesh
                                 ? base_.mesh().nearest_attributes
                                 : base_.mesh().inputs;
    const part::PartAttribute& attribute = attributes[from.index];
    const int32_t value = std::bit_cast<int32_t>(attribute.face_values[static_cast<size_t>(
        items_[i].triangle * attribute.components + from.component)]);
    return {value, value};
}

}  // namespace openfab::surface
