// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fields/node_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "mesh/read/threemf_text.h"
#include "tools/fields/messages.h"

namespace openfab::tools {

namespace {

using mesh::ThreemfType;

/// In the order of the specification (Part II, chapter 5). Where an operation is not defined for matrices in
/// OpenFL, node_text writes it for each row.
constexpr NodeKind kKinds[] = {
    {"addition", "A B", "**", "{0} + {1}"},
    {"subtraction", "A B", "**", "{0} - {1}"},
    {"multiplication", "A B", "**", "{0} * {1}"},
    {"division", "A B", "**", "{0} / {1}"},
    {"composevector", "x y z", "sss", "float3({0}, {1}, {2})", 'v'},
    {"vectorfromscalar", "A", "s", "float3({0}, {0}, {0})", 'v'},
    {"composematrix", "m00 m01 m02 m03 m10 m11 m12 m13 m20 m21 m22 m23 m30 m31 m32 m33",
     "ssssssssssssssss",
     "float4x4({0}, {1}, {2}, {3}, {4}, {5}, {6}, {7}, {8}, {9}, {10}, {11}, {12}, {13}, {14}, "
     "{15})",
     'm'},
    {"matrixfromcolumns", "A B C D", "vvvv",
     "float4x4({0}.x, {1}.x, {2}.x, {3}.x, {0}.y, {1}.y, {2}.y, {3}.y, {0}.z, {1}.z, {2}.z, "
     "{3}.z, 0, 0, 0, 1)",
     'm'},
    {"matrixfromrows", "A B C D", "vvvv",
     "float4x4({0}.x, {0}.y, {0}.z, 0, {1}.x, {1}.y, {1}.z, 0, {2}.x, {2}.y, {2}.z, 0, {3}.x, "
     "{3}.y, {3}.z, 1)",
     'm'},
    {"dot", "A B", "vv", "dot({0}, {1})", 's'},
    {"cross", "A B", "vv", "cross({0}, {1})", 'v'},
    {"matvecmultiplication matrixvectormultiplication", "A B", "mv", "mul({0}, float4({1}, 1)).xyz",
     'v'},
    {"transpose", "A", "m", "transpose({0})", 'm'},
    {"inverse", "A", "m", "inverse({0})", 'm'},
    {"sin", "A", "*", "sin({0})"},
    {"cos", "A", "*", "cos({0})"},
    {"tan", "A", "*", "tan({0})"},
    {"arcsin asin", "A", "*", "asin({0})"},
    {"arccos acos", "A", "*", "acos({0})"},
    {"arctan atan", "A", "*", "atan({0})"},
    {"arctan2 atan2", "A B", "**", "atan2({0}, {1})"},
    {"min", "A B", "**", "min({0}, {1})"},
    {"max", "A B", "**", "max({0}, {1})"},
    {"abs", "A", "*", "abs({0})"},
    {"fmod", "A B", "**", "fmod({0}, {1})"},
    {"mod", "A B", "**", "{0} - {1} * floor({0} / {1})"},
    {"pow", "A B", "**", "pow({0}, {1})"},
    {"sqrt", "A", "*", "sqrt({0})"},
    {"exp", "A", "*", "exp({0})"},
    {"log", "A", "*", "log({0})"},
    {"log2", "A", "*", "log2({0})"},
    {"log10", "A", "*", "log10({0})"},
    {"select", "A B C D", "****", "select({0} < {1}, {2}, {3})"},
    {"clamp", "A min max", "***", "max({1}, min({0}, {2}))"},
    {"cosh", "A", "*", "cosh({0})"},
    {"sinh", "A", "*", "sinh({0})"},
    {"tanh", "A", "*", "tanh({0})"},
    {"round", "A", "*", "round({0})"},
    {"ceil", "A", "*", "ceil({0})"},
    {"floor", "A", "*", "floor({0})"},
    {"sign", "A", "*", "sign({0})"},
    {"fract", "A", "*", "frac({0})"},
    {"length", "A", "v", "length({0})", 's'},
};

/// Of two operands OpenFL knows these of matrices, too.
bool takes_matrices(std::string_view text) {
    return text.size() == 9 && text.starts_with("{0} ");
}

ThreemfType type_of(char letter) {
    return letter == 's'   ? ThreemfType::kScalar
           : letter == 'v' ? ThreemfType::kVector
                           : ThreemfType::kMatrix;
}

/// Puts the inputs into a text.
std::string filled(std::string_view text, const std::vector<FieldValue>& inputs,
                   const std::string& behind = {}) {
    std::string out;
    for (size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '{') {
            out += text[i];
            continue;
        }
        const size_t end = text.find('}', i);
        size_t number = 0;
        for (const char c : text.substr(i + 1, end - i - 1))
            number = 10 * number + static_cast<size_t>(c - '0');
        out += inputs[number].text + behind;
        i = end;
    }
    return out;
}

}  // namespace

std::string_view openfl_type(ThreemfType type) {
    switch (type) {
        case ThreemfType::kScalar:
            return "float";
        case ThreemfType::kVector:
            return "float3";
        case ThreemfType::kMatrix:
            return "float4x4";
        case ThreemfType::kResource:
            break;
    }
    return "int";
}

std::string_view name_of(ThreemfType type) {
    switch (type) {
        case ThreemfType::kScalar:
            return messages::kAScalar;
        case ThreemfType::kVector:
            return messages::kAVector;
        case ThreemfType::kMatrix:
            return messages::kAMatrix;
        case ThreemfType::kResource:
            break;
    }
    return messages::kAResource;
}

std::string float_text(double value) {
    const auto number = static_cast<float>(value);
    if (!std::isfinite(number)) return {};
    return fmt::format("{}", number == 0 ? 0.0f : number);
}

const NodeKind* find_node_kind(std::string_view name) {
    for (const NodeKind& kind : kKinds) {
        const std::vector<std::string_view> names = mesh::threemf_words(kind.names);
        if (std::ranges::find(names, name) != names.end()) return &kind;
    }
    return nullptr;
}

std::vector<std::string> node_kinds() {
    std::vector<std::string> all{"constant",         "constvec",         "constmat",
                                 "constresourceid",  "functioncall",     "mesh",
                                 "unsignedmesh",     "decomposevector",  "beamlattice",
                                 "functiongradient", "normalizedistance"};
    for (const NodeKind& kind : kKinds)
        all.emplace_back(mesh::threemf_words(kind.names)[0]);
    return all;
}

Complaint node_text(const NodeKind& kind, const std::vector<FieldValue>& inputs, FieldValue* out) {
    const std::vector<std::string_view> names = mesh::threemf_words(kind.inputs);
    const FieldValue* any = nullptr;
    for (size_t i = 0; i < inputs.size(); ++i) {
        const char wanted = kind.types[i];
        if (inputs[i].type == ThreemfType::kResource)
            return fmt::format(messages::kInputIsResource, names[i]);
        if (wanted == '*') {
            // A scalar goes with a vector, which the specification does not ask for.
            const bool mixed = any != nullptr && any->type != inputs[i].type;
            if (mixed &&
                (any->type == ThreemfType::kMatrix || inputs[i].type == ThreemfType::kMatrix))
                return fmt::format(messages::kInputAndAnother, names[i], name_of(inputs[i].type),
                                   name_of(any->type));
            if (any == nullptr || any->type == ThreemfType::kScalar) any = &inputs[i];
        } else if (inputs[i].type != type_of(wanted)) {
            return fmt::format(messages::kInputInstead, names[i], name_of(inputs[i].type),
                               name_of(type_of(wanted)));
        }
    }
    out->type = kind.result == '*' ? any->type : type_of(kind.result);
    const bool rows =
        any != nullptr && any->type == ThreemfType::kMatrix && !takes_matrices(kind.text);
    if (!rows) {
        out->text = filled(kind.text, inputs);
        return {};
    }
    std::string text;
    for (const char* row : {"[0]", "[1]", "[2]", "[3]"})
        text += (text.empty() ? "" : ", ") + filled(kind.text, inputs, row);
    out->text = fmt::format("float4x4({})", text);
    return {};
}

Complaint constant_text(const mesh::ThreemfNode& node, FieldValue* out) {
    std::string list;
    for (const double value : node.numbers) {
        const std::string text = float_text(value);
        if (text.empty()) return fmt::format(messages::kBeyondSinglePrecision, value);
        list += (list.empty() ? "" : ", ") + text;
    }
    constexpr size_t kVector = 3;
    out->type = node.numbers.size() == 1         ? ThreemfType::kScalar
                : node.numbers.size() == kVector ? ThreemfType::kVector
                                                 : ThreemfType::kMatrix;
    out->text =
        node.numbers.size() == 1 ? list : fmt::format("{}({})", openfl_type(out->type), list);
    return {};
}

}  // namespace openfab::tools
