// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fields/function_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/near_miss.h"
#include "base/text.h"
#include "mesh/read/threemf_text.h"
#include "tools/fields/messages.h"

namespace openfab::tools {

namespace {

using mesh::ThreemfFunction;
using mesh::ThreemfNode;
using mesh::ThreemfPort;
using mesh::ThreemfType;

constexpr size_t kDeepest = 64;          ///< calls within calls
constexpr size_t kLongest = 16'000'000;  ///< text, bytes
constexpr const char* kCall = "functioncall";

/// "NODE.OUTPUT" in two.
std::pair<std::string, std::string> parts_of(const std::string& from) {
    const size_t dot = from.find('.');
    if (dot == std::string::npos) return {from, ""};
    return {from.substr(0, dot), from.substr(dot + 1)};
}

const ThreemfPort* find_port(const std::vector<ThreemfPort>& ports, std::string_view name) {
    for (const ThreemfPort& port : ports) {
        if (port.name == name) return &port;
    }
    // Programs differ in the case of `functionID`.
    for (const ThreemfPort& port : ports) {
        if (lower_ascii(port.name) == lower_ascii(std::string(name))) return &port;
    }
    return nullptr;
}

bool has_named_outputs(const ThreemfNode& node) {
    return node.kind == "decomposevector" || node.kind == kCall || node.kind == "functiongradient";
}

/// The inputs that a node's text is made of, those that are given.
std::vector<const ThreemfPort*> ports_of(const ThreemfNode& node) {
    std::vector<const ThreemfPort*> out;
    const auto add = [&](std::string_view name) {
        const ThreemfPort* port = find_port(node.inputs, name);
        if (port != nullptr && !port->from.empty()) out.push_back(port);
    };
    if (const NodeKind* kind = find_node_kind(node.kind)) {
        for (const std::string_view name : mesh::threemf_words(kind->inputs))
            add(name);
    } else if (node.kind == "decomposevector") {
        add("A");
    } else {
        for (const ThreemfPort& port : node.inputs) {
            if (!port.from.empty()) out.push_back(&port);
        }
    }
    return out;
}

}  // namespace

std::string FunctionTexts::shown(std::string_view name) {
    return std::string(name.substr(0, 80));
}

std::string openfl_name(std::string_view name) {
    std::string out;
    for (const char c : name.substr(0, 60)) {
        const bool plain =
            (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
        out += plain ? c : '_';
    }
    // Names that begin with _ are a module's own.
    if (out.empty() || out[0] == '_' || (out[0] >= '0' && out[0] <= '9')) out = "f" + out;
    return out;
}

std::string mapped_text(const Affine3d& map, const std::string& point) {
    if (map == Affine3d{}) return point;
    const auto vector = [](const Vec3d& v) {
        return fmt::format("float3({}, {}, {})", float_text(v.x), float_text(v.y), float_text(v.z));
    };
    const Affine3d unmoved{map.m, {}};
    std::string text = point;
    if (!(unmoved == Affine3d{})) {
        const double s = map.m[0];
        const Affine3d even{{s, 0, 0, 0, s, 0, 0, 0, s}, {}};
        std::string list;
        for (const double value : map.m)
            list += (list.empty() ? "" : ", ") + float_text(value);
        text = unmoved == even ? fmt::format("{} * {}", point, float_text(s))
                               : fmt::format("mul(float3x3({}), {})", list, point);
    }
    if (map.t == Vec3d{}) return text;
    return fmt::format("{} + {}", text, vector(map.t));
}

Error FunctionTexts::error(const std::string& place, const std::string& what,
                           const std::string& help) const {
    return user_error(fmt::format("{}: {}: {}", file_, place, what), help);
}

std::string FunctionTexts::place(int64_t function) const {
    const auto it = model_.fields.functions.find(function);
    if (it == model_.fields.functions.end() || it->second.name.empty())
        return fmt::format(messages::kTheFunction, function);
    return fmt::format(messages::kTheNamedFunction, function, shown(it->second.name));
}

std::string FunctionTexts::place(const Scope& scope, const ThreemfNode* node) const {
    const std::string function = place(scope.key->function);
    return node == nullptr ? function
                           : fmt::format(messages::kTheNode, function, shown(node->name));
}

std::string FunctionTexts::unique(const std::string& wanted) {
    std::string name = wanted;
    for (int i = 2; !names_.insert(name).second; ++i)
        name = fmt::format("{}_{}", wanted, i);
    return name;
}

Result<std::string> FunctionTexts::at(const mesh::ThreemfField& field, const std::string& point,
                                      ThreemfType type, const std::string& whose) {
    const auto it = model_.fields.functions.find(field.function);
    if (it == model_.fields.functions.end())
        return error(whose, fmt::format(messages::kNoSuchFunction, field.function));
    if (it->second.image < 0) {
        for (const ThreemfPort& port : it->second.inputs) {
            if (port.type == ThreemfType::kVector && it->second.inputs.size() == 1) continue;
            if (port.name != "pos" || port.type != ThreemfType::kVector)
                return error(place(field.function),
                             fmt::format(messages::kCalledWithPoint, whose, shown(port.name)),
                             messages::kCalledWithPointHelp);
        }
    }
    const Result<Made> made = make({field.function, field.channel, {}});
    if (!made) return made.error();
    if (made->type != type)
        return error(place(field.function),
                     fmt::format(messages::kOutputIsAndWants, shown(field.channel),
                                 name_of(made->type), whose, name_of(type)));
    const bool asks = it->second.image >= 0 || !it->second.inputs.empty();
    return fmt::format("{}({})", made->name, asks ? mapped_text(field.transform, point) : "");
}

Result<FunctionTexts::Made> FunctionTexts::make(const Key& key) {
    const auto function = model_.fields.functions.find(key.function);
    if (function == model_.fields.functions.end())
        return error(open_.empty() ? file_ : place(open_.back()),
                     fmt::format(messages::kCallsNoFunction, key.function));
    const auto [it, fresh] = made_.try_emplace(key);
    if (!fresh && !it->second.name.empty()) return it->second;
    if (!fresh || open_.size() >= kDeepest) {
        std::string chain;
        const size_t from = open_.size() > 8 ? open_.size() - 8 : 0;
        for (size_t i = from; i < open_.size(); ++i)
            chain += fmt::format("{} -> ", open_[i]);
        return error(place(key.function),
                     fresh ? fmt::format(messages::kCallsTooDeep, kDeepest)
                           : fmt::format(messages::kCallsItself, chain, key.function),
                     messages::kCallsItselfHelp);
    }
    open_.push_back(key.function);
    Result<Made> made = function->second.image >= 0 ? make_image(key, function->second)
                                                    : make_graph(key, function->second);
    open_.pop_back();
    if (!made) return made;
    return made_[key] = *made;
}

Result<std::vector<std::pair<size_t, std::string>>> FunctionTexts::order(const Scope& scope,
                                                                         const std::string& from) {
    // Depth first without recursion: a chain of nodes may be as long as the file.
    using Item = std::pair<size_t, std::string>;
    struct Step {
        Item item;
        std::vector<const ThreemfPort*> ports;
        size_t next = 0;
    };
    std::vector<Item> out;
    std::map<Item, bool> done;  // false: open
    std::vector<Step> stack;
    const auto enter = [&](const std::string& reference, const ThreemfNode* by) -> Result<void> {
        const auto [name, output] = parts_of(reference);
        if (name == "inputs") return {};
        const auto it = scope.nodes.find(name);
        if (it == scope.nodes.end()) {
            std::vector<std::string> names;
            for (const auto& [known, index] : scope.nodes)
                names.push_back(known);
            return error(place(scope, by),
                         fmt::format(messages::kNoSuchNode, shown(reference), shown(name)),
                         suggest(shown(name), names));
        }
        const ThreemfNode& node = scope.function->nodes[it->second];
        const Item item{it->second, has_named_outputs(node) ? output : ""};
        const auto [state, fresh] = done.try_emplace(item, false);
        if (fresh) {
            stack.push_back({item, ports_of(node), 0});
            return {};
        }
        if (state->second) return {};
        std::string ring;
        for (const Step& step : stack) {
            if (!ring.empty() || step.item == item)
                ring += scope.function->nodes[step.item.first].name.substr(0, 80) + " <- ";
            if (ring.size() > 400) break;
        }
        return error(place(scope, &node),
                     fmt::format(messages::kDependsOnItself, ring, shown(node.name)),
                     messages::kDependsOnItselfHelp);
    };
    if (Result<void> entered = enter(from, nullptr); !entered) return entered.error();
    while (!stack.empty()) {
        Step& top = stack.back();
        if (top.next < top.ports.size()) {
            const ThreemfPort* port = top.ports[top.next++];
            const ThreemfNode& node = scope.function->nodes[top.item.first];
            if (Result<void> entered = enter(port->from, &node); !entered) return entered.error();
            continue;
        }
        done[top.item] = true;
        out.push_back(top.item);
        stack.pop_back();
    }
    return out;
}

Result<FunctionTexts::Made> FunctionTexts::make_graph(const Key& key,
                                                      const ThreemfFunction& function) {
    Scope scope;
    scope.key = &key;
    scope.function = &function;
    const ThreemfPort* out = find_port(function.outputs, key.output);
    if (out == nullptr) {
        std::vector<std::string> names;
        for (const ThreemfPort& port : function.outputs)
            names.push_back(port.name);
        return error(place(key.function), fmt::format(messages::kNoOutput, shown(key.output)),
                     suggest(shown(key.output), names));
    }
    if (out->from.empty())
        return error(place(key.function),
                     fmt::format(messages::kOutputRefersToNothing, shown(out->name)));
    for (size_t i = 0; i < function.nodes.size(); ++i) {
        if (function.nodes[i].name.empty())
            return error(place(key.function), messages::kNodeWithoutIdentifier);
        if (!scope.nodes.emplace(function.nodes[i].name, i).second)
            return error(place(key.function),
                         fmt::format(messages::kTwoNodesOfName, shown(function.nodes[i].name)));
    }
    std::string parameters;
    for (const ThreemfPort& port : function.inputs) {
        FieldValue value{"", port.type};
        if (port.type == ThreemfType::kResource) {
            const auto bound = key.resources.find(port.name);
            if (bound == key.resources.end()) continue;
            value.text = fmt::format("{}", bound->second);
        } else {
            value.text = openfl_name(port.name) + "_in";
            for (int k = 2; !scope.taken.insert(value.text).second; ++k)
                value.text = fmt::format("{}_in{}", openfl_name(port.name), k);
            parameters += fmt::format("{}{} {}", parameters.empty() ? "" : ", ",
                                      openfl_type(port.type), value.text);
        }
        scope.inputs[port.name] = value;
    }
    const Result<std::vector<std::pair<size_t, std::string>>> nodes = order(scope, out->from);
    if (!nodes) return nodes.error();
    for (const auto& [node, output] : *nodes) {
        if (Result<void> written = write(&scope, node, output); !written) return written.error();
    }
    const ThreemfNode none;
    const Result<FieldValue> value = value_of(scope, none, *out);
    if (!value) return value.error();
    const bool spreads = value->type == ThreemfType::kScalar && out->type == ThreemfType::kVector;
    if (value->type != out->type && !spreads)
        return error(place(key.function), fmt::format(messages::kOutputIsGiven, shown(out->name),
                                                      name_of(out->type), name_of(value->type)));
    const std::string plain = openfl_name(function.name.empty() ? "function" : function.name);
    const Made made{unique(fmt::format("{}_{}_{}", plain, key.function, openfl_name(out->name))),
                    out->type};
    std::string title = fmt::format("    // {}, `{}`.", place(key.function), shown(out->name));
    title[7] = 'F';
    texts_.push_back(fmt::format("{}\n    {} {}({})\n    {{\n{}        return {};\n    }}\n",
                                 printable(title), openfl_type(out->type), made.name, parameters,
                                 scope.lines, value->text));
    length_ += texts_.back().size();
    if (length_ > kLongest)
        return error(place(key.function),
                     fmt::format(messages::kTextTooLong, kLongest / 1'000'000));
    return made;
}

Result<void> FunctionTexts::write(Scope* scope, size_t index, const std::string& output) {
    const ThreemfNode& node = scope->function->nodes[index];
    Result<FieldValue> value = node_value(scope, node, output);
    if (!value) return value.error();
    if (value->type != ThreemfType::kResource) {
        std::string wanted = openfl_name(node.name) + "_";
        wanted += output.empty() ? "v" : openfl_name(output);
        std::string name = wanted;
        for (int k = 2; !scope->taken.insert(name).second; ++k)
            name = fmt::format("{}{}", wanted, k);
        scope->lines +=
            fmt::format("        {} {} = {};\n", openfl_type(value->type), name, value->text);
        value->text = name;
    }
    scope->values[node.name + "." + output] = std::move(*value);
    return {};
}

Result<FieldValue> FunctionTexts::value_of(const Scope& scope, const ThreemfNode& node,
                                           const ThreemfPort& port) {
    const auto [name, output] = parts_of(port.from);
    if (name == "inputs") {
        const auto it = scope.inputs.find(output);
        if (it != scope.inputs.end()) return it->second;
        std::vector<std::string> names;
        for (const auto& [known, value] : scope.inputs)
            names.push_back(known);
        return error(place(scope, node.name.empty() ? nullptr : &node),
                     fmt::format(messages::kNoInput, shown(port.from), shown(output)),
                     suggest(shown(output), names));
    }
    const ThreemfNode& from = scope.function->nodes[scope.nodes.at(name)];
    return scope.values.at(name + "." + (has_named_outputs(from) ? output : ""));
}

Result<FieldValue> FunctionTexts::input(const Scope& scope, const ThreemfNode& node,
                                        std::string_view name) {
    const ThreemfPort* port = find_port(node.inputs, name);
    if (port == nullptr || port->from.empty())
        return error(place(scope, &node),
                     fmt::format(messages::kNodeNeedsInput, shown(node.kind), name));
    return value_of(scope, node, *port);
}

Result<FieldValue> FunctionTexts::node_value(Scope* scope, const ThreemfNode& node,
                                             const std::string& output) {
    FieldValue value;
    if (node.kind == "constresourceid")
        return FieldValue{fmt::format("{}", node.resource), ThreemfType::kResource};
    if (!node.numbers.empty()) {
        const Complaint wrong = constant_text(node, &value);
        if (!wrong.empty()) return error(place(*scope, &node), wrong.what);
        return value;
    }
    if (node.kind == kCall) return call(scope, node, output);
    if (node.kind == "functiongradient") return gradient(scope, node, output);
    if (node.kind == "normalizedistance") return normalized(scope, node);
    if (node.kind == "mesh" || node.kind == "unsignedmesh" || node.kind == "beamlattice")
        return distance(scope, node);
    if (node.kind == "decomposevector") {
        Result<FieldValue> vector = input(*scope, node, "A");
        if (!vector) return vector;
        if (vector->type != ThreemfType::kVector)
            return error(place(*scope, &node),
                         fmt::format(messages::kInputANotVector, name_of(vector->type)));
        if (output != "x" && output != "y" && output != "z")
            return error(place(*scope, &node), fmt::format(messages::kVectorHasNo, shown(output)),
                         messages::kVectorOutputs);
        return FieldValue{vector->text + "." + output, ThreemfType::kScalar};
    }
    const NodeKind* kind = find_node_kind(node.kind);
    if (kind == nullptr)
        return error(place(*scope, &node), fmt::format(messages::kUnknownNode, shown(node.kind)),
                     suggest(shown(node.kind), node_kinds()));
    std::vector<FieldValue> inputs;
    for (const std::string_view name : mesh::threemf_words(kind->inputs)) {
        Result<FieldValue> one = input(*scope, node, name);
        if (!one) return one;
        inputs.push_back(std::move(*one));
    }
    NodeKind kept = *kind;
    const std::string text = keep_undefined(*kind);
    kept.text = text;
    const Complaint wrong = node_text(kept, inputs, &value);
    if (!wrong.empty()) return error(place(*scope, &node), wrong.what, wrong.help);
    return value;
}

/// `max(x, y)` is `y` where `x` is undefined, `sign(x)` 0 and `pow(x, 0)` 1; here that stays undefined, for the fallback.
std::string FunctionTexts::keep_undefined(const NodeKind& kind) {
    static constexpr std::string_view kUndefined[] = {"division", "arcsin", "arccos", "tan",
                                                      "fmod",     "mod",    "pow",    "sqrt",
                                                      "log",      "log2",   "log10",  "inverse"};
    /// With the inputs that are lost.
    static constexpr std::pair<std::string_view, std::string_view> kDefined[] = {
        {"min", "0"}, {"max", "0"}, {"clamp", "01"}, {"sign", "0"}, {"pow", "01"}};
    const std::string_view name = mesh::threemf_words(kind.names)[0];
    std::string text(kind.text);
    if (may_be_undefined_) {
        for (const auto& [of, inputs] : kDefined) {
            for (size_t i = 0; of == name && i < inputs.size(); ++i)
                text = fmt::format("select({{{0}}} == {{{0}}}, {1}, {{{0}}})", inputs[i], text);
        }
    }
    may_be_undefined_ =
        may_be_undefined_ || std::ranges::find(kUndefined, name) != std::end(kUndefined);
    return text;
}

Result<FieldValue> FunctionTexts::call(Scope* scope, const ThreemfNode& node,
                                       const std::string& output) {
    const Result<FieldValue> id = input(*scope, node, "functionID");
    if (!id) return id;
    if (id->type != ThreemfType::kResource)
        return error(place(*scope, &node), messages::kFunctionIdNoResource);
    Key key{std::stoll(id->text), output, {}};
    const auto callee = model_.fields.functions.find(key.function);
    if (callee == model_.fields.functions.end())
        return error(place(*scope, &node), fmt::format(messages::kCallsNoFunction, key.function));
    std::vector<ThreemfPort> wanted = callee->second.inputs;
    if (callee->second.image >= 0) wanted = {{"pos", ThreemfType::kVector, ""}};
    std::string arguments;
    for (const ThreemfPort& port : wanted) {
        const Result<FieldValue> given = input(*scope, node, port.name);
        if (!given) return given;
        const bool spreads =
            given->type == ThreemfType::kScalar && port.type == ThreemfType::kVector;
        if (given->type != port.type && !spreads)
            return error(
                place(*scope, &node),
                fmt::format(messages::kInputIsAndWants, shown(port.name), name_of(given->type),
                            place(key.function), name_of(port.type)));
        if (port.type == ThreemfType::kResource) {
            key.resources[port.name] = std::stoll(given->text);
        } else {
            arguments += (arguments.empty() ? "" : ", ") + given->text;
        }
    }
    const Result<Made> made = make(key);
    if (!made) return made.error();
    return FieldValue{fmt::format("{}({})", made->name, arguments), made->type};
}

Result<FieldValue> FunctionTexts::distance(Scope* scope, const ThreemfNode& node) {
    const Result<FieldValue> pos = input(*scope, node, "pos");
    if (!pos) return pos;
    const bool lattice = node.kind == "beamlattice";
    const Result<FieldValue> id = input(*scope, node, lattice ? "beamlattice" : "mesh");
    if (!id) return id;
    if (id->type != ThreemfType::kResource || pos->type != ThreemfType::kVector)
        return error(place(*scope, &node), messages::kWantsVectorResource);
    const int64_t object = std::stoll(id->text);
    const auto it = model_.objects.find(object);
    if (lattice) {
        if (it == model_.objects.end() || it->second.lattice == nullptr ||
            it->second.lattice->beams.empty())
            return error(place(*scope, &node),
                         fmt::format(messages::kObjectWithoutLattice, object));
        lattices_.insert(object);
        return FieldValue{fmt::format("lattice_{}_distance({})", object, pos->text),
                          ThreemfType::kScalar};
    }
    if (it == model_.objects.end() || it->second.triangles.empty())
        return error(place(*scope, &node), fmt::format(messages::kObjectIsNoMesh, object));
    meshes_.insert(object);
    const std::string text = fmt::format("mesh_{}_distance({})", object, pos->text);
    return FieldValue{node.kind == "mesh" ? text : "abs(" + text + ")", ThreemfType::kScalar};
}

}  // namespace openfab::tools
