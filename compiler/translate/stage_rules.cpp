// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/stage_rules.h"

#include "compiler/check/check.h"

namespace openfab::translate {

/// Returns true after a message if the function was called from a dither stage.
bool StageRules::refuse_in_dither(const check::Expr& expr, std::string_view what) {
    if (place_.kind != ir::StageKind::kDither) return false;
    sink_->report(expr.span, diag::kStageMismatch, what, "called in a dither stage")
        .note(place_.fablet.dither.span, "stage declared `@Dither` here, which calls this function")
        .help("a dither rule looks at the voxel's fractions and its index");
    return true;
}

/// Returns true after a message if the function was called from a shape stage.
bool StageRules::refuse_in_shape(const check::Expr& expr, std::string_view what, const char* help) {
    if (place_.kind != ir::StageKind::kShape && !place_.grows()) return false;
    sink_
        ->report(expr.span, diag::kStageMismatch, what,
                 place_.grows() ? "called in a grow stage" : "called in a shape stage")
        .note(place_.fablet.shape.span,
              place_.grows() ? "stage declared `@Grow` here, which calls this function"
                             : "stage declared `@Shape` here, which calls this function")
        .help(place_.grows() ? check::kNoQueriesInGrow : help);
    return true;
}

/// Returns false after a message if the function was called from another stage.
bool StageRules::asks_in_volume(const check::Expr& expr, const char* name) {
    if (refuse_in_dither(expr, name) || refuse_in_shape(expr, name, check::shape_query_help(name)))
        return false;
    if (place_.kind != ir::StageKind::kSurface) return true;
    sink_->report(expr.span, diag::kStageMismatch, name, "called in a surface stage")
        .note(place_.fablet.surface.span,
              "stage declared `@Surface` here, which calls this function");
    return false;
}

/// As asks_in_volume, of what a shape may ask, too.
bool StageRules::asks_of_object(const check::Expr& expr) {
    return place_.kind == ir::StageKind::kShape || asks_in_volume(expr, "distance_to");
}

}  // namespace openfab::translate
