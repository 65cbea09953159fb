// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "compiler/translate/formulas.h"
#include "compiler/translate/stage_rules.h"

namespace openfab::translate {

/// The components of values of a type.
class Layout {
  public:
    Layout(Emitter* emit, const Place& place) : emit_(*emit), place_(place) {}
    std::vector<ir::Type> components(const check::Type& type) const;
    size_t component_count(const check::Type& type) const;
    /// Returns the first component of member `index`, and the number of its components.
    std::pair<size_t, size_t> member_range(const check::Type& type, size_t index) const;
    Value zero(const check::Type& type);
    /// For a variable without an initializer: it starts at zero, which arrays and compositions may be
    /// meant to do; of others it is likely a mistake to use that.
    Value unassigned(const check::Type& type);

  private:
    void add_components(const check::Type& type, std::vector<ir::Type>* out) const;

    Emitter& emit_;
    const Place& place_;
};

}  // namespace openfab::translate
