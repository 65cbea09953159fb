// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Enums: names for ints. What is declared with an enum's name is an int; only a uniform keeps the names, which a world
// and its editors may use.
#include <fmt/format.h>

#include <algorithm>

#include "compiler/check/checker.h"
#include "compiler/ir/choices.h"

namespace openfab::check {

namespace {

constexpr size_t kMaxNames = 256;

/// Returns a text without what separates names and labels.
std::string one_line(std::string_view text) {
    std::string out(text);
    std::replace_if(
        out.begin(), out.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
    return out;
}

/// Returns the text of a `string label = "…"`; empty without one.
std::string label_of(const ast::Variable& item) {
    for (const ast::Annotation& a : item.annotations) {
        if (a.name == "label" && a.value != nullptr &&
            a.value->kind == ast::ExprKind::kStringLiteral)
            return one_line(a.value->text);
    }
    return "";
}

/// Returns the one of `choices` that has this name or label, or null.
const Choice* find_choice(const std::vector<Choice>& choices, std::string_view name) {
    const auto found = std::find_if(choices.begin(), choices.end(), [&](const Choice& one) {
        return one.name == name || one.label == name;
    });
    return found == choices.end() ? nullptr : &*found;
}

}  // namespace

void Checker::declare_enum(const ast::Enum& from, std::vector<std::unique_ptr<Symbol>>* constants) {
    context_ = StageContext::kGlobal;
    auto type = std::make_unique<Symbol>();
    type->kind = SymbolKind::kType;
    type->name = from.name;
    type->span = from.span;
    type->is_const = true;
    type->type = kIntType;
    if (!find_type(from.name).is_error()) {
        sink_
            ->report(from.span, diag::kBadDeclaration,
                     fmt::format("`{}` is a built-in type", from.name))
            .help("give the enum another name");
        return;
    }
    if (from.items.empty()) {
        sink_->report(from.span, diag::kBadDeclaration,
                      fmt::format("enum `{}` has no names", from.name));
    }
    if (from.items.size() > kMaxNames) {
        sink_->report(from.span, diag::kTooComplex,
                      fmt::format("enum `{}` has more than {} names", from.name, kMaxNames));
        return;
    }
    declare(type.get());
    int64_t next = 0;
    for (const ast::Variable& item : from.items) {
        auto symbol = std::make_unique<Symbol>();
        symbol->kind = SymbolKind::kConstant;
        symbol->name = item.name;
        symbol->span = item.span;
        symbol->is_const = true;
        symbol->type = kIntType;
        if (item.init != nullptr)
            next = constant_int(*item.init, "the value of an enum's name").value_or(0);
        if (next > INT32_MAX) {
            sink_->report(item.span, diag::kNarrowing, std::to_string(next), "int");
            next = 0;
        }
        const auto bits = static_cast<uint32_t>(static_cast<int32_t>(next));
        symbol->init = make(ExprKind::kConstant, kIntType, item.span);
        symbol->init->bits = bits;
        symbol->known = bits;
        const std::string label = label_of(item);
        const Choice* known = label.empty() ? nullptr : find_choice(type->choices, label);
        if (known != nullptr)
            sink_->report(item.span, diag::kBadDeclaration,
                          fmt::format("`{}` already stands for `{}`", label, known->name));
        type->choices.push_back({std::string(item.name),
                                 label.empty() ? std::string(item.name) : label,
                                 static_cast<int32_t>(next)});
        ++next;
        declare(symbol.get());
        constants->push_back(std::move(symbol));
    }
    types_.push_back(std::move(type));
}

/// Gives a uniform the names that its values have: those of its enum, or the labels `on` and `off` of a bool.
void Checker::add_choices(const ast::Variable& v, const Type& element, ir::Uniform* uniform) const {
    const Symbol* type = find(v.type.text);
    std::vector<Choice> choices;
    if (type != nullptr && type->kind == SymbolKind::kType) choices = type->choices;
    if (element == kBoolType) {
        std::string off = "off", on = "on";
        bool labelled = false;
        for (const ast::Annotation& a : v.annotations) {
            const bool text = a.value != nullptr && a.value->kind == ast::ExprKind::kStringLiteral;
            if (!text || (a.name != "off" && a.name != "on")) continue;
            (a.name == "on" ? on : off) = one_line(a.value->text);
            labelled = true;
        }
        if (labelled) choices = {{"false", off, 0}, {"true", on, 1}};
    }
    if (choices.empty()) return;
    std::string text;
    for (const Choice& one : choices)
        text +=
            fmt::format("{}{}\t{}\t{}", text.empty() ? "" : "\n", one.name, one.value, one.label);
    uniform->annotations.emplace_back(ir::kChoices, std::move(text));
}

}  // namespace openfab::check
