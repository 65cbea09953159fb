// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The grow stage: a rule that makes a node, a struct, of the node that it grows from. Members with certain names say
// what the node is and how far it grows; other stages read the rest as attributes.

#include <fmt/format.h>

#include <algorithm>

#include "compiler/check/checker.h"

namespace openfab::check {

namespace {

/// A member that means something to the printer.
struct Role {
    std::string_view name;
    std::string_view types;  ///< as in a message
    bool (*fits)(const Type& type);
    const char* what;
};

const Type kEnds = array_of(kFloat3Type, 2);

constexpr Role kRoles[] = {
    {"end", "`float3 end[2]`", [](const Type& t) { return t == kEnds; },
     "the middle of the balls at the beam's ends, in mm"},
    {"radius", "`float radius`, or `float radius[2]`",
     [](const Type& t) { return t == kFloatType || t == array_of(kFloatType, 2); },
     "the radius of the beam in mm, 0 for a node that is nothing itself"},
    {"children", "`int children`", [](const Type& t) { return t == kIntType; },
     "how many nodes grow of this one"},
    {"reach", "`float reach`", [](const Type& t) { return t == kFloatType; },
     "how far, in mm, anything that grows of it gets from its beam"},
    {"box", "`float3 box[2]`", [](const Type& t) { return t == kEnds; },
     "two corners of a box that holds all that grows of it"},
    {"flat", "`int flat`, or `bool flat`",
     [](const Type& t) { return t == kIntType || t == kBoolType; },
     "whether the beam is cut flat at its ends"},
    {"object", "`int object`", [](const Type& t) { return t == kIntType; },
     "the number, from 1, of the `Object` uniform that stands at `end[0]`, 0 for none"},
    {"axes", "`float3 axes[3]`", [](const Type& t) { return t == array_of(kFloat3Type, 3); },
     "where x, y and z of the object that stands there point, their lengths its scale"},
};

bool may_be_missing(const Role& role, const StructType& node) {
    const auto has = [&](std::string_view name) {
        return std::ranges::find(node.members, name, &StructMember::name) != node.members.end();
    };
    if (role.name == "reach" || role.name == "box") return has("reach") || has("box");
    return role.name == "flat" || role.name == "object" || role.name == "axes";
}

}  // namespace

void Checker::check_grow(const ast::Stage& from, const ast::Stage* shape, Fablet* to) {
    if (shape != nullptr) {
        sink_->report(from.span, diag::kBadDeclaration, "a fablet is one solid")
            .note(shape->span, "which is declared here")
            .help("write a fablet for each: an object may have the solid of another fablet");
        return;
    }
    to->ir.has_shape = true;
    to->shape.span = from.span;
    scopes_.emplace_back();
    size_t nodes = 0;
    for (const ast::Variable& v : from.varyings) {
        check_varying(v, from, to);
        nodes += find_type(v.type.text).is_attributes() ? 0 : 1;
    }
    if (to->node.is_error() && nodes == 0) {
        sink_->report(from.span, diag::kBadDeclaration, "a grow stage has no node to grow from")
            .help(
                "write `@Grow(@varying { GrowAttributes attr, Node parent })`, of a struct `Node`");
    }
    if (!to->node.is_error()) {
        check_node(from, *to);
        check_stage_body(from, &to->shape, StageContext::kGrow, to->node);
    }
    scopes_.pop_back();
}

/// Takes the varying whose type is the struct.
void Checker::check_parent(const ast::Variable& v, const Type& type, Fablet* to) {
    if (type.is(Base::kStruct) && to->node.is_error() && !v.is_out && !v.nearest) {
        to->node = type;
        add_stage_symbol(&to->shape, SymbolKind::kGrowParent, v, type, 0);
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
    add_stage_symbol(&to->shape, SymbolKind::kLocal, v, {}, 0);
}

/// Checks the members that mean something.
void Checker::check_node(const ast::Stage& from, const Fablet& to) {
    const StructType& node = *to.node.record;
    const bool places =
        std::ranges::find(node.members, "object", &StructMember::name) != node.members.end();
    for (const Role& role : kRoles) {
        const auto member = std::ranges::find(node.members, role.name, &StructMember::name);
        // Without objects these are the rule's own.
        if (role.name == "axes" && !places) continue;
        if (member == node.members.end()) {
            if (may_be_missing(role, node)) continue;
            sink_
                ->report(node.span, diag::kBadDeclaration,
                         fmt::format("`{}` is a node without `{}`", node.name, role.name))
                .note(from.span, "it grows here")
                .help(fmt::format("add {}: {}", role.types, role.what));
            if (role.name == "reach") return;  // and no box either
        } else if (!role.fits(member->type) && !member->type.is_error()) {
            sink_
                ->report(member->span, diag::kBadDeclaration,
                         fmt::format("`{}` of a node is {}, and this is `{}`", role.name,
                                     role.types, type_name(member->type)))
                .note(from.span, "the stage that returns it is declared here")
                .help(fmt::format("it is {}", role.what));
        }
    }
    if (places && to.ir.object_count == 0) {
        const auto member = std::ranges::find(node.members, "object", &StructMember::name);
        sink_
            ->report(member->span, diag::kBadDeclaration,
                     "`object` of a node is the number of an `Object` uniform, and the fablet has "
                     "none")
            .note(from.span, "it grows here")
            .help("declare `@uniform { Object leaf; }`, which the world binds to an object");
    }
}

}  // namespace openfab::check
