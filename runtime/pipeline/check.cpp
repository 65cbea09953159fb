// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abi/argument_group.h"
#include "abi/kernel_call.h"
#include "abi/stage_table.h"
#include "runtime/dither/dither_rule.h"
#include "runtime/pipeline/messages.h"
#include "runtime/solid/cut/cut.h"
#include "runtime/surface/crowding.h"

namespace openfab::pipeline {

namespace {

using abi::ArgumentGroup;
using abi::group_of;

bool common_argument(openfab_arg_kind kind) {
    const ArgumentGroup group = group_of(kind);
    return group == ArgumentGroup::kPart || group == ArgumentGroup::kBlocks;
}

bool volume_argument(openfab_arg_kind kind) {
    return common_argument(kind) || kind == OPENFAB_ARG_GROUPS ||
           group_of(kind) == ArgumentGroup::kNearest;
}

bool slab_argument(openfab_arg_kind kind) {
    return common_argument(kind) || kind == OPENFAB_ARG_GROUPS ||
           group_of(kind) == ArgumentGroup::kSlab;
}

bool segment_argument(openfab_arg_kind kind) {
    return volume_argument(kind) || kind == OPENFAB_ARG_STATE || kind == OPENFAB_ARG_STATE_OUT;
}

/// Of a slab kernel after segments, which asks for no nearest points itself.
bool last_segment_argument(openfab_arg_kind kind) {
    return kind != OPENFAB_ARG_NEAREST_SOURCE &&
           (slab_argument(kind) || volume_argument(kind) || kind == OPENFAB_ARG_STATE);
}

bool bounds_argument(openfab_arg_kind kind) {
    return common_argument(kind) || group_of(kind) == ArgumentGroup::kVolumeBounds;
}

bool demand_argument(openfab_arg_kind kind) {
    return common_argument(kind) || kind == OPENFAB_ARG_GROUPS || kind == OPENFAB_ARG_DEMAND;
}

Result<void> check_kernel(const part::Part& part, const char* name, const openfab_kernel& kernel,
                          bool (*fits)(openfab_arg_kind)) {
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        const openfab_arg& arg = kernel.args[i];
        const bool slot_fits =
            (arg.kind != OPENFAB_ARG_WEIGHT_LO && arg.kind != OPENFAB_ARG_WEIGHT_HI &&
             arg.kind != OPENFAB_ARG_FRACTION) ||
            arg.a < part.fablet->slot_count + (arg.kind == OPENFAB_ARG_FRACTION ? 1 : 0);
        if (!fits(arg.kind) || !slot_fits) {
            return internal_error(fmt::format(messages::kArgumentKind, part.fablet->name, i, name,
                                              static_cast<int>(arg.kind)));
        }
    }
    if (kernel.arg_count > 0 && !abi::is_compiled(kernel)) {
        return internal_error(fmt::format(messages::kKernelWithoutCode, part.fablet->name, name));
    }
    return {};
}

Result<void> check_part(const part::Part& part, size_t materials) {
    const openfab_fablet& fablet = *part.fablet;
    if (fablet.abi_version != OPENFAB_ABI_VERSION) {
        return internal_error(fmt::format(messages::kOtherInterface, fablet.name,
                                          fablet.abi_version, OPENFAB_ABI_VERSION));
    }
    if (part.slot_material.size() != static_cast<size_t>(fablet.slot_count)) {
        return internal_error(fmt::format(messages::kSlotsUnbound, part.name,
                                          part.slot_material.size(), fablet.slot_count));
    }
    for (uint8_t code : part.slot_material) {
        if (code > materials)
            return internal_error(fmt::format(messages::kNoMaterialCode, part.name, code));
    }
    const openfab_segments& segments = fablet.volume_segments;
    for (int32_t k = 0; k < (segments.step_count > 0 ? segments.kernel_count : 0); ++k) {
        if (const auto r = check_kernel(part, "volume", segments.kernels[k], segment_argument); !r)
            return r.error();
    }
    const auto fits = segments.step_count == 0 ? slab_argument : last_segment_argument;
    if (const auto r = check_kernel(part, "slab", fablet.slab, fits); !r) return r.error();
    if (const auto r = check_kernel(part, "volume_demand", fablet.volume_demand, demand_argument);
        !r)
        return r.error();
    return check_kernel(part, "volume_bounds", fablet.volume_bounds, bounds_argument);
}

}  // namespace

Result<void> check_input(const PrintInput& input, const PrintOptions& options) {
    if (!dither::find_dither(options.dither)) {
        return usage_error(
            fmt::format(messages::kNoSuchDither, options.dither, dither::dither_names()));
    }
    if (options.threads < 0 || options.threads > 1024) {
        return usage_error(fmt::format(messages::kThreadsOutside, options.threads));
    }
    if (input.materials.size() > OPENFAB_MAX_MATERIALS) {
        std::string names;
        for (const auto& m : input.materials)
            names += (names.empty() ? "" : ", ") + m.name;
        return user_error(fmt::format(messages::kTooManyMaterials, input.materials.size(),
                                      OPENFAB_MAX_MATERIALS, names));
    }
    if (input.support_code < 0 ||
        input.support_code > static_cast<int32_t>(input.materials.size())) {
        return internal_error(fmt::format(messages::kNoSupportMaterial, input.support_code));
    }
    for (int a = 0; a < 3; ++a) {
        if (!(input.pitch_mm[a] > 0) || !std::isfinite(input.pitch_mm[a])) {
            return user_error(fmt::format(messages::kVoxelOutside, input.pitch_mm.x,
                                          input.pitch_mm.y, input.pitch_mm.z));
        }
    }
    for (const part::Part& part : input.parts) {
        if (const auto r = check_part(part, input.materials.size()); !r) return r.error();
    }
    return {};
}

std::vector<std::string> crowded_warnings(
    const std::vector<part::Part>& parts, const std::vector<int32_t>& owners,
    const std::vector<std::shared_ptr<solid::Solid>>& solids) {
    constexpr size_t kMostLines = 4;
    std::vector<std::string> warnings;
    size_t crowded = 0;
    for (size_t i = 0; i < parts.size(); ++i) {
        const solid::Dicing* dicing = solids[i]->dicing();
        if (owners[i] != static_cast<int32_t>(i) || dicing == nullptr) continue;
        const double around = dicing->crowding();
        if (!(around > surface::kCrowded) || ++crowded > kMostLines) continue;
        const part::Part& part = parts[i];
        const std::string bound =
            std::isfinite(part.max_displacement_mm)
                ? fmt::format(messages::kLowerDisplacement, part.max_displacement_mm)
                : messages::kBoundDisplacement;
        warnings.push_back(fmt::format(messages::kPrintsSlowly, part.name, part.instance, around,
                                       surface::kCrowded, bound));
    }
    if (crowded > kMostLines)
        warnings.push_back(fmt::format(messages::kMorePrintSlowly, crowded - kMostLines));
    return warnings;
}

}  // namespace openfab::pipeline
