// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import_pictures.h"
#include "base/json_text.h"

#include <fmt/format.h>

#include <filesystem>

#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

const char* wrap_name(mesh::PictureWrap wrap) {
    switch (wrap) {
        case mesh::PictureWrap::kClamp:
            return "clamp";
        case mesh::PictureWrap::kMirror:
            return "mirror";
        case mesh::PictureWrap::kNone:
            return "black";
        case mesh::PictureWrap::kRepeat:
            break;
    }
    return "repeat";
}

/// Repeating is the default of worlds.
std::string wrap_text(const std::array<mesh::PictureWrap, 2>& wrap) {
    const std::string u = wrap_name(wrap[0]), v = wrap_name(wrap[1]);
    if (u == v) return u == "repeat" ? "" : fmt::format(", \"wrap\": \"{}\"", u);
    return fmt::format(", \"wrap\": [\"{}\", \"{}\"]", u, v);
}

const char* space_text(mesh::PictureUse::Space space) {
    switch (space) {
        case mesh::PictureUse::Space::kSrgb:
            return ", \"space\": \"srgb\"";
        case mesh::PictureUse::Space::kLinear:
            return ", \"space\": \"linear\"";
        case mesh::PictureUse::Space::kOwn:
            break;
    }
    return "";
}

/// Whether a picture may have alpha; those of the usual kinds that have none are known.
bool may_have_alpha(std::string_view bytes) {
    if (bytes.starts_with("\xff\xd8")) return false;  // JPEG
    constexpr size_t kColorType = 25;
    if (!bytes.starts_with("\x89PNG") || bytes.size() <= kColorType) return true;
    constexpr char kAlpha = 4;  // a bit of it
    return (bytes[kColorType] & kAlpha) != 0 || bytes.find("tRNS") != std::string_view::npos;
}

}  // namespace

std::vector<std::string> leave_out_unreadable(const Pictures& pictures,
                                              std::vector<mesh::Look>* looks) {
    std::vector<std::string> notes;
    std::map<std::string, bool> told;
    for (mesh::Look& look : *looks) {
        if (!look.picture) continue;
        const auto found = pictures.find(look.picture->source);
        if (found != pictures.end() && found->second) continue;
        if (told.emplace(look.picture->source, true).second) {
            const std::string of =
                look.name.empty() ? "" : fmt::format(messages::kOfMaterial, look.name);
            const std::string why =
                found == pictures.end() ? "" : ": " + found->second.error().text();
            notes.push_back(fmt::format(messages::kPictureOfLeftOut, look.picture->name, of, why));
        }
        look.picture.reset();
    }
    return notes;
}

std::string ImportPictures::add(const mesh::PictureUse& use, bool luminance,
                                std::vector<std::string>* notes) {
    const auto found = pictures_.find(use.source);
    if (found == pictures_.end() || !found->second) {
        if (told_.emplace(use.source, true).second) {
            notes->push_back(found == pictures_.end()
                                 ? fmt::format(messages::kPictureLeftOut, use.name)
                                 : found->second.error().text());
        }
        return {};
    }
    const bool opaque = !luminance && use.alpha == mesh::PictureUse::Alpha::kOpaque &&
                        may_have_alpha(**found->second);
    return add_as(use.name, *found->second,
                  Way{use.wrap, opaque, use.nearest && !luminance, use.space}, luminance);
}

std::string ImportPictures::add(const std::string& name, const SharedBytes& bytes,
                                const std::array<mesh::PictureWrap, 2>& wrap, bool luminance) {
    return add_as(name, bytes, Way{.wrap = wrap}, luminance);
}

std::string ImportPictures::add_as(const std::string& name, const SharedBytes& bytes,
                                   const Way& way, bool luminance) {
    const auto [shared, first] = shared_.try_emplace({bytes.get(), way});
    if (!first) return shared->second;
    const std::filesystem::path plain = plain_name(name);
    const auto [file, fresh_file] = by_content_.try_emplace(*bytes);
    const auto texture_of = [&](const std::string& stem) {
        const std::string texture = names_.unique(stem);
        if (fresh_file) {
            file->second = texture + plain.extension().string();
            files_.push_back({file->second, bytes});
        }
        lines_.push_back(fmt::format(
            "{}: {{\"file\": {}{}{}{}{}}}", json_string(texture), json_string(file->second),
            wrap_text(way.wrap), way.nearest ? ", \"filter\": \"nearest\"" : "",
            luminance ? "" : space_text(way.space),
            luminance    ? ", \"space\": \"data\", \"channels\": \"luminance\""
            : way.opaque ? ", \"channels\": \"opaque\""
                         : ""));
        return texture;
    };
    if (!fresh_file) {
        const auto [known, fresh] = by_file_.try_emplace({file->second, way});
        if (fresh) known->second = texture_of(plain.stem().string());
        return shared->second = known->second;
    }
    const std::string texture = texture_of(plain.stem().string());
    by_file_[{file->second, way}] = texture;
    return shared->second = texture;
}

Result<std::string> ImportPictures::add_volume(const FieldImage& image) {
    const auto [stack, fresh] = stacks_.try_emplace(image.sheets);
    if (fresh) {
        stack->second = fmt::format("volume_{}", stacks_.size());
        for (size_t i = 0; i < image.sheets.size(); ++i) {
            const auto found = pictures_.find(image.sheets[i]);
            if (found == pictures_.end() || !found->second)
                return user_error(
                    fmt::format(messages::kSheetOfImage, i, image.image,
                                found == pictures_.end()
                                    ? fmt::format(messages::kSheetIsMissing, image.sheets[i])
                                    : ": " + found->second.error().text()));
            files_.push_back({fmt::format("{}/sheet_{:05}.png", stack->second, i), *found->second});
        }
    }
    const auto [known, first] = volumes_.try_emplace({stack->second, image.repeats, image.nearest});
    if (!first) return known->second;
    known->second = names_.unique(stack->second);
    const auto part = [](int64_t n) { return 1 / static_cast<double>(n); };
    lines_.push_back(fmt::format(
        "{}: {{\"file\": \"{}/sheet_*.png\", \"origin_mm\": [0, 0, 0], \"spacing_mm\": [{:.12g}, "
        "{:.12g}, {:.12g}], \"wrap\": \"{}\"{}, \"space\": \"data\"}}",
        json_string(known->second), stack->second, part(image.size[0]), part(image.size[1]),
        part(image.size[2]), image.repeats ? "repeat" : "clamp",
        image.nearest ? ", \"filter\": \"nearest\"" : ""));
    return known->second;
}

Result<std::string> ImportPictures::add_map(const FieldMap& map) {
    const auto found = pictures_.find(map.source);
    if (found == pictures_.end() || !found->second)
        return user_error(fmt::format(
            messages::kDisplacementMap, map.source,
            found == pictures_.end() ? messages::kMapIsMissing
                                     : messages::kMapCannotBeRead + found->second.error().text()));
    const std::filesystem::path plain =
        plain_name(std::filesystem::path(map.source).filename().string());
    const std::string texture = names_.unique(plain.stem().string());
    files_.push_back({texture + plain.extension().string(), *found->second});
    // Beyond an end that is none the fablet does not look.
    std::array<mesh::PictureWrap, 2> wrap = map.wrap;
    for (mesh::PictureWrap& one : wrap)
        one = one == mesh::PictureWrap::kNone ? mesh::PictureWrap::kClamp : one;
    lines_.push_back(fmt::format("{}: {{\"file\": {}{}{}, \"space\": \"data\"}}",
                                 json_string(texture), json_string(files_.back().name),
                                 wrap_text(wrap), map.nearest ? ", \"filter\": \"nearest\"" : ""));
    return texture;
}

std::string ImportPictures::add_file(const std::string& name, const std::string& extension,
                                     SharedBytes bytes) {
    const std::string texture = names_.unique(name);
    lines_.push_back(fmt::format("{}: {{\"file\": {}}}", json_string(texture),
                                 json_string(texture + extension)));
    files_.push_back({texture + extension, std::move(bytes)});
    return texture;
}

}  // namespace openfab::tools
