// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How the converter reads a world's texture.

#include "texture/volume.h"
#include "world/world.h"

namespace openfab::world {

texture::ImageOptions image_options(const Texture& texture);
texture::VolumeOptions volume_options(const Texture& texture);

}  // namespace openfab::world
