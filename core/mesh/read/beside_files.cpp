// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/beside_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "base/input_file.h"
#include "base/text.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

namespace fs = std::filesystem;

/// Returns a file in the folder of `path` whose name is the same in lower case; else an empty path.
fs::path in_other_letters(const fs::path& path) {
    const std::string wanted = lower_ascii(path.filename().string());
    std::string found;
    std::error_code failed;
    for (fs::directory_iterator it(path.parent_path(), failed), end; !failed && it != end;
         it.increment(failed)) {
        std::string name = it->path().filename().string();
        // Of several the first by name, since folders have no order.
        if (lower_ascii(name) == wanted && (found.empty() || name < found)) found = std::move(name);
    }
    return found.empty() ? fs::path() : path.parent_path() / found;
}

int hex_digit(char c) {
    const size_t at = std::string_view("0123456789abcdef").find(lower_ascii(c));
    return at == std::string_view::npos ? -1 : static_cast<int>(at);
}

}  // namespace

std::string percent_decoded(std::string_view name) {
    std::string out;
    for (size_t i = 0; i < name.size(); ++i) {
        const int high = name[i] == '%' && i + 2 < name.size() ? hex_digit(name[i + 1]) : -1;
        const int low = high >= 0 ? hex_digit(name[i + 2]) : -1;
        out += low >= 0 ? static_cast<char>(high * 16 + low) : name[i];
        if (low >= 0) i += 2;
    }
    return out;
}

fs::path folder_of(const fs::path& mesh) {
    const fs::path folder = mesh.parent_path();
    return folder.empty() ? "." : folder;
}

fs::path with_slashes(std::string_view name) {
    std::string text(name);
    std::replace(text.begin(), text.end(), '\\', '/');
    return text;
}

Result<fs::path> find_beside(const fs::path& mesh, const fs::path& folder, std::string_view name) {
    constexpr size_t kLongest = 4096;
    if (name.empty() || name.size() > kLongest || name.find('\0') != std::string_view::npos)
        return user_error(messages::kNoNameOfFile);
    const fs::path root = without_links(folder_of(mesh));
    const fs::path named = with_slashes(name);
    std::error_code ignored;
    bool elsewhere = false;
    // Some programs write names as addresses.
    const std::string text = percent_decoded(name);
    const fs::path decoded = text.find('\0') == std::string::npos ? with_slashes(text) : named;
    for (const fs::path& path : {folder / named, folder / named.filename(), folder / decoded,
                                 folder / decoded.filename()}) {
        if (!path.has_filename()) continue;
        const fs::path other = fs::exists(path, ignored) ? path : in_other_letters(path);
        if (other.empty()) continue;
        if (is_below(without_links(other), root)) return other;
        elsewhere = true;
    }
    if (elsewhere || !is_below(without_links(folder / named), root))
        return user_error(messages::kNotBelowFolder, messages::kNotBelowFolderHelp);
    // Tiles of coordinates beyond 1, as Blender and painting programs write them.
    for (const char* tiles : {"<UDIM>", "<udim>", "<UVTILE>", "%(UDIM)d"}) {
        if (name.find(tiles) != std::string_view::npos)
            return user_error(messages::kPictureTiles, messages::kPictureTilesHelp);
    }
    return user_error(messages::kNoSuchFile, messages::kNoSuchFileHelp);
}

void read_beside(const fs::path& mesh, std::span<const std::string> sources, int64_t memory_bytes,
                 const TakePicture& take) {
    const fs::path root = without_links(folder_of(mesh));
    for (size_t i = 0; i < sources.size(); ++i) {
        const Result<fs::path> path = find_beside(mesh, folder_of(mesh), sources[i]);
        if (!path) {
            take(i, path.error());
            continue;
        }
        const Result<InputFile> file = InputFile::open(*path, {root});
        Result<std::string> bytes = file ? file->read_all(memory_bytes) : file.error();
        if (bytes) memory_bytes -= static_cast<int64_t>(bytes->size());
        take(i, std::move(bytes));
    }
}

}  // namespace openfab::mesh
