// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "compiler/graph/editor.h"

namespace openfab::graph {

namespace {

/// Whether a value may stand for a parameter, as far as names of types tell.
int fit(const std::string& wants, const std::string& type) {
    if (wants == type) return 3;
    if (type.empty() || wants.empty() || wants == "T") return 1;
    const check::Type has = check::find_type(type);
    if (wants == "floatN" || wants == "intN" || wants == "uintN")
        return has.is_scalar() || has.is_vector() ? 2 : 0;
    if (wants == "boolN") return has.is(check::Base::kBool) ? 2 : 0;
    const check::Type wanted = check::find_type(wants);
    // A scalar goes with any vector.
    return has.is_scalar() && wanted.is_numeric() && wanted.is_arithmetic() ? 1 : 0;
}

}  // namespace

Result<const Entry*> Editor::entry() {
    entries_ = entries_of(analysis_);
    const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& one) {
        return one.signature == action_.signature && one.module == action_.module;
    });
    if (found == entries_.end())
        return user_error(fmt::format("there is no function `{}`", action_.signature));
    return &*found;
}

std::string Editor::place() const {
    // A local copy of the place is what the rest of the code uses.
    for (const Node& node : tab_->nodes) {
        const bool copy = node.kind == NodeKind::kValue && node.is_root && node.statement >= 0 &&
                          node.outputs[0].type == "float3" && node.ports.size() == 1 &&
                          node.ports[0].from.exists() && node.ports[0].suffix.empty();
        if (!copy) continue;
        const Node& from = tab_->nodes[static_cast<size_t>(node.ports[0].from.node)];
        const bool first = action_.before < 0 || node.statement < action_.before;
        if (from.role == "attribute" && first) return node.outputs[0].name;
    }
    for (const char* end : {".voxelCenter", ".p"}) {
        for (const Output& one : tab_->inputs) {
            if (one.name.ends_with(end) && one.type == "float3") return one.name;
        }
    }
    for (const Output& one : tab_->inputs) {
        if (one.type == "float3") return one.name;
    }
    return "";
}

std::optional<std::string> Editor::uniform_of(std::string_view type, int before) const {
    std::optional<std::string> found;
    for (const Uniform& one : graph_.uniforms) {
        const source::Span& at = one.declared;
        const std::string_view text = analysis_.sources().text(server::Analysis::kDocument);
        const bool array = text.substr(at.end).find_first_not_of(' ') != std::string_view::npos &&
                           text[text.find_first_not_of(' ', at.end)] == '[' &&
                           text.substr(text.find_first_not_of(' ', at.end), 2) != "[[";
        if (one.fablet != tab_->fablet || one.type != type || array) continue;
        found = one.name;
        if (before-- == 0) break;
    }
    return found;
}

std::string Editor::argument(const Parameter& parameter, int before) const {
    const std::string& type = parameter.type;
    const std::string at = place();
    const bool is_place = parameter.name == "p" || parameter.name == "position" ||
                          parameter.name == "point" || parameter.name == "at";
    if (!parameter.sample.empty()) return parameter.sample;
    if (is_place && !at.empty()) {
        if (type == "float3" || type == "floatN" || type == "T") return at;
        if (type == "float2") return at + ".xy";
    }
    if (type == "float2" && (is_place || parameter.name == "uv")) {
        for (const Output& one : tab_->inputs) {
            if (one.type == "float2") return one.name;
        }
    }
    if (type == "VolumeAttributes" || type == "SurfaceAttributes" || type == "DitherAttributes" ||
        type == "ShapeAttributes" || type == "GrowAttributes") {
        for (const Output& one : tab_->inputs) {
            const size_t dot = one.name.find('.');
            if (dot != std::string::npos) return one.name.substr(0, dot);
        }
    }
    if ((parameter.name == "d" || parameter.name == "distance") && !at.empty() &&
        tab_->name == "@Volume")
        return "distance(" + at + ")";
    if (parameter.name == "octaves") return "4";
    if (parameter.name == "amount" || parameter.name == "to" || parameter.name == "size")
        return "1";
    if (type == "float3" && !at.empty() && parameter.name.size() == 1) return at;
    if (type == "Material" || type == "ImageTexture2D" || type == "ImageTexture3D" ||
        type == "Object" || type == "Spline" || type == "ColorRamp")
        return uniform_of(type, before).value_or(type == "Material" ? "VOID" : "");
    if (type == "MaterialComposition") {
        for (const Node& node : tab_->nodes) {
            if (!node.outputs.empty() && node.outputs[0].type == type &&
                !node.outputs[0].name.empty())
                return node.outputs[0].name;
        }
    }
    return zero_of(type);
}

Result<std::string> Editor::call(const Entry& entry, int given, const std::string& text) {
    std::vector<std::string> arguments;
    for (size_t i = 0; i < entry.parameters.size(); ++i) {
        const Parameter& p = entry.parameters[i];
        const bool is_given = static_cast<int>(i) == given;
        if (!is_given && p.has_default) break;
        const auto before = std::count_if(
            entry.parameters.begin(), entry.parameters.begin() + static_cast<std::ptrdiff_t>(i),
            [&](const Parameter& other) { return other.type == p.type; });
        const std::string one = is_given ? text : argument(p, static_cast<int>(before));
        if (one.empty()) {
            return user_error(
                fmt::format("`{}` needs a `{}`, and there is none", entry.name, p.type),
                "add a uniform of that type first");
        }
        arguments.push_back(one);
    }
    if (entry.kind == Entry::Kind::kLibrary) rewrite_.import(entry.module);
    const auto bracketed = [](const std::string& operand) {
        return is_operand(operand) ? operand : "(" + operand + ")";
    };
    if (entry.kind == Entry::Kind::kOperator) {
        for (std::string& one : arguments)
            one = bracketed(one);
        return arguments.size() == 3
                   ? fmt::format("{} ? {} : {}", arguments[0], arguments[1], arguments[2])
                   : fmt::format("{} {} {}", arguments[0], entry.name, arguments[1]);
    }
    if (entry.kind == Entry::Kind::kMethod) {
        const std::string object = bracketed(arguments[0]);
        arguments.erase(arguments.begin());
        return fmt::format("{}.{}({})", object, entry.name, fmt::join(arguments, ", "));
    }
    if (entry.kind == Entry::Kind::kType && arguments.size() == 1 && given < 0) return arguments[0];
    return fmt::format("{}({})", entry.name, fmt::join(arguments, ", "));
}

Result<void> Editor::insert() {
    const Result<const Port*> port = find_port();
    if (!port) return port.error();
    const Result<const Entry*> found = entry();
    if (!found) return found.error();
    const Entry& made = **found;
    int best = -1;
    int most = 0;
    for (size_t i = 0; i < made.parameters.size(); ++i) {
        const int fits = fit(made.parameters[i].type, (*port)->type);
        if (fits <= most) continue;
        most = fits;
        best = static_cast<int>(i);
    }
    if (best < 0) return user_error(fmt::format("`{}` takes no `{}`", made.name, (*port)->type));
    const Result<std::string> text = call(made, best, rewrite_.expression((*port)->span));
    if (!text) return text.error();
    put(**find_node(action_.node), **port, *text);
    return {};
}

uint32_t Editor::insertion(int before) const {
    const std::vector<Statement>& all = tab_->statements;
    if (before >= 0 && static_cast<size_t>(before) < all.size())
        return all[static_cast<size_t>(before)].lead;
    if (!all.empty() && all.back().returns) return all.back().lead;
    return all.empty() ? tab_->open.end : all.back().tail;
}

Result<void> Editor::add() {
    const Result<const Entry*> found = entry();
    if (!found) return found.error();
    const Entry& made = **found;
    const Result<std::string> text = call(made, -1, "");
    if (!text) return text.error();
    const bool statement =
        made.kind == Entry::Kind::kMethod && made.result == "MaterialComposition";
    std::string line = *text + ";\n";
    if (!statement) {
        // A result of any type is that of what it is made of.
        std::string type = made.result;
        if (type == "T" || type == "floatN") {
            type = "float";
            for (size_t i = 0; i < made.parameters.size(); ++i) {
                const bool place_in =
                    (made.parameters[i].type == "floatN" || made.parameters[i].type == "T") &&
                    !place().empty() && argument(made.parameters[i]) == place();
                if (place_in) type = "float3";
            }
        }
        if (type == "boolN") type = "bool";
        if (type == "intN") type = "int";
        if (type == "uintN") type = "uint";
        if (!can_be_declared(type))
            return user_error(
                fmt::format("`{}` gives a `{}`, which no variable holds", made.name, type));
        const std::string base = made.kind == Entry::Kind::kType ? "value" : name_for(made.name);
        line = fmt::format("{} {} = {};\n", type, rewrite_.fresh_name(base), *text);
    }
    const uint32_t at = insertion(action_.before);
    const std::string_view all = analysis_.sources().text(server::Analysis::kDocument);
    rewrite_.insert(at, (at == 0 || all[at - 1] == '\n' ? "" : "\n") + line);
    return {};
}

Result<void> Editor::paste() {
    const Result<std::string> text = rewrite_.with_fresh_names(action_.text);
    if (!text) return text.error();
    const uint32_t at = insertion(-1);
    const std::string_view all = analysis_.sources().text(server::Analysis::kDocument);
    rewrite_.insert(at, (at == 0 || all[at - 1] == '\n' ? "" : "\n") + *text + "\n");
    return {};
}

Result<void> Editor::remove() {
    const Result<const Node*> found = find_node(action_.node);
    if (!found) return found.error();
    const Node& node = **found;
    if (node.kind == NodeKind::kResult)
        return user_error("the result stays: a stage or function ends with it");
    if (node.kind == NodeKind::kInput) {
        if (node.role != "uniform")
            return user_error(fmt::format("`{}` is an input; delete what uses it", node.title));
        return user_error(fmt::format("the uniform `{}` is in use", node.title),
                          "disconnect its wires, then delete it in the list of uniforms");
    }
    // Who reads it gets what it was made of, or nothing.
    struct Reader {
        const Node* node;
        const Port* port;
    };
    std::vector<Reader> readers;
    for (const Node& other : tab_->nodes) {
        for (const Port& port : other.ports) {
            if (port.from.node == action_.node) readers.push_back({&other, &port});
        }
    }
    const std::string type = node.outputs.empty() ? "" : node.outputs[0].type;
    const bool chain = type == "MaterialComposition" && node.is_root &&
                       (node.kind == NodeKind::kWrite || node.kind == NodeKind::kOpaque);
    if (node.is_root && (chain || readers.empty() || node.kind == NodeKind::kWrite)) {
        const Statement& statement = tab_->statements[static_cast<size_t>(node.statement)];
        if (statement.declares.size() > 1)
            return user_error(
                "several variables are declared in one statement; delete it in the text");
        rewrite_.remove(statement.span);
        return {};
    }
    std::string instead = zero_of(type);
    const Port* same = nullptr;
    for (const Port& port : node.ports) {
        if (same == nullptr && port.span.file == server::Analysis::kDocument && port.type == type)
            same = &port;
    }
    if (same == nullptr && instead.empty())
        return user_error(fmt::format("something needs this `{}`", type),
                          "connect that to another one first");
    if (!node.is_root) {
        const Reader& reader = readers.front();
        const std::string text = same != nullptr ? rewrite_.expression(same->span) : instead;
        source::Span at = reader.port->object;
        if (at.file == 0) at = reader.port->span;
        const bool brackets =
            (reader.node->kind == NodeKind::kOperator || !reader.port->suffix.empty() ||
             reader.node->title.starts_with(".")) &&
            !is_operand(text);
        rewrite_.replace(at, brackets ? "(" + text + ")" : text);
        return {};
    }
    if (node.kind == NodeKind::kOpaque)
        return user_error("other nodes use what these statements make",
                          "connect them to others first");
    // A variable that is used keeps its name, with what the node was made of.
    if (node.kind == NodeKind::kValue) {
        const Statement& statement = tab_->statements[static_cast<size_t>(node.statement)];
        const bool wire = same != nullptr && same->from.exists();
        for (const Reader& reader : readers) {
            if (reader.port->span.file != server::Analysis::kDocument)
                return user_error(
                    fmt::format("`{}` is used within statements", node.outputs[0].name),
                    "change these in the text first");
            const std::string text = wire ? rewrite_.expression(same->span) : instead;
            if (text.empty())
                return user_error(fmt::format("something needs `{}`", node.outputs[0].name));
            const bool brackets = !is_operand(text) || (!reader.port->suffix.empty() && !wire);
            rewrite_.replace(reader.port->object, brackets ? "(" + text + ")" : text);
        }
        if (statement.declares.size() > 1)
            return user_error(
                "several variables are declared in one statement; delete it in the text");
        rewrite_.remove(statement.span);
        return {};
    }
    rewrite_.replace(node.span, same != nullptr ? rewrite_.expression(same->span) : instead);
    return {};
}

Result<void> Editor::rename(uint32_t declared, const std::string& name) {
    if (!is_name(name)) return user_error(fmt::format("`{}` is not a name", name));
    for (const check::Function* f : analysis_.functions("")) {
        if (f->name == name) return user_error(fmt::format("`{}` is a function", name));
    }
    const bool taken = std::any_of(
        analysis_.tokens().begin(), analysis_.tokens().end(), [&](const syntax::Token& t) {
            return t.kind == syntax::TokenKind::kIdentifier && t.text == name;
        });
    if (taken) return user_error(fmt::format("`{}` is the name of something else here", name));
    if (has_errors(analysis_.diagnostics()))
        return user_error("names can be changed once the document has no errors");
    std::set<uint32_t> done;
    for (const check::Use& use : analysis_.names()) {
        const bool same = use.declared.file == server::Analysis::kDocument &&
                          use.declared.begin == declared && use.kind == check::UseKind::kSymbol &&
                          use.span.file == server::Analysis::kDocument;
        if (!same || !done.insert(use.span.begin).second) continue;
        // A name in brackets has a span with them.
        const size_t at = analysis_.token_at(use.span.begin);
        for (size_t i = at; i < analysis_.tokens().size(); ++i) {
            const syntax::Token& t = analysis_.tokens()[i];
            if (t.span.begin >= use.span.end) break;
            if (t.span.begin >= use.span.begin && t.text == use.name)
                rewrite_.replace(t.span, name);
        }
    }
    return {};
}

Result<void> Editor::name() {
    const Result<const Node*> found = find_node(action_.node);
    if (!found) return found.error();
    const Node& node = **found;
    if (node.kind == NodeKind::kInput && node.role == "uniform")
        return rename(node.declared.begin, action_.text);
    if (node.kind == NodeKind::kInput || node.outputs.empty())
        return user_error(fmt::format("`{}` cannot be named here", node.title));
    if (node.outputs[0].variable != 0) return rename(node.outputs[0].variable, action_.text);
    if (!is_name(action_.text)) return user_error(fmt::format("`{}` is not a name", action_.text));
    const std::string& type = node.outputs[0].type;
    if (!can_be_declared(type)) return user_error(fmt::format("no variable holds a `{}`", type));
    if (rewrite_.fresh_name(action_.text) != action_.text)
        return user_error(fmt::format("`{}` is the name of something else here", action_.text));
    const std::string text = rewrite_.expression(node.span);
    rewrite_.replace(node.span, action_.text);
    rewrite_.insert(tab_->statements[static_cast<size_t>(node.statement)].lead,
                    fmt::format("{} {} = {};\n", type, action_.text, text));
    return {};
}

}  // namespace openfab::graph
