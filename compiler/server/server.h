// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The language server without its transport: messages in, messages out. It reads files only as imports of documents, by
// the compiler's own way, and never writes one.

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/json.h"
#include "compiler/server/answers.h"

namespace openfab::server {

class Server {
  public:
    /// The largest document; a larger one is not analysed.
    static constexpr size_t kMaxDocumentBytes = 4u << 20;

    /// Answers further methods; nothing if a method is none of them.
    using More = std::function<std::optional<Result<void>>(std::string_view method,
                                                           const JsonValue& params, JsonText* out)>;
    explicit Server(More more = {}) : more_(std::move(more)) {}

    /// Takes one message of JSON-RPC 2.0. Returns those to send: an answer if it was a request.
    std::vector<std::string> handle(std::string_view message);
    /// Analyses the documents that changed since, and returns what to publish about them. Between messages that are
    /// already there it need not be called, so that typing is not slowed down.
    std::vector<std::string> publish();
    bool has_changes() const { return !changed_.empty(); }

    /// True once the client asked to exit.
    bool exited() const { return exited_; }
    /// The exit code: 0 after `shutdown`, else 1.
    int exit_code() const { return shut_down_ ? 0 : 1; }

  private:
    /// Answers a request into `out`; an error is sent instead.
    Result<void> answer(std::string_view method, const JsonValue& params, JsonText* out);
    void notice(std::string_view method, const JsonValue& params);
    void initialize(const JsonValue& params, JsonText* out);
    void change(const JsonValue& params);
    Result<Query> query_of(const JsonValue& params, bool with_position);
    Range range_of(const JsonValue* range) const;

    More more_;
    Workspace workspace_;
    std::set<std::string> changed_;
    bool initialized_ = false;
    bool shut_down_ = false;
    bool exited_ = false;
};

}  // namespace openfab::server
