// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/texture_options.h"

namespace openfab::world {

texture::ImageOptions image_options(const Texture& texture) {
    static constexpr const char* kSpaces[] = {"auto", "srgb", "linear", "data"};
    return {kSpaces[static_cast<size_t>(texture.space)], texture.luminance, texture.opaque};
}

texture::VolumeOptions volume_options(const Texture& texture) {
    return {image_options(texture), texture.origin_mm, texture.spacing_mm, texture.field,
            texture.unit,           texture.pitch_mm,  texture.outside,    texture.time,
            texture.segment,        texture.echo,      texture.detector,   texture.energy_window,
            texture.phase};
}

}  // namespace openfab::world
