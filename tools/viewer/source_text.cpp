// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/source_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/hash.h"
#include "base/input_file.h"
#include "tools/viewer/messages.h"

namespace openfab::viewer {

namespace fs = std::filesystem;

void write_diagnostics(const std::vector<client::Diagnostic>& diagnostics,
                       const std::vector<fs::path>& sources, JsonText* out) {
    out->begin_array();
    for (const client::Diagnostic& one : diagnostics) {
        const auto found =
            std::find_if(sources.begin(), sources.end(), [&](const fs::path& source) {
                return source.lexically_normal() == one.file.lexically_normal();
            });
        const auto number = static_cast<int32_t>(found - sources.begin());
        out->begin_object().member("fablet", found == sources.end() ? -1 : number);
        out->member("file", one.file.filename().string());
        out->member("severity", one.severity).member("message", one.message);
        out->member("line", one.line).member("column", one.column);
        out->member("end_line", one.end_line).member("end_column", one.end_column);
        out->key("help").begin_array();
        for (const std::string& line : one.help)
            out->value(line);
        out->end_array().end_object();
    }
    out->end_array();
}

Result<std::string> read_source(const fs::path& file, const std::vector<fs::path>& roots) {
    const Result<InputFile> opened = InputFile::open(file, roots);
    if (!opened)
        return with_context(opened.error(), fmt::format(messages::kCannotRead, file.string()));
    Result<std::string> text = opened->read_all(client::kLargestSource);
    if (!text) return with_context(text.error(), fmt::format(messages::kCannotRead, file.string()));
    return text;
}

std::string stamp_of(const std::string& text) {
    return fmt::format("{:016x}", xxh3(text));
}

}  // namespace openfab::viewer
