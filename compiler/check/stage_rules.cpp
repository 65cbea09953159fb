// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/stage_rules.h"

#include "compiler/check/check.h"

namespace openfab::check {

const char* shape_query_help(std::string_view /*query*/) {
    return "what the stage returns makes the surface: put it into a function of a point, and call "
           "that; of another body there is `distance_to`";
}

/// Reports what a dither rule cannot use; false elsewhere.
bool StageRules::refuse_in_dither(const source::Span& span, std::string_view what) const {
    if (place_.context != StageContext::kDither) return false;
    sink_->report(span, diag::kStageMismatch, what, "called in a dither stage")
        .note(place_.stage, "stage declared `@Dither` here")
        .help("a dither rule looks at the voxel's fractions and its index");
    return true;
}

/// Reports what a shape, or a rule that grows, cannot use; false elsewhere.
bool StageRules::refuse_in_shape(const source::Span& span, std::string_view what,
                                 const char* help) const {
    if (place_.context != StageContext::kShape && place_.context != StageContext::kGrow)
        return false;
    const bool grows = place_.context == StageContext::kGrow;
    sink_
        ->report(span, diag::kStageMismatch, what,
                 grows ? "called in a grow stage" : "called in a shape stage")
        .note(place_.stage, grows ? "stage declared `@Grow` here" : "stage declared `@Shape` here")
        .help(grows ? kNoQueriesInGrow : help);
    return true;
}

}  // namespace openfab::check
