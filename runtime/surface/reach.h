// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a displaced surface may lie, from its bounds alone (Surface::reach).

#include <vector>

#include "runtime/surface/base_mesh.h"
#include "runtime/surface/patch_table.h"
#include "runtime/surface/surface.h"

namespace openfab::surface {

void add_reach(const BaseMesh& base, const PatchTable& table, int32_t patch,
               std::vector<Reach>* out);

}  // namespace openfab::surface
