// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/graph/service.h"

#include <memory>
#include <string>

#include "compiler/graph/edit.h"
#include "compiler/graph/picture.h"

namespace openfab::graph {

namespace {

constexpr size_t kMaxTextBytes = 4u << 20;

std::string text_of(const JsonValue& params, const char* name) {
    const JsonValue* found = member_of(params, name);
    return found == nullptr ? std::string() : found->text;
}

Result<void> edit(const server::Analysis& before, const std::filesystem::path& path,
                  const JsonValue& params, JsonText* out) {
    const JsonValue* json = member_of(params, "action");
    if (json == nullptr) return user_error("an action is missing");
    const Result<Action> action = action_of(*json);
    if (!action) return action.error();
    const Result<std::string> made = edited(before, graph_of(before), *action);
    if (!made) return made.error();
    const server::Analysis after(path, *made, {});
    if (Result<void> fine = still_fine(before, after); !fine) return fine.error();
    out->begin_object().member("text", *made).key("graph");
    write_graph(after, graph_of(after), out);
    out->end_object();
    return {};
}

}  // namespace

std::optional<Result<void>> answer(std::string_view method, const JsonValue& params,
                                   JsonText* out) {
    if (!params.is(JsonValue::Kind::kObject) && method.starts_with("openfl/"))
        return Result<void>(user_error("parameters are missing"));
    if (method == "openfl/picture") {
        const JsonValue* json = member_of(params, "action");
        if (json == nullptr) return Result<void>(user_error("an action is missing"));
        const Result<Action> of = action_of(*json);
        return of ? write_picture(of->signature, of->module, out) : Result<void>(of.error());
    }
    const bool graph = method == "openfl/graph";
    const bool palette = method == "openfl/palette";
    if (!graph && !palette && method != "openfl/edit") return std::nullopt;
    const std::string text = text_of(params, "text");
    if (text.size() > kMaxTextBytes)
        return Result<void>(user_error("the document is larger than 4 MiB"));
    const std::filesystem::path path = text_of(params, "path");
    const server::Analysis analysis(path, text, {});
    if (graph) {
        write_graph(analysis, graph_of(analysis), out);
        return Result<void>();
    }
    if (palette) {
        write_entries(entries_of(analysis), out);
        return Result<void>();
    }
    return edit(analysis, path, params, out);
}

}  // namespace openfab::graph
