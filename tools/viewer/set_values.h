// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The values of uniforms that the page has set and that are not in the world's file yet.

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "client/print_words.h"

namespace openfab::viewer {

struct SetValue {
    std::string object, uniform, value;  ///< value is JSON
    std::string trouble;                 ///< why the last print refused it

    std::string setting() const { return object + '.' + uniform + '=' + value; }
    bool is_of(const std::string& of_object, const std::string& of_uniform) const {
        return object == of_object && uniform == of_uniform;
    }
};

/// Thread-safe.
class SetValues {
  public:
    struct List {
        std::vector<SetValue> values;
        int64_t edition = 0;  ///< of these values; another where one is set or forgotten

        /// The value of an object's uniform, or nullptr.
        const SetValue* find(const std::string& object, const std::string& uniform) const;
        /// As `openfab print --set` takes them.
        std::vector<std::string> settings() const;
    };
    List list() const;
    void set(const std::string& object, const std::string& uniform, const std::string& value);
    void forget_all();
    /// Forgets those of a list; a value that was set since stays.
    void forget(const List& written);
    /// An object's uniform has another name now.
    void rename(const std::string& object, const std::string& from, const std::string& to);
    /// Notes what a print says of values. Returns what it says of others.
    client::PrintWords note_troubles(const client::PrintWords& words);

  private:
    mutable std::mutex mutex_;
    List list_;
};

}  // namespace openfab::viewer
