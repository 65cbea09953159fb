// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `openfab view` in the background, and an HTTP client that can also say what a browser never would.

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "base/json.h"
#include "tests/support/process/process.h"

namespace openfab::testing {

struct HttpAnswer {
    int status = 0;                              ///< 0: the connection was closed without one
    std::map<std::string, std::string> headers;  ///< names in small letters
    std::string body;

    /// The body as JSON; fails the test where it is none.
    JsonValue json() const;
};

/// Connects to a port of this machine; fails the test where nothing listens there.
int connect_to(int port);
/// Sends as much as the other end takes.
void send_bytes(int connection, const std::string& bytes);
/// Sends bytes to a port of this machine, and returns all that comes until the other end closes.
std::string send_raw(int port, const std::string& bytes);

class Viewer {
  public:
    /// Starts `openfab view ARGUMENTS…` and waits for its address; fails the test where none comes.
    explicit Viewer(std::vector<std::string> arguments, const std::string& cache = "");
    /// Ends it by Ctrl-C.
    ~Viewer();
    Viewer(const Viewer&) = delete;
    Viewer& operator=(const Viewer&) = delete;

    /// It says this at its start; without the call it says nothing.
    void says(const std::string& text) { said_ = text; }

    int port() const { return port_; }
    const std::string& token() const { return token_; }

    /// With the token.
    HttpAnswer get(const std::string& path) const;
    HttpAnswer post(const std::string& path, const std::string& body) const;
    /// With these header lines besides Connection, and no token of its own.
    HttpAnswer ask(const std::string& method, const std::string& path,
                   const std::vector<std::string>& headers, const std::string& body = "") const;
    std::string host_header() const;
    std::string token_header() const { return "X-OpenFab-Token: " + token_; }
    /// Waits until `api/state` is as wanted; fails the test after a minute.
    JsonValue wait_for(const std::function<bool(const JsonValue& state)>& wanted) const;

  private:
    std::atomic<bool> end_{false};
    std::atomic<bool> ended_{false};
    std::string url_;
    int port_ = 0;
    std::string token_;
    std::string said_;
    Outcome outcome_;
    std::thread thread_;
};

/// A member of an object, which must be there.
const JsonValue& member(const JsonValue& object, const std::string& key);

}  // namespace openfab::testing
