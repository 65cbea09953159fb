// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where in the program the checker is, and what the stage there cannot use.

#include <cstdint>
#include <string_view>

#include "compiler/check/tree.h"
#include "compiler/diag/sink.h"

namespace openfab::check {

enum class StageContext : uint8_t { kGlobal, kFunction, kSurface, kVolume, kDither, kShape, kGrow };

/// Where the checker is.
struct Place {
    StageContext context = StageContext::kGlobal;
    source::Span stage;            ///< where the stage is declared
    Function* function = nullptr;  ///< null outside of one
    Fablet* fablet = nullptr;      ///< null outside of one
};

class StageRules {
  public:
    StageRules(diag::Sink* sink, const Place& place) : sink_(sink), place_(place) {}
    bool refuse_in_dither(const source::Span& span, std::string_view what) const;
    bool refuse_in_shape(const source::Span& span, std::string_view what, const char* help) const;

  private:
    diag::Sink* sink_;
    const Place& place_;
};

}  // namespace openfab::check
