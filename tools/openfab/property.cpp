// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab property TABLE.json`: makes a module of a table of mixtures.

#include <filesystem>

#include "base/json.h"
#include "base/say.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/property_table.h"
#include "tools/openfab/stock.h"

namespace openfab::tools {

Result<void> make_property_module(const PropertyArguments& arguments) {
    const auto& [table, output, temperature, rate] = arguments;
    const Result<Conditions> asked = parse_conditions(temperature, rate);
    if (!asked) return asked.error();
    constexpr size_t kMostBytes = 1'000'000;
    const Result<std::string> text = read_text_file(table, kMostBytes);
    if (!text) return text.error();
    const Result<std::string> module = property_module(*text, table, *asked);
    if (!module) return module.error();
    if (!output.empty()) return write_file(output, *module);
    show(*module);
    return {};
}

}  // namespace openfab::tools
