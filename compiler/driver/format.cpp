// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/format/format.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "base/replace_file.h"
#include "base/say.h"
#include "compiler/driver/commands.h"

namespace openfab::driver {

namespace {

constexpr const char* kStandardInput = "-";

/// Reads standard input as a source; nothing, with a message in `fault`, if it is too large.
std::optional<uint32_t> load_standard_input(source::SourceManager* sources, std::string* fault) {
    std::string text;
    char block[1 << 16];
    while (std::cin.read(block, sizeof block), std::cin.gcount() > 0) {
        text.append(block, static_cast<size_t>(std::cin.gcount()));
        if (text.size() <= source::SourceManager::kMaxFileBytes) continue;
        *fault = "standard input: is larger than 16 MiB, the limit of a source file";
        return std::nullopt;
    }
    return sources->add("standard input", std::move(text));
}

int format_file(const std::string& file, bool check, const CommonOptions& common) {
    source::SourceManager sources;
    diag::Sink sink;
    std::string fault;
    const bool piped = file == kStandardInput;
    const std::optional<uint32_t> source =
        piped ? load_standard_input(&sources, &fault) : sources.load(file, &fault);
    if (!source) return fail(fault, piped ? kExitUserInput : unread_exit_code(file));
    const Result<std::string> text = format::format(sources, *source, &sink);
    print_diagnostics(sink, sources, common);
    if (!text) {
        const bool bug = text.error().code == ErrorCode::kInternal;
        return bug ? fail(fmt::format("{}: {}", file, text.error().text()), kExitBug)
                   : kExitUserInput;
    }
    const bool same = *text == sources.text(*source);
    if (check) {
        if (!same)
            say(fmt::format("{}: error: is not formatted; `openflc fmt` does it\n",
                            sources.name(*source)));
        return same ? kExitDone : kExitUserInput;
    }
    if (piped) {
        write_out(*text);
        return kExitDone;
    }
    if (same) return kExitDone;
    const Result<void> written = replace_file(file, *text);
    return written ? kExitDone : fail(written.error().text(), kExitOutside);
}

}  // namespace

int format_files(const FormatOptions& options, const CommonOptions& common) {
    int code = kExitDone;
    for (const std::string& file : options.files)
        code = std::max(code, format_file(file, options.check, common));
    return code;
}

}  // namespace openfab::driver
