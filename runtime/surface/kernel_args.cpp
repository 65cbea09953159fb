// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/kernel_args.h"

#include <fmt/format.h>

#include "abi/argument_group.h"
#include "runtime/surface/messages.h"

namespace openfab::surface {

StaticArgs::StaticArgs(const part::Part& part)
    : part_(part), textures_(std::make_unique<abi::KernelBuffer[]>(3 * part.textures.size())) {
    for (int axis = 0; axis < 3; ++axis) {
        frame_[static_cast<size_t>(OPENFAB_FRAME_CENTER + axis)] =
            static_cast<float>(part.mesh->center_part_mm[axis]);
    }
    frame_[OPENFAB_FRAME_MAX_DISPLACEMENT] = part.max_displacement_mm;
    values_.set_dense(abi::halide_type(OPENFAB_UINT), part.uniform_values.data(),
                      {static_cast<int32_t>(part.uniform_values.size())});
    for (size_t i = 0; i < part.textures.size(); ++i) {
        const texture::Pyramid& p = *part.textures[i];
        const auto count = [](size_t n) { return static_cast<int32_t>(n); };
        textures_[3 * i + OPENFAB_TEXTURE_TEXELS].set_dense(
            abi::halide_type(OPENFAB_FLOAT), p.texels().data(), {count(p.texels().size())});
        textures_[3 * i + OPENFAB_TEXTURE_INFO].set_dense(
            abi::halide_type(OPENFAB_INT), p.info().data(), {count(p.info().size())});
        textures_[3 * i + OPENFAB_TEXTURE_MINMAX].set_dense(
            abi::halide_type(OPENFAB_FLOAT), p.minmax().data(), {count(p.minmax().size())});
    }
}

const void* StaticArgs::find(const openfab_arg& arg) const {
    switch (arg.kind) {
        case OPENFAB_ARG_UNIFORM:
            return &part_.uniform_values[arg.a];
        case OPENFAB_ARG_VALUES:
            return values_.raw();
        case OPENFAB_ARG_FRAME:
            return &frame_[arg.a];
        case OPENFAB_ARG_INSTANCE:
            return &part_.instance;
        case OPENFAB_ARG_TEXTURE:
            return textures_[static_cast<size_t>(3 * arg.a + arg.b)].raw();
        default:
            return nullptr;
    }
}

NearestLayout::NearestLayout(const openfab_fablet& fablet) {
    for (int32_t i = 0; i < fablet.nearest_count; ++i) {
        const openfab_varying& input = fablet.nearest[i];
        NearestComponent from{NearestComponent::From::kMesh, i, 0};
        if (input.source >= 0) {
            const int32_t copied = fablet.surface_outputs[input.source].source;
            from = copied >= 0
                       ? NearestComponent{NearestComponent::From::kSurfaceInput, copied, 0}
                       : NearestComponent{NearestComponent::From::kSurfaceOutput, input.source, 0};
        }
        for (from.component = 0; from.component < input.components; ++from.component) {
            (input.scalar == OPENFAB_FLOAT ? floats : ints).push_back(from);
        }
    }
}

namespace {

bool is_attribute(openfab_arg_kind kind) {
    return kind == OPENFAB_ARG_SURFACE_ATTR || kind == OPENFAB_ARG_SURFACE_ATTR_GRAD ||
           kind == OPENFAB_ARG_SURFACE_ATTR_LO || kind == OPENFAB_ARG_SURFACE_ATTR_HI ||
           kind == OPENFAB_ARG_SURFACE_ATTR_GRAD_LO || kind == OPENFAB_ARG_SURFACE_ATTR_GRAD_HI;
}

bool fits_surface(openfab_arg_kind kind) {
    using enum abi::ArgumentGroup;
    const abi::ArgumentGroup group = abi::group_of(kind);
    return group == kPart || group == kSurfaceInput || group == kSurfaceOutput ||
           group == kSurfaceBoundsInput || group == kSurfaceBoundsOutput;
}

/// Checks the sizes of a part's arrays; a mismatch is an internal error and would read out of
/// range.
Result<void> check_arrays(const part::Part& part) {
    const part::PartMesh& mesh = *part.mesh;
    const size_t triangles = mesh.triangles.size();
    const auto fits = [&](const part::PartAttribute& a) {
        const size_t n = static_cast<size_t>(a.components);
        return a.scalar == OPENFAB_FLOAT ? a.corner_values.size() == 3 * triangles * n
                                         : a.face_values.size() == triangles * n;
    };
    const openfab_fablet& fablet = *part.fablet;
    bool good = triangles < std::numeric_limits<int32_t>::max() / 4 &&
                (fablet.has_surface == 0 ||
                 mesh.inputs.size() == static_cast<size_t>(fablet.surface_input_count)) &&
                mesh.nearest_attributes.size() == static_cast<size_t>(fablet.nearest_count) &&
                (mesh.corner_normals.empty() || mesh.corner_normals.size() == 3 * triangles) &&
                (mesh.corner_uv.empty() || mesh.corner_uv.size() == 6 * triangles);
    for (const part::PartAttribute& a : mesh.inputs)
        good = good && fits(a);
    for (int32_t i = 0; good && i < fablet.nearest_count; ++i) {
        good = fablet.nearest[i].source >= 0 || fits(mesh.nearest_attributes[i]);
    }
    if (good) return {};
    return internal_error(fmt::format(messages::kArraysDoNotFit, part.name, fablet.name));
}

Result<void> check_surface_kernels(const part::Part& part) {
    const openfab_fablet& fablet = *part.fablet;
    if (fablet.has_surface == 0) return {};
    for (const openfab_kernel* kernel : {&fablet.surface, &fablet.surface_bounds}) {
        const bool segmented = kernel == &fablet.surface && fablet.surface_segments.step_count > 0;
        if (!segmented && !abi::is_compiled(*kernel)) {
            return internal_error(fmt::format(messages::kKernelMissing, fablet.name));
        }
        for (int32_t i = 0; i < kernel->arg_count; ++i) {
            const openfab_arg& arg = kernel->args[i];
            if (is_attribute(arg.kind) && arg.a >= OPENFAB_SURFACE_UV &&
                part.mesh->corner_uv.empty()) {
                return user_error(fmt::format(messages::kNoUv, part.name, fablet.name));
            }
            const bool frame = arg.kind == OPENFAB_ARG_FRAME;
            if (frame && arg.a != OPENFAB_FRAME_MAX_DISPLACEMENT &&
                (arg.a < OPENFAB_FRAME_CENTER || arg.a >= OPENFAB_FRAME_CENTER + 3)) {
                return internal_error(fmt::format(messages::kFrameValue, fablet.name, arg.a));
            }
            if (!fits_surface(arg.kind)) {
                return internal_error(fmt::format(messages::kArgumentOfOther, fablet.name,
                                                  static_cast<int>(arg.kind)));
            }
        }
    }
    return {};
}

}  // namespace

Result<void> check_surface_input(const part::Part& part) {
    if (Result<void> good = check_arrays(part); !good) return good;
    return check_surface_kernels(part);
}

}  // namespace openfab::surface
