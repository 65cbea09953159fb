// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab archive --reprint JOB.zip -o OUT`: makes an archived print again, and says what differs.

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>

#include "backends/formats/formats.h"
#include "backends/ofr/ofr_reader.h"
#include "backends/raster/folder_sink.h"
#include "backends/raster/slice_digests.h"
#include "base/clean_exit.h"
#include "base/exit_kind.h"
#include "base/input_file.h"
#include "base/jail.h"
#include "base/json_text.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "base/sha256.h"
#include "base/start_program.h"
#include "base/system_reason.h"
#include "base/talking_program.h"
#include "base/text.h"
#include "base/units.h"
#include "mesh/read/zip_file.h"
#include "tools/openfab/archive.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/programs.h"
#include "world/printer_list.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// What is read of a package beside its files.
struct ReadArchive {
    std::string json;
    std::string page;  ///< empty: there is none
};

void pass(JailLine* line, ReadArchive* read) {
    pass(line, &read->json);
    pass(line, &read->page);
}

/// Fails where the files are more than anybody's print has, or than there is room for.
Result<void> check_room(const Archive& archive, const std::string& file, const fs::path& root) {
    constexpr size_t kMostFiles = 100'000;
    constexpr int64_t kMostBytes = int64_t{1} << 46;
    if (archive.files.size() > kMostFiles)
        return user_error(
            fmt::format(messages::kArchiveOfManyFiles, file, archive.files.size(), kMostFiles));
    std::set<std::string> entries;
    int64_t bytes = 0;
    for (const ArchivedFile& one : archive.files) {
        // One that is unpacked many times would fill a disk.
        if (!entries.insert(mesh::ZipFile::key(one.entry)).second)
            return user_error(fmt::format(messages::kArchivedTwice, one.entry));
        bytes = std::min(kMostBytes, bytes + std::min(kMostBytes, one.bytes));
    }
    std::error_code unknown;
    const fs::space_info space = fs::space(root, unknown);
    if (!unknown && static_cast<uintmax_t>(bytes) > space.available) {
        return outside_error(fmt::format(messages::kNoRoomForArchive, file, format_bytes(bytes),
                                         root.parent_path().string(),
                                         format_bytes(static_cast<int64_t>(space.available))));
    }
    return {};
}

/// Writes the files below `root`, each of which must be what archive.json says.
Result<void> unpack(const mesh::ZipFile& zip, const Archive& archive, const fs::path& root,
                    int64_t memory_bytes) {
    for (const ArchivedFile& file : archive.files) {
        const Result<std::string> bytes =
            zip.read(file.entry, std::min(file.bytes, memory_bytes / 2));
        if (!bytes) return bytes.error();
        if (static_cast<int64_t>(bytes->size()) != file.bytes ||
            hex_text(sha256(*bytes)) != file.sha256)
            return user_error(fmt::format(messages::kArchivedFileDiffers, file.path));
        const fs::path to = root / file.path;
        std::error_code status;
        fs::create_directories(to.parent_path(), status);
        // A file where another's folder is, or twice the same, is no archive of ours.
        if (status || fs::exists(to, status))
            return user_error(fmt::format(messages::kArchivedTwice, file.path));
        std::ofstream out(to, std::ios::binary);
        out.write(bytes->data(), static_cast<std::streamsize>(bytes->size()));
        out.close();
        if (!out) {
            return outside_error(
                fmt::format(messages::kCannotWrite, to.string(), system_reason(errno)));
        }
        if (file.executable) ::chmod(to.c_str(), 0700);
    }
    return {};
}

/// Reads an archive, and unpacks its files below `root`.
Result<ReadArchive> read_archive(const std::string& file, const fs::path& root,
                                 int64_t memory_bytes) {
    constexpr int64_t kLargestText = 256 << 20;
    const int64_t most_text = std::min(kLargestText, memory_bytes / 8);
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return with_context(opened.error(), file + ": ");
    if (opened->bytes() > memory_bytes / 2)
        return user_error(fmt::format(messages::kArchiveTakesTooMuch, file,
                                      format_bytes(opened->bytes()), format_bytes(memory_bytes)));
    const Result<std::string> bytes = opened->read_all(memory_bytes / 2);
    if (!bytes) return with_context(bytes.error(), file + ": ");
    const Result<mesh::ZipFile> zip = mesh::ZipFile::open(*bytes, file);
    if (!zip) return zip.error();
    ReadArchive out;
    Result<std::string> text = zip->read("archive.json", most_text);
    if (!text) return text.error();
    out.json = std::move(*text);
    if (zip->has("record.html")) {
        Result<std::string> page = zip->read("record.html", most_text);
        if (!page) return page.error();
        out.page = std::move(*page);
    }
    const Result<Archive> archive = parse_archive(out.json, file);
    if (!archive) return archive.error();
    if (Result<void> room = check_room(*archive, file, root); !room) return room.error();
    if (Result<void> unpacked = unpack(*zip, *archive, root, memory_bytes); !unpacked)
        return unpacked.error();
    return out;
}

/// Same in a jail (base/jail.h), since an archive may come from a stranger.
Result<Archive> open_archive(const std::string& file, const fs::path& root, int64_t memory_bytes) {
    JailLimits limits;
    limits.memory_bytes = memory_bytes;
    limits.converts = true;
    limits.reads = {without_links(file), without_links(root)};
    limits.writes = {without_links(root)};
    const Result<ReadArchive> read = read_in_jail<ReadArchive>(
        file, limits, [&] { return read_archive(file, root, memory_bytes); });
    if (!read) return read.error();
    Result<Archive> archive = parse_archive(read->json, file);
    if (archive && !archive->page_sha256.empty() && !is_page_of(*archive, read->json, read->page))
        warn(fmt::format(messages::kRecordPageChanged, file));
    return archive;
}

/// Returns whether a command's program is there: one of the archive, or one along the PATH.
bool is_there(const std::string& program, const fs::path& world_folder) {
    if (program.find('/') != std::string::npos)
        return ::access((world_folder / program).c_str(), X_OK) == 0;
    const char* path = std::getenv("PATH");
    const std::string places = path == nullptr ? "" : path;
    for (size_t at = 0; at <= places.size();) {
        const size_t end = std::min(places.find(':', at), places.size());
        if (::access((fs::path(places.substr(at, end - at)) / program).c_str(), X_OK) == 0)
            return true;
        at = end + 1;
    }
    return false;
}

/// Returns the words of `openfab print`; fails for those that no archive has.
Result<std::vector<std::string>> print_words(const Archive& archive, const fs::path& root,
                                             const ArchiveArguments& arguments) {
    std::vector<std::string> words;
    std::string input;
    bool formatted = false;
    for (const job::OptionWords& option : archive.options) {
        const ArchivedOption* known = find_archived_option(option.name);
        if (known == nullptr ||
            (known->role != OptionRole::kKept && known->role != OptionRole::kPath))
            return user_error(fmt::format(messages::kOptionNotArchived, option.name));
        if (option.name == kProgramsWord && !arguments.programs)
            return user_error(messages::kReprintRunsPrograms, messages::kReprintRunsProgramsHelp);
        for (std::string value : option.values) {
            // Of a file only what was unpacked: an archive may come from a stranger.
            const fs::path path = root / value;
            std::error_code ignored;
            if (known->role == OptionRole::kPath) {
                const bool is_name = value.find('/') == std::string::npos && !fs::exists(path);
                if (!is_name && !is_below(without_links(path), without_links(root)))
                    return user_error(
                        fmt::format(messages::kPathNotKept, option.name, printable(value)));
                if (!is_name) value = path.string();
            }
            if (option.name == "INPUT")
                input = value;
            else
                words.push_back(option.name + "=" + value);
        }
        if (option.values.empty()) words.push_back(option.name);
        formatted |= option.name == "--format";
    }
    if (!fs::path(input).is_absolute())
        return user_error(fmt::format(messages::kArchiveWrong, arguments.file, "INPUT"));
    if (!formatted) words.push_back("--format=" + archive.format);
    words.push_back("--allow=" + root.string());
    if (!arguments.memory.empty()) words.push_back("--memory=" + arguments.memory);
    if (arguments.threads > 0) words.push_back(fmt::format("--threads={}", arguments.threads));
    std::error_code ignored;
    words.push_back("--output=" + fs::absolute(arguments.output, ignored).string());
    words.push_back(input);
    return words;
}

/// Names what decides the voxels and is not the same.
std::string differences(const Archive& archive, const std::string& output) {
    std::string out;
    const auto add = [&](const std::string& what) { out += (out.empty() ? "" : ", ") + what; };
    std::map<std::string, std::string> here;
    const fs::path file = job::record_file(output);
    if (const Result<JsonValue> record = job::read_record(file)) {
        const JsonValue* list = member_of(*record, "provenance");
        for (size_t i = 0; list != nullptr && i < list->items.size(); ++i) {
            const std::vector<JsonValue>& pair = list->items[i].items;
            if (pair.size() == 2) here[pair[0].text] = pair[1].text;
        }
    }
    for (const auto& [name, value] : archive.provenance) {
        const auto found = here.find(name);
        if (found == here.end())
            add(name);
        else if (found->second != value)
            add(fmt::format(messages::kDiffersHere, name, found->second, value));
    }
    const Result<std::string> profile = world::printer_text(archive.printer);
    if (profile && hex_text(sha256(*profile)) != archive.printer_sha256)
        add(fmt::format(messages::kProfileDiffers, archive.printer));
    return out.empty() ? messages::kNothingKnownDiffers : out;
}

}  // namespace

Result<std::string> hash_of_print(const std::string& output) {
    std::error_code status;
    if (!fs::is_directory(output, status)) {
        const Result<pipeline::PrintTotals> totals = ofr::OfrReader::read_totals(output);
        if (!totals) return with_context(totals.error(), output + ": ");
        return fmt::format("{:016x}", totals->hash);
    }
    const fs::path file = fs::path(output) / "manifest.json";
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return with_context(opened.error(), file.string() + ": ");
    const Result<std::string> text = opened->read_all(raster::kMostManifestBytes);
    if (!text) return with_context(text.error(), file.string() + ": ");
    std::string hash = raster::manifest_hash(*text);
    if (hash.empty()) return user_error(fmt::format(messages::kFolderDamaged, file.string()));
    return hash;
}

Result<void> reprint_archive(const ArchiveArguments& arguments) {
    const Result<int64_t> memory = parse_memory_option(arguments.memory);
    if (!memory) return memory.error();
    std::error_code status;
    if (fs::equivalent(arguments.file, arguments.output, status))
        return user_error(fmt::format(messages::kArchiveOverInput, arguments.output));
    const Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    const fs::path root = (*folder)->path();
    const Result<Archive> opened = open_archive(arguments.file, root, *memory);
    if (!opened) return opened.error();
    const Archive& archive = *opened;
    const Result<std::vector<std::string>> words = print_words(archive, root, arguments);
    if (!words) return words.error();
    const fs::path world_folder = fs::path(words->back()).parent_path();
    for (const std::vector<std::string>& command : archive.programs) {
        if (!is_there(command[0], world_folder))
            return user_error(fmt::format(messages::kArchivedProgramMissing, command[0]));
    }
    const Result<fs::path> programs = program_folder();
    if (!programs) return programs.error();
    std::vector<std::string> argv{(*programs / "openfab").string(), "print"};
    argv.insert(argv.end(), words->begin(), words->end());
    // The print tells it, with what there is to say.
    const bool tells = claim_interrupted();
    const Result<int> code = run_program(argv, tells);
    if (tells && code && *code == 0) unclaim_interrupted();
    if (!code) return code.error();
    if (*code != 0) {
        return Error{
            kind_of_exit(*code), fmt::format(messages::kReprintFailed, arguments.file), "", {}};
    }
    const Result<std::string> hash = hash_of_print(arguments.output);
    if (!hash) return hash.error();
    if (*hash != archive.hash) {
        return user_error(fmt::format(messages::kReprintDiffers, arguments.output, *hash,
                                      archive.hash, differences(archive, arguments.output)));
    }
    show(fmt::format(messages::kReprintSame, printable(arguments.output), *hash));
    return {};
}

}  // namespace openfab::tools
