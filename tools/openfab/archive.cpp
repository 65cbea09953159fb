// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab archive PRINT -o JOB.zip`: keeps all that a print was made from, as its record names it.

#include "tools/openfab/archive.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <optional>
#include <set>
#include <system_error>

#include "backends/common/package.h"
#include "backends/common/part_file.h"
#include "backends/job/inputs.h"
#include "backends/ofr/ofr_reader.h"
#include "base/input_file.h"
#include "base/json_text.h"
#include "base/say.h"
#include "base/sha256.h"
#include "base/text.h"
#include "base/units.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

std::string member_text(const JsonValue& object, const char* name) {
    const JsonValue* value = member_of(object, name);
    return value == nullptr ? std::string() : value->text;
}

std::vector<job::OptionWords> options_of(const JsonValue& record, const char* name) {
    std::vector<job::OptionWords> options;
    const JsonValue* list = member_of(record, name);
    for (size_t i = 0; list != nullptr && i < list->items.size(); ++i) {
        const std::vector<JsonValue>& words = list->items[i].items;
        if (words.empty()) continue;
        job::OptionWords& option = options.emplace_back();
        option.name = words[0].text;
        for (size_t w = 1; w < words.size(); ++w)
            option.values.push_back(words[w].text);
    }
    return options;
}

/// Reads the record of a print that is complete, and to which nothing else was written since.
Result<JsonValue> read_complete_record(const fs::path& output) {
    std::error_code status;
    const fs::path file = job::record_file(output.string());
    if (!fs::exists(output, status))
        return user_error(fmt::format(messages::kNothingToArchive, output.string()));
    if (file.empty() || !fs::exists(file, status))
        return user_error(fmt::format(messages::kNoRecordBeside, output.string(), file.string()),
                          messages::kNoRecordBesideHelp);
    Result<JsonValue> record = job::read_record(file);
    if (!record) return record;
    if (member_text(*record, "state") != "complete")
        return user_error(fmt::format(messages::kArchiveOfUnfinished, output.string()));
    const Result<std::string> hash = hash_of_print(output.string());
    if (!hash) return hash.error();
    if (*hash != member_text(*record, "hash"))
        return user_error(fmt::format(messages::kRecordOfOther, file.string(), output.string()));
    const JsonValue* compilation = member_of(*record, "compilation");
    if (compilation == nullptr || !compilation->is(JsonValue::Kind::kArray))
        return user_error(fmt::format(messages::kArchiveOfProgram, output.string()),
                          messages::kArchiveOfProgramHelp);
    return record;
}

/// Fails where an input is no longer what the print read, or changed before its end.
Result<void> check_inputs(const JsonValue& record, const std::vector<job::Input>& inputs) {
    constexpr size_t kMostNamed = 5;
    std::vector<std::string> wrong;
    for (const job::Input& input : inputs) {
        if (input.sha256.empty() || job::read_input(input.path).sha256 != input.sha256)
            wrong.push_back(input.path.string());
    }
    if (const JsonValue* events = member_of(record, "events")) {
        for (const JsonValue& event : events->items) {
            const JsonValue* changed =
                event.is(JsonValue::Kind::kObject) ? member_of(event, "changed_inputs") : nullptr;
            for (size_t i = 0; changed != nullptr && i < changed->items.size(); ++i)
                wrong.push_back(changed->items[i].text);
        }
    }
    if (wrong.empty()) return {};
    std::string names;
    for (size_t i = 0; i < std::min(wrong.size(), kMostNamed); ++i)
        names += (i == 0 ? "`" : ", `") + wrong[i] + "`";
    if (wrong.size() > kMostNamed)
        names += fmt::format(messages::kAndMoreFiles, wrong.size() - kMostNamed);
    return user_error(fmt::format(messages::kInputsChanged, names), messages::kInputsChangedHelp);
}

/// Returns the deepest folder that holds all of them.
fs::path common_folder(const std::vector<job::Input>& inputs, const fs::path& first) {
    fs::path common = first;
    for (const job::Input& input : inputs) {
        fs::path both;
        const fs::path folder = input.path.parent_path();
        auto a = common.begin();
        for (auto b = folder.begin(); a != common.end() && b != folder.end() && *a == *b; ++a, ++b)
            both /= *a;
        common = both;
    }
    return common;
}

bool is_plain(const std::string& path) {
    return std::all_of(path.begin(), path.end(), [](unsigned char c) {
        return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-' || c == '/';
    });
}

/// Names the files in the package as they are named on the disk, where readers of ZIP files agree on such a name.
void name_entries(const char* folder, std::vector<ArchivedFile>* files) {
    std::set<std::string> taken;
    for (size_t i = 0; i < files->size(); ++i) {
        ArchivedFile& file = (*files)[i];
        file.entry = fmt::format("{}/{}", folder, file.path);
        if (is_plain(file.path) && taken.insert(lower_ascii(file.entry)).second) continue;
        file.entry = fmt::format("{}/{}-file", folder, i + 1);
        taken.insert(file.entry);
    }
}

/// Fails where a world calls a file by a name that only leads there on this machine.
Result<void> check_names(const JsonValue& value, const std::set<std::string>& inputs,
                         const fs::path& world) {
    if (value.is(JsonValue::Kind::kString) && value.text.starts_with("/") &&
        inputs.count(fs::path(value.text).lexically_normal().string()) != 0) {
        return error_at({world.string(), value.line, value.column},
                        fmt::format(messages::kNamedAbsolutely, value.text),
                        messages::kNamedAbsolutelyHelp);
    }
    for (const JsonValue& item : value.items) {
        if (Result<void> fine = check_names(item, inputs, world); !fine) return fine;
    }
    for (const JsonMember& member : value.members) {
        if (Result<void> fine = check_names(member.value, inputs, world); !fine) return fine;
    }
    return {};
}

Result<void> check_names(const std::vector<job::Input>& inputs) {
    constexpr size_t kLargest = 256'000'000;
    std::set<std::string> names;
    for (const job::Input& input : inputs)
        names.insert(input.path.string());
    for (const job::Input& input : inputs) {
        if (input.path.extension() != ".json") continue;
        const Result<std::string> text = read_text_file(input.path, kLargest);
        if (!text) return text.error();
        const Result<JsonValue> json = parse_json(*text, input.path.string());
        if (!json) continue;
        if (Result<void> fine = check_names(*json, names, input.path); !fine) return fine;
    }
    return {};
}

/// Keeps the options that make the same voxels, with paths below `root`.
Result<std::vector<job::OptionWords>> keep_options(const std::vector<job::OptionWords>& options,
                                                   const fs::path& folder, const fs::path& root,
                                                   const std::vector<job::Input>& inputs) {
    std::set<fs::path> known, folders;
    for (const job::Input& input : inputs) {
        known.insert(input.path);
        folders.insert(input.path.parent_path());
    }
    std::vector<job::OptionWords> kept;
    for (job::OptionWords option : options) {
        const ArchivedOption* found = find_archived_option(option.name);
        if (found == nullptr || found->role == OptionRole::kRefused)
            return user_error(fmt::format(messages::kOptionNotArchived, option.name));
        if (found->role == OptionRole::kDropped) continue;
        if (found->role == OptionRole::kPath) {
            for (std::string& value : option.values) {
                fs::path path = (folder / value).lexically_normal();
                if (!path.has_filename()) path = path.parent_path();
                // Names of printers and of stock fablets are no files.
                if (known.count(path) != 0 || folders.count(path) != 0)
                    value = path.lexically_relative(root).string();
                else if (option.name == "INPUT" || value.find('/') != std::string::npos)
                    return user_error(fmt::format(messages::kPathNotKept, option.name, value));
            }
        }
        kept.push_back(std::move(option));
    }
    return kept;
}

/// Adds a file to the package, and fails where it is not what it was.
Result<void> add_file(const ArchivedFile& file, backends::Package* package) {
    const auto changed = [&] {
        return user_error(fmt::format(messages::kInputsChanged, "`" + file.from.string() + "`"),
                          messages::kInputsChangedHelp);
    };
    const Result<InputFile> opened = InputFile::open(file.from);
    if (!opened) return changed();
    Result<void> done = package->begin(file.entry, file.bytes);
    Sha256 sum;
    std::vector<uint8_t> buffer(256 << 10);
    int64_t at = 0;
    while (done) {
        const Result<size_t> got = opened->read(at, buffer.data(), buffer.size());
        if (!got) return with_context(got.error(), file.from.string() + ": ");
        if (*got == 0) break;
        const std::span<const uint8_t> bytes = std::span(buffer).first(*got);
        sum.add(bytes);
        at += static_cast<int64_t>(*got);
        if (at > file.bytes) return changed();
        done = package->write(bytes);
    }
    if (done) done = package->end();
    if (done && hex_text(sum.digest()) != file.sha256) return changed();
    return done;
}

Result<void> write_archive(const Archive& archive, const std::string& output) {
    Result<std::unique_ptr<backends::PartFile>> file = backends::PartFile::create(output);
    if (!file) return file.error();
    Result<backends::OutputFile*> flushed = (*file)->flushed();
    if (!flushed) return flushed.error();
    Result<std::unique_ptr<backends::Package>> package = backends::Package::create(*flushed);
    if (!package) return package.error();
    const std::string json = archive_json(archive);
    Result<void> done = (*package)->add("archive.json", json);
    if (done) done = (*package)->add("record.html", archive_page(archive, hex_text(sha256(json))));
    for (const std::vector<ArchivedFile>* files : {&archive.files, &archive.attached}) {
        for (const ArchivedFile& each : *files) {
            if (done) done = add_file(each, package->get());
        }
    }
    if (done) done = (*package)->close();
    return done ? (*file)->keep() : done;
}

Result<std::vector<ArchivedFile>> attach(const std::vector<std::string>& files) {
    std::vector<ArchivedFile> attached;
    for (const std::string& file : files) {
        job::Input input = job::read_input(file);
        if (input.sha256.empty()) return user_error(fmt::format(messages::kCannotAttach, file));
        attached.push_back(
            {{}, input.path.filename().string(), input.path, input.bytes, input.sha256});
    }
    name_entries("attached", &attached);
    return attached;
}

Result<Archive> gather(const ArchiveArguments& arguments) {
    const Result<JsonValue> record = read_complete_record(arguments.file);
    if (!record) return record.error();
    const std::vector<job::Input> inputs = job::inputs_of(*record);
    if (Result<void> same = check_inputs(*record, inputs); !same) return same.error();
    if (Result<void> fine = check_names(inputs); !fine) return fine.error();
    Archive out;
    out.title = member_text(*record, "title");
    out.format = member_text(*record, "output_format");
    out.hash = member_text(*record, "hash");
    if (const JsonValue* printer = member_of(*record, "printer")) {
        out.printer = member_text(*printer, "name");
        out.printer_sha256 = member_text(*printer, "sha256");
    }
    for (const job::OptionWords& pair : options_of(*record, "provenance"))
        out.provenance.emplace_back(pair.name, pair.values.empty() ? "" : pair.values[0]);
    for (const job::OptionWords& command : options_of(*record, "programs")) {
        out.programs.push_back({command.name});
        out.programs.back().insert(out.programs.back().end(), command.values.begin(),
                                   command.values.end());
    }
    const fs::path folder = member_text(*record, "folder");
    std::vector<job::OptionWords> options = options_of(*record, "options");
    for (job::OptionWords& option : options_of(*record, "compilation")) {
        out.checked |= option.name == "--check";
        options.push_back(std::move(option));
    }
    const fs::path root =
        common_folder(inputs, inputs.empty() ? folder : inputs[0].path.parent_path());
    Result<std::vector<job::OptionWords>> kept = keep_options(options, folder, root, inputs);
    if (!kept) return kept.error();
    out.options = std::move(*kept);
    for (const job::Input& input : inputs) {
        out.files.push_back({{},
                             input.path.lexically_relative(root).string(),
                             input.path,
                             input.bytes,
                             input.sha256,
                             ::access(input.path.c_str(), X_OK) == 0});
    }
    name_entries("files", &out.files);
    out.story = job::story_lines(*record, arguments.file);
    out.person = arguments.person;
    Result<std::vector<ArchivedFile>> attached = attach(arguments.attached);
    if (!attached) return attached.error();
    out.attached = std::move(*attached);
    out.page_sha256 = hex_text(sha256(archive_page(out, "")));
    return out;
}

}  // namespace

Result<void> run_archive(const ArchiveArguments& arguments) {
    if (arguments.reprint) return reprint_archive(arguments);
    const Result<Archive> archive = gather(arguments);
    if (!archive) return archive.error();
    for (const ArchivedFile& file : archive->files) {
        std::error_code ignored;
        if (fs::equivalent(file.from, arguments.output, ignored))
            return user_error(fmt::format(messages::kArchiveOverInput, arguments.output));
    }
    if (Result<void> whole = verify(arguments.file, arguments.memory); !whole) return whole;
    if (Result<void> written = write_archive(*archive, arguments.output); !written) return written;
    int64_t bytes = 0;
    for (const ArchivedFile& file : archive->files)
        bytes += file.bytes;
    say(fmt::format(messages::kArchived, printable(arguments.output), archive->files.size(),
                    format_bytes(bytes), archive->hash));
    for (const std::vector<std::string>& command : archive->programs)
        note(fmt::format(messages::kProgramNotKept, command[0]));
    return {};
}

}  // namespace openfab::tools
