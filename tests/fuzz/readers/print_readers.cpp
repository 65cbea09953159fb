// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/readers/print_readers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

#include "backends/ofr/ofr_reader.h"
#include "backends/read/print_file.h"
#include "backends/zarr/layout.h"
#include "backends/zarr/shard_list.h"
#include "backends/zarr/store.h"
#include "tests/fuzz/readers/geometry_readers.h"
#include "tests/fuzz/readers/readers.h"
#include "tests/support/meshes/temp_folder.h"
#include "texture/pyramid.h"
#include "tools/texture/convert_volume.h"

namespace openfab::testing {

const std::filesystem::path& folder() {
    static const testing::TempFolder folder;
    return folder.path();
}

std::string written(const std::string& name, std::string_view bytes) {
    const std::filesystem::path file = folder() / name;
    std::ofstream(file, std::ios::binary) << bytes;
    return file.string();
}

bool open_pyramid(const std::filesystem::path& file) {
    const auto pyramid = texture::Pyramid::open(file, texture::kWrapRepeat, 0);
    if (!answered(pyramid)) return false;
    // What it says it has is there.
    const std::span<const float> texels = (*pyramid)->texels(), bounds = (*pyramid)->minmax();
    const volatile float sum = std::accumulate(texels.begin(), texels.end(), 0.0F) +
                               std::accumulate(bounds.begin(), bounds.end(), 0.0F);
    (void)sum;
    return true;
}

namespace {

/// The viewer's reader, in any order. Returns how many slices it read.
int32_t slices_seen(const std::string& file) {
    auto print = prints::PrintFile::open(file, kReaderBytes);
    if (!answered(print)) return 0;
    prints::SliceBuffers buffers;
    int32_t good = 0;
    const int32_t begin = (*print)->info().slice_begin;
    for (int32_t z = begin + (*print)->whole_slices() - 1; z >= begin; --z)
        good += answered((*print)->read_slice(z, &buffers)) ? 1 : 0;
    return good;
}

}  // namespace

bool ofr(std::string_view bytes) {
    const std::string file = written("a.ofr", bytes);
    const int32_t seen = slices_seen(file);
    (void)answered(ofr::OfrReader::read_totals(file));
    auto reader = ofr::OfrReader::open(file);
    if (!answered(reader)) return false;
    for (;;) {
        const Result<bool> more = (*reader)->next();
        if (!answered(more)) return false;
        if (*more) continue;
        if (seen != (*reader)->whole_slices()) std::abort();
        return true;
    }
}

bool gcvf(std::string_view bytes) {
    return slices_seen(written("a.gcvf", bytes)) > 0;
}

/// A folder of slices, as a print and as a volume: its manifest, and a slice behind it.
bool slices(std::string_view bytes) {
    constexpr std::string_view kBetween = "\n--- slice ---\n";
    const size_t end = std::min(bytes.find(kBetween), bytes.size());
    std::filesystem::create_directories(folder() / "slices");
    written("slices/manifest.json", bytes.substr(0, end));
    const bool any = end < bytes.size();
    const std::string slice =
        written("slices/slice_0001.png", any ? bytes.substr(end + kBetween.size()) : "");
    if (!any) std::filesystem::remove(slice);
    const std::filesystem::path out = folder() / "out.oftx";
    texture::ReadLimits limits;
    limits.memory_bytes = kReaderBytes;
    const bool is_volume = answered(
        tools::make_volume_file(folder() / "slices", out, texture::VolumeOptions{}, limits));
    if (is_volume && !open_pyramid(out)) std::abort();
    return slices_seen((folder() / "slices").string()) > 0 && is_volume;
}

/// A store of Zarr as a volume: the text of its array, of version 2 where it has a `dtype`, and its first chunk or shard.
bool zarr_array(std::string_view bytes) {
    constexpr std::string_view kChunk = "\n--- chunk ---\n";
    const size_t end = std::min(bytes.find(kChunk), bytes.size());
    const std::string_view text = bytes.substr(0, end);
    const std::string_view chunk = bytes.substr(std::min(end + kChunk.size(), bytes.size()));
    const std::filesystem::path store = folder() / "array.zarr";
    std::filesystem::remove_all(store);
    std::filesystem::create_directories(store / "c/0/0");
    written(text.find("\"dtype\"") != std::string_view::npos ? "array.zarr/.zarray"
                                                             : "array.zarr/zarr.json",
            text);
    if (end < bytes.size()) {
        for (const char* name : {"c/0/0/0", "0.0.0", "c.0.0.0"})
            written("array.zarr/" + std::string(name), chunk);
    }
    const std::filesystem::path out = folder() / "out.oftx";
    texture::ReadLimits limits;
    limits.memory_bytes = kReaderBytes;
    if (!answered(tools::make_volume_file(store, out, texture::VolumeOptions{}, limits)))
        return false;
    if (!open_pyramid(out)) std::abort();
    return true;
}

/// A store of Zarr, of one slab: the text of its group, a list of shards, and the shard of the finest level. The list is
/// read; that the shard is the one of the store's own list is made so.
bool zarr_store(std::string_view bytes) {
    constexpr std::string_view kList = "\n--- list ---\n", kShard = "\n--- shard ---\n";
    const size_t list_at = std::min(bytes.find(kList), bytes.size());
    const size_t shard_at = std::min(bytes.find(kShard), bytes.size());
    if (list_at == bytes.size() || shard_at < list_at + kList.size()) return false;
    const std::string group(bytes.substr(0, list_at));
    const std::string_view list =
        bytes.substr(list_at + kList.size(), shard_at - list_at - kList.size());
    const std::string shard(bytes.substr(std::min(shard_at + kShard.size(), bytes.size())));
    const Result<pipeline::PrintInfo> info = zarr::read_group(group, "zarr.json");
    if (!answered(info)) return false;
    const std::vector<zarr::Level> levels = zarr::levels_of(info->size);
    const size_t slab_levels = std::min(levels.size(), zarr::kSlabLevels);
    const std::string identity = zarr::identity_of(group);
    const bool lists = zarr::parse_list(list, identity, slab_levels).has_value();
    const std::filesystem::path store = folder() / "store";
    std::filesystem::remove_all(store);
    std::filesystem::create_directories(store / "openfab");
    std::filesystem::create_directories(store / "0/c/0/0");
    written("store/zarr.json", group);
    written("store/0/c/0/0/0", shard);
    for (size_t level = 0; level < levels.size(); ++level) {
        std::filesystem::create_directories(store / std::to_string(level));
        written(fmt::format("store/{}/zarr.json", level), zarr::array_json(levels[level]));
    }
    const std::span<const uint8_t> raw(reinterpret_cast<const uint8_t*>(shard.data()),
                                       shard.size());
    std::vector<zarr::ShardDigest> digests(slab_levels);
    digests[0] = zarr::digest_of(raw);
    const int32_t end = std::min(zarr::kSlab, info->size.z);
    written("store/" + zarr::list_name(0, end),
            zarr::list_head(identity, 0, end) + zarr::slab_line(0, digests));
    return slices_seen(store.string()) > 0 && lists;
}

}  // namespace openfab::testing
