// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What the surface stage gets at a micro-vertex, and what becomes of it.

#include <algorithm>
#include <bit>
#include <cmath>

#include "tests/support/reference/plain_dicer.h"

namespace openfab::reference {

Vec3d PlainDicer::undisplaced(int32_t t, const Point& point) const {
    if (point.kind == Point::kCorner) return position(t, point.number);
    Vec3d p;
    for (int axis = 0; axis < 3; ++axis) {
        double lo = 0, hi = 0, v = 0;
        if (point.kind == Point::kSide) {
            const bool rising = up(t, point.number);
            const double from = position(t, rising ? point.number : point.number + 1)[axis];
            const double to = position(t, rising ? point.number + 1 : point.number)[axis];
            v = static_cast<double>(point.i) / factor(t, point.number) * (to - from) + from;
            lo = std::min(from, to), hi = std::max(from, to);
        } else {
            const double v0 = position(t, 0)[axis], v1 = position(t, 1)[axis],
                         v2 = position(t, 2)[axis];
            const double wa = static_cast<double>(point.a) / steps(t),
                         wb = static_cast<double>(point.b) / steps(t);
            v = (wa * (v1 - v0) + wb * (v2 - v0)) + v0;
            lo = std::min({v0, v1, v2}), hi = std::max({v0, v1, v2});
        }
        p[axis] = std::clamp(v, lo, hi);
    }
    return p;
}

float PlainDicer::value(int32_t t, const Point& point, const std::array<float, 3>& v) const {
    if (point.kind == Point::kCorner) return v[point.number];
    if (point.kind == Point::kSide) {
        const bool rising = up(t, point.number);
        const float from = v[static_cast<size_t>(rising ? point.number : (point.number + 1) % 3)];
        const float to = v[static_cast<size_t>(rising ? (point.number + 1) % 3 : point.number)];
        return static_cast<float>(point.i) / static_cast<float>(factor(t, point.number)) *
                   (to - from) +
               from;
    }
    const float n = static_cast<float>(steps(t));
    const float wa = static_cast<float>(point.a) / n, wb = static_cast<float>(point.b) / n;
    return (wa * (v[1] - v[0]) + wb * (v[2] - v[0])) + v[0];
}

std::array<float, 3> PlainDicer::corners_of(const part::PartAttribute& attribute, int32_t t,
                                            int32_t component) const {
    std::array<float, 3> v;
    for (int32_t c = 0; c < 3; ++c) {
        v[c] =
            attribute
                .corner_values[static_cast<size_t>((3 * t + c) * attribute.components + component)];
    }
    return v;
}

/// ng, dpdu and dpdv of triangle t.
void PlainDicer::frame(int32_t t, MicroInputs* in) const {
    const Vec3d e1 = position(t, 1) - position(t, 0), e2 = position(t, 2) - position(t, 0);
    const Vec3d n = cross(e1, e2);
    const double area2 = length(n);
    if (area2 > 0) in->ng = vec_cast<float>(Vec3d{n.x / area2, n.y / area2, n.z / area2});
    if (mesh_.corner_uv.empty()) return;
    const float* uv = &mesh_.corner_uv[static_cast<size_t>(6 * t)];
    const double u1 = static_cast<double>(uv[2]) - uv[0], v1 = static_cast<double>(uv[3]) - uv[1];
    const double u2 = static_cast<double>(uv[4]) - uv[0], v2 = static_cast<double>(uv[5]) - uv[1];
    const double det = u1 * v2 - v1 * u2;
    if (det == 0) return;
    in->dpdu = vec_cast<float>((e1 * v2 - e2 * v1) * (1 / det));
    in->dpdv = vec_cast<float>((e2 * u1 - e1 * u2) * (1 / det));
}

MicroInputs PlainDicer::inputs(int32_t t, const Point& point) const {
    MicroInputs in;
    int32_t evaluator = t;
    if (point.kind == Point::kCorner) evaluator = corner_evaluator(t, point.number);
    if (point.kind == Point::kSide) evaluator = side_evaluator(t, point.number);
    const float n = static_cast<float>(steps(evaluator));
    const auto gradient = [&](const std::array<float, 3>& v) {
        return std::array<float, 2>{(v[1] - v[0]) / n, (v[2] - v[0]) / n};
    };
    MicroInputs own;
    frame(t, &own);
    frame(evaluator, &in);
    const Vec3d p = undisplaced(t, point);
    in.p = {static_cast<float>(p.x) + 0.0f, static_cast<float>(p.y) + 0.0f,
            static_cast<float>(p.z) + 0.0f};
    const auto normal = [&](int32_t triangle, const Vec3f& ng, int axis) {
        if (mesh_.corner_normals.empty()) return std::array<float, 3>{ng[axis], ng[axis], ng[axis]};
        const Vec3f* v = &mesh_.corner_normals[static_cast<size_t>(3 * triangle)];
        return std::array<float, 3>{v[0][axis], v[1][axis], v[2][axis]};
    };
    for (int axis = 0; axis < 3; ++axis) {
        in.n[axis] = value(t, point, normal(t, own.ng, axis));
        in.n_gradient[axis] = gradient(normal(evaluator, in.ng, axis));
        for (int32_t step = 0; step < 2; ++step) {
            const double d = position(evaluator, step + 1)[axis] - position(evaluator, 0)[axis];
            in.p_gradient[axis][step] = static_cast<float>(d / steps(evaluator));
        }
    }
    const float length2 = (in.n.x * in.n.x + in.n.y * in.n.y) + in.n.z * in.n.z;
    if (length2 > 0 && std::isfinite(length2)) {
        const float l = std::sqrt(length2);
        in.n = {in.n.x / l, in.n.y / l, in.n.z / l};
    } else {
        in.n = own.ng;
    }
    for (size_t k = 0; k < 2 && !mesh_.corner_uv.empty(); ++k) {
        const auto uv = [&](int32_t triangle) {
            const float* v = &mesh_.corner_uv[static_cast<size_t>(6 * triangle)];
            return std::array<float, 3>{v[k], v[2 + k], v[4 + k]};
        };
        in.uv[k] = value(t, point, uv(t));
        in.uv_gradient[k] = gradient(uv(evaluator));
    }
    for (const part::PartAttribute& input : mesh_.inputs) {
        in.floats.emplace_back(), in.flats.emplace_back(), in.gradients.emplace_back();
        for (int32_t k = 0; k < input.components; ++k) {
            if (input.scalar == OPENFAB_FLOAT) {
                in.floats.back().push_back(value(t, point, corners_of(input, t, k)));
                in.gradients.back().push_back(gradient(corners_of(input, evaluator, k)));
            } else {
                in.flats.back().push_back(
                    input.face_values[static_cast<size_t>(t * input.components + k)]);
            }
        }
    }
    return in;
}

Vertex PlainDicer::vertex(int32_t t, const Point& point) const {
    Vertex out;
    const MicroInputs in = inputs(t, point);
    MicroOutputs result;
    out.position = in.p;
    if (displaced(t)) {
        result = evaluate_(in);
        const Vec3f p = result.position;
        if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) {
            out.position = {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};
        }
    }
    const openfab_fablet& fablet = *part_.fablet;
    for (int32_t i = 0; i < fablet.nearest_count; ++i) {
        const openfab_varying& nearest = fablet.nearest[i];
        const int32_t copied =
            nearest.source < 0 ? -1 : fablet.surface_outputs[nearest.source].source;
        for (int32_t k = 0; k < nearest.components; ++k) {
            const size_t c = static_cast<size_t>(k);
            const bool is_float = nearest.scalar == OPENFAB_FLOAT;
            uint32_t bits = 0;
            if (nearest.source >= 0 && copied < 0) {
                bits = result.outputs[nearest.source][c];
            } else if (nearest.source >= 0) {
                bits =
                    is_float ? std::bit_cast<uint32_t>(in.floats[copied][c]) : in.flats[copied][c];
            } else {
                const part::PartAttribute& a = mesh_.nearest_attributes[i];
                bits = is_float ? std::bit_cast<uint32_t>(value(t, point, corners_of(a, t, k)))
                                : a.face_values[static_cast<size_t>(t * a.components + k)];
            }
            if (is_float) {
                out.floats.push_back(std::bit_cast<float>(bits));
            } else {
                out.ints.push_back(bits);
            }
        }
    }
    return out;
}

}  // namespace openfab::reference
