// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Hashes for tables over strangers' input, which cannot know what collides: they depend on a secret that is another one in
// each process. So nothing that is written may depend on them, nor on the order of a table that uses them.

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace openfab {

class KeyedHash {
  public:
    using is_transparent = void;

    KeyedHash();

    /// Mixes one number more into a hash, which begins with `start`.
    uint64_t start() const { return first_; }
    uint64_t mix(uint64_t hash, uint64_t value) const {
        // The high half of the product depends on all bits of both, and on the secret.
        __extension__ using Wide = unsigned __int128;
        const Wide product = static_cast<Wide>(hash ^ value) * second_;
        return static_cast<uint64_t>(product) ^ static_cast<uint64_t>(product >> 64);
    }

    size_t operator()(uint64_t value) const { return mix(mix(first_, value), first_); }
    size_t operator()(int32_t value) const {
        return (*this)(uint64_t{static_cast<uint32_t>(value)});
    }
    size_t operator()(std::string_view text) const;

  private:
    uint64_t first_, second_;
};

}  // namespace openfab
