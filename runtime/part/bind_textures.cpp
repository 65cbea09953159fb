// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/part/bind_textures.h"

#include <fmt/format.h>

#include "base/units.h"
#include "runtime/part/messages.h"
#include "texture/cache.h"
#include "texture/volume.h"
#include "world/texture_options.h"

namespace openfab::part {

int64_t mapped_bytes(const texture::Pyramid& pyramid) {
    return static_cast<int64_t>(pyramid.texels().size_bytes() + pyramid.minmax().size_bytes());
}

Result<std::vector<std::shared_ptr<const texture::Pyramid>>> TextureBinder::open(
    const BoundUniforms& uniforms) {
    std::vector<std::shared_ptr<const texture::Pyramid>> out;
    for (size_t i = 0; i < uniforms.textures.size(); ++i) {
        Result<std::shared_ptr<const texture::Pyramid>> pyramid =
            open_one(uniforms.textures[i], uniforms.texture_is_volume[i]);
        if (!pyramid) return pyramid.error();
        out.push_back(std::move(*pyramid));
    }
    return out;
}

Result<std::shared_ptr<const texture::Pyramid>> TextureBinder::open_one(int32_t index,
                                                                        bool volume) {
    auto& known = opened_[{index, volume}];
    if (known != nullptr) return known;
    const world::Texture& texture = world_.textures[index];
    const texture::WrapModes wrap(static_cast<int32_t>(texture.wrap),
                                  static_cast<int32_t>(texture.wrap_v));
    if (volume && wrap.u != wrap.v) {
        Error error =
            user_error(fmt::format(messages::kVolumeWrap, texture.name), messages::kVolumeWrapHelp);
        error.location = texture.location;
        return error;
    }
    if (!volume && !texture.of_volume.empty()) {
        const auto& [key, location] = texture.of_volume.front();
        return error_at(location, fmt::format(messages::kKeyOfVolume, key, texture.name),
                        messages::kKeyOfVolumeHelp);
    }
    const auto filter = static_cast<int32_t>(texture.filter);
    const texture::ReadLimits limits{memory_bytes_, world_.roots};
    Result<std::shared_ptr<const texture::Pyramid>> pyramid =
        volume ? texture::get_volume(texture.file, world::volume_options(texture), wrap, filter,
                                     limits)
               : texture::get_pyramid(texture.file, world::image_options(texture), wrap, filter,
                                      limits);
    if (!pyramid) {
        Error error =
            with_context(pyramid.error(), fmt::format(messages::kTextureBefore, texture.name));
        error.location = texture.location;
        return error;
    }
    if (Result<void> fits = take(texture, mapped_bytes(**pyramid)); !fits) return fits.error();
    for (const std::string& told : (*pyramid)->notes())
        notes_.push_back(fmt::format(messages::kTextureBefore, texture.name) + told);
    known = *pyramid;
    return known;
}

Result<void> TextureBinder::take(const world::Texture& texture, int64_t bytes) {
    bytes_ += bytes;
    if (largest_ == nullptr || bytes > largest_bytes_) {
        largest_ = &texture;
        largest_bytes_ = bytes;
    }
    if (bytes_ <= memory_bytes_) return Ok{};
    return error_at(texture.location,
                    fmt::format(messages::kTexturesTakeMemory, texture.name, format_bytes(bytes_),
                                format_bytes(memory_bytes_)),
                    fmt::format(messages::kTexturesTakeMemoryHelp, largest_->name,
                                format_bytes(largest_bytes_)));
}

}  // namespace openfab::part
