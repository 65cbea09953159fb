// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/appearance.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/color.h"
#include "base/input_file.h"
#include "base/json.h"
#include "base/scan_number.h"
#include "base/text.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr int64_t kLargestFile = 2'000'000'000;
constexpr int64_t kLargestLibrary = 64'000'000;
constexpr size_t kMostLibraries = 100;
constexpr std::string_view kBlanks = " \t\r";

std::string_view trimmed(std::string_view text) {
    const size_t start = text.find_first_not_of(kBlanks);
    if (start == std::string_view::npos) return {};
    return text.substr(start, text.find_last_not_of(kBlanks) - start + 1);
}

/// Removes and returns the first word of a line.
std::string_view take_word(std::string_view* line) {
    *line = trimmed(*line);
    const std::string_view word = line->substr(0, line->find_first_of(kBlanks));
    *line = trimmed(line->substr(word.size()));
    return word;
}

/// Calls visit(line) for each line, without comments and blanks around.
template <typename Visit>
void each_line(std::string_view text, const Visit& visit) {
    while (!text.empty()) {
        const std::string_view line = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(line.size() + 1, text.size()));
        visit(trimmed(line.substr(0, line.find('#'))));
    }
}

bool is_inside(const fs::path& path, const fs::path& folder) {
    return is_below(without_links(path), without_links(folder.empty() ? "." : folder));
}

/// Programs on Windows write backslashes.
fs::path with_slashes(std::string_view name) {
    std::string text(name);
    std::replace(text.begin(), text.end(), '\\', '/');
    return text;
}

/// Skips the options of a map_Kd line, each with its number of values.
void take_map_options(std::string_view* line, Picture* picture, LooksMaker* out) {
    while (line->starts_with('-')) {
        const std::string_view option = take_word(line);
        if (option == "-clamp") {
            picture->clamp = take_word(line) == "on";
        } else if (option == "-o" || option == "-s" || option == "-t") {
            out->note(
                fmt::format("`{}` of a picture is left out: coordinates stay as they are", option));
            double ignored = 0;
            for (int i = 0; i < 3; ++i) {
                std::string_view rest = *line;
                if (!scan_number(take_word(&rest), &ignored).empty()) break;
                *line = rest;
            }
        } else if (option == "-mm") {
            take_word(line);
            take_word(line);
        } else {
            take_word(line);  // -blendu, -blendv, -boost, -bm, -cc, -imfchan, -texres, -type
        }
    }
}

void read_picture(std::string_view line, const fs::path& file, MaterialAppearance* appearance,
                  LooksMaker* out) {
    Picture picture;
    take_map_options(&line, &picture, out);
    if (line.empty()) return;
    const fs::path folder = file.parent_path();
    fs::path path = folder / with_slashes(line);
    std::error_code ignored;
    // Many libraries contain paths of another machine.
    const bool is_elsewhere = !is_inside(path, folder);
    if (!fs::exists(path, ignored) || is_elsewhere) path = folder / with_slashes(line).filename();
    const Result<SharedBytes> bytes =
        out->picture(without_links(path).string(), [&](int64_t most) -> Result<std::string> {
            if (!is_inside(path, folder)) return user_error("not below the mesh's folder");
            return read_text_file(path, static_cast<size_t>(most));
        });
    if (!bytes) {
        const char* const why =
            is_elsewhere ? "it is not below the mesh's folder; put a copy beside the mesh: " : "";
        out->note(fmt::format("the picture `{}` of material `{}` is left out: {}{}", line,
                              appearance->name, why, bytes.error().text()));
        return;
    }
    picture.name = path.filename().string();
    picture.bytes = *bytes;
    appearance->picture = std::move(picture);
}

/// Parses a material library (.mtl): newmtl, Kd, map_Kd with its options. Other lines are ignored.
void parse_mtl(std::string_view text, const fs::path& file, LooksMaker* out) {
    MaterialAppearance* appearance = nullptr;
    each_line(text, [&](std::string_view line) {
        const std::string_view word = take_word(&line);
        if (word == "newmtl") {
            appearance = out->add(std::string(line));
        } else if (word == "Kd" && appearance != nullptr) {
            std::array<double, 3> color{};
            for (double& channel : color) {
                if (!scan_number(take_word(&line), &channel).empty()) return;
                channel = srgb_to_linear(std::clamp(channel, 0.0, 1.0));
            }
            appearance->color = color;
        } else if (word == "map_Kd" && appearance != nullptr) {
            read_picture(line, file, appearance, out);
        }
    });
}

Result<Appearances> obj_appearances(std::string_view text, const fs::path& file,
                                    int64_t memory_bytes) {
    LooksMaker out(&memory_bytes);
    std::vector<fs::path> libraries;
    each_line(text, [&](std::string_view line) {
        if (take_word(&line) == "mtllib" && !line.empty() && libraries.size() <= kMostLibraries)
            libraries.push_back(with_slashes(line));
    });
    if (libraries.size() > kMostLibraries)
        return user_error(
            fmt::format("{}: more than {} material libraries", file.string(), kMostLibraries));
    std::sort(libraries.begin(), libraries.end());
    libraries.erase(std::unique(libraries.begin(), libraries.end()), libraries.end());
    for (const fs::path& library : libraries) {
        const fs::path path = file.parent_path() / library;
        const auto most = static_cast<size_t>(std::min(out.memory_left(), kLargestLibrary));
        const Result<std::string> found =
            is_inside(path, file.parent_path())
                ? read_text_file(path, most)
                : Result<std::string>(user_error("not below the mesh's folder"));
        if (!found) {
            out.note(fmt::format("the material library `{}` is left out: {}", library.string(),
                                 found.error().text()));
            continue;
        }
        parse_mtl(*found, path, &out);
    }
    return out.finish(file.string());
}

Error too_much(const std::string& file) {
    return user_error(
        fmt::format("{}: its materials and their pictures take more memory than is left beside the "
                    "mesh; allow more with `--memory`",
                    file));
}

std::string lower_extension(const fs::path& file) {
    return lower_ascii(file.extension().string());
}

}  // namespace

std::unordered_map<std::string_view, size_t> indices_of(const Appearances& appearances) {
    std::unordered_map<std::string_view, size_t> indices;
    for (size_t i = 0; i < appearances.appearances.size(); ++i)
        indices.emplace(appearances.appearances[i].name, i);
    return indices;
}

bool LooksMaker::take(size_t bytes) {
    memory_left_ -= static_cast<int64_t>(bytes);
    return memory_left_ >= 0;
}

MaterialAppearance* LooksMaker::add(const std::string& name) {
    // The list doubles and is copied then; the map holds the name again.
    constexpr size_t kNode = 64;
    if (memory_left_ < 0 || index_by_name_.count(name) != 0) return nullptr;
    if (!take(3 * sizeof(MaterialAppearance) + kNode + sizeof name + 2 * name.size()))
        return nullptr;
    index_by_name_.emplace(name, appearances_.appearances.size());
    appearances_.appearances.push_back({});
    appearances_.appearances.back().name = name;
    return &appearances_.appearances.back();
}

Result<SharedBytes> LooksMaker::picture(
    const std::string& key, const std::function<Result<std::string>(int64_t most)>& read) {
    if (const auto known = pictures_.find(key); known != pictures_.end()) return known->second;
    Result<std::string> bytes = read(std::max<int64_t>(memory_left_, 0));
    Result<SharedBytes> found =
        bytes ? Result<SharedBytes>(std::make_shared<const std::string>(std::move(*bytes)))
              : Result<SharedBytes>(bytes.error());
    constexpr size_t kNode = 200;
    take(kNode + key.size() + (found ? (*found)->size() : found.error().text().size()));
    return pictures_.emplace(key, std::move(found)).first->second;
}

void LooksMaker::note(std::string text) {
    if (take(2 * sizeof text + text.size())) appearances_.notes.push_back(std::move(text));
}

Result<Appearances> LooksMaker::finish(const std::string& file) {
    return memory_left_ >= 0 ? Result<Appearances>(std::move(appearances_))
                             : Result<Appearances>(too_much(file));
}

Result<Appearances> read_appearances(const fs::path& mesh, int64_t memory_bytes) {
    const std::string extension = lower_extension(mesh);
    if (extension == ".stl" || extension == ".ply") return Appearances{};
    std::error_code unknown;
    const uintmax_t size = fs::file_size(mesh, unknown);
    if (!unknown && static_cast<int64_t>(size) > memory_bytes) return too_much(mesh.string());
    const Result<std::string> bytes =
        read_text_file(mesh, static_cast<size_t>(std::min(memory_bytes, kLargestFile)));
    if (!bytes) return bytes.error();
    memory_bytes -= static_cast<int64_t>(bytes->capacity());
    if (extension == ".obj") return obj_appearances(*bytes, mesh, memory_bytes);
    if (extension == ".3mf") return threemf_appearances(*bytes, mesh.string(), memory_bytes);
    return gltf_appearances(*bytes, mesh.string(), memory_bytes);
}

}  // namespace openfab::tools
