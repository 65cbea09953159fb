// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// XXH3-64 (xxhash.com), the same on every machine.

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <type_traits>

namespace openfab {

/// Hashes contiguous bytes, with the widest vectors that this machine has.
uint64_t xxh3(std::span<const uint8_t> bytes, uint64_t seed);
inline uint64_t xxh3(std::string_view text) {
    return xxh3({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, 0);
}

/// Hashes a stream of bytes; the result equals xxh3 of all of them with seed 0.
class Hasher {
  public:
    Hasher();

    void add_bytes(const void* data, size_t bytes);
    /// Appends the bytes of a number, or of a struct of integers without padding.
    template <typename T>
    void add(const T& value) {
        static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>,
                      "no bytes without a meaning");
        add_bytes(&value, sizeof value);
    }
    /// Appends the length (64 bits), then the bytes, so that `a`, `bc` differs from `ab`, `c`.
    void add_text(std::string_view text) {
        add(static_cast<uint64_t>(text.size()));
        add_bytes(text.data(), text.size());
    }
    uint64_t value() const;

  private:
    struct State;
    struct Delete {
        void operator()(State* state) const;
    };
    std::unique_ptr<State, Delete> state_;
};

}  // namespace openfab
