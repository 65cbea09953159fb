// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/output_check.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <tuple>

#include "backends/raster/folder_sink.h"
#include "backends/raster/npy_sink.h"
#include "backends/stream/address.h"
#include "program/messages.h"
#include "program/outputs.h"

namespace openfab::program {

namespace {

namespace fs = std::filesystem;

/// The identity of a file: device and inode, and for a file that does not exist yet its name in the
/// folder with that inode.
struct Identity {
    dev_t device = 0;
    ino_t number = 0;
    std::string name;
    bool operator==(const Identity&) const = default;
};

std::optional<struct stat> status_of(const fs::path& path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return {};
    return status;
}

/// Returns nothing for pipes and devices, and if the folder does not exist either.
std::optional<Identity> identity_of(fs::path path) {
    // A dangling link says where the file would be created.
    constexpr int kMostLinks = 40;
    for (int links = 0; links < kMostLinks; ++links) {
        if (const auto status = status_of(path)) {
            if (!S_ISREG(status->st_mode) && !S_ISDIR(status->st_mode)) return {};
            return Identity{status->st_dev, status->st_ino, {}};
        }
        std::error_code none;
        const fs::path target = fs::read_symlink(path, none);
        if (none) break;
        path = target.is_absolute() ? target : path.parent_path() / target;
    }
    // `out/` and `out` are the same.
    path = path.lexically_normal();
    if (!path.has_filename()) path = path.parent_path();
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    if (const auto status = status_of(folder))
        return Identity{status->st_dev, status->st_ino, path.filename().string()};
    // Folders that do not exist yet are compared by name.
    std::error_code ignored;
    return Identity{0, 0, fs::weakly_canonical(path, ignored).string()};
}

Error clash(const NamedOutput& output, const std::string& with) {
    return user_error(
        fmt::format(messages::kWouldOverwrite, output.option, output.path.string(), with));
}

std::string described(const fs::path& input) {
    return fmt::format(messages::kWhichIsAnInput, input.string());
}

/// Fails where a file cannot be written that the work ends with: not after all of it.
Result<void> check_place(const fs::path& path) {
    const auto status = status_of(path);
    if (status && S_ISDIR(status->st_mode))
        return user_error(fmt::format(messages::kOutputIsAFolder, path.string()));
    if (status && !S_ISREG(status->st_mode)) return {};
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    if (::access(folder.c_str(), W_OK | X_OK) == 0) return {};
    return outside_error(fmt::format(messages::kCannotCreate, path.string(), std::strerror(errno)));
}

/// Fails if an input or another output is, or would be, a file in a folder of slices.
Result<void> check_folder(const NamedOutput& folder, const std::vector<NamedOutput>& outputs,
                          const std::vector<fs::path>& inputs) {
    std::vector<fs::path> others = inputs;
    for (const NamedOutput& output : outputs)
        others.push_back(output.path);
    const auto what = [&](size_t i) {
        return i < inputs.size() ? described(inputs[i])
                                 : fmt::format("`{} {}`", outputs[i - inputs.size()].option,
                                               outputs[i - inputs.size()].path.string());
    };
    const std::optional<Identity> there = identity_of(folder.path);
    for (size_t i = 0; i < others.size(); ++i) {
        const fs::path plain = others[i].lexically_normal();
        if (!raster::is_folder_file(plain.filename().string())) continue;
        const fs::path above = plain.has_parent_path() ? plain.parent_path() : fs::path(".");
        if (there && identity_of(above) == there) return clash(folder, what(i));
    }
    // Names in the folder may be links to files elsewhere.
    std::vector<std::optional<Identity>> of_others;
    of_others.reserve(others.size());
    for (const fs::path& other : others)
        of_others.push_back(identity_of(other));
    std::error_code status;
    for (fs::directory_iterator entry(folder.path, status), end; !status && entry != end;
         entry.increment(status)) {
        if (!raster::is_folder_file(entry->path().filename().string())) continue;
        const std::optional<Identity> file = identity_of(entry->path());
        for (size_t i = 0; i < others.size() && file; ++i) {
            if (of_others[i] == file) return clash(folder, what(i));
        }
    }
    return {};
}

}  // namespace

std::vector<NamedOutput> outputs_of(const OutputOptions& options, const backends::Format* format,
                                    const std::vector<pipeline::SliceMaterial>& materials) {
    std::vector<NamedOutput> out;
    // Written under a temporary name and then renamed; pipes and devices directly.
    const auto whole = [&](const char* option, const fs::path& path) {
        out.push_back({option, path});
        if (identity_of(path)) out.push_back({option, path.string() + ".part"});
    };
    const bool is_file =
        !options.output.empty() && options.output != "-" && !stream::is_address(options.output);
    if (is_file && (format == nullptr || format->files == nullptr)) {
        out.push_back({"-o", options.output});
    } else if (is_file) {
        for (const backends::FormatFile& file : format->files(options.output, materials)) {
            if (file.renamed)
                whole("-o", file.path);
            else
                out.push_back({"-o", file.path});
        }
    }
    if (!options.fractions_file.empty()) {
        out.push_back({"--fractions", options.fractions_file});
        whole("--fractions", raster::array_json_path(options.fractions_file));
    }
    if (!options.stats_file.empty()) whole("--stats", options.stats_file);
    for (const NamedOutput& more : options.more_outputs)
        whole(more.option.c_str(), more.path);
    for (const preview::PreviewSpec& spec : options.previews) {
        if (!spec.file.empty()) whole("--preview", spec.file);
    }
    return out;
}

Result<void> check_outputs(const std::vector<NamedOutput>& outputs,
                           const std::vector<fs::path>& inputs) {
    std::vector<std::optional<Identity>> made;
    for (const NamedOutput& output : outputs) {
        made.push_back(identity_of(output.path));
        if (!made.back()) continue;
        for (const fs::path& input : inputs) {
            if (identity_of(input) == made.back()) return clash(output, described(input));
        }
        for (size_t i = 0; i + 1 < made.size(); ++i) {
            if (made[i] != made.back()) continue;
            return user_error(fmt::format(messages::kOutputsAreOneFile, outputs[i].option,
                                          outputs[i].path.string(), output.option,
                                          output.path.string()));
        }
    }
    return {};
}

Result<void> check_outputs(const OutputOptions& options, const backends::Format* format,
                           const std::vector<pipeline::SliceMaterial>& materials,
                           const std::vector<fs::path>& inputs) {
    const std::vector<NamedOutput> outputs = outputs_of(options, format, materials);
    if (Result<void> apart = check_outputs(outputs, inputs); !apart) return apart;
    for (const NamedOutput& more : options.more_outputs) {
        if (Result<void> possible = check_place(more.path); !possible) return possible;
    }
    if (format == nullptr || format->kind != backends::FormatKind::kFolder ||
        options.output.empty())
        return {};
    const auto folder = std::find_if(outputs.begin(), outputs.end(), [](const NamedOutput& output) {
        return output.option == "-o";
    });
    std::vector<NamedOutput> others = outputs;
    std::erase_if(others, [](const NamedOutput& output) { return output.option == "-o"; });
    return check_folder(*folder, others, inputs);
}

}  // namespace openfab::program
