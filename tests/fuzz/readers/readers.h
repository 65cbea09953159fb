// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The readers of untrusted files, each as a function of bytes, with corpora in
// tests/fuzz/corpus/NAME. libFuzzer drives them (reader_fuzzer.cpp), and an ordinary
// test replays and damages what is in the corpora (readers_test.cpp).

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace openfab::testing {

/// Memory limit of a reader.
constexpr int64_t kReaderBytes = 100'000'000;

struct Reader {
    const char* name;
    bool text;  ///< damaged in words and numbers, else in bytes
    /// Returns whether the bytes were read successfully. Aborts where a result is inconsistent.
    bool (*read)(std::string_view bytes);
    /// Makes the checksums of damaged bytes right again, as far as they still are a file of this
    /// kind, so that more than the comparison of a checksum is tried; null where there are none.
    void (*seal)(std::string* bytes) = nullptr;
};

std::span<const Reader> readers();
const Reader* find_reader(std::string_view name);

}  // namespace openfab::testing
