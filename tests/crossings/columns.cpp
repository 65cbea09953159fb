// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/crossings/columns.h"

namespace openfab::testing {

std::span<const Column> columns() {
    static const std::vector<Column> all = [] {
        std::vector<Column> out;
        for (const auto& some : {placement_columns(), process_columns(), output_columns(),
                                 tool_columns(), mechanics_columns(), view_columns()})
            out.insert(out.end(), some.begin(), some.end());
        return out;
    }();
    return all;
}

}  // namespace openfab::testing
