// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "client/fablet_compiler.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <utility>

#include "base/input_file.h"
#include "base/own_folder.h"
#include "client/child.h"
#include "client/members.h"
#include "client/messages.h"

namespace openfab::client {

namespace {

namespace fs = std::filesystem;

constexpr int64_t kLargestOutput = 4 << 20;
constexpr int kMostModules = 200;

Diagnostic diagnostic_of(const JsonValue& read) {
    Diagnostic made{text_member(read, "file"),
                    text_member(read, "severity"),
                    text_member(read, "message"),
                    static_cast<int32_t>(number_member(read, "line")),
                    static_cast<int32_t>(number_member(read, "column")),
                    static_cast<int32_t>(number_member(read, "end_line")),
                    static_cast<int32_t>(number_member(read, "end_column"))};
    if (const JsonValue* help = member_of(read, "help"); help != nullptr) {
        for (const JsonValue& line : help->items)
            made.help.push_back(line.text);
    }
    return made;
}

/// Copies the modules beside a source, which it may import.
void copy_modules(const fs::path& source, const fs::path& folder) {
    std::error_code status;
    int copied = 0;
    for (fs::directory_iterator entry(source.parent_path(), status), end;
         !status && entry != end && copied < kMostModules; entry.increment(status)) {
        const fs::path& file = entry->path();
        if (file.extension() != ".fl" || file.filename() == source.filename()) continue;
        const Result<InputFile> opened = InputFile::open(file);
        if (!opened) continue;
        const Result<std::string> text = opened->read_all(kLargestSource);
        if (!text) continue;
        std::ofstream(folder / file.filename(), std::ios::binary) << *text;
        ++copied;
    }
}

}  // namespace

Result<JsonValue> FabletCompiler::run(const std::vector<std::string>& words, int* exit_code) const {
    std::vector<std::string> argv{(programs_ / "openflc").string(), "--diagnostics", "json"};
    argv.insert(argv.end(), words.begin(), words.end());
    const fs::path out = scratch_ / "openflc.out";
    const fs::path err = scratch_ / "openflc.err";
    Result<std::unique_ptr<Child>> child = Child::start(argv, out, err);
    if (!child) return child.error();
    *exit_code = (*child)->wait();
    // Diagnostics go to one stream, results to the other.
    for (const fs::path& file : {out, err}) {
        const std::string text = end_of_file(file, kLargestOutput);
        if (!text.starts_with('{')) continue;
        return parse_json(std::string_view(text).substr(0, text.find('\n')), "openflc");
    }
    const std::string text = end_of_file(err, 2000);
    return user_error(text.empty() ? fmt::format(messages::kCompilerEnded, *exit_code) : text);
}

Result<std::vector<Diagnostic>> FabletCompiler::check(const fs::path& source) const {
    int exit_code = 0;
    const Result<JsonValue> read = run({"check", as_argument(source)}, &exit_code);
    if (!read) return read.error();
    std::vector<Diagnostic> diagnostics;
    if (const JsonValue* list = member_of(*read, "diagnostics"); list != nullptr) {
        for (const JsonValue& item : list->items)
            diagnostics.push_back(diagnostic_of(item));
    }
    return diagnostics;
}

Result<std::vector<Diagnostic>> FabletCompiler::check_text(const fs::path& source,
                                                           const std::string& text) const {
    const Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create(scratch_);
    if (!folder) return folder.error();
    const Result<fs::path> copy = put_source((*folder)->path(), source, text);
    if (!copy) return copy.error();
    Result<std::vector<Diagnostic>> diagnostics = check(*copy);
    if (!diagnostics) return diagnostics;
    // As if they were of the files that were copied.
    for (Diagnostic& diagnostic : *diagnostics) {
        if (diagnostic.file.parent_path() == copy->parent_path())
            diagnostic.file = source.parent_path() / diagnostic.file.filename();
    }
    return diagnostics;
}

Result<fs::path> put_source(const fs::path& folder, const fs::path& source,
                            const std::string& text) {
    copy_modules(source, folder);
    fs::path copy = folder / source.filename();
    std::ofstream out(copy, std::ios::binary);
    out << text;
    out.close();
    if (!out) return outside_error(fmt::format(messages::kCannotWrite, copy.string()));
    return copy;
}

Result<std::map<std::string, JsonValue>> FabletCompiler::describe(const fs::path& source) const {
    int exit_code = 0;
    Result<JsonValue> read = run({"describe", as_argument(source)}, &exit_code);
    if (!read) return read.error();
    std::map<std::string, JsonValue> fablets;
    if (const JsonValue* list = member_of(*read, "fablets"); list != nullptr) {
        for (const JsonValue& fablet : list->items)
            fablets.emplace(text_member(fablet, "name"), fablet);
    }
    return fablets;
}

bool has_errors(const std::vector<Diagnostic>& diagnostics) {
    return std::any_of(diagnostics.begin(), diagnostics.end(),
                       [](const Diagnostic& one) { return one.severity == "error"; });
}

}  // namespace openfab::client
