// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Fetches the pictures of a glTF file, for import.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "mesh/read/gltf.h"
#include "mesh/read/gltf_file.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {

Result<void> read_gltf_pictures(const std::filesystem::path& file,
                                std::span<const std::string> sources, int64_t memory_bytes,
                                const TakePicture& take) {
    constexpr int64_t kLargestFile = 2'000'000'000;
    const Result<std::string> bytes = read_text_file(
        file, static_cast<size_t>(std::clamp<int64_t>(memory_bytes, 0, kLargestFile)));
    if (!bytes) return bytes.error();
    Result<GltfFile> gltf =
        GltfFile::open(*bytes, file.string(), memory_bytes - static_cast<int64_t>(bytes->size()));
    if (!gltf) return gltf.error();
    for (size_t i = 0; i < sources.size(); ++i) {
        const std::string& source = sources[i];
        const char* const end = source.data() + source.size();
        int64_t image = -1;
        const auto [stop, wrong] = std::from_chars(source.data(), end, image);
        if (wrong != std::errc() || stop != end)
            return internal_error(fmt::format(messages::kNoPictureOfGltf, source));
        take(i, gltf->image_at(image));
    }
    return Ok{};
}

}  // namespace openfab::mesh
