// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// See plain.h.

#include "tests/support/plain_threads/tbb/plain.h"

namespace tbb {

class global_control {
  public:
    enum parameter { max_allowed_parallelism };
    global_control(parameter /*which*/, size_t value)
        : before_(plain::allowed.exchange(static_cast<int>(value))) {}
    ~global_control() { plain::allowed.store(before_); }
    global_control(const global_control&) = delete;
    global_control& operator=(const global_control&) = delete;

  private:
    int before_;
};

}  // namespace tbb
