// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/list_textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "base/json_text.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "base/start_program.h"
#include "base/text.h"
#include "client/fablet_compiler.h"
#include "texture/cache.h"
#include "texture/volume.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/programs.h"
#include "world/texture_options.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 12> kPictures{".png", ".jpg", ".jpeg", ".exr",
                                                     ".bmp", ".tga", ".gif",  ".webp",
                                                     ".pgm", ".ppm", ".pnm",  ".pbm"};
constexpr std::array<std::string_view, 23> kVolumes{
    ".tif", ".tiff",   ".nrrd", ".nhdr", ".nii", ".gz",  ".mha", ".mhd",
    ".mrc", ".rec",    ".npy",  ".cube", ".vti", ".vtr", ".vts", ".vtu",
    ".vtk", ".vtkhdf", ".xdmf", ".xmf",  ".dcm", ".ima", ".vdb"};

using Opened = Result<std::shared_ptr<const texture::Pyramid>>;

bool has_extension(const fs::path& file, std::span<const std::string_view> known) {
    const std::string extension = lower_ascii(file.extension().string());
    return std::find(known.begin(), known.end(), extension) != known.end();
}

bool is_volume_file(const fs::path& file) {
    return has_extension(file, kVolumes) || texture::is_medium_list(file) ||
           texture::is_dicom(file);
}

void show_size(const texture::Pyramid& pyramid) {
    const std::span<const int32_t> info = pyramid.info();
    const std::string numbers =
        fmt::format("{} number{}", pyramid.channels(), pyramid.channels() == 1 ? "" : "s");
    if (!pyramid.is_volume()) {
        const int32_t* level = info.data() + texture::kInfoHeader;
        show(fmt::format("  picture    {} x {} texels of {}\n", level[1], level[2], numbers));
        return;
    }
    std::array<float, 6> box;  // the lowest corner, and the size
    std::memcpy(box.data(), info.data() + texture::kInfoHeader, sizeof box);
    const int32_t* level = info.data() + texture::kVolumeInfoHeader;
    show(fmt::format(
        "  volume     {} x {} x {} texels of {}, {:.4g} x {:.4g} x {:.4g} mm, from "
        "{:.4g} {:.4g} {:.4g}\n",
        level[1], level[2], level[3], numbers, box[3], box[4], box[5], box[0], box[1], box[2]));
}

/// The kinds of a source's textures, `texture2d` or `texture3d`, by fablet and uniform.
class UniformKinds {
  public:
    UniformKinds() {
        const Result<fs::path> programs = program_folder();
        Result<std::unique_ptr<TemporaryFolder>> scratch = TemporaryFolder::create();
        if (!programs || !scratch) return;
        scratch_ = std::move(*scratch);
        compiler_.emplace(*programs, scratch_->path());
    }

    /// Empty where the fablet or the uniform is not known: its source may be wrong, which a print says.
    std::string of(const world::FabletRef& fablet, const std::string& uniform) {
        if (!compiler_) return {};
        const auto [known, fresh] = described_.try_emplace(fablet.source);
        if (fresh) {
            if (auto found = compiler_->describe(fablet.source)) known->second = std::move(*found);
        }
        const auto one = known->second.find(fablet.fablet);
        if (one == known->second.end()) return {};
        const JsonValue* uniforms = member_of(one->second, "uniforms");
        for (const JsonValue& each :
             uniforms != nullptr ? uniforms->items : std::vector<JsonValue>()) {
            const JsonValue *name = member_of(each, "name"), *kind = member_of(each, "kind");
            if (name != nullptr && kind != nullptr && name->text == uniform) return kind->text;
        }
        return {};
    }

  private:
    std::unique_ptr<TemporaryFolder> scratch_;
    std::optional<client::FabletCompiler> compiler_;
    std::map<fs::path, std::map<std::string, JsonValue>> described_;
};

/// How fablets look each texture up, by its name.
std::map<std::string, std::string> kinds_of(const world::World& world) {
    std::map<std::string, std::string> out;
    UniformKinds kinds;
    const auto take = [&](const std::string& fablet, const world::UniformBindings& bindings) {
        const auto ref = world.fablets.find(fablet);
        if (ref == world.fablets.end()) return;
        for (const auto& [uniform, binding] : bindings) {
            const auto* names = std::get_if<std::vector<std::string>>(&binding.value);
            if (names == nullptr) continue;
            const std::string kind = kinds.of(ref->second, uniform);
            if (!kind.starts_with("texture")) continue;
            for (const std::string& name : *names)
                out.emplace(name, kind);
        }
    };
    for (const auto& [name, fablet] : world.fablets)
        take(name, fablet.uniforms);
    for (const world::Object& object : world.objects) {
        take(object.fablet, object.uniforms);
        const world::StageRef* stage = world.stage_of(object.mesh);
        if (stage != nullptr) take(stage->fablet, object.uniforms);
    }
    return out;
}

}  // namespace

bool is_texture_file(const fs::path& file) {
    return has_extension(file, kPictures) || is_volume_file(file);
}

bool is_volume_folder(const fs::path& folder) {
    const Result<std::vector<fs::path>> files = texture::volume_files(folder);
    return files && std::any_of(files->begin(), files->end(), is_texture_file);
}

Result<void> list_texture(const fs::path& file, int64_t memory_bytes) {
    const texture::ReadLimits limits{memory_bytes, {}};
    const Opened opened = has_extension(file, kPictures)
                              ? texture::get_pyramid(file, {}, 0, 0, limits)
                              : texture::get_volume(file, {}, 0, 0, limits);
    if (!opened) return opened.error();
    show(fmt::format("texture    {}\n", printable(file.string())));
    show_size(**opened);
    for (const std::string& told : (*opened)->notes())
        note(told);
    return {};
}

void list_textures(const world::World& world, int64_t memory_bytes) {
    if (world.textures.empty()) return;
    const std::map<std::string, std::string> kinds = kinds_of(world);
    const texture::ReadLimits limits{memory_bytes, world.roots};
    for (const world::Texture& texture : world.textures) {
        show(fmt::format("texture    {}: {}\n", printable(texture.name),
                         printable(texture.file.string())));
        const auto kind = kinds.find(texture.name);
        const bool volume =
            kind != kinds.end() ? kind->second == "texture3d" : !texture.of_volume.empty();
        if (kind == kinds.end() && !volume) continue;  // nothing looks it up
        const Opened opened =
            volume
                ? texture::get_volume(texture.file, world::volume_options(texture), 0, 0, limits)
                : texture::get_pyramid(texture.file, world::image_options(texture), 0, 0, limits);
        if (opened) show_size(**opened);
        for (const std::string& told :
             opened ? (*opened)->notes() : std::vector{opened.error().text()})
            warn(fmt::format(messages::kOfTexture, texture.name, told));
    }
}

}  // namespace openfab::tools
