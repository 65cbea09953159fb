// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/graph/look.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "compiler/check/type.h"

namespace openfab::graph {

namespace {

/// A printf has a limit of values, and a picture of colours.
constexpr size_t kMostMaterials = 16;
/// A name that no text has.
constexpr const char* kShown = "openfab_shown";

/// A value that a printf can write, with what converts it.
struct Printed {
    int numbers = 0;  ///< 0: it cannot
    std::string conversion;
};

Printed printed(const std::string& name) {
    const check::Type type = check::find_type(name);
    if (!type.is_numeric()) return {};
    switch (check::component_type(type)) {
        case ir::Type::kFloat:
            return {type.size, "%.9g"};
        case ir::Type::kInt:
            return {type.size, "%d"};
        case ir::Type::kUint:
            return {type.size, "%u"};
        case ir::Type::kBool:
            return type.is_scalar() ? Printed{1, "%d"} : Printed{};
    }
    return {};
}

class Looker {
  public:
    Looker(const server::Analysis& analysis, const Graph& graph, const Tab& tab,
           const LookedWhere& where)
        : analysis_(analysis), graph_(graph), tab_(tab), where_(where) {}

    Looks look(const std::vector<int>& nodes) {
        for (const Uniform& one : graph_.uniforms) {
            const bool mine = one.type == "Material" && one.fablet == tab_.fablet && !is_array(one);
            if (mine && out_.materials.size() < kMostMaterials) out_.materials.push_back(one.name);
        }
        // Points of a surface are their own places, and come before all voxels.
        out_.is_surface = tab_.name == "@Surface";
        if (!out_.is_surface) tell_places();
        for (size_t i = 0; i < tab_.nodes.size(); ++i) {
            const auto id = static_cast<int>(i);
            if (nodes.empty() || std::find(nodes.begin(), nodes.end(), id) != nodes.end()) add(id);
        }
        const std::string_view text = analysis_.sources().text(server::Analysis::kDocument);
        uint32_t at = 0;
        for (const auto& [place, inserted] : inserted_) {
            out_.text += text.substr(at, place - at);
            out_.text += inserted;
            at = place;
        }
        out_.text += text.substr(at);
        return std::move(out_);
    }

  private:
    std::string text(const source::Span& span) const {
        return std::string(analysis_.sources().text(span));
    }

    bool is_array(const Uniform& uniform) const {
        const std::string_view text = analysis_.sources().text(server::Analysis::kDocument);
        const size_t behind = text.find_first_not_of(" \t\r\n", uniform.declared.end);
        return behind != std::string_view::npos && text[behind] == '[' &&
               text.substr(behind, 2) != "[[";
    }

    /// In the volume stage that the voxels are of, where each is.
    void tell_places() {
        const std::string kPlace = ".buildPosition";
        for (const Tab& stage : graph_.tabs) {
            if (stage.name != "@Volume") continue;
            if (!tab_.fablet.empty() && stage.fablet != tab_.fablet) continue;
            for (const Output& input : stage.inputs) {
                if (!input.name.ends_with(kPlace)) continue;
                const std::string attr = input.name.substr(0, input.name.size() - kPlace.size());
                if (const std::string where = condition(attr); !where.empty()) {
                    inserted_[stage.open.end] += fmt::format(" bool {} = {};", kShown, where);
                    only_ = fmt::format(" if ({})", kShown);
                }
                inserted_[stage.open.end] += fmt::format(
                    "{} printf(\"@%d %.9g\", {}.instance, {}.buildPosition);", only_, attr, attr);
                out_.has_places = true;
            }
        }
    }

    /// Whether a voxel is where one looks, as an expression; empty: each is.
    std::string condition(const std::string& attr) const {
        std::string out;
        if (where_.shell_mm > 0)
            out = fmt::format("-distance({}.voxelCenter) < {:.9g}", attr, where_.shell_mm);
        for (size_t axis = 0; axis < where_.within_mm.size(); ++axis) {
            if (!where_.within_mm[axis]) continue;
            const auto& [low, high] = *where_.within_mm[axis];
            const std::string at = fmt::format("{}.buildPosition.{}", attr, "xyz"[axis]);
            out += fmt::format("{}{} >= {:.9g} && {} < {:.9g}", out.empty() ? "" : " && ", at, low,
                               at, high);
        }
        return out;
    }

    void add(int id) {
        const Node& node = tab_.nodes[static_cast<size_t>(id)];
        if (node.kind == NodeKind::kResult) {
            if (!node.ports.empty() && node.ports[0].span.file == server::Analysis::kDocument)
                print(id, node.ports[0].type, text(node.ports[0].span), before(node));
            return;
        }
        if (node.outputs.empty()) return;
        const Output& output = node.outputs[0];
        if (node.kind == NodeKind::kInput) {
            print(id, output.type, node.title, tab_.open.end);
        } else if (node.is_root && !output.name.empty()) {
            const Statement& statement = tab_.statements[static_cast<size_t>(node.statement)];
            if (!statement.returns) print(id, output.type, output.name, statement.span.end);
        } else if (node.kind != NodeKind::kOpaque) {
            print(id, output.type, text(node.span), before(node));
        }
    }

    uint32_t before(const Node& node) const {
        return tab_.statements[static_cast<size_t>(node.statement)].span.begin;
    }

    void print(int id, const std::string& type, const std::string& value, uint32_t at) {
        Printed as = printed(type);
        std::string values = type == "bool" ? fmt::format("(({}) ? 1 : 0)", value) : value;
        if (type == "MaterialComposition" && !out_.materials.empty() && check_name(value)) {
            as = {static_cast<int>(out_.materials.size()), ""};
            values.clear();
            for (const std::string& material : out_.materials) {
                as.conversion += as.conversion.empty() ? "%.9g" : " %.9g";
                values += fmt::format("{}{}.Get({})", values.empty() ? "" : ", ", value, material);
            }
        }
        if (as.numbers == 0) return;
        inserted_[at] +=
            fmt::format("{} printf(\"={} {}\", {});", only_, id, as.conversion, values);
        out_.values.push_back({id, type, as.numbers});
    }

    /// Amounts are asked for one by one: not of a call, which each of them would do again.
    static bool check_name(const std::string& text) {
        return std::all_of(text.begin(), text.end(), [](char c) {
            return c == '_' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
                   (c >= 'A' && c <= 'Z');
        });
    }

    const server::Analysis& analysis_;
    const Graph& graph_;
    const Tab& tab_;
    const LookedWhere& where_;
    std::string only_;  ///< before a printf: where it does
    std::map<uint32_t, std::string> inserted_;
    Looks out_;
};

}  // namespace

LookedWhere looked_where(const JsonValue& action) {
    const auto number = [](const JsonValue& json) {
        return json.is(JsonValue::Kind::kNumber) && std::isfinite(json.number);
    };
    LookedWhere where;
    if (const JsonValue* shell = member_of(action, "shell_mm"); shell != nullptr && number(*shell))
        where.shell_mm = shell->number;
    const JsonValue* within = member_of(action, "within_mm");
    if (within == nullptr) return where;
    for (size_t axis = 0; axis < std::min<size_t>(within->items.size(), 3); ++axis) {
        const std::vector<JsonValue>& limits = within->items[axis].items;
        if (limits.size() == 2 && number(limits[0]) && number(limits[1]))
            where.within_mm[axis] = std::pair(limits[0].number, limits[1].number);
    }
    return where;
}

Result<Looks> looks_of(const server::Analysis& analysis, const Graph& graph, int tab,
                       const std::vector<int>& nodes, const LookedWhere& where) {
    if (tab < 0 || static_cast<size_t>(tab) >= graph.tabs.size())
        return user_error("there is no such stage or function");
    const Tab& of = graph.tabs[static_cast<size_t>(tab)];
    if (of.is_stage && of.name != "@Volume" && of.name != "@Surface")
        return user_error(fmt::format("values of {} cannot be shown", of.name));
    const bool everywhere =
        where.shell_mm <= 0 && std::none_of(where.within_mm.begin(), where.within_mm.end(),
                                            [](const auto& one) { return one.has_value(); });
    if (!everywhere && !of.is_stage)
        return user_error("values of a function are shown over a slice across z");
    return Looker(analysis, graph, of, of.name == "@Volume" ? where : LookedWhere()).look(nodes);
}

void write_looks(const Looks& looks, JsonText* out) {
    out->begin_object().member("text", looks.text).member("places", looks.has_places);
    out->member("surface", looks.is_surface);
    out->key("values").begin_array();
    for (const LookedAt& one : looks.values) {
        out->begin_object().member("node", one.node).member("type", one.type);
        out->member("numbers", one.numbers).end_object();
    }
    out->end_array().key("materials").begin_array();
    for (const std::string& one : looks.materials)
        out->value(one);
    out->end_array().end_object();
}

}  // namespace openfab::graph
