// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the surface and surface_bounds kernels are passed that does not change from call to call,
// and where the @nearest inputs of the volume stage come from.

#include <array>
#include <memory>
#include <vector>

#include "abi/fablet_table.h"
#include "abi/kernel_call.h"
#include "base/result.h"
#include "runtime/part/part.h"

namespace openfab::surface {

/// Scalars and textures of one part, at fixed addresses.
class StaticArgs {
  public:
    explicit StaticArgs(const scene::Part& part);
    StaticArgs(const StaticArgs&) = delete;
    StaticArgs& operator=(const StaticArgs&) = delete;

    /// The argument to pass, or null where `arg` is a buffer of the batch.
    const void* find(const openfab_arg& arg) const;

  private:
    const scene::Part& part_;
    std::array<float, OPENFAB_FRAME_COUNT> frame_{};
    std::unique_ptr<abi::KernelBuffer[]> textures_;  ///< 3 for each texture
};

/// One component of a @nearest input.
struct NearestComponent {
    enum class From : uint8_t { kSurfaceInput, kSurfaceOutput, kMesh } from = From::kMesh;
    int32_t index = 0;  ///< of the surface input, surface output or @nearest input
    int32_t component = 0;
};

/// The @nearest inputs, flattened: floats, then everything else.
struct NearestLayout {
    explicit NearestLayout(const openfab_fablet& fablet);
    std::vector<NearestComponent> floats, ints;
};

/// Refuses a kernel that asks for what a surface stage cannot have, or for `uv` on a mesh without
/// it; and arrays of the mesh that do not fit the fablet.
Result<void> check_surface_input(const scene::Part& part);

}  // namespace openfab::surface
