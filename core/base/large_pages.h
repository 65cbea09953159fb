// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Memory for a million things is asked for at once: with large pages one fault takes the place of 512. Half of the time in
// which a mesh is read would go to faults.

#include <cstddef>
#include <vector>

namespace openfab {

/// Advises the system to back memory that nothing was written to yet with large pages; small pieces are left alone, and a
/// system that has none does nothing.
void advise_large_pages(void* memory, size_t bytes);

/// Reserves memory that will be filled.
template <typename T>
void reserve_large(std::vector<T>* values, size_t count) {
    if (count <= values->capacity()) return;
    values->reserve(count);
    advise_large_pages(values->data() + values->size(), (count - values->size()) * sizeof(T));
}

/// Returns `count` equal values.
template <typename T>
std::vector<T> large_vector(size_t count, const T& value = T()) {
    std::vector<T> out;
    reserve_large(&out, count);
    out.resize(count, value);
    return out;
}

}  // namespace openfab
