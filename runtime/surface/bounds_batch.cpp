// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/bounds_batch.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/check.h"

namespace openfab::surface {

namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
// Interpolating in float takes seven roundings of values up to twice the largest corner: less than
// 2^-20 of it. Twice that.
constexpr float kFloatSlack = 0x1p-19f;

float below(float x) {
    return std::nextafter(x, -kInf);
}
float above(float x) {
    return std::nextafter(x, kInf);
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
    return kind >= OPENFAB_ARG_SURFACE_IN_LO && kind <= OPENFAB_ARG_SURFACE_ATTR_GRAD_HI;
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

Range<float> BoundsBatch::normal_range(const Item& item, int32_t axis) const {
    const Vec3f ng = base_.frame(item.triangle).ng;
    std::array<Vec3f, 3> n;
    for (int32_t c = 0; c < 3; ++c)
        n[c] = base_.normal(3 * item.triangle + c, ng);
    if (n[0] == n[1] && n[0] == n[2]) {
        const float v = unit_normal(n[0], ng)[axis];
        return {v, v};
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
    Range<float> out{-1.0f, 1.0f};
    if (least > 1e-3) {
        const double lo = l[axis].lo, hi = l[axis].hi;
        const double from = lo < 0 ? lo / least : lo / greatest,
                     to = hi < 0 ? hi / greatest : hi / least;
        out.lo = std::max(out.lo, static_cast<float>(from - kFloatSlack));
        out.hi = std::min(out.hi, static_cast<float>(to + kFloatSlack));
    }
    // A unit vector in float may exceed 1 by its rounding; where normals cancel the geometric one
    // stands in.
    out.lo -= kFloatSlack, out.hi += kFloatSlack;
    if (!(least > 1e-3)) out.add({ng[axis], ng[axis]});
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

Range<float> BoundsBatch::float_argument(const Item& item, const openfab_arg& arg) const {
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
    if (arg.a == OPENFAB_SURFACE_N) return normal_range(item, arg.b);
    if (arg.a != OPENFAB_SURFACE_UV) return frame_range(item, arg);
    const float* uv =
        base_.mesh().corner_uv.data() + 6 * static_cast<size_t>(item.triangle) + arg.b;
    return linear(item, {uv[0], uv[2], uv[4]});
}

abi::KernelStatus BoundsBatch::evaluate() {
    const size_t n = items_.size();
    if (n == 0) return {};
    for (size_t i = 0; i < batched_.size(); ++i) {
        if (batched_[i] == 0) continue;
        const openfab_arg& arg = kernel_.args[i];
        const bool high = is_high(arg.kind);
        const void* data = nullptr;
        if (arg.scalar == OPENFAB_FLOAT) {
            floats_[i].resize((n + 63) & ~size_t{63});
            data = floats_[i].data();
            for (size_t k = 0; k < n && is_input(arg.kind); ++k) {
                const Range<float> range = float_argument(items_[k], arg);
                floats_[i][k] = high ? range.hi : range.lo;
            }
        } else {
            ints_[i].resize((n + 63) & ~size_t{63});
            data = ints_[i].data();
            for (size_t k = 0; k < n && is_input(arg.kind); ++k) {
                const part::PartAttribute& input = base_.mesh().inputs[arg.a];
                ints_[i][k] = std::bit_cast<int32_t>(input.face_values[static_cast<size_t>(
                    items_[k].triangle * input.components + arg.b)]);
            }
        }
        buffers_[i].set_dense(abi::halide_type(arg.scalar), data, {static_cast<int32_t>(n)});
    }
    return call_.run();
}

/// The kernel's interval, cut to the user's bound: a displacement that is too long is scaled to it.
/// Returns the range of a displacement. If an interval is known, all displacements are finite.
Range<float> BoundsBatch::displacement(int32_t i, int32_t axis) const {
    const float bound = part_.max_displacement_mm;
    Range<float> all[3];
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
    if (!known) return {-bound, bound};
    Range<float> out = all[axis];
    const double length = std::sqrt(length2);
    if (length > bound * (1 - 0x1p-20)) {
        // A scaled displacement keeps at least this share, less kShrink (bound_displacement.h) and
        // rounding; none if the share or the length may be outside the range of floats.
        const double share = bound / length;
        const double kept = share > 0x1p-100 && length < 0x1p120 ? share * (1 - 0x1p-19) : 0;
        out.lo = std::min(out.lo, below(static_cast<float>(out.lo * kept)));
        out.hi = std::max(out.hi, above(static_cast<float>(out.hi * kept)));
        out.lo = std::max(out.lo, -above(bound * (1 + 0x1p-20f)));
        out.hi = std::min(out.hi, above(bound * (1 + 0x1p-20f)));
    }
    return out;
}

bool BoundsBatch::is_zero(int32_t i) const {
    for (int32_t axis = 0; axis < 3; ++axis) {
        const Range<float> d = displacement(i, axis);
        if (!(d.lo == 0 && d.hi == 0)) return false;
    }
    return true;
}

Box3f BoundsBatch::box(int32_t i) const {
    Box3f out;
    for (int32_t axis = 0; axis < 3; ++axis) {
        const Range<float> p = position_range(items_[i], axis);
        const Range<float> d = displacement(i, axis);
        // Rounding is monotone, so the rounded sums bound the rounded sums.
        out.lo[axis] = p.lo + d.lo;
        out.hi[axis] = p.hi + d.hi;
    }
    return out;
}

bool BoundsBatch::is_bounded(int32_t i) const {
    const Box3f b = box(i);
    for (int32_t axis = 0; axis < 3; ++axis) {
        if (!(b.lo[axis] > -kInf && b.hi[axis] < kInf)) return false;
    }
    return true;
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
