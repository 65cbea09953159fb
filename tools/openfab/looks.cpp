// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/looks.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/color.h"
#include "base/input_file.h"
#include "base/json.h"
#include "base/scan_number.h"
#include "base/text.h"

namespace openfab::tool {

namespace {

namespace fs = std::filesystem;

constexpr size_t kLargestFile = 2'000'000'000;
constexpr size_t kLargestLibrary = 64'000'000;
constexpr size_t kLargestPicture = 1'000'000'000;
constexpr std::string_view kBlanks = " \t\r";

std::string_view trimmed(std::string_view text) {
    const size_t start = text.find_first_not_of(kBlanks);
    if (start == std::string_view::npos) return {};
    return text.substr(start, text.find_last_not_of(kBlanks) - start + 1);
}

/// Takes the first word off a line.
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

/// Programs on Windows write their own separators.
fs::path with_slashes(std::string_view name) {
    std::string text(name);
    std::replace(text.begin(), text.end(), '\\', '/');
    return text;
}

/// The options of a map_Kd line off its front: each has a number of values.
void take_map_options(std::string_view* line, Picture* picture, std::vector<std::string>* notes) {
    while (line->starts_with('-')) {
        const std::string_view option = take_word(line);
        if (option == "-clamp") {
            picture->clamp = take_word(line) == "on";
        } else if (option == "-o" || option == "-s" || option == "-t") {
            notes->push_back(
                fmt::format("`{}` of a picture is left out: coordinates stay as they are", option));
            double ignored = 0;
            for (int i = 0; i < 3; ++i) {
                std::string_view rest = *line;
                if (!scene::scan_number(take_word(&rest), &ignored).empty()) break;
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

void read_picture(std::string_view line, const fs::path& file, Look* look, Looks* out) {
    Picture picture;
    take_map_options(&line, &picture, &out->notes);
    if (line.empty()) return;
    const fs::path folder = file.parent_path();
    fs::path path = folder / with_slashes(line);
    std::error_code ignored;
    // Many libraries name the place where the picture was on another machine.
    if (!fs::exists(path, ignored) || !is_inside(path, folder))
        path = folder / with_slashes(line).filename();
    Result<std::string> bytes =
        is_inside(path, folder) ? scene::read_text_file(path, kLargestPicture)
                                : Result<std::string>(user_error("not below the mesh's folder"));
    if (!bytes) {
        out->notes.push_back(fmt::format("the picture `{}` of material `{}` is left out: {}", line,
                                         look->name, bytes.error().text()));
        return;
    }
    picture.name = path.filename().string();
    picture.bytes = std::move(*bytes);
    look->picture = std::move(picture);
}

Result<Looks> obj_looks(std::string_view text, const fs::path& file) {
    Looks out;
    std::vector<fs::path> libraries;
    each_line(text, [&](std::string_view line) {
        if (take_word(&line) == "mtllib" && !line.empty()) libraries.push_back(with_slashes(line));
    });
    std::sort(libraries.begin(), libraries.end());
    libraries.erase(std::unique(libraries.begin(), libraries.end()), libraries.end());
    for (const fs::path& library : libraries) {
        const fs::path path = file.parent_path() / library;
        const Result<std::string> found =
            is_inside(path, file.parent_path())
                ? scene::read_text_file(path, kLargestLibrary)
                : Result<std::string>(user_error("not below the mesh's folder"));
        if (!found) {
            out.notes.push_back(fmt::format("the material library `{}` is left out: {}",
                                            library.string(), found.error().text()));
            continue;
        }
        parse_mtl(*found, path, &out);
    }
    return out;
}

std::string lower_extension(const fs::path& file) {
    return lower_ascii(file.extension().string());
}

}  // namespace

const Look* Looks::find(std::string_view name) const {
    for (const Look& look : looks) {
        if (look.name == name) return &look;
    }
    return nullptr;
}

void parse_mtl(std::string_view text, const fs::path& file, Looks* out) {
    Look* look = nullptr;
    each_line(text, [&](std::string_view line) {
        const std::string_view word = take_word(&line);
        if (word == "newmtl") {
            look = nullptr;
            if (out->find(line) != nullptr) return;  // the first one counts
            out->looks.push_back({});
            look = &out->looks.back();
            look->name = std::string(line);
        } else if (word == "Kd" && look != nullptr) {
            std::array<double, 3> color{};
            for (double& channel : color) {
                if (!scene::scan_number(take_word(&line), &channel).empty()) return;
                channel = texture::srgb_to_linear(std::clamp(channel, 0.0, 1.0));
            }
            look->color = color;
        } else if (word == "map_Kd" && look != nullptr) {
            read_picture(line, file, look, out);
        }
    });
}

Result<Looks> read_looks(const fs::path& mesh) {
    const std::string extension = lower_extension(mesh);
    if (extension == ".stl" || extension == ".ply") return Looks{};
    const Result<std::string> bytes = scene::read_text_file(mesh, kLargestFile);
    if (!bytes) return bytes.error();
    if (extension == ".obj") return obj_looks(*bytes, mesh);
    if (extension == ".3mf") return threemf_looks(*bytes, mesh.string());
    return gltf_looks(*bytes, mesh.string());
}

}  // namespace openfab::tool
