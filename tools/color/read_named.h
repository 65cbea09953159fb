// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <filesystem>

#include "base/input_file.h"
#include "tools/color/messages.h"

namespace openfab::color {

/// Reads a file of at most `largest` bytes and parses its text; errors name the file.
template <typename Parse>
auto read_named(const std::filesystem::path& file, int64_t largest, const Parse& parse)
    -> decltype(parse(std::string())) {
    const auto named = [&](const Error& error) {
        return with_context(error, fmt::format(messages::kCannotReadBefore, file.string()));
    };
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return named(opened.error());
    const Result<std::string> text = opened->read_all(largest);
    if (!text) return named(text.error());
    auto parsed = parse(*text);
    if (!parsed) return named(parsed.error());
    return parsed;
}

}  // namespace openfab::color
