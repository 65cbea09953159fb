// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/fablet_checker.h"

#include <fmt/format.h>

#include <array>
#include <string>
#include <utility>

#include "compiler/check/grow_node.h"

namespace openfab::check {

namespace {

constexpr std::string_view kDistanceClaim = "distance";

/// Adds the members of a SurfacePoint beyond the three common ones: the nearest inputs of the
/// volume stage. Functions see them before the stage itself is checked.
void find_point_members(const ast::Fablet& from, Fablet* to) {
    to->point_members = common_point_members();
    for (const ast::Stage& stage : from.stages) {
        if (stage.kind != ast::StageKind::kVolume) continue;
        for (const ast::Variable& v : stage.varyings) {
            const Type type = find_type(v.type.text);
            if (v.nearest && v.extents.empty() && type.is_numeric()) {
                to->point_members.push_back({std::string(v.name), type, v.span});
            }
        }
        return;
    }
}

/// Gives a fablet the stage `@Dither(@varying { DitherAttributes attr }) { return rule(attr); }`.
void call_rule(const ast::Fablet& from, const Function* rule, Fablet* to) {
    if (rule == nullptr) return;
    to->ir.has_dither = true;
    to->dither.span = from.span;
    auto attributes = std::make_unique<Symbol>();
    attributes->kind = SymbolKind::kAttributes;
    attributes->name = "attr";
    attributes->span = from.span;
    attributes->type = {Base::kDitherAttributes};
    ExprPtr argument = make(ExprKind::kVariable, attributes->type, from.span);
    argument->symbol = attributes.get();
    to->dither.symbols.push_back(std::move(attributes));
    auto result = std::make_unique<Stmt>();
    result->kind = StmtKind::kReturn;
    result->span = from.span;
    result->expr = make(ExprKind::kCall, kIntType, from.span);
    result->expr->function = rule;
    result->expr->args.push_back(std::move(argument));
    to->dither.body = std::make_unique<Stmt>();
    to->dither.body->span = from.span;
    to->dither.body->body.push_back(std::move(result));
}

/// Checks the `[[ ]]` of a stage.
void check_claims(const ast::Stage& stage, Fablet* to, diag::Sink* sink) {
    for (const ast::TypeRef& claim : stage.claims) {
        if (stage.kind != ast::StageKind::kShape) {
            sink->report(claim.span, diag::kBadDeclaration,
                         fmt::format("a `@{}` stage claims nothing", ast::stage_name(stage.kind)))
                .note(stage.span, "the stage is declared here")
                .help(
                    "`[[ distance ]]` is of a `@Shape` whose value is the distance to its surface");
        } else if (claim.text != kDistanceClaim) {
            sink->report(claim.span, diag::kBadDeclaration,
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

/// Gives a fablet of a shape alone a volume stage that returns nothing: all is void.
void leave_empty(const ast::Fablet& from, Fablet* to) {
    to->volume.span = from.span;
    auto result = std::make_unique<Stmt>();
    result->kind = StmtKind::kReturn;
    result->span = from.span;
    result->expr = make(ExprKind::kConstruct, {Base::kComposition, 1}, from.span);
    to->volume.body = std::make_unique<Stmt>();
    to->volume.body->span = from.span;
    to->volume.body->body.push_back(std::move(result));
}

}  // namespace

void FabletChecker::check(const ast::Fablet& from, Fablet* to) {
    place_.fablet = to;
    to->ir.name = from.name;
    to->ir.span = from.span;
    const size_t file_functions = names_.functions().size();
    names_.open();
    to->void_material = std::make_unique<Symbol>();
    to->void_material->kind = SymbolKind::kVoid;
    to->void_material->name = "VOID";
    to->void_material->type = {Base::kMaterial, 1};
    to->void_material->is_const = true;
    names_.declare(to->void_material.get());
    names_.open();
    find_point_members(from, to);
    declarations_.scope(
        from.scope, from.uniforms, [&](const ast::Variable& v) { uniforms_.check(v, to); },
        &to->constants, &to->functions);
    check_recursion(to->functions, sink_);
    stages(from, to);
    // A fablet without materials is all VOID, which still displaces other parts.
    if (to->ir.slot_count == 0) to->ir.void_slot = to->ir.slot_count++;
    names_.close();
    names_.close();
    names_.keep_functions(file_functions);
    place_.fablet = nullptr;
}

void FabletChecker::stages(const ast::Fablet& from, Fablet* to) {
    std::array<const ast::Stage*, 5> stages{};  // by kind
    for (const ast::Stage& stage : from.stages) {
        const ast::Stage*& known = stages[static_cast<size_t>(stage.kind)];
        if (known != nullptr) {
            sink_
                ->report(stage.span, diag::kRedeclared,
                         std::string("@") + ast::stage_name(stage.kind))
                .note(known->span, "the first one is here");
            continue;
        }
        known = &stage;
        check_claims(stage, to, sink_);
    }
    const auto [surface, volume, dither, shape, grow] = stages;
    if (shape != nullptr) check_shape(*shape, to);
    if (grow != nullptr) check_grow(*grow, shape, to);
    if (surface != nullptr) {
        to->ir.has_surface = true;
        to->surface.span = surface->span;
        names_.open();
        for (const ast::Variable& v : surface->varyings)
            varyings_.check(v, *surface, to);
        body(*surface, &to->surface, StageContext::kSurface, kFloat3Type);
        names_.close();
    }
    const bool solid = shape != nullptr || grow != nullptr;
    if (volume == nullptr && solid && dither == nullptr) return leave_empty(from, to);
    if (volume == nullptr) {
        if (from.name.empty()) return;
        diag::Diagnostic& d = sink_->report(from.span, diag::kMissingStage, from.name);
        d.help("write `@Volume(@varying { VolumeAttributes attr }) { … }`");
        for (const auto& f : to->functions) {
            if (f->name == "Volume" || f->name == "volume" || f->name == "main") {
                d.note(f->span, fmt::format("`{}` is an ordinary function here", f->name));
            }
        }
        return;
    }
    to->volume.span = volume->span;
    names_.open();
    for (const ast::Variable& v : volume->varyings)
        varyings_.check(v, *volume, to);
    body(*volume, &to->volume, StageContext::kVolume, {Base::kComposition, 1});
    names_.close();
    if (dither == nullptr) return call_rule(from, rule_, to);
    to->ir.has_dither = true;
    to->dither.span = dither->span;
    names_.open();
    for (const ast::Variable& v : dither->varyings)
        varyings_.check(v, *dither, to);
    body(*dither, &to->dither, StageContext::kDither, kIntType);
    names_.close();
}

void FabletChecker::body(const ast::Stage& from, Stage* to, StageContext context,
                         const Type& result) {
    place_.context = context;
    unknown_.begin_body();
    place_.stage = from.span;
    if (from.body != nullptr) to->body = statements_.stage(*from.body, result);
}

void FabletChecker::check_shape(const ast::Stage& from, Fablet* to) {
    to->ir.has_shape = true;
    to->shape.span = from.span;
    names_.open();
    for (const ast::Variable& v : from.varyings)
        varyings_.check(v, from, to);
    body(from, &to->shape, StageContext::kShape, kFloatType);
    names_.close();
}

void FabletChecker::check_grow(const ast::Stage& from, const ast::Stage* shape, Fablet* to) {
    if (shape != nullptr) {
        sink_->report(from.span, diag::kBadDeclaration, "a fablet is one solid")
            .note(shape->span, "which is declared here")
            .help("write a fablet for each: an object may have the solid of another fablet");
        return;
    }
    to->ir.has_shape = true;
    to->shape.span = from.span;
    names_.open();
    size_t nodes = 0;
    for (const ast::Variable& v : from.varyings) {
        varyings_.check(v, from, to);
        nodes += find_type(v.type.text).is_attributes() ? 0 : 1;
    }
    if (to->node.is_error() && nodes == 0) {
        sink_->report(from.span, diag::kBadDeclaration, "a grow stage has no node to grow from")
            .help(
                "write `@Grow(@varying { GrowAttributes attr, Node parent })`, of a struct `Node`");
    }
    if (!to->node.is_error()) {
        check_node(from, *to, sink_);
        body(from, &to->shape, StageContext::kGrow, to->node);
    }
    names_.close();
}

}  // namespace openfab::check
