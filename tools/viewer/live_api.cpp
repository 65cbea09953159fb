// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/live_api.h"

#include <cmath>
#include <string>

#include "base/json.h"
#include "tools/viewer/messages.h"
#include "tools/viewer/parameters.h"
#include "tools/viewer/print_api.h"

namespace openfab::viewer {

namespace {

constexpr int32_t kMostDraft = 1000;
/// A tree of JSON may take many times its text.
constexpr int64_t kMostJsonBytes = 32 << 20;

Answer fine(std::string json = "{}") {
    return {200, "application/json", std::move(json)};
}

template <typename T>
Answer answer_of(const Result<T>& result) {
    if (!result)
        return refusal(result.error().code == ErrorCode::kUserInput ? 422 : 500,
                       result.error().text());
    if constexpr (std::is_void_v<T>) {
        return fine();
    } else {
        return fine(*result);
    }
}

/// Members of a request's body; what is wrong with one is told once, at the end.
class Body {
  public:
    explicit Body(const JsonValue& json) : json_(json) {}

    const JsonValue& value(const char* name) {
        static const JsonValue nothing;
        const JsonValue* found = member_of(json_, name);
        if (found == nullptr) fail(name, "missing");
        return found == nullptr ? nothing : *found;
    }
    std::string text(const char* name) {
        const JsonValue& found = value(name);
        if (!found.is(JsonValue::Kind::kString)) fail(name, messages::kNotAText);
        return found.text;
    }
    int32_t whole(const char* name, int32_t least, int32_t most) {
        const JsonValue& found = value(name);
        if (found.is(JsonValue::Kind::kNumber) && found.number >= least && found.number <= most &&
            found.number == std::floor(found.number))
            return static_cast<int32_t>(found.number);
        fail(name, messages::kNotAWholeNumber);
        return least;
    }
    bool truth_or(const char* name, bool otherwise) const {
        const JsonValue* found = member_of(json_, name);
        return found != nullptr && found->is(JsonValue::Kind::kBool) ? found->boolean : otherwise;
    }
    const std::string& failed() const { return failed_; }

  private:
    void fail(const std::string& name, const std::string& what) {
        if (failed_.empty()) failed_ = "`" + name + "` is " + what;
    }
    const JsonValue& json_;
    std::string failed_;
};

bool is_graph(const std::string& path) {
    return path == "/api/graph" || path == "/api/edit" || path == "/api/palette" ||
           path == "/api/picture" || path == "/api/look" || path == "/api/assist";
}

Answer post(Live* live, const std::string& path, Body body) {
    if (path == "/api/revert") {
        live->revert();
        return fine();
    }
    if (path == "/api/write") return answer_of(live->write());
    if (path == "/api/print") return answer_of(live->begin_full_print());
    if (path == "/api/stop") {
        live->stop_full_print();
        return fine();
    }
    if (path == "/api/template" || path == "/api/use") {
        const std::string name = body.text("name");
        const std::string object = path == "/api/use" ? body.text("object") : std::string();
        if (!body.failed().empty()) return refusal(400, body.failed());
        if (path == "/api/use")
            return answer_of(live->use_file(name, object, body.truth_or("repair", false)));
        return answer_of(live->use_template(name));
    }
    if (path == "/api/part") {
        const JsonValue& edits = body.value("edits");
        if (!body.failed().empty()) return refusal(400, body.failed());
        return answer_of(live->edit_part(edits));
    }
    if (path == "/api/unpart" || path == "/api/repart")
        return answer_of(live->step_part(path == "/api/repart"));
    if (path == "/api/show") {
        const bool full = body.whole("full", 0, 1) == 1;
        if (!body.failed().empty()) return refusal(400, body.failed());
        return answer_of(live->show_full_print(full));
    }
    if (path == "/api/draft") {
        const int32_t draft = body.whole("draft", 0, kMostDraft);
        if (!body.failed().empty()) return refusal(400, body.failed());
        live->set_draft(draft);
        return fine();
    }
    if (path == "/api/set") {
        const std::string object = body.text("object");
        const std::string uniform = body.text("uniform");
        const JsonValue& value = body.value("value");
        if (!body.failed().empty()) return refusal(400, body.failed());
        return answer_of(live->set(object, uniform, value));
    }
    if (path == "/api/untry") {
        live->end_try();
        return fine();
    }
    const int32_t fablet = body.whole("fablet", 0, INT32_MAX);
    if (path == "/api/places") {
        const JsonValue& places = body.value("places");
        if (!body.failed().empty()) return refusal(400, body.failed());
        return answer_of(live->keep_places(fablet, places));
    }
    const std::string text = body.text("text");
    if (path == "/api/try") {
        const std::string name = body.text("name");
        const std::string uniform = body.text("uniform");
        const JsonValue& value = body.value("value");
        if (!body.failed().empty()) return refusal(400, body.failed());
        if (static_cast<int64_t>(text.size()) > client::kLargestSource)
            return refusal(413, messages::kTooLargeForFablet);
        return answer_of(live->try_value(fablet, text, name, uniform, value));
    }
    const std::string stamp = path == "/api/source" ? body.text("stamp") : std::string();
    const bool acts = is_graph(path) && path != "/api/graph" && path != "/api/palette";
    const JsonValue* action = acts ? &body.value("action") : nullptr;
    if (!body.failed().empty()) return refusal(400, body.failed());
    if (static_cast<int64_t>(text.size()) > client::kLargestSource)
        return refusal(413, messages::kTooLargeForFablet);
    if (path == "/api/look") return answer_of(live->look(fablet, text, *action));
    if (is_graph(path)) return answer_of(live->graph(path.substr(5), fablet, text, action));
    return answer_of(path == "/api/source" ? live->save(fablet, text, stamp)
                                           : live->check(fablet, text));
}

}  // namespace

std::optional<Answer> answer_on_world(Live* live, const Request& request) {
    const std::string& path = request.path;
    const bool reads = path == "/api/live" || path == "/api/source" || path == "/api/texture" ||
                       path == "/api/places";
    const bool writes = path == "/api/places" || path == "/api/check" || path == "/api/source" ||
                        is_graph(path) || path == "/api/set" || path == "/api/draft" ||
                        path == "/api/revert" || path == "/api/write" || path == "/api/print" ||
                        path == "/api/stop" || path == "/api/show" || path == "/api/part" ||
                        path == "/api/unpart" || path == "/api/repart" || path == "/api/try" ||
                        path == "/api/untry" || path == "/api/template" || path == "/api/use" ||
                        path == "/api/upload";
    if (!(request.post ? writes : reads)) return {};
    if (live == nullptr) return refusal(404, messages::kAPrintNotAWorld);
    if (!request.post) {
        if (path == "/api/live") return fine(live->details());
        Parameters in(request);
        if (path == "/api/texture") {
            const int32_t is_volume = in.whole_or("volume", 0, 0, 1);
            const auto name = request.query.find("name");
            if (!in.failed().empty() || name == request.query.end())
                return refusal(400,
                               name == request.query.end() ? messages::kNameMissing : in.failed());
            const Result<std::vector<uint8_t>> png = live->texture(name->second, is_volume == 1);
            if (!png) return answer_of<std::string>(png.error());
            return {{200, "image/png", std::string(png->begin(), png->end())}};
        }
        const int32_t fablet = in.whole("fablet", 0, INT32_MAX);
        if (!in.failed().empty()) return refusal(400, in.failed());
        return answer_of(path == "/api/places" ? live->places(fablet) : live->source(fablet));
    }
    if (!live->watches()) return refusal(403, messages::kWorldOnlyLookedAt);
    if (path == "/api/upload") {
        Parameters in(request);
        const int32_t at = in.whole("at", 0, INT32_MAX);
        const auto name = request.query.find("name");
        if (!in.failed().empty() || name == request.query.end())
            return refusal(400, name == request.query.end() ? messages::kNameMissing : in.failed());
        return answer_of(live->upload(name->second, at, request.body));
    }
    const Result<JsonValue> json = parse_json(request.body, "request", kMostJsonBytes);
    if (!json) return refusal(400, json.error().text());
    return post(live, path, Body(*json));
}

}  // namespace openfab::viewer
