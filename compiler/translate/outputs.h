// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "compiler/translate/calls.h"

namespace openfab::translate {

/// What a stage gives.
class Outputs {
  public:
    Outputs(diag::Sink* sink, const Place& place, ir::Stage* stage, const Paths& paths,
            Calls* calls)
        : sink_(sink), place_(place), stage_(stage), paths_(paths), calls_(*calls) {}
    void surface(const check::Stage& stage);
    void shape(const check::Stage& stage);
    void grow();
    void volume();
    void dither(const check::Stage& stage);

  private:
    void varyings(const check::Stage& stage, check::SymbolKind which, int32_t kind);
    void add(std::string name, int32_t kind, int32_t a, int32_t b, ir::ValueId value);

    diag::Sink* sink_;
    const Place& place_;
    ir::Stage* stage_;
    const Paths& paths_;
    Calls& calls_;
};

}  // namespace openfab::translate
