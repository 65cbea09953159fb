// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The server of the page and of what it asks. It lets through what comes from our own page alone:
// the `Host` header names this machine, so that no other site's name can be pointed here, and all
// but the page's own files wants the token, which is in the address that the user opens.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>

#include "base/embedded_text.h"
#include "base/result.h"

namespace openfab::viewer {

struct Request {
    std::string path;
    bool post = false;
    std::map<std::string, std::string> query;
    std::string body;
};

struct Answer {
    int status = 200;
    std::string type = "application/json";
    std::string body;
    /// Whether the same address always gives the same bytes.
    bool lasting = false;
    int32_t step = -1;  ///< goes into a header; -1: none
};

/// Called from several threads at once.
using Handler = std::function<Answer(const Request&)>;

struct ServerOptions {
    std::string address = "127.0.0.1";  ///< to listen at
    int32_t port = 0;                   ///< 0: any that is free
    std::span<const EmbeddedText> page;
};

class HttpServer {
  public:
    /// Starts listening; `url` receives the address for the browser. Usage errors: an address that
    /// is none, a port that is taken.
    static Result<std::unique_ptr<HttpServer>> listen(const ServerOptions& options, Handler handler,
                                                      std::string* url);
    ~HttpServer();
    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;

    /// Answers requests; returns only on an error.
    Result<void> serve();

  private:
    struct Implementation;
    explicit HttpServer(std::unique_ptr<Implementation> implementation);
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace openfab::viewer
