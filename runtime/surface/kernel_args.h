// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Arguments of the surface and surface_bounds kernels that stay the same from call to call, and the
// sources of the volume stage's @nearest inputs.

#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "abi/fablet_table.h"
#include "abi/kernel_call.h"
#include "base/result.h"
#include "runtime/part/part.h"

namespace openfab::surface {

/// Components of the largest output, a matrix.
constexpr int32_t kMaxComponents = 16;

/// Scalars and textures of one part, at fixed addresses.
class StaticArgs {
  public:
    explicit StaticArgs(const part::Part& part);
    StaticArgs(const StaticArgs&) = delete;
    StaticArgs& operator=(const StaticArgs&) = delete;

    /// Returns the argument to pass, or null if `arg` is a buffer of the batch.
    const void* find(const openfab_arg& arg) const;
    /// Returns the part-space position of the local origin along an axis.
    float center(size_t axis) const { return frame_[OPENFAB_FRAME_CENTER + axis]; }
    /// What ends loops of the stage's segments early once it is set; null: nothing. It is replaced while no
    /// other thread uses this.
    const std::atomic<bool>* stop() const { return stop_; }
    void set_stop(const std::atomic<bool>* stop) const { stop_ = stop; }

  private:
    const part::Part& part_;
    std::array<float, OPENFAB_FRAME_COUNT> frame_{};
    std::unique_ptr<abi::KernelBuffer[]> textures_;  ///< 3 per texture
    mutable abi::KernelBuffer values_;               ///< kernels take a pointer that may write
    mutable const std::atomic<bool>* stop_ = nullptr;
};

/// One component of a @nearest input.
struct NearestComponent {
    enum class From : uint8_t { kSurfaceInput, kSurfaceOutput, kMesh } from = From::kMesh;
    int32_t index = 0;  ///< of the surface input, surface output or @nearest input
    int32_t component = 0;
};

/// The @nearest inputs, flattened: floats, then all others.
struct NearestLayout {
    explicit NearestLayout(const openfab_fablet& fablet);
    std::vector<NearestComponent> floats, ints;
};

/// Checks that the kernel reads only what a surface stage has, and `uv` only if the mesh has it,
/// and that the mesh's arrays fit the fablet.
Result<void> check_surface_input(const part::Part& part);

}  // namespace openfab::surface
