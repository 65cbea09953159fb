// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/graph/assist.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

#include "compiler/server/answers.h"

namespace openfab::graph {

namespace {

int64_t whole(const JsonValue& action, const char* name) {
    constexpr double kMost = 1e9;
    const JsonValue* found = member_of(action, name);
    if (found == nullptr || !found->is(JsonValue::Kind::kNumber) || !std::isfinite(found->number))
        return 0;
    return static_cast<int64_t>(std::clamp(found->number, 0.0, kMost));
}

}  // namespace

Result<void> assist(const server::Analysis& analysis, const std::filesystem::path& path,
                    const std::string& text, const JsonValue& action, JsonText* out) {
    using Answer = void (*)(const server::Query&, JsonText*);
    constexpr std::pair<std::string_view, Answer> kAnswers[] = {
        {"complete", server::complete},
        {"hover", server::hover},
        {"signature", server::signature_help},
        {"format", server::formatting},
    };
    const JsonValue* ask = member_of(action, "ask");
    const auto* found =
        std::find_if(std::begin(kAnswers), std::end(kAnswers),
                     [&](const auto& one) { return ask != nullptr && ask->text == one.first; });
    if (found == std::end(kAnswers))
        return user_error("`ask` is one of complete, hover, signature and format");
    server::Workspace workspace;
    server::Document document;
    document.path = path;
    document.text.set(text);
    const server::Position place{whole(action, "line"), whole(action, "character")};
    const server::Query query{&workspace, &document, &analysis,
                              document.text.offset(place, server::Encoding::kUtf16)};
    found->second(query, out);
    return {};
}

}  // namespace openfab::graph
