// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Appearance in 3MF: display colours of base materials, and the pictures of texture groups.

#include <fmt/format.h>

#include <cstdlib>
#include <map>

#include "base/color.h"
#include "base/xml.h"
#include "mesh/read/threemf.h"
#include "mesh/read/threemf_looks.h"
#include "mesh/read/zip_file.h"
#include "tools/openfab/appearance.h"

namespace openfab::tools {

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
        out[c] =
            srgb_to_linear(static_cast<double>(std::strtol(channel.c_str(), nullptr, 16)) / 255);
    }
    return out;
}

class Materials : public XmlHandler {
  public:
    struct Texture {
        std::string path;
        bool clamp = false;
    };
    Materials(LooksMaker* out, int64_t* memory_left) : out_(*out), memory_left_(*memory_left) {}

    std::map<std::string, Texture> textures;                  ///< by id
    std::vector<std::pair<std::string, std::string>> groups;  ///< id of group, id of texture

    Complaint start(std::string_view name, const XmlAttributes& a) override {
        const auto text = [&](const char* key) {
            const char* found = a.find(key);
            return std::string(found != nullptr ? found : "");
        };
        // Lists double and are copied then; map nodes take about as much.
        const auto take = [&](size_t bytes) { memory_left_ -= static_cast<int64_t>(3 * bytes); };
        if (name == "base") {
            if (MaterialAppearance* appearance = out_.add(text("name")))
                appearance->color = color_of(a.find("displaycolor"));
        } else if (name == "texture2d") {
            Texture texture{text("path"), text("tilestyleu") == "clamp"};
            take(sizeof texture + sizeof(std::string) + texture.path.size() + text("id").size());
            textures[text("id")] = std::move(texture);
        } else if (name == "texture2dgroup") {
            groups.emplace_back(text("id"), text("texid"));
            take(sizeof groups[0] + groups.back().first.size() + groups.back().second.size());
        }
        return memory_left_ < 0
                   ? "the materials take more memory than is allowed; allow more with `--memory`"
                   : "";
    }
    void end(std::string_view) override {}

  private:
    LooksMaker& out_;
    int64_t& memory_left_;
};

}  // namespace

Result<Appearances> threemf_appearances(std::string_view bytes, const std::string& file,
                                        int64_t memory_bytes) {
    const Result<mesh::ZipFile> zip = mesh::ZipFile::open(bytes, file);
    if (!zip) return zip.error();
    const Result<std::string> relationships = zip->read("_rels/.rels", memory_bytes);
    if (!relationships) return relationships.error();
    const Result<std::string> model = mesh::threemf_model_part(*relationships, file);
    if (!model) return model.error();
    Result<std::string> text = zip->read(*model, memory_bytes);
    if (!text) return text.error();
    const auto length = static_cast<int64_t>(text->size());
    memory_bytes -= length;
    LooksMaker out(&memory_bytes);
    Materials found(&out, &memory_bytes);
    const Result<void> parsed = parse_xml(*text, fmt::format("{}: {}", file, *model), &found);
    if (!parsed) return parsed.error();
    text = std::string();
    memory_bytes += length;
    for (const auto& [group, id] : found.groups) {
        MaterialAppearance* appearance = out.add(mesh::threemf_texture_name(group));
        if (appearance == nullptr) continue;
        const auto texture = found.textures.find(id);
        const Result<SharedBytes> picture =
            texture != found.textures.end()
                ? out.picture(mesh::ZipFile::key(texture->second.path),
                              [&](int64_t most) { return zip->read(texture->second.path, most); })
                : Result<SharedBytes>(user_error(fmt::format("{}: no texture {}", file, id)));
        if (picture) {
            const std::filesystem::path path = texture->second.path;
            appearance->picture =
                Picture{path.filename().string(), *picture, texture->second.clamp};
        } else {
            out.note(picture.error().text());
        }
    }
    return out.finish(file);
}

}  // namespace openfab::tools
