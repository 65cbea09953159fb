// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/live_api.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

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

/// What a request asks of a world. Of its values, the first that is wrong is told by answer().
class Call {
  public:
    Call(Live* live, const Request& request) : live_(live), request_(request), query_(request) {}

    Live& live() { return *live_; }
    /// The address behind `/api/`.
    std::string method() const { return request_.path.substr(sizeof("/api/") - 1); }
    const std::string& bytes() const { return request_.body; }
    /// Reads the body as JSON.
    void read_json() {
        Result<JsonValue> json = parse_json(request_.body, "request", kMostJsonBytes);
        if (json) json_ = std::move(*json);
        if (!json) fail(400, json.error().text());
    }

    // Members of the JSON.

    const JsonValue& value(const char* name) {
        static const JsonValue nothing;
        const JsonValue* member = member_of(json_, name);
        if (member == nullptr) fail(400, wrong(name, "missing"));
        return member == nullptr ? nothing : *member;
    }
    std::string text(const char* name) {
        const JsonValue& member = value(name);
        if (!member.is(JsonValue::Kind::kString)) fail(400, wrong(name, messages::kNotAText));
        return member.text;
    }
    std::string source_text() {
        std::string source = text("text");
        if (static_cast<int64_t>(source.size()) > client::kLargestSource)
            fail(413, messages::kTooLargeForFablet);
        return source;
    }
    int32_t whole(const char* name, int32_t least, int32_t most) {
        const JsonValue& member = value(name);
        if (member.is(JsonValue::Kind::kNumber) && member.number >= least &&
            member.number <= most && member.number == std::floor(member.number))
            return static_cast<int32_t>(member.number);
        fail(400, wrong(name, messages::kNotAWholeNumber));
        return least;
    }
    int32_t fablet() { return whole("fablet", 0, INT32_MAX); }
    bool truth_or(const char* name, bool otherwise) const {
        const JsonValue* member = member_of(json_, name);
        return member != nullptr && member->is(JsonValue::Kind::kBool) ? member->boolean
                                                                       : otherwise;
    }

    // Values of the address.

    int32_t asked_whole(const char* name, int32_t most) { return query_.whole(name, 0, most); }
    int32_t asked_whole_or(const char* name, int32_t otherwise, int32_t most) {
        return query_.whole_or(name, otherwise, 0, most);
    }
    std::string asked_name() {
        const auto name = request_.query.find("name");
        if (name == request_.query.end()) fail(400, messages::kNameMissing);
        return name == request_.query.end() ? std::string() : name->second;
    }

    /// Answers by what `act` returns, a Result or nothing; or by what is wrong with the values.
    template <typename Act>
    Answer answer(const Act& act) {
        if (!query_.failed().empty()) fail(400, query_.failed());
        if (status_ != 0) return refusal(status_, why_);
        if constexpr (std::is_void_v<decltype(act())>) {
            act();
            return fine();
        } else {
            return answer_of(act());
        }
    }

  private:
    static std::string wrong(const std::string& name, const std::string& what) {
        return "`" + name + "` is " + what;
    }
    void fail(int status, const std::string& why) {
        if (status_ != 0) return;
        status_ = status;
        why_ = why;
    }

    Live* live_;
    const Request& request_;
    Parameters query_;
    JsonValue json_;
    int status_ = 0;  ///< of what is wrong; 0: nothing
    std::string why_;
};

Answer texture(Call& call) {
    const bool is_volume = call.asked_whole_or("volume", 0, 1) == 1;
    const std::string name = call.asked_name();
    std::string png;
    Answer answer = call.answer([&]() -> Result<void> {
        const Result<std::vector<uint8_t>> bytes = call.live().texture(name, is_volume);
        if (!bytes) return bytes.error();
        png.assign(bytes->begin(), bytes->end());
        return {};
    });
    return png.empty() ? std::move(answer) : Answer{200, "image/png", std::move(png)};
}

Answer drawn(Call& call, const JsonValue* action) {
    const int32_t fablet = call.fablet();
    const std::string text = call.source_text();
    return call.answer([&] { return call.live().graph(call.method(), fablet, text, action); });
}

Answer graph(Call& call) {
    return drawn(call, nullptr);
}

Answer act_on_graph(Call& call) {
    return drawn(call, &call.value("action"));
}

Answer look(Call& call) {
    const int32_t fablet = call.fablet();
    const std::string text = call.source_text();
    const JsonValue& action = call.value("action");
    return call.answer([&] { return call.live().look(fablet, text, action); });
}

Answer save(Call& call) {
    const int32_t fablet = call.fablet();
    const std::string text = call.source_text(), stamp = call.text("stamp");
    return call.answer([&] { return call.live().save(fablet, text, stamp); });
}

Answer check(Call& call) {
    const int32_t fablet = call.fablet();
    const std::string text = call.source_text();
    return call.answer([&] { return call.live().check(fablet, text); });
}

Answer try_value(Call& call) {
    const int32_t fablet = call.fablet();
    const std::string text = call.source_text();
    const std::string name = call.text("name"), uniform = call.text("uniform");
    const JsonValue& value = call.value("value");
    return call.answer([&] { return call.live().try_value(fablet, text, name, uniform, value); });
}

Answer set(Call& call) {
    const std::string object = call.text("object"), uniform = call.text("uniform");
    const JsonValue& value = call.value("value");
    return call.answer([&] { return call.live().set(object, uniform, value); });
}

Answer keep_places(Call& call) {
    const int32_t fablet = call.fablet();
    const JsonValue& places = call.value("places");
    return call.answer([&] { return call.live().keep_places(fablet, places); });
}

Answer upload(Call& call) {
    const int32_t at = call.asked_whole("at", INT32_MAX);
    const std::string name = call.asked_name();
    return call.answer([&] { return call.live().files().upload(name, at, call.bytes()); });
}

Answer use_file(Call& call) {
    const std::string name = call.text("name"), object = call.text("object");
    const bool repair = call.truth_or("repair", false);
    return call.answer([&] { return call.live().use_file(name, object, repair); });
}

Answer edit_part(Call& call) {
    const JsonValue& edits = call.value("edits");
    return call.answer([&] { return call.live().files().edit_part(edits); });
}

/// How a request is read.
enum class Reads : uint8_t {
    kAddress,  ///< a GET
    kJson,     ///< a POST with JSON
    kBytes,    ///< a POST with any bytes
};

struct Row {
    const char* path;
    Reads reads;
    Answer (*answer)(Call& call);
};

constexpr Row kRows[] = {
    {"/api/live", Reads::kAddress, [](Call& call) { return fine(call.live().details()); }},
    {"/api/source", Reads::kAddress,
     [](Call& call) {
         const int32_t fablet = call.asked_whole("fablet", INT32_MAX);
         return call.answer([&] { return call.live().source(fablet); });
     }},
    {"/api/places", Reads::kAddress,
     [](Call& call) {
         const int32_t fablet = call.asked_whole("fablet", INT32_MAX);
         return call.answer([&] { return call.live().places(fablet); });
     }},
    {"/api/texture", Reads::kAddress, texture},
    {"/api/check", Reads::kJson, check},
    {"/api/graph", Reads::kJson, graph},
    {"/api/palette", Reads::kJson, graph},
    {"/api/edit", Reads::kJson, act_on_graph},
    {"/api/picture", Reads::kJson, act_on_graph},
    {"/api/assist", Reads::kJson, act_on_graph},
    {"/api/look", Reads::kJson, look},
    {"/api/source", Reads::kJson, save},
    {"/api/places", Reads::kJson, keep_places},
    {"/api/set", Reads::kJson, set},
    {"/api/try", Reads::kJson, try_value},
    {"/api/untry", Reads::kJson,
     [](Call& call) { return call.answer([&] { call.live().end_try(); }); }},
    {"/api/draft", Reads::kJson,
     [](Call& call) {
         const int32_t draft = call.whole("draft", 0, kMostDraft);
         return call.answer([&] { call.live().set_draft(draft); });
     }},
    {"/api/revert", Reads::kJson,
     [](Call& call) { return call.answer([&] { call.live().revert(); }); }},
    {"/api/write", Reads::kJson,
     [](Call& call) { return call.answer([&] { return call.live().write(); }); }},
    {"/api/part", Reads::kJson, edit_part},
    {"/api/unpart", Reads::kJson,
     [](Call& call) { return call.answer([&] { return call.live().files().step_part(false); }); }},
    {"/api/repart", Reads::kJson,
     [](Call& call) { return call.answer([&] { return call.live().files().step_part(true); }); }},
    {"/api/upload", Reads::kBytes, upload},
    {"/api/use", Reads::kJson, use_file},
    {"/api/template", Reads::kJson,
     [](Call& call) {
         const std::string name = call.text("name");
         return call.answer([&] { return call.live().use_template(name); });
     }},
    {"/api/print", Reads::kJson,
     [](Call& call) { return call.answer([&] { return call.live().begin_full_print(); }); }},
    {"/api/stop", Reads::kJson,
     [](Call& call) { return call.answer([&] { call.live().stop_full_print(); }); }},
    {"/api/show", Reads::kJson,
     [](Call& call) {
         const bool full = call.whole("full", 0, 1) == 1;
         return call.answer([&] { return call.live().show_full_print(full); });
     }},
};

}  // namespace

std::optional<Answer> answer_on_world(Live* live, const Request& request) {
    const auto* row = std::find_if(std::begin(kRows), std::end(kRows), [&](const Row& candidate) {
        return request.path == candidate.path &&
               request.post == (candidate.reads != Reads::kAddress);
    });
    if (row == std::end(kRows)) return {};
    if (live == nullptr) return refusal(404, messages::kAPrintNotAWorld);
    if (request.post && !live->watches()) return refusal(403, messages::kWorldOnlyLookedAt);
    Call call(live, request);
    if (row->reads == Reads::kJson) call.read_json();
    return row->answer(call);
}

}  // namespace openfab::viewer
