// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "compiler/check/checker.h"

namespace openfab::check {

namespace {

constexpr int32_t kMaxSlots = 256;  // a world has 254 materials

/// What the stages of a kind are called, and where they are kept.
struct StageInfo {
    Stage Fablet::*stage;
    Base attributes;
    const char* where;
};

const StageInfo& info_of(ast::StageKind kind) {
    static constexpr std::array<StageInfo, 5> kInfos = {
        {{&Fablet::surface, Base::kSurfaceAttributes, "in a surface stage"},
         {&Fablet::volume, Base::kVolumeAttributes, "in a volume stage"},
         {&Fablet::dither, Base::kDitherAttributes, "in a dither stage"},
         {&Fablet::shape, Base::kShapeAttributes, "in a shape stage"},
         {&Fablet::shape, Base::kGrowAttributes, "in a grow stage"}}};
    return kInfos[static_cast<size_t>(kind)];
}

std::string annotation_text(const ast::Expr& expr) {
    if (expr.kind == ast::ExprKind::kStringLiteral) return std::string(expr.text);
    if (expr.kind == ast::ExprKind::kUnary) {
        return std::string(expr.text) + annotation_text(*expr.args[0]);
    }
    return std::string(expr.text);
}

/// Returns whether an annotation is a limit that must be computed, such as a constant's: any but a
/// decimal number.
bool is_computed(const ast::Annotation& annotation) {
    if (annotation.value == nullptr || (annotation.name != "min" && annotation.name != "max"))
        return false;
    const ast::Expr* number = annotation.value.get();
    if (number->kind == ast::ExprKind::kUnary && number->text == "-")
        number = number->args[0].get();
    const bool is_number =
        number->kind == ast::ExprKind::kIntLiteral || number->kind == ast::ExprKind::kFloatLiteral;
    return !is_number || number->text.starts_with("0x") || number->text.starts_with("0X");
}

std::string varying_list(const std::vector<ir::Varying>& list) {
    std::string out;
    for (const ir::Varying& v : list) {
        out += fmt::format("{}`{} {}`", out.empty() ? "" : ", ", v.type_name, v.name);
    }
    return out;
}

int32_t find_varying(const std::vector<ir::Varying>& list, std::string_view name) {
    for (size_t i = 0; i < list.size(); ++i) {
        if (list[i].name == name) return static_cast<int32_t>(i);
    }
    return -1;
}

}  // namespace

void Checker::check_fablet(const ast::Fablet& from, Fablet* to) {
    fablet_ = to;
    to->ir.name = from.name;
    to->ir.span = from.span;
    const size_t file_functions = visible_functions_.size();
    scopes_.emplace_back();
    to->void_material = std::make_unique<Symbol>();
    to->void_material->kind = SymbolKind::kVoid;
    to->void_material->name = "VOID";
    to->void_material->type = {Base::kMaterial, 1};
    to->void_material->is_const = true;
    declare(to->void_material.get());
    scopes_.emplace_back();
    find_point_members(from, to);
    check_scope(from.scope, &from, to, &to->constants, &to->functions);
    check_recursion(to->functions);
    check_stages(from, to);
    // A fablet without materials is all VOID, which still displaces other parts.
    if (to->ir.slot_count == 0) to->ir.void_slot = to->ir.slot_count++;
    scopes_.pop_back();
    scopes_.pop_back();
    visible_functions_.resize(file_functions);
    fablet_ = nullptr;
}

/// Adds the members of a SurfacePoint beyond the three common ones: the nearest inputs of the
/// volume stage. Functions see them before the stage itself is checked.
void Checker::find_point_members(const ast::Fablet& from, Fablet* to) {
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

/// Assigns a uniform its index among those of its kind; false if its type is not allowed.
bool Checker::assign_uniform_index(const ast::Variable& v, const Type& type, ir::Uniform* uniform,
                                   Fablet* to) {
    Type element = type;
    if (type.is_array()) {
        uniform->array_length = type.length();
        element = type.element();
    }
    const auto assign = [&](openfab_uniform_kind kind, int32_t* count) {
        uniform->kind = kind;
        uniform->first_index = *count;
        *count += uniform->array_length;
    };
    if (element.is(Base::kTexture2D)) {
        assign(OPENFAB_UNIFORM_TEXTURE2D, &to->ir.texture_count);
    } else if (element.is(Base::kTexture3D)) {
        assign(OPENFAB_UNIFORM_TEXTURE3D, &to->ir.texture_count);
    } else if (element.is(Base::kObject)) {
        assign(OPENFAB_UNIFORM_OBJECT, &to->ir.object_count);
    } else if (element.is(Base::kMaterial)) {
        const bool fitted = to->ir.slot_count <= kMaxSlots;
        assign(OPENFAB_UNIFORM_MATERIAL, &to->ir.slot_count);
        if (fitted && to->ir.slot_count > kMaxSlots) {
            sink_->report(v.span, diag::kTooComplex,
                          fmt::format("more than {} uniforms of type `Material`", kMaxSlots));
        }
    } else if (type.is_curve()) {
        uniform->kind = OPENFAB_UNIFORM_CURVE;
        uniform->components = static_cast<int32_t>(min_components(type));
        uniform->first_index = to->ir.uniform_value_count;
        to->ir.uniform_value_count += uniform->components;
    } else if (element.is_arithmetic()) {
        uniform->type = component_type(element);
        uniform->components = static_cast<int32_t>(min_components(element));
        uniform->first_index = to->ir.uniform_value_count;
        to->ir.uniform_value_count += uniform->components * uniform->array_length;
    } else {
        diag::Diagnostic& d =
            sink_->report(v.type.span, diag::kBadDeclaration,
                          fmt::format("a uniform cannot have type `{}`", type_name(type)));
        if (element.is_array()) d.help("a uniform array has one dimension");
        if (element.is_curve()) d.help("give each a name of its own");
        if (element.is(Base::kStruct)) d.help("declare the members as uniforms of their own");
        return false;
    }
    return true;
}

void Checker::check_annotations(const ast::Variable& v, Symbol* symbol, ir::Uniform* uniform) {
    for (const ast::Annotation& a : v.annotations) {
        for (size_t i = 0; i < symbol->annotations.size(); ++i) {
            if (uniform->annotations[i].first != a.name) continue;
            sink_->report(a.span, diag::kRedeclared, a.name)
                .note(symbol->annotations[i].span, "the first one is here");
        }
        Symbol::Annotation& kept = symbol->annotations.emplace_back();
        kept.span = a.span;
        std::string text;
        if (is_computed(a)) {
            context_ = StageContext::kGlobal;
            kept.value = initializer(*a.value, kFloatType);
        } else if (a.value != nullptr) {
            text = annotation_text(*a.value);
        }
        uniform->annotations.emplace_back(a.name, std::move(text));
    }
}

void Checker::check_uniform(const ast::Variable& v, Fablet* to) {
    ir::Uniform uniform;
    uniform.name = v.name;
    uniform.type_name = v.type.text;
    uniform.span = v.span;
    auto symbol = std::make_unique<Symbol>();
    symbol->kind = SymbolKind::kUniform;
    symbol->name = v.name;
    symbol->span = v.span;
    symbol->type = declared_type(v);
    symbol->index = static_cast<int32_t>(to->uniforms.size());
    if (!symbol->type.is_error() && !assign_uniform_index(v, symbol->type, &uniform, to)) {
        symbol->type = {};
    }
    Type element = symbol->type;
    if (element.is_array()) element = element.element();
    if (v.init != nullptr && element.is_arithmetic()) {
        context_ = StageContext::kGlobal;
        symbol->init = initializer(*v.init, symbol->type);
    } else if (v.init != nullptr && !symbol->type.is_error()) {
        sink_->report(
            v.init->span, diag::kBadDeclaration,
            fmt::format("a uniform of type `{}` has no default: the world binds it", v.type.text));
    }
    check_annotations(v, symbol.get(), &uniform);
    add_choices(v, symbol->type, &uniform);
    declare(symbol.get());
    to->ir.uniforms.push_back(std::move(uniform));
    to->uniforms.push_back(std::move(symbol));
}

void Checker::check_stages(const ast::Fablet& from, Fablet* to) {
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
        check_claims(stage, to);
    }
    const auto [surface, volume, dither, shape, grow] = stages;
    if (shape != nullptr) check_shape(*shape, to);
    if (grow != nullptr) check_grow(*grow, shape, to);
    if (surface != nullptr) {
        to->ir.has_surface = true;
        to->surface.span = surface->span;
        scopes_.emplace_back();
        for (const ast::Variable& v : surface->varyings)
            check_varying(v, *surface, to);
        check_stage_body(*surface, &to->surface, StageContext::kSurface, kFloat3Type);
        scopes_.pop_back();
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
    scopes_.emplace_back();
    for (const ast::Variable& v : volume->varyings)
        check_varying(v, *volume, to);
    check_stage_body(*volume, &to->volume, StageContext::kVolume, {Base::kComposition, 1});
    scopes_.pop_back();
    if (dither == nullptr) return call_rule(from, to);
    to->ir.has_dither = true;
    to->dither.span = dither->span;
    scopes_.emplace_back();
    for (const ast::Variable& v : dither->varyings)
        check_varying(v, *dither, to);
    check_stage_body(*dither, &to->dither, StageContext::kDither, kIntType);
    scopes_.pop_back();
}

/// Gives a fablet the stage `@Dither(@varying { DitherAttributes attr }) { return rule(attr); }`.
void Checker::call_rule(const ast::Fablet& from, Fablet* to) {
    if (rule_ == nullptr) return;
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
    result->expr->function = rule_;
    result->expr->args.push_back(std::move(argument));
    to->dither.body = std::make_unique<Stmt>();
    to->dither.body->span = from.span;
    to->dither.body->body.push_back(std::move(result));
}

void Checker::check_stage_body(const ast::Stage& from, Stage* to, StageContext context,
                               const Type& result) {
    context_ = context;
    unknown_names_.clear();
    stage_span_ = from.span;
    return_type_ = result;
    loops_ = 0;
    if (from.body != nullptr) to->body = block(*from.body);
}

void Checker::check_varying(const ast::Variable& v, const ast::Stage& stage, Fablet* to) {
    const Type type = declared_type(v);
    const StageInfo& info = info_of(stage.kind);
    Stage* owner = &(to->*info.stage);
    if (type.is_attributes()) {
        if (!type.is(info.attributes)) {
            sink_->report(v.type.span, diag::kStageMismatch, v.type.text, info.where)
                .note(stage.span, "the stage is declared here")
                .help(fmt::format("here it is `{}`", type_name({info.attributes})));
            return add_stage_symbol(owner, SymbolKind::kAttributes, v, {}, 0);
        }
        return add_stage_symbol(owner, SymbolKind::kAttributes, v, type, 0);
    }
    if (stage.kind == ast::StageKind::kGrow) return check_parent(v, type, to);
    if (!type.is_numeric()) {
        if (!type.is_error()) {
            sink_
                ->report(v.type.span, diag::kBadDeclaration,
                         fmt::format("a varying cannot have type `{}`", type_name(type)))
                .help("a surface carries scalars and vectors");
        }
        return add_stage_symbol(owner, SymbolKind::kLocal, v, {}, 0);
    }
    if (stage.kind == ast::StageKind::kSurface) return check_surface_varying(v, type, to);
    if (stage.kind == ast::StageKind::kVolume) return check_nearest(v, type, to);
    if (stage.kind == ast::StageKind::kShape) return check_shape_varying(v, type, to);
    sink_->report(v.span, diag::kBadDeclaration, "a dither stage has no varyings of its own")
        .note(stage.span, "the stage is declared here")
        .help("a dither rule looks at the voxel's fractions and its index");
    add_stage_symbol(owner, SymbolKind::kLocal, v, {}, 0);
}

ir::Varying Checker::varying(const ast::Variable& v, const Type& type) const {
    ir::Varying out;
    out.name = v.name;
    out.type_name = v.type.text;
    out.type = component_type(type);
    out.components = type.size;
    out.span = v.span;
    return out;
}

void Checker::add_stage_symbol(Stage* stage, SymbolKind kind, const ast::Variable& v,
                               const Type& type, size_t index) {
    auto symbol = std::make_unique<Symbol>();
    symbol->kind = kind;
    symbol->name = v.name;
    symbol->type = type;
    symbol->span = v.span;
    symbol->index = static_cast<int32_t>(index);
    symbol->is_const = v.is_const;
    declare(symbol.get());
    stage->symbols.push_back(std::move(symbol));
}

void Checker::check_surface_varying(const ast::Variable& v, const Type& type, Fablet* to) {
    if (v.nearest) {
        sink_->report(v.span, diag::kStageMismatch, "@nearest", "in a surface stage")
            .note(to->surface.span, "stage declared `@Surface` here")
            .help("the surface stage runs on the surface: leave `@nearest` out");
    }
    if (v.is_in && v.is_out) {
        sink_->report(v.span, diag::kBadDeclaration, "a varying cannot be `inout`")
            .help("declare an input and an `out` of another name");
    }
    if (v.is_out) {
        if (v.init != nullptr) {
            sink_->report(v.init->span, diag::kBadDeclaration,
                          "an output has no default: assign it in the stage");
        }
        add_stage_symbol(&to->surface, SymbolKind::kSurfaceOutput, v, type,
                         to->ir.surface_outputs.size());
        to->ir.surface_outputs.push_back(varying(v, type));
        return;
    }
    auto fallback = std::make_unique<Symbol>();
    fallback->span = v.span;
    fallback->type = type;
    if (v.init != nullptr) {
        context_ = StageContext::kGlobal;
        fallback->init = initializer(*v.init, type);
    }
    check_against_shape(v, type, *to);
    add_stage_symbol(&to->surface, SymbolKind::kSurfaceInput, v, type,
                     to->ir.surface_inputs.size());
    to->ir.surface_inputs.push_back(varying(v, type));
    to->surface_inputs.push_back(std::move(fallback));
}

void Checker::check_nearest(const ast::Variable& v, const Type& type, Fablet* to) {
    if (v.is_out) {
        sink_->report(v.span, diag::kStageMismatch, "out", "varying in a volume stage")
            .note(to->volume.span, "stage declared `@Volume` here")
            .help("the volume stage returns its result, a `MaterialComposition`");
    } else if (!v.nearest) {
        sink_->report(v.span, diag::kMissingNearest, v.name)
            .help(fmt::format("in the volume a varying comes from the nearest surface point: write "
                              "`@nearest {} {}`",
                              v.type.text, v.name));
    }
    if (v.init != nullptr) {
        sink_->report(v.init->span, diag::kBadDeclaration, "a `@nearest` varying has no default")
            .help("give a default to the surface stage's input instead");
    }
    ir::Varying nearest = varying(v, type);
    const std::vector<ir::Varying>& outputs = to->ir.surface_outputs;
    nearest.source = find_varying(outputs, v.name);
    if (nearest.source < 0) nearest.source = find_varying(outputs, std::string(v.name) + "Out");
    if (nearest.source >= 0) {
        const ir::Varying& output = outputs[nearest.source];
        if (output.type != nearest.type || output.components != nearest.components) {
            sink_
                ->report(v.type.span, diag::kVaryingMismatch, v.type.text, v.name, output.type_name,
                         output.name)
                .note(output.span,
                      fmt::format("`out {} {}` is declared here", output.type_name, output.name))
                .help("the outputs of the surface stage are " + varying_list(outputs));
        }
    }
    if (nearest.source < 0) {
        check_against_shape(v, type, *to);
        if (to->ir.has_shape && find_varying(to->ir.shape_outputs, v.name) < 0) {
            diag::Diagnostic& d = sink_->report(
                v.span, diag::kBadDeclaration,
                fmt::format("no stage before this one has `out {} {}`", v.type.text, v.name));
            const bool grows = !to->node.is_error();
            d.note(to->shape.span,
                   grows ? "the rule is declared here" : "the shape is declared here");
            d.help(
                grows
                    ? fmt::format("add `{} {}` to the struct that it returns", v.type.text, v.name)
                : to->ir.shape_outputs.empty()
                    ? fmt::format("add `out {} {}` to the varyings of `@Shape`", v.type.text,
                                  v.name)
                    : "the outputs of the shape stage are " + varying_list(to->ir.shape_outputs));
        }
    }
    add_stage_symbol(&to->volume, SymbolKind::kNearest, v, type, to->ir.nearest.size());
    to->ir.nearest.push_back(std::move(nearest));
}

}  // namespace openfab::check
