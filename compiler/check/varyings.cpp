// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Inputs and outputs of stages. What other stages read of a shape are the outputs of its stage, or the members of a node.
#include "compiler/check/varyings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace openfab::check {

namespace {

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

ir::Varying varying(const ast::Variable& v, const Type& type) {
    ir::Varying out;
    out.name = v.name;
    out.type_name = v.type.text;
    out.type = component_type(type);
    out.components = type.size;
    out.span = v.span;
    return out;
}

}  // namespace

void Varyings::check(const ast::Variable& v, const ast::Stage& stage, Fablet* to) {
    const Type type = expressions_.types().declared_type(v);
    const StageInfo& info = info_of(stage.kind);
    Stage* owner = &(to->*info.stage);
    if (type.is_attributes()) {
        if (!type.is(info.attributes)) {
            sink_->report(v.type.span, diag::kStageMismatch, v.type.text, info.where)
                .note(stage.span, "the stage is declared here")
                .help(fmt::format("here it is `{}`", type_name({info.attributes})));
            return add(owner, SymbolKind::kAttributes, v, {}, 0);
        }
        return add(owner, SymbolKind::kAttributes, v, type, 0);
    }
    if (stage.kind == ast::StageKind::kGrow) return parent(v, type, to);
    if (!type.is_numeric()) {
        if (!type.is_error()) {
            sink_
                ->report(v.type.span, diag::kBadDeclaration,
                         fmt::format("a varying cannot have type `{}`", type_name(type)))
                .help("a surface carries scalars and vectors");
        }
        return add(owner, SymbolKind::kLocal, v, {}, 0);
    }
    if (stage.kind == ast::StageKind::kSurface) return of_surface(v, type, to);
    if (stage.kind == ast::StageKind::kVolume) return nearest(v, type, to);
    if (stage.kind == ast::StageKind::kShape) return of_shape(v, type, to);
    sink_->report(v.span, diag::kBadDeclaration, "a dither stage has no varyings of its own")
        .note(stage.span, "the stage is declared here")
        .help("a dither rule looks at the voxel's fractions and its index");
    add(owner, SymbolKind::kLocal, v, {}, 0);
}

void Varyings::add(Stage* stage, SymbolKind kind, const ast::Variable& v, const Type& type,
                   size_t index) {
    auto symbol = std::make_unique<Symbol>();
    symbol->kind = kind;
    symbol->name = v.name;
    symbol->type = type;
    symbol->span = v.span;
    symbol->index = static_cast<int32_t>(index);
    symbol->is_const = v.is_const;
    names_.declare(symbol.get());
    stage->symbols.push_back(std::move(symbol));
}

void Varyings::of_surface(const ast::Variable& v, const Type& type, Fablet* to) {
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
        add(&to->surface, SymbolKind::kSurfaceOutput, v, type, to->ir.surface_outputs.size());
        to->ir.surface_outputs.push_back(varying(v, type));
        return;
    }
    auto fallback = std::make_unique<Symbol>();
    fallback->span = v.span;
    fallback->type = type;
    if (v.init != nullptr) {
        place_.context = StageContext::kGlobal;
        fallback->init = expressions_.initializers().of(*v.init, type);
    }
    check_against_shape(v, type, *to);
    add(&to->surface, SymbolKind::kSurfaceInput, v, type, to->ir.surface_inputs.size());
    to->ir.surface_inputs.push_back(varying(v, type));
    to->surface_inputs.push_back(std::move(fallback));
}

void Varyings::nearest(const ast::Variable& v, const Type& type, Fablet* to) {
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
    add(&to->volume, SymbolKind::kNearest, v, type, to->ir.nearest.size());
    to->ir.nearest.push_back(std::move(nearest));
}

void Varyings::of_shape(const ast::Variable& v, const Type& type, Fablet* to) {
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
    add(&to->shape, SymbolKind::kShapeOutput, v, type, to->ir.shape_outputs.size());
    to->ir.shape_outputs.push_back(varying(v, type));
}

/// Compares an input of another stage with the output of the shape that it reads.
void Varyings::check_against_shape(const ast::Variable& v, const Type& type, const Fablet& to) {
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

/// Takes the varying whose type is the struct.
void Varyings::parent(const ast::Variable& v, const Type& type, Fablet* to) {
    if (type.is(Base::kStruct) && to->node.is_error() && !v.is_out && !v.nearest) {
        to->node = type;
        add(&to->shape, SymbolKind::kGrowParent, v, type, 0);
        for (const StructMember& member : type.record->members) {
            ir::Varying& output = to->ir.shape_outputs.emplace_back();
            output.name = member.name;
            output.type_name = type_name(member.type);
            output.span = member.span;
            Type element = member.type;
            while (element.is_array())
                element = element.element();
            if (!element.is_arithmetic()) {
                if (element.is_error()) continue;
                sink_
                    ->report(
                        member.span, diag::kBadDeclaration,
                        fmt::format("a node cannot hold `{} {}`", output.type_name, member.name))
                    .note(v.span, "it is the node of a grow stage here")
                    .help("its members are numbers, vectors, matrices and arrays of them");
                continue;
            }
            output.type = component_type(element);
            output.components = static_cast<int32_t>(min_components(member.type));
        }
        return;
    }
    if (!type.is_error()) {
        diag::Diagnostic& d =
            sink_->report(v.span, diag::kBadDeclaration,
                          type.is(Base::kStruct) && !to->node.is_error()
                              ? "a grow stage has one node to grow from"
                          : v.is_out ? "a grow stage has no outputs of its own"
                                     : fmt::format("a grow stage reads no `{}`", type_name(type)));
        d.note(to->shape.span, "stage declared `@Grow` here");
        d.help(
            "it reads its parent, a struct, and returns a node of the same: what it says more is "
            "a member of the struct");
    }
    add(&to->shape, SymbolKind::kLocal, v, {}, 0);
}

}  // namespace openfab::check
