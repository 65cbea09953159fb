// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Integer hashes. The finalizer is Chris Wellons' "lowbias32" (public domain): each input bit flips
// each output bit with a probability of 1/2, off by less than 0.2 % (tests/unit/functions measures
// it).

#include <vector>

#include "compiler/functions/machine.h"

namespace openfab::functions {

template <typename M>
typename M::U mix(typename M::U x) {
    x = (x ^ (x >> 16u)) * 0x7feb352du;
    x = (x ^ (x >> 15u)) * 0x846ca68bu;
    return x ^ (x >> 16u);
}

/// A cheaper `mix` with weaker low 16 bits.
template <typename M>
typename M::U mix_high(typename M::U x) {
    x = (x ^ (x >> 16u)) * 0x7feb352du;
    return (x ^ (x >> 15u)) * 0x846ca68bu;
}

/// Each word passes through the whole finalizer, so lists that differ in one word have different
/// hashes. `which` selects independent hashes of one list.
template <typename M>
typename M::U hash(const std::vector<typename M::U>& words, uint32_t which) {
    typename M::U state = mix<M>(words[0] ^ (0x9e3779b9u * (which + 1u)));
    for (size_t k = 1; k < words.size(); ++k)
        state = mix<M>(words[k] ^ (state + 0x85ebca6bu));
    return state;
}

/// Scrambles a seed for the noises, so that consecutive seeds are unrelated.
template <typename M>
typename M::U seed_key(typename M::U seed) {
    return mix<M>(seed ^ 0x5bd1e995u);
}

}  // namespace openfab::functions
