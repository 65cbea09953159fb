// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Graphs of fablets, by an `openflc lsp` that is kept running: an edit is answered at once. It ends with its line, so
// with the server.

#include <sys/types.h>

#include <filesystem>
#include <mutex>
#include <string>

#include "base/json.h"
#include "base/result.h"

namespace openfab::viewer {

/// Its functions are thread-safe; one request is answered at a time.
class GraphCompiler {
  public:
    /// `programs` is the folder of openflc.
    explicit GraphCompiler(std::filesystem::path programs) : programs_(std::move(programs)) {}
    ~GraphCompiler();
    GraphCompiler(const GraphCompiler&) = delete;
    GraphCompiler& operator=(const GraphCompiler&) = delete;

    /// Returns the answer of a method (compiler/graph/service.h) as JSON; a user error where it is refused.
    Result<std::string> ask(const std::string& method, const std::filesystem::path& path,
                            const std::string& text, const JsonValue* action);

  private:
    Result<void> start();
    void end();
    Result<std::string> exchange(const std::string& message);

    std::filesystem::path programs_;
    std::mutex mutex_;
    pid_t process_ = 0;
    int line_ = -1;
    int64_t number_ = 0;
    std::string received_;
};

}  // namespace openfab::viewer
