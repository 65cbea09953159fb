// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Messages of a program that closes standard error to the libraries that it calls (base/say.h).

namespace openfab {

/// Keeps standard error for our own messages, and closes it to all else, while it exists. Under sanitizers,
/// which report there, too, it stays open.
class OwnStandardError {
  public:
    OwnStandardError();
    ~OwnStandardError();
    OwnStandardError(const OwnStandardError&) = delete;
    OwnStandardError& operator=(const OwnStandardError&) = delete;

  private:
    int before_;  ///< where messages went
    int kept_;
};

/// Returns the descriptor to which messages go.
int message_descriptor();

}  // namespace openfab
