// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/keyed_hash.h"

#include <sys/auxv.h>

#include <cstring>

#include "base/hash.h"

namespace openfab {

KeyedHash::KeyedHash() : first_(0x243f6a8885a308d3), second_(0x13198a2e03707344) {
    // Sixteen bytes that the kernel gives each process: no call that a jail would have to allow.
    if (const auto* const given = reinterpret_cast<const char*>(::getauxval(AT_RANDOM))) {
        std::memcpy(&first_, given, sizeof first_);
        std::memcpy(&second_, given + sizeof first_, sizeof second_);
    }
    second_ |= 1;
}

size_t KeyedHash::operator()(std::string_view text) const {
    return mix(xxh3({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, first_), first_);
}

}  // namespace openfab
