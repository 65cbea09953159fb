// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/graph/graph.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/format/format.h"
#include "compiler/graph/tab_builder.h"

namespace openfab::graph {

namespace {

constexpr int kNoFablet = -1;

class Drawer {
  public:
    explicit Drawer(const server::Analysis& analysis) : analysis_(analysis), known_(analysis) {}

    Graph draw() {
        Graph out;
        const ast::File& file = analysis_.tree();
        out.is_whole = file.damaged.empty() && !has_syntax_errors();
        int index = 0;
        for (const ast::Fablet& fablet : file.fablets) {
            for (const ast::Variable& v : fablet.uniforms)
                out.uniforms.push_back(uniform(fablet, v));
            for (const ast::Stage& stage : fablet.stages)
                out.tabs.push_back(stage_tab(fablet, index, stage));
            ++index;
        }
        index = 0;
        for (const ast::Fablet& fablet : file.fablets) {
            for (const ast::Function& f : fablet.scope.functions)
                out.tabs.push_back(function_tab(std::string(fablet.name), index, f));
            ++index;
        }
        for (const ast::Function& f : file.scope.functions)
            out.tabs.push_back(function_tab("", kNoFablet, f));
        return out;
    }

  private:
    /// Messages of the parser: they leave holes in the tree.
    bool has_syntax_errors() const {
        source::SourceManager sources;
        diag::Sink sink;
        const std::string text(analysis_.sources().text(server::Analysis::kDocument));
        return !format::format(sources, sources.add("document", text), &sink);
    }

    Uniform uniform(const ast::Fablet& fablet, const ast::Variable& v) const {
        Uniform out;
        out.name = v.name;
        out.fablet = fablet.name;
        out.type = v.type.text;
        out.declared = v.span;
        if (v.init != nullptr) out.init = v.init->span;
        for (const ast::Annotation& a : v.annotations) {
            if (a.value == nullptr) continue;
            const bool text = a.value->kind == ast::ExprKind::kStringLiteral;
            out.annotations[std::string(a.name)] =
                text ? std::string(a.value->text) : known_.text(a.value->span);
        }
        for (const check::Use& use : analysis_.names()) {
            if (use.declared == v.span && use.span != v.span && use.kind == check::UseKind::kSymbol)
                ++out.uses;
        }
        return out;
    }

    void inputs_of(const std::vector<ast::Variable>& variables, Tab* tab,
                   std::set<uint32_t>* outputs) const {
        for (const ast::Variable& v : variables) {
            const check::Use* use = known_.use(v.span);
            if (v.is_out) outputs->insert(v.span.begin);
            const check::Type type = use == nullptr ? check::kErrorType : use->type;
            const check::Type named = check::find_type(v.type.text);
            if (type.is_attributes() || named.is_attributes()) {
                for (const check::StructMember& member : check::attribute_members(named))
                    tab->inputs.push_back(
                        {fmt::format("{}.{}", v.name, member.name), check::type_name(member.type)});
            } else if (!v.is_out || v.is_in) {
                tab->inputs.push_back({std::string(v.name), std::string(v.type.text)});
            }
        }
    }

    Tab stage_tab(const ast::Fablet& fablet, int index, const ast::Stage& stage) {
        Tab tab;
        tab.name = fmt::format("@{}", ast::stage_name(stage.kind));
        tab.fablet = fablet.name;
        tab.fablet_index = index;
        tab.is_stage = true;
        tab.span = stage.span;
        body_of(stage.varyings, stage.body, &tab);
        return tab;
    }

    Tab function_tab(const std::string& fablet, int index, const ast::Function& function) {
        Tab tab;
        tab.name = function.name;
        tab.fablet = fablet;
        tab.fablet_index = index;
        tab.span = function.span;
        body_of(function.parameters, function.body, &tab);
        return tab;
    }

    void body_of(const std::vector<ast::Variable>& variables, const ast::StmtPtr& body, Tab* tab) {
        std::set<uint32_t> outputs;
        inputs_of(variables, tab, &outputs);
        TabBuilder builder(known_, tab);
        builder.set_outputs(std::move(outputs));
        if (body != nullptr) builder.draw(*body);
    }

    const server::Analysis& analysis_;
    Known known_;
};

}  // namespace

Graph graph_of(const server::Analysis& analysis) {
    return Drawer(analysis).draw();
}

bool has_errors(const std::vector<diag::Diagnostic>& messages) {
    return std::any_of(messages.begin(), messages.end(), [](const diag::Diagnostic& one) {
        return one.severity == diag::Severity::kError;
    });
}

}  // namespace openfab::graph
