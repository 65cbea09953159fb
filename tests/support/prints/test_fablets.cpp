// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/prints/test_fablets.h"

#include <HalideRuntime.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <numeric>
#include <vector>

#include "abi/kernel_call.h"
#include "abi/stage_table.h"

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

// So many that of 16 blocks 5 are evaluated at once.
constexpr int32_t kStates = 24;
/// Amounts of the slots are the states from this on.
constexpr int32_t kFirstAmount = kStates - 3;
constexpr openfab_arg written(int32_t slot) {
    return {OPENFAB_ARG_STATE_OUT, OPENFAB_FLOAT, kFirstAmount + slot, 0};
}
constexpr openfab_arg amount(int32_t slot) {
    return {OPENFAB_ARG_STATE, OPENFAB_FLOAT, kFirstAmount + slot, 0};
}
constexpr openfab_arg fraction(int32_t channel) {
    return {OPENFAB_ARG_FRACTION, OPENFAB_UINT, channel, 0};
}
constexpr openfab_arg lo(int32_t slot) {
    return {OPENFAB_ARG_WEIGHT_LO, OPENFAB_FLOAT, slot, 0};
}
constexpr openfab_arg hi(int32_t slot) {
    return {OPENFAB_ARG_WEIGHT_HI, OPENFAB_FLOAT, slot, 0};
}

constexpr openfab_arg kColumns = {OPENFAB_ARG_GROUPS, OPENFAB_INT, 0, 0};

const openfab_arg kWeights[] = {kColumns, written(0), written(1), written(2)};
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
    {OPENFAB_ARG_DISTANCE, OPENFAB_FLOAT, 0, 0}, kColumns, written(0), written(1), written(2)};
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
                                    written(0),
                                    written(1),
                                    written(2)};
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
constexpr std::array<openfab_scalar_type, kStates> kStateTypes = [] {
    std::array<openfab_scalar_type, kStates> out{};
    out.fill(OPENFAB_FLOAT);
    out[0] = OPENFAB_BOOL;
    return out;
}();

constexpr std::array<openfab_arg, 11> kSlabArgs = {{{OPENFAB_ARG_CHANNELS, OPENFAB_INT, 0, 0},
                                                    kColumns,
                                                    amount(0),
                                                    amount(1),
                                                    amount(2),
                                                    {OPENFAB_ARG_CODE, OPENFAB_UINT, 0, 0},
                                                    {OPENFAB_ARG_UNUSABLE, OPENFAB_UINT, 0, 0},
                                                    fraction(0),
                                                    fraction(1),
                                                    fraction(2),
                                                    fraction(3)}};
/// Normalises the amounts that the segment has left in states.
int slab(void** args) {
    constexpr int32_t kSlots = 3, kChannels = kSlots + 1;
    const int32_t columns = buffer(args[1])->dim[0].extent;
    std::vector<float> amounts;
    for (int32_t slot = 0; slot < kSlots; ++slot) {
        for (int32_t i = 0; i < 8 * columns; ++i)
            amounts.push_back(
                item<float>(args[2 + slot], 8 * item<int32_t>(args[1], i / 8) + i % 8));
    }
    std::vector<int32_t> all(static_cast<size_t>(columns));
    std::iota(all.begin(), all.end(), 0);
    std::vector<uint16_t> fractions(static_cast<size_t>(8 * kChannels * columns));
    abi::KernelBuffer groups, weights, out;
    groups.set_dense(abi::halide_type(OPENFAB_INT), all.data(), {columns});
    weights.set_dense(abi::halide_type(OPENFAB_FLOAT), amounts.data(), {8, columns, kSlots});
    out.set_dense(abi::halide_type(fraction(0)), fractions.data(), {8, kChannels, columns});
    void* call[] = {groups.raw(), args[0], weights.raw(), out.raw(), args[5], args[6]};
    const int status = openfab_stage_table.normalise[OPENFAB_ISA_SSE41](call);
    for (int32_t i = 0; i < kChannels * columns; ++i) {
        void* const to = args[7 + i % kChannels];
        std::copy_n(&fractions[static_cast<size_t>(8 * i)], 8,
                    &item<uint16_t>(to, i / kChannels * buffer(to)->dim[1].stride));
    }
    return status;
}

constexpr std::array<openfab_arg, kSlabArgs.size() + 1> kSkinSlabArgs = [] {
    std::array<openfab_arg, kSlabArgs.size() + 1> out{};
    out[0] = {OPENFAB_ARG_DISTANCE, OPENFAB_FLOAT, 0, 0};
    std::copy(kSlabArgs.begin(), kSlabArgs.end(), out.begin() + 1);
    return out;
}();
/// The same, but fails where the distances are not those that the segment was given.
int skin_slab(void** args) {
    const int32_t columns = buffer(args[2])->dim[0].extent;
    for (int32_t i = 0; i < 8 * columns; ++i) {
        const int32_t v = 8 * item<int32_t>(args[2], i / 8) + i % 8;
        const Weights w = skin_weights(std::fabs(item<float>(args[0], v)));
        if (item<float>(args[3], v) != w.a || item<float>(args[4], v) != w.b) return -8;
    }
    return slab(args + 1);
}

/// The volume stage has one segment before the slab kernel, `volume`: it writes amounts.
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
    f.volume_segments.state_count = kStates;
    f.volume_segments.states = kStateTypes.data();
    f.slab = kernel(slab, kSlabArgs);
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
    static const openfab_fablet f = [] {
        openfab_fablet made =
            table("Skin", kernel(skin_volume, kSkinArgs), kernel(skin_bounds, kSkinBoundsArgs));
        made.slab = kernel(skin_slab, kSkinSlabArgs);
        return made;
    }();
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
