// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads the values of a request. All come from a page, or from anyone who can connect, so each has
// limits, and none names a file.

#include <cstdint>
#include <string>

#include "base/result.h"
#include "tools/viewer/http_server.h"
#include "tools/viewer/tile.h"

namespace openfab::viewer {

/// Collects values; after the first that is wrong, failed() says what, and the rest read as their
/// least.
class Parameters {
  public:
    explicit Parameters(const Request& request) : request_(request) {}

    /// A whole number from `least` to `most`.
    int32_t whole(const std::string& name, int32_t least, int32_t most);
    /// Same, or `otherwise` where it is not given.
    int32_t whole_or(const std::string& name, int32_t otherwise, int32_t least, int32_t most);
    /// One of these words, separated by `|`; returns its place.
    int32_t one_of(const std::string& name, const std::string& words);
    /// RRGGBBAA for each code from 0; codes beyond are magenta, so that damage is seen.
    Palette palette(const std::string& name);

    const std::string& failed() const { return failed_; }

  private:
    const std::string* find(const std::string& name);
    void fail(const std::string& name, const std::string& rule);

    const Request& request_;
    std::string failed_;
};

}  // namespace openfab::viewer
