// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/memory_option.h"

#include "base/units.h"
#include "program/options.h"

namespace openfab::tool {

void add_memory_option(CLI::App* command, std::string* text) {
    command->add_option("--memory", *text, "memory budget of the whole process (default: 1.5GB)")
        ->type_name("SIZE");
}

Result<int64_t> memory_of(const std::string& text) {
    if (text.empty()) return print::Options().memory_bytes;
    Result<int64_t> bytes = parse_bytes(text);
    if (!bytes) return usage_error("`--memory`: " + bytes.error().text());
    return bytes;
}

}  // namespace openfab::tool
