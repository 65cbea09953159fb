// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Looks of 3MF: display colours of base materials, and the pictures of texture groups.

#include <fmt/format.h>

#include <cstdlib>
#include <map>

#include "base/color.h"
#include "mesh/read/threemf.h"
#include "mesh/read/threemf_model.h"
#include "mesh/read/xml.h"
#include "mesh/read/zip_file.h"
#include "tools/openfab/looks.h"

namespace openfab::tool {

namespace {

/// `#rrggbb` or `#rrggbbaa`.
std::optional<std::array<double, 3>> color_of(const char* text) {
    const std::string_view hex = text != nullptr ? text : "";
    if ((hex.size() != 7 && hex.size() != 9) || hex[0] != '#' ||
        hex.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string_view::npos)
        return {};
    std::array<double, 3> out{};
    for (size_t c = 0; c < 3; ++c) {
        const std::string channel(hex.substr(1 + 2 * c, 2));
        out[c] = texture::srgb_to_linear(
            static_cast<double>(std::strtol(channel.c_str(), nullptr, 16)) / 255);
    }
    return out;
}

class Materials : public scene::XmlHandler {
  public:
    struct Texture {
        std::string path;
        bool clamp = false;
    };
    std::vector<Look> looks;
    std::map<std::string, Texture> textures;                  ///< by id
    std::vector<std::pair<std::string, std::string>> groups;  ///< id of group, id of texture

    Complaint start(std::string_view name, const scene::XmlAttributes& a) override {
        const auto text = [&](const char* key) {
            const char* found = a.find(key);
            return std::string(found != nullptr ? found : "");
        };
        if (name == "base") {
            looks.push_back({text("name"), color_of(a.find("displaycolor")), {}, false});
        } else if (name == "texture2d") {
            textures[text("id")] = {text("path"), text("tilestyleu") == "clamp"};
        } else if (name == "texture2dgroup") {
            groups.emplace_back(text("id"), text("texid"));
        }
        return {};
    }
    void end(std::string_view) override {}
};

}  // namespace

Result<Looks> threemf_looks(std::string_view bytes, const std::string& file) {
    const Result<scene::ZipFile> zip = scene::ZipFile::open(bytes, file);
    if (!zip) return zip.error();
    const Result<std::string> relationships = zip->read("_rels/.rels");
    if (!relationships) return relationships.error();
    const Result<std::string> model = scene::threemf_model_part(*relationships, file);
    if (!model) return model.error();
    const Result<std::string> text = zip->read(*model);
    if (!text) return text.error();
    Materials found;
    const Result<void> parsed =
        scene::parse_xml(*text, fmt::format("{}: {}", file, *model), &found);
    if (!parsed) return parsed.error();
    Looks out;
    for (Look& look : found.looks) {
        if (out.find(look.name) == nullptr) out.looks.push_back(std::move(look));
    }
    for (const auto& [group, id] : found.groups) {
        Look look;
        look.name = scene::threemf_texture_name(group);
        const auto texture = found.textures.find(id);
        const Result<std::string> picture =
            texture != found.textures.end()
                ? zip->read(texture->second.path)
                : Result<std::string>(user_error(fmt::format("{}: no texture {}", file, id)));
        if (picture) {
            const std::filesystem::path path = texture->second.path;
            look.picture = Picture{path.filename().string(), *picture, texture->second.clamp};
        } else {
            out.notes.push_back(picture.error().text());
        }
        out.looks.push_back(std::move(look));
    }
    return out;
}

}  // namespace openfab::tool
