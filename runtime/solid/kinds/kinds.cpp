// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/kinds/kinds.h"

#include "base/check.h"
#include "runtime/solid/beams/beam_solid.h"
#include "runtime/solid/grow/grow_solid.h"
#include "runtime/solid/mesh/mesh_solid.h"
#include "runtime/solid/shape/shape_solid.h"

namespace openfab::solid {

namespace {

// The first that has a source makes the part: shapes and beams have a mesh, too, their box.
constexpr const Kind* kKinds[] = {&kGrowKind, &kShapeKind, &kBeamKind, &kMeshKind};

}  // namespace

const Kind& kind_of(const part::Part& part) {
    for (const Kind* kind : kKinds) {
        if (kind->source(part) != nullptr) return *kind;
    }
    OPENFAB_CHECK(false);
}

}  // namespace openfab::solid
