// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The attributes of stages, `attr.voxelCenter`: which there are, and help with names that may mean one.
#include <fmt/format.h>

#include <string>

#include "compiler/check/expression_checker.h"
#include "compiler/check/foreign_names.h"

namespace openfab::check {

namespace {

struct AttributeInfo {
    std::string_view name;
    Attribute id;
    Type type;
    unsigned of;  ///< the stages that have it
};
constexpr unsigned kOfSurface = 1, kOfVolume = 2, kOfDither = 4, kOfShape = 8, kOfGrow = 16;
constexpr AttributeInfo kAttributes[] = {
    {"p", Attribute::kP, kFloat3Type, kOfSurface | kOfShape},
    {"n", Attribute::kN, kFloat3Type, kOfSurface},
    {"ng", Attribute::kNg, kFloat3Type, kOfSurface},
    {"uv", Attribute::kUv, {Base::kFloat, 2}, kOfSurface},
    {"dpdu", Attribute::kDpdu, kFloat3Type, kOfSurface},
    {"dpdv", Attribute::kDpdv, kFloat3Type, kOfSurface},
    {"voxelCenter", Attribute::kVoxelCenter, kFloat3Type, kOfVolume},
    {"voxelSize", Attribute::kVoxelSize, kFloat3Type, kOfVolume | kOfDither},
    {"buildPosition", Attribute::kBuildPosition, kFloat3Type, kOfVolume},
    {"instance", Attribute::kInstance, kIntType, kOfSurface | kOfVolume},
    {"voxel", Attribute::kVoxel, {Base::kInt, 3}, kOfDither},
    {"seed", Attribute::kSeed, kUintType, kOfDither},
    {"count", Attribute::kCount, kIntType, kOfDither},
    {"child", Attribute::kChild, kIntType, kOfGrow},
    {"level", Attribute::kLevel, kIntType, kOfGrow},
    {"path", Attribute::kPath, kUintType, kOfGrow},
};

unsigned stage_of(const Type& attributes) {
    if (attributes.is(Base::kSurfaceAttributes)) return kOfSurface;
    if (attributes.is(Base::kShapeAttributes)) return kOfShape;
    if (attributes.is(Base::kGrowAttributes)) return kOfGrow;
    return attributes.is(Base::kVolumeAttributes) ? kOfVolume : kOfDither;
}

}  // namespace

std::vector<StructMember> attribute_members(const Type& attributes) {
    std::vector<StructMember> out;
    for (const AttributeInfo& info : kAttributes) {
        if ((info.of & stage_of(attributes)) != 0)
            out.push_back({std::string(info.name), info.type, {}});
    }
    return out;
}

/// Returns the attributes of the stage or function, or null.
const Symbol* ExpressionChecker::attributes() const {
    for (const Scope& scope : scopes_) {
        for (const auto& [text, symbol] : scope) {
            if (symbol->type.is_attributes()) return symbol;
        }
    }
    return nullptr;
}

/// Returns help for a name of another language, or one that exists only in the surface stage.
std::string ExpressionChecker::help_for_name(std::string_view name) const {
    std::string foreign_help = foreign_name_help(name);
    if (!foreign_help.empty()) return foreign_help;
    for (const AttributeInfo& info : kAttributes) {
        if (info.name != name) continue;
        const Symbol* symbol = attributes();
        if (symbol == nullptr) break;
        if ((info.of & stage_of(symbol->type)) != 0)
            return fmt::format("write `{}.{}`", symbol->name, name);
    }
    if (name == "attr") {
        switch (context_) {
            case StageContext::kVolume:
                return "declare it: `@Volume(@varying { VolumeAttributes attr })`";
            case StageContext::kSurface:
                return "declare it: `@Surface(@varying { SurfaceAttributes attr })`";
            case StageContext::kDither:
                return "declare it: `@Dither(@varying { DitherAttributes attr })`";
            case StageContext::kShape:
                return "declare it: `@Shape(@varying { ShapeAttributes attr })`";
            case StageContext::kGrow:
                return "declare it: `@Grow(@varying { GrowAttributes attr, Node parent })`";
            case StageContext::kGlobal:
            case StageContext::kFunction:
                break;
        }
    }
    if (context_ != StageContext::kVolume) return "";
    for (const auto* list :
         {&fablet_->ir.surface_outputs, &fablet_->ir.surface_inputs, &fablet_->ir.shape_outputs}) {
        for (const ir::Varying& v : *list) {
            if (v.name != name) continue;
            return fmt::format(
                "the {} stage has it: add `@nearest {} {}` to the varyings of this one",
                list != &fablet_->ir.shape_outputs ? "surface"
                : !fablet_->node.is_error()        ? "grow"
                                                   : "shape",
                v.type_name, v.name);
        }
    }
    if (name == "uv")
        return "texture coordinates come from the mesh: add `@nearest float2 uv` to the varyings";
    return "";
}

ExprPtr ExpressionChecker::attribute_member(const ast::Expr& expr, ExprPtr object) {
    const unsigned stage = stage_of(object->type);
    std::vector<std::string> names;
    std::string list;
    for (const AttributeInfo& info : kAttributes) {
        if ((info.of & stage) == 0) continue;
        if (info.name == expr.text) {
            ExprPtr out = make(ExprKind::kAttribute, info.type, expr.span);
            out->attribute = info.id;
            record_use(expr.text_span, StructMember{std::string(info.name), info.type, {}});
            return out;
        }
        names.emplace_back(info.name);
        list += fmt::format("{}`{}`", list.empty() ? "" : ", ", info.name);
    }
    diag::Diagnostic& d =
        sink_->report(expr.text_span, diag::kUnknownMember, type_name(object->type), expr.text);
    if (const std::string help = foreign_attribute_help(expr.text, object->type); !help.empty()) {
        d.help(help);
    } else {
        d.suggest(expr.text_span, expr.text, names, "it has " + list);
    }
    return poison(expr.span);
}

}  // namespace openfab::check
