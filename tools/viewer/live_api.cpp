// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/live_api.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <string_view>
#include <tuple>
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

/// Returns the answer of what a Result holds: text is JSON, bytes are a PNG.
template <typename T>
Answer answer_of(const Result<T>& result) {
    if (!result)
        return refusal(result.error().code == ErrorCode::kUserInput ? 422 : 500,
                       result.error().text());
    if constexpr (std::is_void_v<T>) {
        return fine();
    } else if constexpr (std::is_same_v<T, std::string>) {
        return fine(*result);
    } else {
        return {200, "image/png", std::string(result->begin(), result->end())};
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

    /// Answers by what `act` returns, a Result, a text or nothing; or by what is wrong with the values.
    template <typename Act>
    Answer answer(const Act& act) {
        if (!query_.failed().empty()) fail(400, query_.failed());
        if (status_ != 0) return refusal(status_, why_);
        using Returned = decltype(act());
        if constexpr (std::is_void_v<Returned>) {
            act();
            return fine();
        } else if constexpr (std::is_same_v<Returned, std::string>) {
            return fine(act());
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

// What values of a call are read by.

auto text(const char* name) {
    return [name](Call& call) { return call.text(name); };
}
auto value(const char* name) {
    return [name](Call& call) { return std::cref(call.value(name)); };
}
auto whole(const char* name, int32_t most) {
    return [=](Call& call) { return call.whole(name, 0, most); };
}
int32_t fablet(Call& call) {
    return call.whole("fablet", 0, INT32_MAX);
}
int32_t asked_fablet(Call& call) {
    return call.asked_whole("fablet", INT32_MAX);
}
std::string source_text(Call& call) {
    return call.source_text();
}
const JsonValue* action(Call& call) {
    return &call.value("action");
}
const JsonValue* no_action(Call& /*call*/) {
    return nullptr;
}

using Answerer = std::function<Answer(Call&)>;

/// Answers by a function of Live, whose arguments are read in this order: the first that is wrong is told.
template <typename Act, typename... Reads>
Answerer by(Act act, Reads... reads) {
    return [=](Call& call) {
        const std::tuple<decltype(reads(call))...> values{reads(call)...};
        return call.answer([&] {
            return std::apply(
                [&](const auto&... of) { return std::invoke(act, call.live(), of...); }, values);
        });
    };
}
/// The same by a function of the world's files.
template <typename Act, typename... Reads>
Answerer by_files(Act act, Reads... reads) {
    return by([=](Live& live, const auto&... of) { return std::invoke(act, live.files(), of...); },
              reads...);
}

/// How a request is read.
enum class Reads : uint8_t {
    kAddress,  ///< a GET
    kJson,     ///< a POST with JSON
    kBytes,    ///< a POST with any bytes
};

struct Row {
    std::string_view path;
    Reads reads;
    Answerer answer;
};

const std::vector<Row>& rows() {
    const auto name = [](Call& call) { return call.asked_name(); };
    const auto at = [](Call& call) { return call.asked_whole("at", INT32_MAX); };
    const auto bytes = [](Call& call) { return std::cref(call.bytes()); };
    const auto method = [](Call& call) { return call.method(); };
    const auto is_volume = [](Call& call) { return call.asked_whole_or("volume", 0, 1) == 1; };
    const auto repair = [](Call& call) { return call.truth_or("repair", false); };
    const auto step = [](bool forward) { return [=](Call& /*call*/) { return forward; }; };
    static const std::vector<Row> kRows = {
        {"live", Reads::kAddress, by(&Live::details)},
        {"source", Reads::kAddress, by(&Live::source, asked_fablet)},
        {"places", Reads::kAddress, by(&Live::places, asked_fablet)},
        {"texture", Reads::kAddress, by(&Live::texture, name, is_volume)},
        {"check", Reads::kJson, by(&Live::check, fablet, source_text)},
        {"graph", Reads::kJson, by(&Live::graph, method, fablet, source_text, no_action)},
        {"palette", Reads::kJson, by(&Live::graph, method, fablet, source_text, no_action)},
        {"edit", Reads::kJson, by(&Live::graph, method, fablet, source_text, action)},
        {"picture", Reads::kJson, by(&Live::graph, method, fablet, source_text, action)},
        {"assist", Reads::kJson, by(&Live::graph, method, fablet, source_text, action)},
        {"look", Reads::kJson, by(&Live::look, fablet, source_text, value("action"))},
        {"source", Reads::kJson, by(&Live::save, fablet, source_text, text("stamp"))},
        {"places", Reads::kJson, by(&Live::keep_places, fablet, value("places"))},
        {"set", Reads::kJson, by(&Live::set, text("object"), text("uniform"), value("value"))},
        {"try", Reads::kJson,
         by(&Live::try_value, fablet, source_text, text("name"), text("uniform"), value("value"))},
        {"untry", Reads::kJson, by(&Live::end_try)},
        {"draft", Reads::kJson, by(&Live::set_draft, whole("draft", kMostDraft))},
        {"revert", Reads::kJson, by(&Live::revert)},
        {"write", Reads::kJson, by(&Live::write)},
        {"part", Reads::kJson, by_files(&WorldFiles::edit_part, value("edits"))},
        {"unpart", Reads::kJson, by_files(&WorldFiles::step_part, step(false))},
        {"repart", Reads::kJson, by_files(&WorldFiles::step_part, step(true))},
        {"upload", Reads::kBytes, by_files(&WorldFiles::upload, name, at, bytes)},
        {"use", Reads::kJson, by(&Live::use_file, text("name"), text("object"), repair)},
        {"template", Reads::kJson, by(&Live::use_template, text("name"))},
        {"print", Reads::kJson, by(&Live::begin_full_print)},
        {"stop", Reads::kJson, by(&Live::stop_full_print)},
        {"show", Reads::kJson, by(&Live::show_full_print, whole("full", 1))},
    };
    return kRows;
}

}  // namespace

std::optional<Answer> answer_on_world(Live* live, const Request& request) {
    constexpr std::string_view kBegin = "/api/";
    if (!request.path.starts_with(kBegin)) return {};
    const auto row = std::find_if(rows().begin(), rows().end(), [&](const Row& candidate) {
        return request.path.substr(kBegin.size()) == candidate.path &&
               request.post == (candidate.reads != Reads::kAddress);
    });
    if (row == rows().end()) return {};
    if (live == nullptr) return refusal(404, messages::kAPrintNotAWorld);
    if (request.post && !live->watches()) return refusal(403, messages::kWorldOnlyLookedAt);
    Call call(live, request);
    if (row->reads == Reads::kJson) call.read_json();
    return row->answer(call);
}

}  // namespace openfab::viewer
