// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// libFuzzer target (preset `fuzz`), built once for each reader: it must handle any bytes.

#include <cstdlib>

#include "tests/fuzz/readers/readers.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const openfab::testing::Reader* const reader =
        openfab::testing::find_reader(OPENFAB_FUZZED_READER);
    if (reader == nullptr) std::abort();
    reader->read({reinterpret_cast<const char*>(data), size});
    return 0;
}
