// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The readers of what people hand to the programs, each as a function of bytes, and where their
// corpora are: tests/fuzz/corpus/NAME. libFuzzer drives them (reader_fuzzer.cpp), and an ordinary
// test replays and damages what is in the corpora (readers_test.cpp).

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace openfab::tests {

/// What a reader may take.
constexpr int64_t kReaderBytes = 100'000'000;

struct Reader {
    const char* name;
    bool text;  ///< damaged by words and numbers, else by bytes
    /// Whether the bytes were read whole. Aborts where an answer makes no sense.
    bool (*read)(std::string_view bytes);
};

std::span<const Reader> readers();
const Reader* find_reader(std::string_view name);

}  // namespace openfab::tests
