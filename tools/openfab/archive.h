// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A print as a record: all that it was made from, in one file, from which it is made again elsewhere.
//
// An archive is a ZIP file:
//   archive.json    what it is, see run_archive: hash, provenance, printer, options, files, story
//   record.html     the same for people, with a place for a signature
//   files/…         world or mesh, fablets, pictures and all else that the print read
//   attached/…      files that were given with `--attach`, as reports of checks and of mechanics

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "backends/job/record.h"
#include "base/json.h"
#include "base/result.h"
#include "tools/openfab/commands.h"

namespace openfab::tools {

/// What an option of a print means to one that is made again elsewhere.
enum class OptionRole {
    kKept,     ///< its words stay
    kPath,     ///< its value is a file of the archive, where it is not a name
    kDropped,  ///< no voxel depends on it, or it names what the reprint replaces
    kRefused,  ///< of our own tools
};
struct ArchivedOption {
    const char* name;
    OptionRole role;
};
/// Finds an option; null where it is not known.
const ArchivedOption* find_archived_option(std::string_view name);

/// A file of an archive.
struct ArchivedFile {
    std::string entry;           ///< its name in the package
    std::string path;            ///< below the folder where it is unpacked
    std::filesystem::path from;  ///< where it lies now; empty in an archive that was read
    int64_t bytes = 0;
    std::string sha256;
    bool executable = false;
};

/// What archive.json says.
struct Archive {
    std::string title, format, hash;
    std::string printer, printer_sha256;
    std::vector<std::pair<std::string, std::string>> provenance;
    std::string folder;  ///< where its paths count from, below the folder where it is unpacked
    std::vector<job::OptionWords> options;
    std::vector<std::vector<std::string>> programs;
    std::vector<ArchivedFile> files, attached;
    std::vector<std::string> story;
    bool checked = false;  ///< `openfab check` found nothing before the print
    std::string person;    ///< who is responsible; may be empty
    /// Of the page without the digest of archive.json, which it has in turn; empty in archives of before.
    std::string page_sha256;
};

/// Returns archive.json, and reads it.
std::string archive_json(const Archive& archive);
Result<Archive> parse_archive(const std::string& text, const std::string& name);

/// Returns the page for people.
std::string archive_page(const Archive& archive, const std::string& json_sha256);

/// Returns whether a page is the one that was made with this archive.json.
bool is_page_of(const Archive& archive, const std::string& json, std::string page);

/// Unpacks an archive and makes its print again.
Result<void> reprint_archive(const ArchiveArguments& arguments);

}  // namespace openfab::tools
