// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The textures of a world's parts.

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/part/uniforms.h"
#include "texture/pyramid.h"
#include "world/world.h"

namespace openfab::part {

/// Returns the memory of a texture once it is fully resident.
int64_t mapped_bytes(const texture::Pyramid& pyramid);

class TextureBinder {
  public:
    /// All textures together, and the making of each, may take `memory_bytes`.
    TextureBinder(const world::World& world, int64_t memory_bytes)
        : world_(world), memory_bytes_(memory_bytes) {}

    /// What is told of the opened textures, a line each.
    const std::vector<std::string>& notes() const { return notes_; }
    /// Returns the textures that uniforms name, each opened once.
    Result<std::vector<std::shared_ptr<const texture::Pyramid>>> open(
        const BoundUniforms& uniforms);

  private:
    Result<std::shared_ptr<const texture::Pyramid>> open_one(int32_t index, bool volume);
    /// Before the next one is made: all of them stay mapped during the print.
    Result<void> take(const world::Texture& texture, int64_t bytes);

    const world::World& world_;
    const int64_t memory_bytes_;
    int64_t bytes_ = 0;  ///< of all opened textures
    const world::Texture* largest_ = nullptr;
    int64_t largest_bytes_ = 0;
    std::map<std::pair<int32_t, bool>, std::shared_ptr<const texture::Pyramid>> opened_;
    std::vector<std::string> notes_;
};

}  // namespace openfab::part
