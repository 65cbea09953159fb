// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/memory/meter.h"

#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<int64_t> live{0}, peak{0};

void* counted(void* p) {
    if (p == nullptr) std::abort();
    const int64_t now = live += static_cast<int64_t>(::malloc_usable_size(p));
    int64_t before = peak;
    while (now > before && !peak.compare_exchange_weak(before, now)) {
    }
    return p;
}

void freed(void* p) {
    if (p != nullptr) live -= static_cast<int64_t>(::malloc_usable_size(p));
    std::free(p);
}

}  // namespace

void* operator new(size_t size) {
    return counted(std::malloc(size));
}
void* operator new(size_t size, std::align_val_t align) {
    return counted(std::aligned_alloc(static_cast<size_t>(align), (size + 63) / 64 * 64));
}
// std::stable_sort asks for its buffer so: a sanitizer's own would not go with our delete.
void* operator new(size_t size, const std::nothrow_t&) noexcept {
    return counted(std::malloc(size));
}
void operator delete(void* p) noexcept {
    freed(p);
}
void operator delete(void* p, size_t) noexcept {
    freed(p);
}
void operator delete(void* p, std::align_val_t) noexcept {
    freed(p);
}
void operator delete(void* p, size_t, std::align_val_t) noexcept {
    freed(p);
}

namespace openfab::testing {

Meter::Meter() : before_(live) {
    peak = before_;
}

int64_t Meter::peak_bytes() const {
    return peak - before_;
}

}  // namespace openfab::testing
