// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/graph/service.h"

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "compiler/graph/assist.h"
#include "compiler/graph/edit.h"
#include "compiler/graph/look.h"
#include "compiler/graph/picture.h"

namespace openfab::graph {

namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxTextBytes = 4u << 20;

std::string text_of(const JsonValue& params, const char* name) {
    const JsonValue* found = member_of(params, name);
    return found == nullptr ? std::string() : found->text;
}

/// What was analysed last: an edit is mostly one of the text that was drawn last, or that the last edit made.
class Kept {
  public:
    std::shared_ptr<const server::Analysis> of(const fs::path& path, const std::string& text) {
        if (last_ == nullptr || path != path_ || text != text_ || times() != times_)
            keep(path, text, std::make_shared<const server::Analysis>(path, text, kNoneOpen));
        return last_;
    }
    void keep(const fs::path& path, const std::string& text,
              std::shared_ptr<const server::Analysis> analysis) {
        path_ = path;
        text_ = text;
        last_ = std::move(analysis);
        times_ = times();
    }

  private:
    /// When each module that may be imported was written; one that comes new counts, too.
    std::map<fs::path, fs::file_time_type> times() const {
        std::map<fs::path, fs::file_time_type> out;
        std::error_code status;
        for (fs::directory_iterator entry(path_.parent_path(), status), end;
             !status && entry != end; entry.increment(status)) {
            std::error_code gone;
            if (entry->path().extension() == ".fl" && entry->path() != path_)
                out[entry->path()] = entry->last_write_time(gone);
        }
        return out;
    }

    static inline const server::OpenFiles kNoneOpen;
    fs::path path_;
    std::string text_;
    std::shared_ptr<const server::Analysis> last_;
    std::map<fs::path, fs::file_time_type> times_;
};

Kept& kept() {
    static Kept one;
    return one;
}

Result<void> edit(const server::Analysis& before, const fs::path& path, const JsonValue& params,
                  JsonText* out) {
    const JsonValue* json = member_of(params, "action");
    if (json == nullptr) return user_error("an action is missing");
    const Result<Action> action = action_of(*json);
    if (!action) return action.error();
    const Result<std::string> made = edited(before, graph_of(before), *action);
    if (!made) return made.error();
    const auto after = std::make_shared<const server::Analysis>(path, *made, server::OpenFiles());
    if (Result<void> fine = still_fine(before, *after); !fine) return fine.error();
    out->begin_object().member("text", *made).key("graph");
    write_graph(*after, graph_of(*after), out);
    out->end_object();
    kept().keep(path, *made, after);
    return {};
}

Result<void> look(const server::Analysis& analysis, const JsonValue& params, JsonText* out) {
    const JsonValue* json = member_of(params, "action");
    if (json == nullptr) return user_error("an action is missing");
    const Result<Action> of = action_of(*json);
    if (!of) return of.error();
    if (has_errors(analysis.diagnostics()))
        return user_error("the text has errors; values are shown when they are mended");
    const Result<Looks> looks =
        looks_of(analysis, graph_of(analysis), of->tab, of->nodes, looked_where(*json));
    if (!looks) return looks.error();
    write_looks(*looks, out);
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
    const bool looks = method == "openfl/look";
    const bool assists = method == "openfl/assist";
    if (!graph && !palette && !looks && !assists && method != "openfl/edit") return std::nullopt;
    const std::string text = text_of(params, "text");
    if (text.size() > kMaxTextBytes)
        return Result<void>(user_error("the document is larger than 4 MiB"));
    const fs::path path = text_of(params, "path");
    const std::shared_ptr<const server::Analysis> last = kept().of(path, text);
    const server::Analysis& analysis = *last;
    if (graph) {
        write_graph(analysis, graph_of(analysis), out);
        return Result<void>();
    }
    if (palette) {
        write_entries(entries_of(analysis), out);
        return Result<void>();
    }
    if (assists) {
        const JsonValue* json = member_of(params, "action");
        if (json == nullptr) return Result<void>(user_error("an action is missing"));
        return assist(analysis, path, text, *json, out);
    }
    return looks ? look(analysis, params, out) : edit(analysis, path, params, out);
}

}  // namespace openfab::graph
