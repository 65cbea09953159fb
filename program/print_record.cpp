// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/print_record.h"

#include <cstdlib>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "backends/job/inputs.h"
#include "backends/stream/address.h"
#include "base/input_file.h"
#include "base/json.h"
#include "base/sha256.h"
#include "world/printer_list.h"

namespace openfab::program {

namespace {

namespace fs = std::filesystem;

/// Returns the options of the compilation that `openfab print` tells.
std::optional<std::vector<job::OptionWords>> compilation_words() {
    const char* text = std::getenv(kCompilationVariable);
    if (text == nullptr) return {};
    std::vector<job::OptionWords> words;
    const Result<JsonValue> list = parse_json(text, kCompilationVariable);
    if (!list) return {};
    for (const JsonValue& option : list->items) {
        if (option.items.empty()) continue;
        job::OptionWords& one = words.emplace_back();
        one.name = option.items[0].text;
        for (size_t i = 1; i < option.items.size(); ++i)
            one.values.push_back(option.items[i].text);
    }
    return words;
}

/// Adds what a schedule option names: a file, or all schedules of a folder.
void add_schedules(const fs::path& path, std::vector<fs::path>* files) {
    std::error_code status;
    if (!fs::is_directory(path, status)) return files->push_back(path);
    std::set<fs::path> sorted;
    for (fs::directory_iterator at(path, status), end; !status && at != end; at.increment(status)) {
        if (at->path().extension() == ".sched") sorted.insert(at->path());
    }
    files->insert(files->end(), sorted.begin(), sorted.end());
}

/// Lists all that was read, the world or mesh first.
std::vector<fs::path> files_of(const Options& options, const Job& job,
                               const std::vector<job::OptionWords>& compilation) {
    std::vector<fs::path> files{options.input};
    const bool is_world = options.input.ends_with(".json");
    std::error_code ignored;
    for (const fs::path& input : job.inputs) {
        // Of a mesh, the source of a stock fablet is a name alone.
        if (input != "/proc/self/exe" && (is_world || fs::exists(input, ignored)))
            files.push_back(input);
    }
    // A file that makes a folder a project lets files in it name each other.
    const fs::path project = reading_root(fs::path(options.input).parent_path()) / kProjectFile;
    if (fs::exists(project, ignored)) files.push_back(project);
    if (!job.printer.process.field.empty()) files.push_back(job.printer.process.field);
    if (const size_t equals = options.altered.field.find('='); equals != std::string::npos)
        files.emplace_back(options.altered.field.substr(equals + 1));
    for (const job::OptionWords& option : compilation) {
        for (const std::string& value : option.values) {
            if (option.name == "--schedule") add_schedules(value, &files);
            // The name of a stock fablet is no file.
            if (option.name == "--fablet" && fs::exists(value, ignored)) files.emplace_back(value);
        }
    }
    return files;
}

}  // namespace

std::unique_ptr<job::Record> make_record(const Options& options, const Job& job,
                                         const backends::Format* format) {
    if (format == nullptr || options.words.empty() || options.output.empty() ||
        options.output == "-" || stream::is_address(options.output))
        return nullptr;
    const bool is_folder = format->kind == backends::FormatKind::kFolder;
    if (!is_folder && !format->streams) return nullptr;
    fs::path file = job::record_file(options.output);
    if (file.empty()) return nullptr;
    job::Facts facts;
    facts.format = format->name;
    std::error_code ignored;
    facts.folder = fs::current_path(ignored);
    facts.options = options.words;
    facts.compilation = compilation_words();
    facts.printer = job.printer.name;
    if (const Result<std::string> profile = world::printer_text(job.printer_source); profile)
        facts.printer_sha256 = hex_text(sha256(*profile));
    facts.programs = job.programs;
    facts.inputs = job::read_inputs(
        files_of(options, job, facts.compilation.value_or(std::vector<job::OptionWords>())));
    return std::make_unique<job::Record>(std::move(file), std::move(facts), options.resume);
}

}  // namespace openfab::program
