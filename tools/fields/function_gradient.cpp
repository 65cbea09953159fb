// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Nodes of functions of 3MF that ask how another function changes.

#include <fmt/format.h>

#include "tools/fields/function_text.h"
#include "tools/fields/messages.h"

namespace openfab::tools {

using mesh::ThreemfNode;
using mesh::ThreemfType;

Result<FunctionTexts::Slope> FunctionTexts::slope(Scope* scope, const ThreemfNode& node) {
    const Result<FieldValue> id = input(*scope, node, "functionID");
    if (!id) return id.error();
    const Result<FieldValue> pos = input(*scope, node, "pos");
    if (!pos) return pos.error();
    const Result<FieldValue> step = input(*scope, node, "step");
    if (!step) return step.error();
    if (id->type != ThreemfType::kResource || pos->type != ThreemfType::kVector ||
        step->type != ThreemfType::kScalar)
        return error(place(*scope, &node), messages::kWantsResourceVectorScalar);
    const Result<Made> made = make({std::stoll(id->text), node.of_output, {}});
    if (!made) return made.error();
    if (made->type != ThreemfType::kScalar)
        return error(place(*scope, &node), messages::kGradientOfNoScalar);
    std::string list;
    for (const char* axis : {"h, 0, 0", "0, h, 0", "0, 0, h"})
        list += fmt::format("{}{}(p + float3({})) - {}(p - float3({}))", list.empty() ? "" : ", ",
                            made->name, axis, made->name, axis);
    const std::string name = unique(made->name + "_gradient");
    texts_.push_back(fmt::format(
        "    // How it changes, by differences over 2 h.\n    float3 {}(float3 p, float step)\n    "
        "{{\n"
        "        float h = max(abs(step), 1e-8);\n        return float3({}) / (2 * h);\n    }}\n",
        name, list));
    return Slope{fmt::format("{}({})", made->name, pos->text),
                 fmt::format("{}({}, {})", name, pos->text, step->text)};
}

Result<FieldValue> FunctionTexts::gradient(Scope* scope, const ThreemfNode& node,
                                           const std::string& output) {
    const Result<Slope> of = slope(scope, node);
    if (!of) return of.error();
    if (output == "magnitude")
        return FieldValue{"length(" + of->gradient + ")", ThreemfType::kScalar};
    if (output == "gradient") return FieldValue{of->gradient, ThreemfType::kVector};
    return FieldValue{"normalize(" + of->gradient + ")", ThreemfType::kVector};
}

/// A value over how fast it changes: near the surface a distance.
Result<FieldValue> FunctionTexts::normalized(Scope* scope, const ThreemfNode& node) {
    const Result<Slope> of = slope(scope, node);
    if (!of) return of.error();
    return FieldValue{fmt::format("{} / max(length({}), 1e-8)", of->value, of->gradient),
                      ThreemfType::kScalar};
}

}  // namespace openfab::tools
