// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/surface/hand_fablet.h"

#include <HalideRuntime.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>

namespace openfab::testing {

namespace {

struct Hand {
    int32_t mode;
    float amplitude, bound;
    float u, v;
    int32_t face;
    Vec3f p, n, ng;
    float u_grad[2], v_grad[2];
};

struct HandOut {
    Vec3f position;
    int32_t status = 0;
    float height = 0;
    int32_t zone = 0;
};

/// 0 at integers, 1 midway between them.
float wave(float x) {
    const float f = x - std::floor(x);
    return 4 * f * (1 - f);
}

float thickness(const Hand& in) {
    switch (static_cast<HandMode>(in.mode)) {
        case HandMode::kBack:
            return in.face == 1 ? in.amplitude * wave(3 * in.u) * wave(2 * in.v) : 0;
        case HandMode::kRelief:
            if (in.face != 1) return 0;
            return in.amplitude * (0.6f * wave(1.1f * in.u + 0.2f) * wave(1.3f * in.v) +
                                   0.25f * wave(7.3f * in.u + 2 * in.v) * wave(9.1f * in.v) +
                                   0.1f * wave(37 * in.u) * wave(31 * in.v + 3 * in.u) +
                                   0.05f * wave(199 * in.u) * wave(143 * in.v));
        case HandMode::kBumps:
            return in.amplitude *
                   (wave(0.7f * in.p.x) + wave(0.9f * in.p.y + 0.3f) * wave(1.1f * in.p.z) - 1);
        case HandMode::kFootprint: {
            const float width = std::fabs(in.u_grad[0]) + std::fabs(in.v_grad[1]);
            return in.amplitude * (std::min(width * 4, 0.5f) + in.ng.y);
        }
        case HandMode::kStill:
            return 0;
        case HandMode::kOffset:
            return in.amplitude;
        case HandMode::kSteps:
            return in.amplitude * static_cast<float>(1 + in.face % 3) / 3;
        case HandMode::kDents:
            return in.amplitude * wave(0.12f * in.p.x + 0.45f) * wave(0.11f * in.p.y + 0.5f) *
                   wave(0.13f * in.p.z + 0.5f);
        case HandMode::kBroken:
            if (in.u > 0.75f) return std::numeric_limits<float>::quiet_NaN();
            if (in.u < 0.25f) return std::numeric_limits<float>::infinity();
            return in.amplitude * wave(5 * in.v);
    }
    return 0;
}

HandOut evaluate(const Hand& in) {
    HandOut out;
    out.height = thickness(in);
    Vec3f d = in.n * out.height;
    if (!(std::isfinite(d.x) && std::isfinite(d.y) && std::isfinite(d.z))) {
        d = {0, 0, 0};
        out.height = 0;
        out.status = 1;
    }
    const float length = std::sqrt((d.x * d.x + d.y * d.y) + d.z * d.z);
    if (length > in.bound) {
        d = d * (in.bound / length);
        out.status = 2;
    }
    out.position = in.p + d;
    out.zone = static_cast<int32_t>(std::floor(8 * in.u)) + in.face * 100;
    return out;
}

// The order of arguments, one line for each.
enum : int32_t {
    kMode,
    kAmplitude,
    kBound,
    kU,
    kV,
    kFace,
    kP,
    kN = kP + 3,
    kNg = kN + 3,
    kGrad = kNg + 3,
    kPosition = kGrad + 4,
    kStatus = kPosition + 3,
    kHeight,
    kZone,
    kArgCount
};

const std::vector<openfab_arg>& surface_args() {
    static const std::vector<openfab_arg> args = [] {
        std::vector<openfab_arg> a(kArgCount);
        a[kMode] = {OPENFAB_ARG_UNIFORM, OPENFAB_INT, 0, 0};
        a[kAmplitude] = {OPENFAB_ARG_UNIFORM, OPENFAB_FLOAT, 1, 0};
        a[kBound] = {OPENFAB_ARG_FRAME, OPENFAB_FLOAT, OPENFAB_FRAME_MAX_DISPLACEMENT, 0};
        a[kU] = {OPENFAB_ARG_SURFACE_IN, OPENFAB_FLOAT, 0, 0};
        a[kV] = {OPENFAB_ARG_SURFACE_IN, OPENFAB_FLOAT, 0, 1};
        a[kFace] = {OPENFAB_ARG_SURFACE_IN, OPENFAB_INT, 1, 0};
        for (int32_t axis = 0; axis < 3; ++axis) {
            const size_t i = static_cast<size_t>(axis);
            a[kP + i] = {OPENFAB_ARG_SURFACE_ATTR, OPENFAB_FLOAT, OPENFAB_SURFACE_P, axis};
            a[kN + i] = {OPENFAB_ARG_SURFACE_ATTR, OPENFAB_FLOAT, OPENFAB_SURFACE_N, axis};
            a[kNg + i] = {OPENFAB_ARG_SURFACE_ATTR, OPENFAB_FLOAT, OPENFAB_SURFACE_NG, axis};
            a[kPosition + i] = {OPENFAB_ARG_POSITION, OPENFAB_FLOAT, 0, axis};
        }
        for (int32_t b = 0; b < 4; ++b) {
            a[static_cast<size_t>(kGrad + b)] = {OPENFAB_ARG_SURFACE_IN_GRAD, OPENFAB_FLOAT, 0, b};
        }
        a[kStatus] = {OPENFAB_ARG_SURFACE_STATUS, OPENFAB_INT, 0, 0};
        a[kHeight] = {OPENFAB_ARG_SURFACE_OUT, OPENFAB_FLOAT, 2, 0};
        a[kZone] = {OPENFAB_ARG_SURFACE_OUT, OPENFAB_INT, 3, 0};
        return a;
    }();
    return args;
}

template <typename T>
T* data(void** args, int32_t i) {
    return reinterpret_cast<T*>(static_cast<halide_buffer_t*>(args[i])->host);
}
template <typename T>
T scalar(void** args, int32_t i) {
    return *static_cast<const T*>(args[i]);
}

template <bool computed>
int surface_kernel(void** args) {
    const int32_t n = static_cast<halide_buffer_t*>(args[kU])->dim[0].extent;
    Hand in;
    in.mode = scalar<int32_t>(args, kMode);
    in.amplitude = scalar<float>(args, kAmplitude);
    in.bound = scalar<float>(args, kBound);
    for (int32_t i = 0; i < n; ++i) {
        in.u = data<float>(args, kU)[i], in.v = data<float>(args, kV)[i];
        in.face = data<int32_t>(args, kFace)[i];
        for (int axis = 0; axis < 3; ++axis) {
            in.p[axis] = data<float>(args, kP + axis)[i];
            in.n[axis] = data<float>(args, kN + axis)[i];
            in.ng[axis] = data<float>(args, kNg + axis)[i];
        }
        for (int32_t b = 0; b < 2; ++b) {
            in.u_grad[b] = data<float>(args, kGrad + b)[i];
            in.v_grad[b] = data<float>(args, kGrad + 2 + b)[i];
        }
        const HandOut out = evaluate(in);
        for (int axis = 0; axis < 3; ++axis)
            data<float>(args, kPosition + axis)[i] = out.position[axis];
        data<int32_t>(args, kStatus)[i] = out.status;
        if (!computed) continue;
        data<float>(args, kHeight)[i] = out.height;
        data<int32_t>(args, kZone)[i] = out.zone;
    }
    return 0;
}

// surface_bounds: scalars, then pairs lo, hi.
enum : int32_t {
    kBU = 3,
    kBFace = kBU + 4,
    kBN = kBFace + 2,
    kBNg = kBN + 6,     // y alone
    kBGrad = kBNg + 2,  // u along the first axis, v along the second
    kBD = kBGrad + 4,
    kBHeight = kBD + 6,
    kBZone = kBHeight + 2,
    kBCount = kBZone + 2
};

const std::vector<openfab_arg>& bounds_args() {
    static const std::vector<openfab_arg> args = [] {
        std::vector<openfab_arg> a(kBCount);
        for (size_t i = 0; i < 3; ++i)
            a[i] = surface_args()[i];
        a[kBU] = {OPENFAB_ARG_SURFACE_IN_LO, OPENFAB_FLOAT, 0, 0};
        a[kBU + 1] = {OPENFAB_ARG_SURFACE_IN_HI, OPENFAB_FLOAT, 0, 0};
        a[kBU + 2] = {OPENFAB_ARG_SURFACE_IN_LO, OPENFAB_FLOAT, 0, 1};
        a[kBU + 3] = {OPENFAB_ARG_SURFACE_IN_HI, OPENFAB_FLOAT, 0, 1};
        a[kBFace] = {OPENFAB_ARG_SURFACE_IN_LO, OPENFAB_INT, 1, 0};
        a[kBFace + 1] = {OPENFAB_ARG_SURFACE_IN_HI, OPENFAB_INT, 1, 0};
        for (int32_t axis = 0; axis < 3; ++axis) {
            const size_t i = static_cast<size_t>(2 * axis);
            a[kBN + i] = {OPENFAB_ARG_SURFACE_ATTR_LO, OPENFAB_FLOAT, OPENFAB_SURFACE_N, axis};
            a[kBN + i + 1] = {OPENFAB_ARG_SURFACE_ATTR_HI, OPENFAB_FLOAT, OPENFAB_SURFACE_N, axis};
            a[kBD + i] = {OPENFAB_ARG_DISPLACEMENT_LO, OPENFAB_FLOAT, 0, axis};
            a[kBD + i + 1] = {OPENFAB_ARG_DISPLACEMENT_HI, OPENFAB_FLOAT, 0, axis};
        }
        a[kBNg] = {OPENFAB_ARG_SURFACE_ATTR_LO, OPENFAB_FLOAT, OPENFAB_SURFACE_NG, 1};
        a[kBNg + 1] = {OPENFAB_ARG_SURFACE_ATTR_HI, OPENFAB_FLOAT, OPENFAB_SURFACE_NG, 1};
        for (int32_t i = 0; i < 2; ++i) {
            const size_t at = static_cast<size_t>(kBGrad + 2 * i);
            a[at] = {OPENFAB_ARG_SURFACE_IN_GRAD_LO, OPENFAB_FLOAT, 0, 3 * i};
            a[at + 1] = {OPENFAB_ARG_SURFACE_IN_GRAD_HI, OPENFAB_FLOAT, 0, 3 * i};
        }
        a[kBHeight] = {OPENFAB_ARG_SURFACE_OUT_LO, OPENFAB_FLOAT, 2, 0};
        a[kBHeight + 1] = {OPENFAB_ARG_SURFACE_OUT_HI, OPENFAB_FLOAT, 2, 0};
        a[kBZone] = {OPENFAB_ARG_SURFACE_OUT_LO, OPENFAB_INT, 3, 0};
        a[kBZone + 1] = {OPENFAB_ARG_SURFACE_OUT_HI, OPENFAB_INT, 3, 0};
        return a;
    }();
    return args;
}

/// As tight as the arguments allow, to detect a gradient or normal that is missing from their
/// ranges.
void footprint_range(void** args, int32_t i, float amplitude, float* lo, float* hi) {
    float least = 0, most = 0;
    for (int32_t g = kBGrad; g < kBD; g += 2) {
        const float a = data<float>(args, g)[i], b = data<float>(args, g + 1)[i];
        least += a <= 0 && b >= 0 ? 0 : std::min(std::fabs(a), std::fabs(b));
        most += std::max(std::fabs(a), std::fabs(b));
    }
    const float slack = amplitude * 1e-6f;
    const float y0 = data<float>(args, kBNg)[i], y1 = data<float>(args, kBNg + 1)[i];
    *lo = amplitude * (std::min(least * 4, 0.5f) + y0) - slack;
    *hi = amplitude * (std::min(most * 4, 0.5f) + y1) + slack;
}

/// wave over [a, b].
void wave_range(float a, float b, float* lo, float* hi) {
    *lo = std::min(wave(a), wave(b));
    *hi = std::max(wave(a), wave(b));
    if (std::floor(a) != std::floor(b)) *lo = 0;
    if (std::floor(a + 0.5f) != std::floor(b + 0.5f)) *hi = 1;
}

void relief_range(void** args, int32_t i, float amplitude, float* lo, float* hi) {
    const float u0 = data<float>(args, kBU)[i], u1 = data<float>(args, kBU + 1)[i];
    const float v0 = data<float>(args, kBU + 2)[i], v1 = data<float>(args, kBU + 3)[i];
    const float terms[4][6] = {{0.6f, 1.1f, 0, 0.2f, 0, 1.3f},
                               {0.25f, 7.3f, 2, 0, 0, 9.1f},
                               {0.1f, 37, 0, 0, 3, 31},
                               {0.05f, 199, 0, 0, 0, 143}};
    *lo = *hi = 0;
    for (const auto& t : terms) {
        float a0, a1, b0, b1;
        wave_range(t[1] * u0 + t[2] * v0 + t[3], t[1] * u1 + t[2] * v1 + t[3], &a0, &a1);
        wave_range(t[4] * u0 + t[5] * v0, t[4] * u1 + t[5] * v1, &b0, &b1);
        *lo += t[0] * a0 * b0;
        *hi += t[0] * a1 * b1;
    }
    *lo = amplitude * *lo - 1e-5f;
    *hi = amplitude * *hi + 1e-5f;
}

template <bool computed>
int bounds_kernel(void** args) {
    const int32_t n = static_cast<halide_buffer_t*>(args[kBU])->dim[0].extent;
    const HandMode mode = static_cast<HandMode>(scalar<int32_t>(args, kMode));
    const float amplitude = scalar<float>(args, kAmplitude);
    for (int32_t i = 0; i < n; ++i) {
        const int32_t face = data<int32_t>(args, kBFace)[i];
        float lo = 0, hi = 0;
        if (mode == HandMode::kBack && face == 1) hi = amplitude;
        if (mode == HandMode::kRelief && face == 1) relief_range(args, i, amplitude, &lo, &hi);
        if (mode == HandMode::kBumps || mode == HandMode::kStill) lo = -amplitude, hi = amplitude;
        if (mode >= HandMode::kOffset)
            lo = std::min(amplitude, 0.0f), hi = std::max(amplitude, 0.0f);
        if (mode == HandMode::kFootprint) footprint_range(args, i, amplitude, &lo, &hi);
        if (mode == HandMode::kBroken) hi = std::numeric_limits<float>::infinity();
        for (int32_t axis = 0; axis < 3; ++axis) {
            const float n0 = data<float>(args, kBN + 2 * axis)[i],
                        n1 = data<float>(args, kBN + 2 * axis + 1)[i];
            const float d[4] = {n0 * lo, n0 * hi, n1 * lo, n1 * hi};
            data<float>(args, kBD + 2 * axis)[i] = *std::min_element(d, d + 4);
            data<float>(args, kBD + 2 * axis + 1)[i] = *std::max_element(d, d + 4);
        }
        if (!computed) continue;
        data<float>(args, kBHeight)[i] = lo;
        data<float>(args, kBHeight + 1)[i] = hi;
        const float u0 = data<float>(args, kBU)[i], u1 = data<float>(args, kBU + 1)[i];
        data<int32_t>(args, kBZone)[i] = static_cast<int32_t>(std::floor(8 * u0)) + face * 100;
        data<int32_t>(args, kBZone + 1)[i] = static_cast<int32_t>(std::floor(8 * u1)) + face * 100;
    }
    return 0;
}

int unknown_bounds_kernel(void** args) {
    const int32_t n = static_cast<halide_buffer_t*>(args[kBU])->dim[0].extent;
    for (int32_t a = kBD; a < kBHeight + 2; ++a) {
        std::fill_n(data<float>(args, a), n, std::numeric_limits<float>::quiet_NaN());
    }
    std::fill_n(data<int32_t>(args, kBZone), n, 1);
    std::fill_n(data<int32_t>(args, kBZone + 1), n, 0);
    return 0;
}

openfab_fablet make_fablet(bool computed, openfab_kernel_fn bounds) {
    static const openfab_uniform uniforms[] = {
        {"mode", "int", OPENFAB_UNIFORM_VALUE, OPENFAB_INT, 1, 1, 0, nullptr},
        {"amplitude", "float", OPENFAB_UNIFORM_VALUE, OPENFAB_FLOAT, 1, 1, 1, nullptr}};
    static const openfab_varying inputs[] = {{"uv", "float2", OPENFAB_FLOAT, 2, -1, nullptr},
                                             {"face", "int", OPENFAB_INT, 1, -1, nullptr}};
    static const openfab_varying outputs[] = {{"uvOut", "float2", OPENFAB_FLOAT, 2, 0, nullptr},
                                              {"faceOut", "int", OPENFAB_INT, 1, 1, nullptr},
                                              {"height", "float", OPENFAB_FLOAT, 1, -1, nullptr},
                                              {"zone", "int", OPENFAB_INT, 1, -1, nullptr}};
    static const openfab_varying nearest[] = {{"uv", "float2", OPENFAB_FLOAT, 2, 0, nullptr},
                                              {"face", "int", OPENFAB_INT, 1, 1, nullptr},
                                              {"height", "float", OPENFAB_FLOAT, 1, 2, nullptr},
                                              {"zone", "int", OPENFAB_INT, 1, 3, nullptr}};
    openfab_fablet f{};
    f.abi_version = OPENFAB_ABI_VERSION;
    f.name = "Hand";
    f.source_name = "hand.fl";
    f.uniform_count = 2, f.uniforms = uniforms, f.uniform_value_count = 2;
    f.void_slot = -1;
    f.has_surface = 1;
    f.surface_input_count = 2, f.surface_inputs = inputs;
    f.surface_output_count = computed ? 4 : 2, f.surface_outputs = outputs;
    f.nearest_count = computed ? 4 : 2, f.nearest = nearest;
    f.surface = {{computed ? surface_kernel<true> : surface_kernel<false>, nullptr},
                 computed ? kArgCount : kHeight,
                 surface_args().data()};
    f.surface_bounds = {{bounds, nullptr}, computed ? kBCount : kBHeight, bounds_args().data()};
    return f;
}

}  // namespace

const openfab_fablet& hand_fablet(bool computed) {
    static const openfab_fablet with = make_fablet(true, bounds_kernel<true>),
                                without = make_fablet(false, bounds_kernel<false>);
    return computed ? with : without;
}

const openfab_fablet& hand_fablet_unbounded() {
    static const openfab_fablet fablet = make_fablet(true, unknown_bounds_kernel);
    return fablet;
}

std::vector<uint32_t> hand_uniforms(HandMode mode, float amplitude_mm) {
    return {static_cast<uint32_t>(mode), std::bit_cast<uint32_t>(amplitude_mm)};
}

reference::EvaluateMicro hand_evaluate(const part::Part& part) {
    return [&part](const reference::MicroInputs& in) {
        Hand hand;
        hand.mode = static_cast<int32_t>(part.uniform_values[0]);
        hand.amplitude = std::bit_cast<float>(part.uniform_values[1]);
        hand.bound = part.max_displacement_mm;
        hand.u = in.floats[0][0], hand.v = in.floats[0][1];
        hand.face = static_cast<int32_t>(in.flats[1][0]);
        hand.p = in.p, hand.n = in.n, hand.ng = in.ng;
        for (size_t step = 0; step < 2; ++step) {
            hand.u_grad[step] = in.gradients[0][0][step];
            hand.v_grad[step] = in.gradients[0][1][step];
        }
        const HandOut out = evaluate(hand);
        return reference::MicroOutputs{
            out.position,
            {{}, {}, {std::bit_cast<uint32_t>(out.height)}, {static_cast<uint32_t>(out.zone)}}};
    };
}

std::vector<uint8_t> hand_identities(const part::Part& part, bool infer_identity) {
    const size_t triangles = part.mesh->triangles.size();
    std::vector<uint8_t> out(triangles, part.fablet->has_surface == 0 ? 1 : 0);
    const bool possible =
        part.fablet->surface_output_count == 2 && infer_identity && part.fablet->has_surface != 0;
    if (!possible || (part.uniform_values[0] != static_cast<uint32_t>(HandMode::kBack) &&
                      part.uniform_values[0] != static_cast<uint32_t>(HandMode::kRelief)))
        return out;
    for (size_t t = 0; t < triangles; ++t)
        out[t] = part.mesh->inputs[1].face_values[t] != 1;
    return out;
}

std::vector<std::array<Vec3f, 3>> triangles_of(const surface::Surface& surface,
                                               surface::PatchUse use) {
    std::vector<std::array<Vec3f, 3>> out;
    for (size_t p = 0; p < surface.patches().size(); ++p) {
        if ((surface.patches()[p].use & use) == 0) continue;
        const auto mesh = surface.micro(static_cast<int32_t>(p));
        for (const auto& t : mesh->triangles) {
            out.push_back({mesh->positions[t[0]], mesh->positions[t[1]], mesh->positions[t[2]]});
        }
    }
    return out;
}

std::vector<std::array<Vec3d, 3>> covering_triangles(const part::Part& part,
                                                     const surface::Surface& surface) {
    std::vector<std::array<Vec3d, 3>> out;
    if (surface.identity()) {
        for (const auto& t : part.mesh->triangles) {
            out.push_back({part.mesh->positions[t[0]], part.mesh->positions[t[1]],
                           part.mesh->positions[t[2]]});
        }
        return out;
    }
    for (const auto& t : triangles_of(surface, surface::kForCoverage)) {
        out.push_back({vec_cast<double>(t[0]), vec_cast<double>(t[1]), vec_cast<double>(t[2])});
    }
    return out;
}

std::vector<std::array<Vec3f, 3>> triangles_of(const std::vector<reference::DicedTriangle>& diced,
                                               surface::PatchUse use) {
    std::vector<std::array<Vec3f, 3>> out;
    for (const reference::DicedTriangle& t : diced) {
        if (use == surface::kForQuery ? t.query : t.coverage) out.push_back(t.positions);
    }
    return out;
}

int64_t open_edges(const std::vector<std::array<Vec3f, 3>>& triangles) {
    using Key = std::array<uint32_t, 3>;
    const auto key = [](const Vec3f& p) {
        return Key{std::bit_cast<uint32_t>(p.x), std::bit_cast<uint32_t>(p.y),
                   std::bit_cast<uint32_t>(p.z)};
    };
    std::map<std::pair<Key, Key>, int64_t> balance;
    for (const auto& t : triangles) {
        for (size_t e = 0; e < 3; ++e) {
            const Key a = key(t[e]), b = key(t[(e + 1) % 3]);
            balance[std::minmax(a, b)] += a < b ? 1 : -1;
        }
    }
    int64_t open = 0;
    for (const auto& [edge, sum] : balance)
        open += std::abs(sum);
    return open;
}

}  // namespace openfab::testing
