// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/prints/test_fablets.h"

#include <HalideRuntime.h>

#include <cmath>
#include <deque>
#include <limits>

namespace openfab::testing {

Weights skin_weights(float distance) {
    if (distance <= kSkin) return {0.25f, 0.6f, 0.15f};
    return {1, 0, 0};
}

Weights picture_weights(float distance, int32_t face, float u) {
    const float share =
        std::floor(u * 8) / 8;  // in steps, so that the last bit of u does not matter
    if (face == 0 && distance <= kSkin) return {1.0f - share, share, 0};
    return {1, 0, 0};
}

namespace {

halide_buffer_t* buffer(void* arg) {
    return static_cast<halide_buffer_t*>(arg);
}

template <typename T>
T& item(void* arg, int32_t i) {
    return reinterpret_cast<T*>(buffer(arg)->host)[i];
}

/// Calls `weights(voxel)` for each voxel of the columns that args[first] lists, where `voxel` is its
/// index in a flat buffer; outputs are args[first + 1..first + 3].
template <typename F>
int each_voxel(void** args, int first, const F& weights) {
    const int32_t columns = buffer(args[first])->dim[0].extent;
    for (int32_t i = 0; i < 8 * columns; ++i) {
        const Weights w = weights(8 * item<int32_t>(args[first], i / 8) + i % 8);
        item<float>(args[first + 1], i) = w.a;
        item<float>(args[first + 2], i) = w.b;
        item<float>(args[first + 3], i) = w.empty;
    }
    return 0;
}

/// Interval outputs args[first..first + 5]: lo and hi of a, b, VOID in turn. Where `known` is
/// false, NaN.
template <typename F>
int each_cube(void** args, int first, const F& known) {
    const int32_t cubes = buffer(args[first])->dim[0].extent;
    for (int32_t i = 0; i < cubes; ++i) {
        Weights w{};
        const bool one = known(i, &w);
        const float nan = std::numeric_limits<float>::quiet_NaN();
        const float values[3] = {one ? w.a : nan, one ? w.b : nan, one ? w.empty : nan};
        for (int s = 0; s < 3; ++s) {
            item<float>(args[first + 2 * s], i) = values[s];
            item<float>(args[first + 2 * s + 1], i) = values[s];
        }
    }
    return 0;
}

constexpr openfab_arg weight(int32_t slot) {
    return {OPENFAB_ARG_WEIGHT, OPENFAB_FLOAT, slot, 0};
}
constexpr openfab_arg lo(int32_t slot) {
    return {OPENFAB_ARG_WEIGHT_LO, OPENFAB_FLOAT, slot, 0};
}
constexpr openfab_arg hi(int32_t slot) {
    return {OPENFAB_ARG_WEIGHT_HI, OPENFAB_FLOAT, slot, 0};
}

constexpr openfab_arg kColumns = {OPENFAB_ARG_GROUPS, OPENFAB_INT, 0, 0};

const openfab_arg kWeights[] = {kColumns, weight(0), weight(1), weight(2)};
const openfab_arg kBounds[] = {lo(0), hi(0), lo(1), hi(1), lo(2), hi(2)};

constexpr Weights kSolid{1, 0, 0}, kTint{3, 7, 0}, kHole{0, 0, 1};

template <Weights const& composition>
int constant_volume(void** args) {
    return each_voxel(args, 0, [](int32_t) { return composition; });
}
template <Weights const& composition>
int constant_bounds(void** args) {
    return each_cube(args, 0, [](int32_t, Weights* w) {
        *w = composition;
        return true;
    });
}

const openfab_arg kSkinArgs[] = {
    {OPENFAB_ARG_DISTANCE, OPENFAB_FLOAT, 0, 0}, kColumns, weight(0), weight(1), weight(2)};
int skin_volume(void** args) {
    return each_voxel(args, 1,
                      [&](int32_t v) { return skin_weights(std::fabs(item<float>(args[0], v))); });
}
const openfab_arg kSkinBoundsArgs[] = {{OPENFAB_ARG_DISTANCE_LO, OPENFAB_FLOAT, 0, 0},
                                       {OPENFAB_ARG_DISTANCE_HI, OPENFAB_FLOAT, 0, 0},
                                       lo(0),
                                       hi(0),
                                       lo(1),
                                       hi(1),
                                       lo(2),
                                       hi(2)};
/// Distances are negative inside, so the nearest to the surface is hi.
bool skin_known(void** args, int32_t i, Weights* w) {
    const float nearest = -item<float>(args[1], i), farthest = -item<float>(args[0], i);
    *w = skin_weights(nearest);
    return nearest > kSkin || farthest <= kSkin;
}
int skin_bounds(void** args) {
    return each_cube(args, 2, [&](int32_t i, Weights* w) { return skin_known(args, i, w); });
}

const openfab_arg kPictureArgs[] = {{OPENFAB_ARG_DISTANCE, OPENFAB_FLOAT, 0, 0},
                                    {OPENFAB_ARG_NEAREST, OPENFAB_FLOAT, 0, 0},
                                    {OPENFAB_ARG_NEAREST, OPENFAB_INT, 1, 0},
                                    kColumns,
                                    weight(0),
                                    weight(1),
                                    weight(2)};
int picture_volume(void** args) {
    return each_voxel(args, 3, [&](int32_t v) {
        return picture_weights(std::fabs(item<float>(args[0], v)), item<int32_t>(args[2], v),
                               item<float>(args[1], v));
    });
}
const openfab_arg kPictureBoundsArgs[] = {{OPENFAB_ARG_DISTANCE_LO, OPENFAB_FLOAT, 0, 0},
                                          {OPENFAB_ARG_DISTANCE_HI, OPENFAB_FLOAT, 0, 0},
                                          {OPENFAB_ARG_NEAREST_LO, OPENFAB_INT, 1, 0},
                                          lo(0),
                                          hi(0),
                                          lo(1),
                                          hi(1),
                                          lo(2),
                                          hi(2)};
int picture_bounds(void** args) {
    return each_cube(args, 3, [&](int32_t i, Weights* w) {
        *w = {1, 0, 0};
        return -item<float>(args[1], i) > kSkin || item<int32_t>(args[2], i) > 0;
    });
}

int fail(void**) {
    return -7;
}

const openfab_uniform kUniforms[] = {
    {"a", "Material", OPENFAB_UNIFORM_MATERIAL, OPENFAB_BOOL, 0, 1, 0, nullptr},
    {"b", "Material", OPENFAB_UNIFORM_MATERIAL, OPENFAB_BOOL, 0, 1, 1, nullptr},
};
const openfab_varying kPictureNearest[] = {{"uv", "float2", OPENFAB_FLOAT, 2, -1, nullptr},
                                           {"face", "int", OPENFAB_INT, 1, -1, nullptr}};

openfab_kernel kernel(openfab_kernel_fn fn, std::span<const openfab_arg> args) {
    return {{fn, fn}, static_cast<int32_t>(args.size()), args.data()};
}

const openfab_step kOneKernel[] = {{OPENFAB_STEP_KERNEL, 0, 0}};
const openfab_scalar_type kStates[] = {OPENFAB_BOOL};

/// The volume stage is one segment, `volume`: its kernel gives amounts.
openfab_fablet table(const char* name, const openfab_kernel& volume, const openfab_kernel& bounds,
                     std::span<const openfab_varying> nearest = {}) {
    static std::deque<openfab_kernel> kernels;
    kernels.push_back(volume);
    openfab_fablet f{};
    f.abi_version = OPENFAB_ABI_VERSION;
    f.name = name;
    f.source_name = "tests";
    f.uniform_count = 2;
    f.uniforms = kUniforms;
    f.slot_count = 3;
    f.void_slot = 2;
    f.nearest_count = static_cast<int32_t>(nearest.size());
    f.nearest = nearest.data();
    // Its inputs come before the list of columns.
    f.fields = volume.args;
    while (f.fields[f.field_count].kind != OPENFAB_ARG_GROUPS)
        ++f.field_count;
    f.volume_segments.step_count = 1;
    f.volume_segments.steps = kOneKernel;
    f.volume_segments.kernel_count = 1;
    f.volume_segments.kernels = &kernels.back();
    f.volume_segments.state_count = 1;
    f.volume_segments.states = kStates;
    f.volume_bounds = bounds;
    return f;
}

}  // namespace

const openfab_fablet& solid_fablet() {
    static const openfab_fablet f = table("Solid", kernel(constant_volume<kSolid>, kWeights),
                                          kernel(constant_bounds<kSolid>, kBounds));
    return f;
}
const openfab_fablet& tint_fablet() {
    static const openfab_fablet f = table("Tint", kernel(constant_volume<kTint>, kWeights),
                                          kernel(constant_bounds<kTint>, kBounds));
    return f;
}
const openfab_fablet& hole_fablet() {
    static const openfab_fablet f = table("Hole", kernel(constant_volume<kHole>, kWeights),
                                          kernel(constant_bounds<kHole>, kBounds));
    return f;
}
const openfab_fablet& skin_fablet() {
    static const openfab_fablet f =
        table("Skin", kernel(skin_volume, kSkinArgs), kernel(skin_bounds, kSkinBoundsArgs));
    return f;
}
const openfab_fablet& picture_fablet() {
    static const openfab_fablet f =
        table("Picture", kernel(picture_volume, kPictureArgs),
              kernel(picture_bounds, kPictureBoundsArgs), kPictureNearest);
    return f;
}
const openfab_fablet& broken_fablet() {
    static const openfab_fablet f = table("Broken", kernel(fail, kWeights), openfab_kernel{});
    return f;
}

}  // namespace openfab::testing
