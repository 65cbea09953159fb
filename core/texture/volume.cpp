// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/hash.h"
#include "base/input_file.h"
#include "base/jail.h"
#include "base/text.h"
#include "texture/data_files.h"
#include "texture/helper.h"
#include "texture/messages.h"
#include "texture/meta_header.h"
#include "texture/nifti_header.h"
#include "texture/nrrd_header.h"
#include "texture/pyramid_file.h"
#include "texture/xdmf_grid.h"
#include "texture/zarr_store.h"

namespace openfab::texture {
namespace {

namespace fs = std::filesystem;

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

/// Replaces `%d` and `%04d` by a single `%`.
std::string plain_pattern(std::string_view text) {
    std::string out;
    for (size_t i = 0; i < text.size(); ++i) {
        size_t end = i + 1;
        while (text[i] == '%' && end < text.size() && is_digit(text[end]))
            ++end;
        const bool number = text[i] == '%' && end < text.size() && text[end] == 'd';
        out += text[i];
        if (number) i = end;
    }
    return out;
}

/// Advances the set of possible match ends by one character of the pattern at a time: the work is
/// the product of both lengths for any pattern.
bool matches(std::string_view pattern, std::string_view name) {
    std::vector<char> ends(name.size() + 1, 0), next(name.size() + 1);
    ends[0] = 1;
    for (const char sign : pattern) {
        std::fill(next.begin(), next.end(), 0);
        for (size_t n = 0; n <= name.size(); ++n) {
            if (sign == '*') {
                next[n] = ends[n] != 0 || (n > 0 && next[n - 1] != 0);
            } else if (n > 0 && sign == '%') {
                next[n] = is_digit(name[n - 1]) && (ends[n - 1] != 0 || next[n - 1] != 0);
            } else if (n > 0 && ends[n - 1] != 0) {
                next[n] = sign == '#' ? is_digit(name[n - 1]) : sign == name[n - 1];
            }
        }
        ends.swap(next);
    }
    return ends[name.size()] != 0;
}

/// Compares numbers by value, so that slice 10 follows slice 9.
bool comes_before(const fs::path& left, const fs::path& right) {
    const std::string a = left.filename().string(), b = right.filename().string();
    size_t i = 0, j = 0;
    while (i < a.size() && j < b.size()) {
        if (!is_digit(a[i]) || !is_digit(b[j])) {
            if (a[i] != b[j]) return a[i] < b[j];
            ++i, ++j;
            continue;
        }
        const auto number = [](const std::string& s, size_t* at) {
            while (*at < s.size() && s[*at] == '0')
                ++*at;
            const size_t begin = *at;
            while (*at < s.size() && is_digit(s[*at]))
                ++*at;
            return std::string_view(s).substr(begin, *at - begin);
        };
        const std::string_view x = number(a, &i), y = number(b, &j);
        if (x.size() != y.size()) return x.size() < y.size();
        if (x != y) return x < y;
    }
    if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
    return a < b;
}

/// Lists all files in a folder and in those below it, without following links.
Result<std::vector<fs::path>> files_below(const fs::path& folder) {
    std::vector<fs::path> out;
    std::error_code trouble;
    for (fs::recursive_directory_iterator it(folder.empty() ? fs::path(".") : folder, trouble), end;
         !trouble && it != end; it.increment(trouble)) {
        constexpr int kDeepest = 16;
        constexpr size_t kMostFiles = 200'000;
        const bool hidden = it->path().filename().string()[0] == '.';
        std::error_code ignored;
        if (hidden || it.depth() >= kDeepest) it.disable_recursion_pending();
        if (!hidden && it->is_regular_file(ignored)) out.push_back(it->path());
        if (out.size() > kMostFiles) {
            return user_error(fmt::format(messages::kCannotRead, folder.string(),
                                          fmt::format(messages::kTooManyFiles, kMostFiles)));
        }
    }
    std::sort(out.begin(), out.end());
    return out;
}

std::string three(const std::array<double, 3>& v) {
    return fmt::format("{:.17g},{:.17g},{:.17g}", v[0], v[1], v[2]);
}

/// The options as the converter takes them.
std::vector<std::string> arguments(const VolumeOptions& options) {
    std::vector<std::string> out = {"--volume"};
    if (options.origin_mm) out.push_back("--origin=" + three(*options.origin_mm));
    if (options.spacing_mm) out.push_back("--spacing=" + three(*options.spacing_mm));
    if (!options.field.empty()) out.push_back("--field=" + options.field);
    if (!options.unit.empty()) out.push_back("--unit=" + options.unit);
    if (options.pitch_mm > 0) out.push_back(fmt::format("--pitch={:.17g}mm", options.pitch_mm));
    if (options.outside) out.push_back(fmt::format("--outside={:.17g}", *options.outside));
    if (!options.segment.empty()) out.push_back("--segment=" + options.segment);
    const std::pair<const char*, std::optional<double>> numbers[] = {
        {"time", options.time},         {"echo", options.echo},
        {"detector", options.detector}, {"energy-window", options.energy_window},
        {"phase", options.phase},
    };
    for (const auto& [name, value] : numbers) {
        if (value) out.push_back(fmt::format("--{}={:.17g}", name, *value));
    }
    return out;
}

}  // namespace

bool is_dicom(const fs::path& path) {
    constexpr int64_t kMark = 128;
    std::array<char, 4> mark{};
    const Result<InputFile> file = InputFile::open(path);
    if (!file) return false;
    const Result<size_t> got = file->read(kMark, mark.data(), mark.size());
    return got && std::string_view(mark.data(), *got) == "DICM";
}

bool is_medium_list(const fs::path& file) {
    return lower_ascii(file.filename().string()) == "dicomdir";
}

namespace {

bool is_print_manifest(const fs::path& file) {
    return file.filename() == kPrintManifest;
}

}  // namespace

Result<std::vector<fs::path>> volume_files(const fs::path& source) {
    std::error_code trouble;
    if (fs::is_regular_file(source, trouble)) {
        if (is_medium_list(source)) return files_below(source.parent_path());
        return std::vector<fs::path>{source};
    }
    const bool folder = fs::is_directory(source, trouble);
    if (folder) {
        if (fs::path metadata = zarr_metadata(source); !metadata.empty())
            return std::vector<fs::path>{std::move(metadata)};
    }
    const fs::path directory = folder ? source : source.parent_path();
    const std::string pattern = folder ? "*" : plain_pattern(source.filename().string());
    std::vector<fs::path> files;
    // The work is the product of its length and that of all names.
    constexpr size_t kLongestPattern = 1000;
    const bool many = folder || (pattern.find_first_of("*#%") != std::string::npos &&
                                 pattern.size() <= kLongestPattern);
    if (many) {
        for (fs::directory_iterator it(directory.empty() ? fs::path(".") : directory, trouble), end;
             !trouble && it != end; it.increment(trouble)) {
            const std::string name = it->path().filename().string();
            std::error_code ignored;
            if (name[0] != '.' && it->is_regular_file(ignored) && matches(pattern, name))
                files.push_back(it->path());
        }
    }
    if (folder && std::any_of(files.begin(), files.end(), is_print_manifest)) {
        std::erase_if(files, [](const fs::path& file) {
            return !is_print_manifest(file) && !file.filename().string().starts_with("slice_");
        });
    }
    if (folder && std::any_of(files.begin(), files.end(), is_medium_list))
        return files_below(directory);
    if (folder && files.empty()) {
        Result<std::vector<fs::path>> below = files_below(directory);
        if (!below || std::any_of(below->begin(), below->end(), is_dicom)) return below;
    }
    if (files.empty()) {
        return user_error(fmt::format(messages::kCannotRead, source.string(),
                                      folder ? messages::kFolderEmpty : messages::kNoSuchFile));
    }
    std::sort(files.begin(), files.end(), comes_before);
    return files;
}

namespace {

bool is_npy(const InputFile& file) {
    std::array<char, 6> mark{};
    const Result<size_t> got = file.read(0, mark.data(), mark.size());
    return got && std::string_view(mark.data(), *got) == "\x93NUMPY";
}

/// Names the files of a store but the one that describes it.
std::vector<std::string> read_files_of_store(const fs::path& file, const VolumeOptions& options,
                                             const ReadLimits& limits) {
    const Result<ZarrVolume> volume = read_zarr_store(file, options, limits);
    if (!volume) return {};
    Result<std::vector<std::string>> names = zarr_files(file, *volume);
    if (!names) return {};
    std::erase(*names, file.filename().string());
    return std::move(*names);
}

std::vector<std::string> read_data_files_of(const fs::path& file, const VolumeOptions& options,
                                            const ReadLimits& limits) {
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return {};
    if (is_zarr_metadata(file)) return read_files_of_store(file, options, limits);
    if (is_xdmf(file)) {
        const Result<XdmfGrid> grid = read_xdmf_grid(*opened, options.time, options.field, limits);
        return grid ? grid->data_files() : std::vector<std::string>();
    }
    if (std::string beside = file.filename().string() + ".json";
        is_npy(*opened) && fs::exists(file.parent_path() / beside))
        return {std::move(beside)};
    std::string begin(NiftiHeader::kBytes, '\0');
    const Result<size_t> got = opened->read(0, begin.data(), begin.size());
    if (!got) return {};
    begin.resize(*got);
    if (is_nifti(begin)) {
        const Result<NiftiHeader> header = read_nifti_header(begin);
        if (!header || !header->detached) return {};
        return {nifti_data_file(file.filename().string())};
    }
    std::string name;
    std::vector<std::string> listed;
    const auto take = [&](const auto& header) {
        if (!header) return;
        name = header->data_file();
        listed = header->listed;
    };
    if (begin.starts_with("NRRD")) {
        take(read_nrrd_header(*opened));
    } else if (is_meta_image(file)) {
        take(read_meta_header(*opened));
    }
    if (name.empty()) return {};
    Result<std::vector<std::string>> names = read_data_files(name, listed);
    return names ? std::move(*names) : std::vector<std::string>();
}

/// Names the data files of a header of NRRD, NIfTI or MetaImage, of an XDMF file or of a store of Zarr, and what tells the place of an array
/// of a print; none of any other file,
/// or of one that cannot be read.
std::vector<std::string> data_files_of(const fs::path& file, const VolumeOptions& options,
                                       const ReadLimits& limits) {
    using Names = std::vector<std::string>;
    JailLimits jail = limits_of_header(file, limits.memory_bytes);
    if (is_zarr_metadata(file))
        jail.reads =
            limits.roots.empty() ? std::vector{reading_root(file.parent_path())} : limits.roots;
    Result<Names> names = read_in_jail<Names>(
        file, jail, [&]() -> Result<Names> { return read_data_files_of(file, options, limits); });
    return names ? std::move(*names) : Names();
}

}  // namespace

std::vector<fs::path> detached_data(const fs::path& file, const VolumeOptions& options) {
    std::vector<fs::path> out;
    for (const std::string& name : data_files_of(file, options, {}))
        out.push_back(file.parent_path() / name);
    return out;
}

Result<uint64_t> volume_key(const fs::path& source, const VolumeOptions& options,
                            const ReadLimits& limits) {
    const Result<std::vector<fs::path>> files = volume_files(source);
    if (!files) return files.error();
    // The number counts changes of what volumes are read as; 5: numbers, grids, series, frames of DICOM and names of
    // slices as docs/how-to/fields.md has them.
    std::string text = fmt::format("volume 5, first row lowest|{}", files->size());
    for (const std::string& argument : arguments(options))
        text += "|" + argument;
    for (const fs::path& file : *files) {
        const Result<uint64_t> key = content_key(file, options.image);
        if (!key) return key.error();
        text += fmt::format("|{:016x}", *key);
        // Names of several say which channel or time each is of.
        if (files->size() > 1) text += "|" + file.filename().string();
    }
    if (files->size() == 1) {
        for (const std::string& name : data_files_of(files->front(), options, limits)) {
            // Opened and checked to be allowed before a byte of it is read.
            const Result<InputFile> data = open_data_file(files->front(), name, limits);
            if (!data)
                return with_context(data.error(),
                                    fmt::format(messages::kCannotReadBecause, source.string()));
            const Result<uint64_t> key = content_key(data->name(), options.image);
            if (!key) return key.error();
            text += fmt::format("|{:016x}", *key);
        }
    }
    // A format without a signature is recognized by its extension.
    text += "|" + files->front().extension().string();
    return xxh3(text);
}

Result<std::shared_ptr<const Pyramid>> get_volume(const fs::path& source,
                                                  const VolumeOptions& options, WrapModes wrap,
                                                  int32_t filter, const ReadLimits& limits) {
    const Result<uint64_t> key = volume_key(source, options, limits);
    if (!key) return key.error();
    return find_or_make(*key, source, options.image, wrap, filter, limits, arguments(options));
}

}  // namespace openfab::texture
