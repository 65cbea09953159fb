// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "compiler/graph/graph.h"

namespace openfab::graph {

namespace {

constexpr const char* kKindNames[] = {"input", "call",   "operator", "value",
                                      "write", "opaque", "result"};

/// Bytes as UTF-16 code units.
class Units {
  public:
    explicit Units(std::string_view text) : units_(text.size() + 1) {
        uint32_t units = 0;
        for (size_t at = 0; at < text.size();) {
            const size_t bytes = source::code_point_bytes(text, at);
            for (size_t i = 0; i < bytes; ++i)
                units_[at + i] = units;
            units += bytes == 4 ? 2 : 1;
            at += bytes;
        }
        units_.back() = units;
    }
    int64_t at(uint32_t byte) const { return units_[std::min<size_t>(byte, units_.size() - 1)]; }

  private:
    std::vector<uint32_t> units_;
};

class Writer {
  public:
    Writer(const server::Analysis& analysis, const Graph& graph, JsonText* out)
        : analysis_(analysis),
          graph_(graph),
          out_(*out),
          units_(analysis.sources().text(server::Analysis::kDocument)),
          messages_(analysis.diagnostics()) {}

    void write() {
        out_.begin_object().member("whole", graph_.is_whole);
        out_.member("errors", has_errors(messages_)).key("tabs").begin_array();
        for (const Tab& tab : graph_.tabs)
            write_tab(tab);
        out_.end_array().key("uniforms").begin_array();
        for (const Uniform& one : graph_.uniforms)
            write_uniform(one);
        out_.end_array().key("diagnostics").begin_array();
        for (const diag::Diagnostic& one : messages_)
            write_message(one);
        out_.end_array().end_object();
    }

  private:
    std::string text(const source::Span& span) const {
        return span.file == server::Analysis::kDocument
                   ? std::string(analysis_.sources().text(span))
                   : std::string();
    }

    void place(const source::Span& span) {
        if (span.file != server::Analysis::kDocument) return;
        out_.member("begin", units_.at(span.begin)).member("end", units_.at(span.end));
        const auto line = analysis_.sources().locate(span.file, span.begin).line;
        out_.member("line", static_cast<int64_t>(line));
    }

    void write_tab(const Tab& tab) {
        out_.begin_object().member("name", tab.name).member("fablet", tab.fablet);
        out_.member("stage", tab.is_stage);
        place({tab.span.file, tab.span.begin, std::max(tab.span.end, tab.close.end)});
        out_.key("inputs").begin_array();
        for (const Output& one : tab.inputs)
            out_.begin_object().member("name", one.name).member("type", one.type).end_object();
        out_.end_array().key("statements").begin_array();
        for (const Statement& one : tab.statements) {
            out_.begin_object();
            place({one.span.file, one.span.begin, std::max(one.span.end, one.tail)});
            out_.end_object();
        }
        out_.end_array().key("nodes").begin_array();
        for (size_t i = 0; i < tab.nodes.size(); ++i)
            write_node(tab, i);
        out_.end_array().end_object();
    }

    void write_node(const Tab& tab, size_t index) {
        const Node& node = tab.nodes[index];
        out_.begin_object().member("id", static_cast<int64_t>(index));
        out_.member("kind", kKindNames[static_cast<size_t>(node.kind)]);
        if (!node.role.empty()) out_.member("role", node.role);
        out_.member("title", node.title).member("help", node.help);
        out_.member("statement", node.statement).member("root", node.is_root);
        place(node.span);
        if (node.kind == NodeKind::kOpaque) out_.member("text", text(node.span));
        if (node.declared.file > server::Analysis::kDocument) {
            out_.member("module", analysis_.path_of(node.declared.file).stem().string());
        }
        out_.key("ports").begin_array();
        for (const Port& port : node.ports)
            write_port(port);
        out_.end_array().key("outputs").begin_array();
        for (const Output& one : node.outputs)
            out_.begin_object().member("name", one.name).member("type", one.type).end_object();
        out_.end_array();
        write_troubles(tab, index);
        out_.end_object();
    }

    void write_port(const Port& port) {
        out_.begin_object().member("label", port.label).member("type", port.type);
        out_.member("wants", port.wants).member("text", text(port.span));
        out_.member("plain", port.is_plain);
        place(port.span);
        if (port.from.exists()) {
            out_.member("from", port.from.node).member("output", port.from.output);
            out_.member("suffix", port.suffix);
        }
        out_.end_object();
    }

    /// Messages stand at the innermost node that they are about.
    void write_troubles(const Tab& tab, size_t index) {
        std::vector<const diag::Diagnostic*> mine;
        for (const diag::Diagnostic& one : messages_) {
            if (one.span.file != server::Analysis::kDocument) continue;
            int best = -1;
            uint32_t least = UINT32_MAX;
            for (size_t i = 0; i < tab.nodes.size(); ++i) {
                const source::Span& span = tab.nodes[i].span;
                const bool holds = span.file == server::Analysis::kDocument &&
                                   span.begin <= one.span.begin && one.span.begin < span.end;
                if (!holds || span.end - span.begin >= least) continue;
                least = span.end - span.begin;
                best = static_cast<int>(i);
            }
            if (best == static_cast<int>(index)) mine.push_back(&one);
        }
        if (mine.empty()) return;
        out_.key("troubles").begin_array();
        for (const diag::Diagnostic* one : mine) {
            out_.begin_object().member("severity", severity(*one)).member("message", one->message);
            out_.end_object();
        }
        out_.end_array();
    }

    void write_uniform(const Uniform& one) {
        out_.begin_object().member("name", one.name).member("type", one.type);
        out_.member("fablet", one.fablet).member("uses", one.uses);
        place(one.declared);
        out_.member("default", text(one.init)).key("annotations").begin_object();
        for (const auto& [name, value] : one.annotations)
            out_.member(name, value);
        out_.end_object().end_object();
    }

    static const char* severity(const diag::Diagnostic& one) {
        return one.severity == diag::Severity::kError ? "error" : "warning";
    }

    void write_message(const diag::Diagnostic& one) {
        source::Span span = one.span;
        std::string message = one.message;
        if (span.file != server::Analysis::kDocument) {
            message.insert(
                0, "in `" + std::string(analysis_.reported_sources().name(span.file)) + "`: ");
            span = {server::Analysis::kDocument, 0, 0};
            for (const diag::Note& note : one.notes) {
                if (note.span.file == server::Analysis::kDocument) span = note.span;
            }
        }
        out_.begin_object().member("severity", severity(one)).member("message", message);
        place(span);
        out_.key("help").begin_array();
        for (const std::string& help : one.helps)
            out_.value(help);
        out_.end_array().end_object();
    }

    const server::Analysis& analysis_;
    const Graph& graph_;
    JsonText& out_;
    Units units_;
    std::vector<diag::Diagnostic> messages_;
};

}  // namespace

void write_graph(const server::Analysis& analysis, const Graph& graph, JsonText* out) {
    Writer(analysis, graph, out).write();
}

}  // namespace openfab::graph
