// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// libFuzzer target (preset `fuzz`), built once for each reader: it must handle any bytes.

#include <algorithm>
#include <cstdlib>
#include <random>
#include <string>

#include "tests/fuzz/mutations/move_elements.h"
#include "tests/fuzz/readers/readers.h"

namespace {

const openfab::testing::Reader& fuzzed() {
    static const openfab::testing::Reader* const reader =
        openfab::testing::find_reader(OPENFAB_FUZZED_READER);
    if (reader == nullptr) std::abort();
    return *reader;
}

}  // namespace

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t most);

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    fuzzed().read({reinterpret_cast<const char*>(data), size});
    return 0;
}

/// Half of what changes gets right checksums; of text a fourth changes its structure.
extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t most, unsigned seed) {
    if (fuzzed().text && seed % 4 == 1) {
        std::string text(reinterpret_cast<const char*>(data), size);
        std::mt19937_64 random(seed);
        if (openfab::testing::move_element(&text, &random) && text.size() <= most) {
            std::copy(text.begin(), text.end(), data);
            return text.size();
        }
    }
    size = LLVMFuzzerMutate(data, size, most);
    if (fuzzed().seal == nullptr || seed % 2 == 0) return size;
    std::string bytes(reinterpret_cast<const char*>(data), size);
    fuzzed().seal(&bytes);
    std::copy(bytes.begin(), bytes.end(), data);
    return size;
}
