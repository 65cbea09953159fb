// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/graph/palette.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/json.h"
#include "compiler/check/builtins.h"
#include "compiler/check/signatures.h"
#include "compiler/frontend/modules.h"
#include "compiler/graph/library_costs.h"

namespace openfab::graph {

namespace {

constexpr const char* kEntryKinds[] = {"library", "builtin", "own", "operator", "type", "method"};

std::string trimmed(std::string_view text) {
    const size_t begin = text.find_first_not_of(' ');
    if (begin == std::string_view::npos) return {};
    return std::string(text.substr(begin, text.find_last_not_of(' ') + 1 - begin));
}

/// Splits at commas that are in no brackets.
std::vector<std::string> arguments_of(std::string_view call) {
    std::vector<std::string> out;
    const size_t open = call.find('(');
    if (open == std::string_view::npos || !call.ends_with(')')) return out;
    int depth = 0;
    std::string one;
    for (const char c : call.substr(open + 1, call.size() - open - 2)) {
        if (c == '(' || c == '{') ++depth;
        if (c == ')' || c == '}') --depth;
        if (c == ',' && depth == 0) {
            out.push_back(trimmed(one));
            one.clear();
        } else {
            one += c;
        }
    }
    if (!trimmed(one).empty()) out.push_back(trimmed(one));
    return out;
}

/// Whether a text is made of numbers alone, so that it means the same anywhere.
bool is_constant(std::string_view text) {
    source::SourceManager sources;
    diag::Sink sink;
    const std::vector<syntax::Token> tokens =
        syntax::lex(sources, sources.add("sample", std::string(text)), &sink);
    return sink.errors() == 0 && tokens.size() > 1 &&
           std::all_of(tokens.begin(), tokens.end(), [](const syntax::Token& t) {
               return t.kind != syntax::TokenKind::kIdentifier ||
                      check::find_type(t.text).is_arithmetic();
           });
}

/// Calls of library functions that show something, and their costs, by module and types.
struct Measured {
    std::string call;
    double nanoseconds = -1;
};
const std::map<std::string, Measured>& measured() {
    static const std::map<std::string, Measured> known = [] {
        std::map<std::string, Measured> out;
        const Result<JsonValue> json = parse_json(kLibraryCosts[0].text, "costs");
        const JsonValue* list = json ? member_of(*json, "functions") : nullptr;
        if (list == nullptr) return out;
        for (const JsonValue& one : list->items) {
            const auto text = [&](const char* name) {
                const JsonValue* value = member_of(one, name);
                return value == nullptr ? std::string() : value->text;
            };
            const JsonValue* cost = member_of(one, "ns");
            out[text("module") + "/" + text("function")] = {text("call"),
                                                            cost == nullptr ? -1 : cost->number};
        }
        return out;
    }();
    return known;
}

Entry entry_of(const check::Function& f, Entry::Kind kind, const std::string& module,
               const std::string& help) {
    Entry out;
    out.kind = kind;
    out.name = f.name;
    out.module = module;
    out.signature = server::signature(f);
    out.help = help;
    out.result = check::type_name(f.return_type);
    std::string types;
    for (const auto& p : f.parameters) {
        const std::string type = check::type_name(p->type);
        types += (types.empty() ? "" : ", ") + type;
        out.parameters.push_back({type, p->name, p->is_out, p->fallback != nullptr, ""});
    }
    const auto found =
        measured().find(fmt::format("{}/{} {}({})", module, out.result, f.name, types));
    if (found == measured().end()) return out;
    out.nanoseconds = found->second.nanoseconds;
    out.call = found->second.call;
    const std::vector<std::string> samples = arguments_of(found->second.call);
    for (size_t i = 0; i < samples.size() && i < out.parameters.size(); ++i) {
        if (is_constant(samples[i])) out.parameters[i].sample = samples[i];
    }
    return out;
}

/// The standard library: analysed once.
const std::vector<Entry>& library() {
    static const std::vector<Entry> known = [] {
        std::string text;
        for (const std::string& module : frontend::library_modules())
            text += "import " + module + ";\n";
        const server::Analysis analysis({}, text, {});
        std::vector<Entry> out;
        for (const ast::Import& import : analysis.tree().imports) {
            const std::optional<uint32_t> file = analysis.file_of_import(import);
            for (const auto& f : analysis.program().functions) {
                if (!file || f->span.file != *file || f->name.starts_with('_')) continue;
                out.push_back(entry_of(*f, Entry::Kind::kLibrary, std::string(import.name),
                                       analysis.comment_above(f->span)));
            }
        }
        return out;
    }();
    return known;
}

Entry built_in(const check::Signature& one) {
    Entry out;
    out.kind = Entry::Kind::kBuiltIn;
    out.name = one.name;
    out.signature = one.form;
    out.help = one.text;
    out.result = trimmed(one.form.substr(0, one.form.find(' ')));
    for (std::string_view text : check::parameters_of(one.form)) {
        Parameter p;
        const size_t equals = text.find('=');
        p.has_default = equals != std::string_view::npos;
        std::string left = trimmed(text.substr(0, equals));
        p.is_out = left.starts_with("out ");
        if (p.is_out) left = left.substr(4);
        const size_t space = left.rfind(' ');
        p.name = space == std::string::npos ? left : left.substr(space + 1);
        p.type = space == std::string::npos ? "" : left.substr(0, space);
        out.parameters.push_back(std::move(p));
    }
    return out;
}

/// What is of no use as a node: a function as an argument, messages.
bool is_node(const Entry& one) {
    return one.result != "void" && !one.name.starts_with("distanceTo") &&
           std::none_of(one.parameters.begin(), one.parameters.end(), [](const Parameter& p) {
               return p.is_out || p.type == "function" || p.type == "string";
           });
}

void add_operators(std::vector<Entry>* out) {
    struct Row {
        const char* name;
        const char* result;
        const char* help;
    };
    constexpr Row kRows[] = {
        {"+", "T", "the sum"},
        {"-", "T", "the difference"},
        {"*", "T", "the product, component by component"},
        {"/", "T", "the quotient, component by component"},
        {"<", "bool", "whether `a` is less"},
        {">", "bool", "whether `a` is greater"},
        {"&&", "bool", "whether both hold"},
        {"||", "bool", "whether one of them holds"},
    };
    for (const Row& row : kRows) {
        Entry one;
        one.kind = Entry::Kind::kOperator;
        one.name = row.name;
        one.help = row.help;
        one.result = row.result;
        const bool truth = one.name == "&&" || one.name == "||";
        const std::string type = truth ? "bool" : "T";
        one.parameters = {{type, "a", false, false, ""},
                          {type, "b", false, false, truth ? "true" : "1"}};
        one.signature = "a " + one.name + " b";
        out->push_back(std::move(one));
    }
    Entry choice;
    choice.kind = Entry::Kind::kOperator;
    choice.name = "? :";
    choice.signature = "condition ? a : b";
    choice.help = "`a` where the condition holds, else `b`";
    choice.result = "T";
    choice.parameters = {{"bool", "if", false, false, "true"},
                         {"T", "then", false, false, "1"},
                         {"T", "else", false, false, "0"}};
    out->push_back(std::move(choice));
    const char* const axes[] = {"x", "y", "z", "w"};
    for (int n = 1; n <= 4; ++n) {
        Entry one;
        one.kind = Entry::Kind::kType;
        one.name = n == 1 ? "float" : fmt::format("float{}", n);
        one.result = one.name;
        one.help = n == 1 ? "a number of its own" : "a vector of numbers";
        for (int i = 0; i < n; ++i)
            one.parameters.push_back({"float", axes[i], false, false, "0"});
        one.signature = one.name + "(" +
                        (n == 1   ? "x"
                         : n == 2 ? "x, y"
                         : n == 3 ? "x, y, z"
                                  : "x, y, z, w") +
                        ")";
        out->push_back(std::move(one));
    }
}

void add_methods(std::vector<Entry>* out) {
    for (const char* name : {"Set", "Add"}) {
        for (const check::Signature& one : check::signatures_of(name)) {
            Entry entry = built_in(one);
            entry.kind = Entry::Kind::kMethod;
            entry.result = "MaterialComposition";
            entry.parameters.insert(entry.parameters.begin(),
                                    {"MaterialComposition", "of", false, false, ""});
            out->push_back(std::move(entry));
        }
    }
    for (const char* name : {"Sample1", "Sample3"}) {
        for (const check::Signature& one : check::signatures_of(name)) {
            Entry entry = built_in(one);
            if (entry.parameters.empty() || entry.parameters[0].type == "float") continue;
            const bool volume = entry.parameters[0].type == "float3";
            entry.kind = Entry::Kind::kMethod;
            entry.parameters.insert(
                entry.parameters.begin(),
                {volume ? "ImageTexture3D" : "ImageTexture2D", "of", false, false, ""});
            out->push_back(std::move(entry));
        }
    }
}

}  // namespace

std::string zero_of(std::string_view type) {
    if (type == "bool") return "false";
    if (type == "float" || type == "int" || type == "uint" || type == "T" || type == "floatN" ||
        type == "intN" || type == "uintN")
        return "0";
    if (type == "boolN") return "false";
    const check::Type found = check::find_type(type);
    if (!found.is_vector()) return {};
    std::string out(type);
    for (int i = 0; i < found.size; ++i)
        out += i == 0 ? "(0" : ", 0";
    return out + ")";
}

std::vector<Entry> entries_of(const server::Analysis& analysis) {
    std::vector<Entry> out;
    add_operators(&out);
    add_methods(&out);
    for (const std::string& name : check::function_names()) {
        for (const check::Signature& one : check::signatures_of(name)) {
            Entry entry = built_in(one);
            if (is_node(entry)) out.push_back(std::move(entry));
        }
    }
    for (const Entry& one : library()) {
        if (is_node(one)) out.push_back(one);
    }
    for (const check::Function* f : analysis.functions("")) {
        const std::filesystem::path file = analysis.path_of(f->span.file);
        // The library's are listed already.
        if (f->span.file != server::Analysis::kDocument && file.empty()) continue;
        Entry entry = entry_of(*f, Entry::Kind::kOwn, "", analysis.comment_above(f->span));
        if (is_node(entry)) out.push_back(std::move(entry));
    }
    return out;
}

void write_entries(const std::vector<Entry>& entries, JsonText* out) {
    out->begin_array();
    for (const Entry& one : entries) {
        out->begin_object().member("kind", kEntryKinds[static_cast<size_t>(one.kind)]);
        out->member("name", one.name).member("module", one.module);
        out->member("signature", one.signature).member("help", one.help);
        out->member("result", one.result);
        if (one.nanoseconds >= 0) out->member("ns", one.nanoseconds);
        out->key("parameters").begin_array();
        for (const Parameter& p : one.parameters)
            out->begin_object().member("name", p.name).member("type", p.type).end_object();
        out->end_array().end_object();
    }
    out->end_array();
}

}  // namespace openfab::graph
