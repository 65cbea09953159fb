// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The struct that a grow stage returns. Members with certain names say what a node is and how far it grows; other stages
// read the rest as attributes.
#include "compiler/check/grow_node.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

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

/// Checks the members that mean something.
void check_node(const ast::Stage& from, const Fablet& to, diag::Sink* sink) {
    const StructType& node = *to.node.record;
    const bool places =
        std::ranges::find(node.members, "object", &StructMember::name) != node.members.end();
    for (const Role& role : kRoles) {
        const auto member = std::ranges::find(node.members, role.name, &StructMember::name);
        // Without objects these are the rule's own.
        if (role.name == "axes" && !places) continue;
        if (member == node.members.end()) {
            if (may_be_missing(role, node)) continue;
            sink->report(node.span, diag::kBadDeclaration,
                         fmt::format("`{}` is a node without `{}`", node.name, role.name))
                .note(from.span, "it grows here")
                .help(fmt::format("add {}: {}", role.types, role.what));
            if (role.name == "reach") return;  // and no box either
        } else if (!role.fits(member->type) && !member->type.is_error()) {
            sink->report(member->span, diag::kBadDeclaration,
                         fmt::format("`{}` of a node is {}, and this is `{}`", role.name,
                                     role.types, type_name(member->type)))
                .note(from.span, "the stage that returns it is declared here")
                .help(fmt::format("it is {}", role.what));
        }
    }
    if (places && to.ir.object_count == 0) {
        const auto member = std::ranges::find(node.members, "object", &StructMember::name);
        sink->report(member->span, diag::kBadDeclaration,
                     "`object` of a node is the number of an `Object` uniform, and the fablet has "
                     "none")
            .note(from.span, "it grows here")
            .help("declare `@uniform { Object leaf; }`, which the world binds to an object");
    }
}

}  // namespace openfab::check
