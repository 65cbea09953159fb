// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The shape stage: what it claims, its outputs, and what other stages read of them. To these a shape is a mesh whose
// attributes are the stage's outputs.

#include <fmt/format.h>

#include <algorithm>

#include "compiler/check/checker.h"

namespace openfab::check {

namespace {

constexpr std::string_view kDistanceClaim = "distance";

}  // namespace

const char* shape_query_help(std::string_view /*query*/) {
    return "what the stage returns makes the surface: put it into a function of a point, and call "
           "that; of another body there is `distance_to`";
}

/// Reports a value that cannot be meant as a shape's; false for numbers.
bool StatementChecker::is_no_shape(const Expr& value) {
    const bool number = value.type.is_scalar() && value.type.base != Base::kBool;
    if (number || value.type.is_error()) return false;
    const bool truth = value.type.is_scalar();
    sink_->report(value.span, diag::kNoConversion, type_name(value.type), "float")
        .note(stage_span_, "stage declared `@Shape` here")
        .help(truth
                  ? "a shape returns a number, negative inside: of a condition, `inside ? -1 : 1`, "
                    "better a distance, `length(p) - 5`"
                  : "a shape returns one number, negative inside: `length(p) - 5` is a ball of "
                    "radius 5");
    return true;
}

/// Checks the `[[ ]]` of a stage.
void Checker::check_claims(const ast::Stage& stage, Fablet* to) {
    for (const ast::TypeRef& claim : stage.claims) {
        if (stage.kind != ast::StageKind::kShape) {
            sink_
                ->report(claim.span, diag::kBadDeclaration,
                         fmt::format("a `@{}` stage claims nothing", ast::stage_name(stage.kind)))
                .note(stage.span, "the stage is declared here")
                .help(
                    "`[[ distance ]]` is of a `@Shape` whose value is the distance to its surface");
        } else if (claim.text != kDistanceClaim) {
            sink_
                ->report(claim.span, diag::kBadDeclaration,
                         fmt::format("a shape cannot claim `{}`", claim.text))
                .suggest(
                    claim.span, claim.text, std::vector<std::string>{"distance"},
                    "it may claim `distance`: its value is the distance to its surface, in mm");
        } else {
            to->ir.shape_is_distance = true;
            to->ir.claim_span = claim.span;
        }
    }
}

void Checker::check_shape(const ast::Stage& from, Fablet* to) {
    to->ir.has_shape = true;
    to->shape.span = from.span;
    scopes_.emplace_back();
    for (const ast::Variable& v : from.varyings)
        check_varying(v, from, to);
    check_stage_body(from, &to->shape, StageContext::kShape, kFloatType);
    scopes_.pop_back();
}

/// Gives a fablet of a shape alone a volume stage that returns nothing: all is void.
void Checker::leave_empty(const ast::Fablet& from, Fablet* to) {
    to->volume.span = from.span;
    auto result = std::make_unique<Stmt>();
    result->kind = StmtKind::kReturn;
    result->span = from.span;
    result->expr = make(ExprKind::kConstruct, {Base::kComposition, 1}, from.span);
    to->volume.body = std::make_unique<Stmt>();
    to->volume.body->span = from.span;
    to->volume.body->body.push_back(std::move(result));
}

void Checker::check_shape_varying(const ast::Variable& v, const Type& type, Fablet* to) {
    if (v.nearest) {
        sink_->report(v.span, diag::kStageMismatch, "@nearest", "in a shape stage")
            .note(to->shape.span, "stage declared `@Shape` here")
            .help("a shape has no surface before it is evaluated: leave `@nearest` out");
    } else if (v.is_in && v.is_out) {
        sink_->report(v.span, diag::kBadDeclaration, "a varying cannot be `inout`")
            .help(
                "a shape reads a point, `attr.p`, and returns a number; declare an `out` for what "
                "it says more");
    } else if (!v.is_out) {
        diag::Diagnostic& d =
            sink_->report(v.span, diag::kBadDeclaration, "a shape stage has no inputs of its own");
        d.note(to->shape.span, "the stage is declared here");
        const bool point = type == kFloat3Type;
        d.help(point ? "the point is `attr.p` of `ShapeAttributes attr`"
                     : fmt::format("an attribute that it gives is `out {} {}`; a number of the "
                                   "part is a uniform",
                                   v.type.text, v.name));
    }
    if (v.init != nullptr) {
        sink_->report(v.init->span, diag::kBadDeclaration,
                      "an output has no default: assign it in the stage");
    }
    add_stage_symbol(&to->shape, SymbolKind::kShapeOutput, v, type, to->ir.shape_outputs.size());
    to->ir.shape_outputs.push_back(varying(v, type));
}

/// Compares an input of another stage with the output of the shape that it reads.
void Checker::check_against_shape(const ast::Variable& v, const Type& type, const Fablet& to) {
    const auto output = std::ranges::find(to.ir.shape_outputs, v.name, &ir::Varying::name);
    if (output == to.ir.shape_outputs.end()) return;
    // Of a node, an array of two floats has a value for each end.
    const bool grows = !to.node.is_error();
    const bool ends = grows && output->type_name == type_name(array_of(type, 2)) &&
                      output->type == ir::Type::kFloat;
    const bool same = output->components == type.size && !output->type_name.ends_with("]");
    if (output->type == component_type(type) && (same || ends)) return;
    diag::Diagnostic& d = sink_->report(
        v.type.span, diag::kBadDeclaration,
        fmt::format("`{} {}` reads the {} `{} {}`: the types differ", v.type.text, v.name,
                    grows ? "node's" : "shape's output", output->type_name, output->name));
    d.note(output->span, fmt::format("`{}{} {}` is declared here", grows ? "" : "out ",
                                     output->type_name, output->name));
    if (grows)
        d.help("a number or vector, or two floats: of the beam's first end and of its second");
}

}  // namespace openfab::check
