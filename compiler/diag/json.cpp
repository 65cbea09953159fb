// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/diag/json.h"

#include <fmt/format.h>

#include "compiler/source/source_manager.h"

namespace openfab::diag {

std::string json_string(std::string_view text) {
    std::string out = "\"";
    for (size_t i = 0; i < text.size();) {
        const size_t bytes = source::code_point_bytes(text, i);
        const auto lead = static_cast<unsigned char>(text[i]);
        if (bytes == 1 && lead >= 0x80) {
            out += "\\ufffd";
        } else if (lead == '"' || lead == '\\') {
            out += '\\';
            out += text[i];
        } else if (lead == '\n') {
            out += "\\n";
        } else if (lead < 0x20 || lead == 0x7f) {
            out += fmt::format("\\u{:04x}", lead);
        } else {
            out += text.substr(i, bytes);
        }
        i += bytes;
    }
    return out + '"';
}

}  // namespace openfab::diag
