// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/server/server.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace openfab::server {

namespace {

/// Codes of JSON-RPC and of the protocol.
constexpr int32_t kParseError = -32700;
constexpr int32_t kInvalidRequest = -32600;
constexpr int32_t kMethodNotFound = -32601;
constexpr int32_t kInvalidParams = -32602;
constexpr int32_t kNotInitialized = -32002;
constexpr int32_t kRequestFailed = -32803;

/// A tree of JSON with its text; a document takes most of it.
constexpr int64_t kMaxJsonBytes = 256 << 20;

const JsonValue kNothing;

const JsonValue& at(const JsonValue& object, std::string_view key) {
    const JsonValue* found = object.is(JsonValue::Kind::kObject) ? member_of(object, key) : nullptr;
    return found == nullptr ? kNothing : *found;
}

int64_t whole(const JsonValue& value) {
    constexpr double kMost = 2147483647;
    if (!value.is(JsonValue::Kind::kNumber) || !std::isfinite(value.number)) return 0;
    return static_cast<int64_t>(std::clamp(value.number, -kMost, kMost));
}

double fraction(const JsonValue& value) {
    return value.is(JsonValue::Kind::kNumber) && std::isfinite(value.number)
               ? std::clamp(value.number, 0.0, 1.0)
               : 0;
}

std::string error_message(const JsonValue& id, int32_t code, const std::string& message) {
    JsonText out;
    out.begin_object().member("jsonrpc", "2.0").member("id", id).key("error").begin_object();
    out.member("code", code).member("message", message).end_object().end_object();
    return out.take();
}

/// A request about a document whose place does not matter, or does.
using Answer = void (*)(const Query&, JsonText*);
struct Method {
    std::string_view name;
    bool with_position;
    Answer answer;
};
constexpr Method kMethods[] = {
    {"textDocument/hover", true, hover},
    {"textDocument/completion", true, complete},
    {"textDocument/signatureHelp", true, signature_help},
    {"textDocument/definition", true, definition},
    {"textDocument/documentSymbol", false, document_symbols},
    {"textDocument/semanticTokens/full", false, semantic_tokens},
    {"textDocument/formatting", false, formatting},
    {"textDocument/documentColor", false, colors},
};

}  // namespace

std::vector<std::string> Server::handle(std::string_view message) {
    const Result<JsonValue> read = parse_json(message, "message", kMaxJsonBytes);
    if (!read) return {error_message(kNothing, kParseError, read.error().text())};
    const JsonValue& method = at(*read, "method");
    const JsonValue& id = at(*read, "id");
    const bool known_id = id.is(JsonValue::Kind::kNumber) || id.is(JsonValue::Kind::kString);
    if (!method.is(JsonValue::Kind::kString)) {
        // An answer to a question: we ask none.
        if (known_id && (read->find("result") != nullptr || read->find("error") != nullptr))
            return {};
        return {
            error_message(known_id ? id : kNothing, kInvalidRequest, "a message has no method")};
    }
    const JsonValue& params = at(*read, "params");
    if (!known_id) {
        notice(method.text, params);
        return {};
    }
    if (!initialized_ && method.text != "initialize")
        return {error_message(id, kNotInitialized, "the first request must be `initialize`")};
    if (shut_down_)
        return {error_message(id, kInvalidRequest, "nothing follows `shutdown` but `exit`")};
    JsonText out;
    out.begin_object().member("jsonrpc", "2.0").member("id", id).key("result");
    const Result<void> answered = answer(method.text, params, &out);
    if (!answered) {
        const Error& error = answered.error();
        const int32_t code = error.code == ErrorCode::kUsage       ? kMethodNotFound
                             : error.code == ErrorCode::kUserInput ? kRequestFailed
                                                                   : kInvalidParams;
        return {error_message(id, code, error.text())};
    }
    out.end_object();
    return {out.take()};
}

Result<void> Server::answer(std::string_view method, const JsonValue& params, JsonText* out) {
    if (method == "initialize") {
        initialize(params, out);
        return {};
    }
    if (method == "shutdown") {
        shut_down_ = true;
        out->null();
        return {};
    }
    if (method == "openfl/libraryText") {
        out->value(Workspace::library_text(at(params, "uri").text));
        return {};
    }
    for (const Method& m : kMethods) {
        if (m.name != method) continue;
        const Result<Query> query = query_of(params, m.with_position);
        if (!query) return query.error();
        m.answer(*query, out);
        return {};
    }
    if (more_) {
        if (std::optional<Result<void>> answered = more_(method, params, out)) return *answered;
    }
    const bool ranged =
        method == "textDocument/codeAction" || method == "textDocument/colorPresentation";
    const bool placed = method == "textDocument/references" ||
                        method == "textDocument/prepareRename" || method == "textDocument/rename";
    if (!ranged && !placed) return usage_error(fmt::format("there is no method `{}`", method));
    const Result<Query> query = query_of(params, placed);
    if (!query) return query.error();
    if (method == "textDocument/references") {
        references(*query, at(at(params, "context"), "includeDeclaration").boolean, out);
        return {};
    }
    if (method == "textDocument/prepareRename") return prepare_rename(*query, out);
    if (method == "textDocument/rename") return rename(*query, at(params, "newName").text, out);
    const Range range = range_of(&at(params, "range"));
    const uint32_t begin = query->document->text.offset(range.start, workspace_.encoding);
    const uint32_t end =
        std::max(begin, query->document->text.offset(range.end, workspace_.encoding));
    if (method == "textDocument/codeAction") {
        code_actions(*query, begin, end, out);
        return {};
    }
    const JsonValue& color = at(params, "color");
    color_presentations(*query, fraction(at(color, "red")), fraction(at(color, "green")),
                        fraction(at(color, "blue")), begin, end, out);
    return {};
}

void Server::initialize(const JsonValue& params, JsonText* out) {
    initialized_ = true;
    const JsonValue& encodings = at(at(at(params, "capabilities"), "general"), "positionEncodings");
    // UTF-16 unless bytes are what the client likes best.
    if (!encodings.items.empty() && encodings.items[0].text == "utf-8")
        workspace_.encoding = Encoding::kUtf8;
    out->begin_object().key("capabilities").begin_object();
    out->member("positionEncoding", workspace_.encoding == Encoding::kUtf8 ? "utf-8" : "utf-16");
    constexpr int32_t kIncremental = 2;
    out->key("textDocumentSync")
        .begin_object()
        .member("openClose", true)
        .member("change", kIncremental)
        .end_object();
    for (const char* name :
         {"hoverProvider", "definitionProvider", "referencesProvider", "documentSymbolProvider",
          "documentFormattingProvider", "colorProvider"})
        out->member(name, true);
    out->key("completionProvider").begin_object().key("triggerCharacters").begin_array();
    out->value(".").value("@").end_array().end_object();
    out->key("signatureHelpProvider").begin_object().key("triggerCharacters").begin_array();
    out->value("(").value(",").end_array().end_object();
    out->key("renameProvider").begin_object().member("prepareProvider", true).end_object();
    out->key("codeActionProvider")
        .begin_object()
        .key("codeActionKinds")
        .begin_array()
        .value("quickfix");
    out->end_array().end_object();
    out->key("semanticTokensProvider").begin_object().key("legend");
    semantic_legend(out);
    out->member("full", true).end_object();
    out->end_object()
        .key("serverInfo")
        .begin_object()
        .member("name", "openflc")
        .end_object()
        .end_object();
}

void Server::notice(std::string_view method, const JsonValue& params) {
    if (method == "exit") exited_ = true;
    if (!initialized_ || shut_down_) return;
    const JsonValue& document = at(params, "textDocument");
    const std::string& uri = at(document, "uri").text;
    if (uri.empty()) return;
    if (method == "textDocument/didOpen") {
        Document& opened =
            workspace_.open(uri, whole(at(document, "version")), at(document, "text").text);
        for (const std::string& one : workspace_.changed(opened))
            changed_.insert(one);
    } else if (method == "textDocument/didChange") {
        change(params);
    } else if (method == "textDocument/didClose") {
        const Document* closed = workspace_.find(uri);
        if (closed == nullptr) return;
        for (const std::string& one : workspace_.changed(*closed))
            changed_.insert(one);
        workspace_.close(uri);
    }
}

void Server::change(const JsonValue& params) {
    Document* document = workspace_.find(at(at(params, "textDocument"), "uri").text);
    if (document == nullptr) return;
    for (const JsonValue& one : at(params, "contentChanges").items) {
        const JsonValue& range = at(one, "range");
        if (range.is(JsonValue::Kind::kObject)) {
            document->text.replace(range_of(&range), at(one, "text").text, workspace_.encoding);
        } else {
            document->text.set(at(one, "text").text);
        }
    }
    document->version = whole(at(at(params, "textDocument"), "version"));
    for (const std::string& one : workspace_.changed(*document))
        changed_.insert(one);
}

Range Server::range_of(const JsonValue* range) const {
    const auto position = [](const JsonValue& value) {
        return Position{whole(at(value, "line")), whole(at(value, "character"))};
    };
    return {position(at(*range, "start")), position(at(*range, "end"))};
}

Result<Query> Server::query_of(const JsonValue& params, bool with_position) {
    const std::string& uri = at(at(params, "textDocument"), "uri").text;
    Document* document = workspace_.find(uri);
    if (document == nullptr)
        return internal_error(fmt::format("the document `{}` is not open", uri));
    if (document->text.text().size() > kMaxDocumentBytes)
        return user_error("the document is larger than 4 MiB");
    Query query{&workspace_, document, &workspace_.analysis(document), 0};
    if (with_position) {
        const JsonValue& position = at(params, "position");
        query.offset = document->text.offset(
            {whole(at(position, "line")), whole(at(position, "character"))}, workspace_.encoding);
    }
    return query;
}

std::vector<std::string> Server::publish() {
    std::vector<std::string> out;
    for (const std::string& uri : std::exchange(changed_, {})) {
        JsonText message;
        message.begin_object()
            .member("jsonrpc", "2.0")
            .member("method", "textDocument/publishDiagnostics");
        message.key("params");
        Document* document = workspace_.find(uri);
        const bool analysed =
            document != nullptr && document->text.text().size() <= kMaxDocumentBytes;
        if (analysed) {
            diagnostics({&workspace_, document, &workspace_.analysis(document), 0}, &message);
        } else {
            message.begin_object()
                .member("uri", uri)
                .key("diagnostics")
                .begin_array()
                .end_array()
                .end_object();
        }
        message.end_object();
        out.push_back(message.take());
    }
    return out;
}

}  // namespace openfab::server
