// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/load/pictures.h"

#include "base/text.h"
#include "mesh/load/jailed.h"
#include "mesh/read/gltf.h"
#include "mesh/read/obj.h"
#include "mesh/read/ply.h"
#include "mesh/read/threemf.h"

namespace openfab::mesh {

Result<void> read_pictures(const std::filesystem::path& file, std::span<const std::string> sources,
                           int64_t memory_bytes, const TakePicture& take) {
    if (sources.empty()) return {};
    using Read = Result<void> (*)(const std::filesystem::path&, std::span<const std::string>,
                                  int64_t, const TakePicture&);
    struct Format {
        const char* extension;
        Read read;
    };
    constexpr Format kFormats[] = {{".obj", read_obj_pictures},
                                   {".ply", read_ply_pictures},
                                   {".gltf", read_gltf_pictures},
                                   {".glb", read_gltf_pictures},
                                   {".3mf", read_threemf_pictures}};
    const std::string extension = lower_ascii(file.extension().string());
    for (const Format& format : kFormats) {
        if (extension != format.extension) continue;
        return pictures_from_jail(file, memory_bytes, sources.size(), take,
                                  [&](const TakePicture& taken) {
                                      return format.read(file, sources, memory_bytes, taken);
                                  });
    }
    return {};
}

}  // namespace openfab::mesh
