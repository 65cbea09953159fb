// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/zarr/whole_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>
#include <vector>

#include "backends/common/output_lock.h"
#include "backends/zarr/messages.h"
#include "backends/zarr/slab.h"
#include "backends/zarr/store_files.h"
#include "base/json_text.h"

namespace openfab::zarr {

namespace {

/// Makes the shards of a level of those of the finer one, whose digests are given; returns their digests.
Result<std::vector<ShardDigest>> make_level(const Store& store, size_t level,
                                            const std::vector<ShardDigest>& finer_digests) {
    const Level& finer = store.levels()[level - 1];
    const Level& of = store.levels()[level];
    std::vector<ShardDigest> digests;
    std::vector<uint8_t> planes, more;
    const auto wanted = static_cast<size_t>(2 * of.depth) * static_cast<size_t>(finer.plane());
    for (int32_t shard = 0; shard < finer.shards(); ++shard) {
        const Result<std::vector<uint8_t>> bytes =
            store.read_shard(level - 1, shard, finer_digests[static_cast<size_t>(shard)]);
        if (!bytes) return bytes.error();
        const int32_t count = store.planes_of(level - 1, shard);
        if (Result<void> read = store.decode(level - 1, shard, *bytes, count, &more); !read)
            return read.error();
        planes.insert(planes.end(), more.begin(), more.end());
        if (planes.size() < wanted && shard + 1 < finer.shards()) continue;
        const Result<std::vector<uint8_t>> made = make_shard(of, halve_planes(finer, planes));
        if (!made) return made.error();
        planes.clear();
        const std::string key = shard_key(level, static_cast<int32_t>(digests.size()));
        digests.push_back(digest_of(*made));
        const Result<void> written = made->empty() ? remove_store_file(store.path() / key)
                                                   : write_store_file(store.path() / key, *made);
        if (!written) return written.error();
    }
    return digests;
}

bool read_coarse(const JsonValue& member, std::map<std::string, ShardDigest>* coarse) {
    for (const JsonMember& shard : member.members) {
        if (shard.value.items.size() != 2) return false;
        ShardDigest digest;
        const std::string& digits = shard.value.items[1].text;
        digest.bytes = static_cast<uint64_t>(shard.value.items[0].whole().value_or(0));
        std::from_chars(digits.data(), digits.data() + digits.size(), digest.digest, 16);
        (*coarse)[shard.key] = digest;
    }
    return true;
}

}  // namespace

std::string manifest_text(const pipeline::PrintInfo& info, const Manifest& manifest) {
    const pipeline::PrintTotals& totals = manifest.totals;
    const double voxel_ml = info.pitch_mm.x * info.pitch_mm.y * info.pitch_mm.z * 1e-3;
    JsonText json(JsonText::Layout::kIndentedLists);
    json.begin_object();
    json.member("complete", true);
    json.member("hash", fmt::format("{:016x}", totals.hash));
    json.member("slices", int64_t{info.size.z});
    json.member("voxels_solid", totals.voxels_solid);
    json.key("tight").begin_list();
    for (const Vec3i& corner : {totals.tight.lo, totals.tight.hi})
        json.value(corner.x).value(corner.y).value(corner.z);
    json.end_array();
    json.key("materials").begin_array();
    for (size_t m = 0; m < info.materials.size(); ++m) {
        const int64_t voxels =
            m + 1 < totals.voxels_by_code.size() ? totals.voxels_by_code[m + 1] : 0;
        const double ml = static_cast<double>(voxels) * voxel_ml;
        json.begin_object();
        json.member("name", info.materials[m].name);
        json.member("voxels", voxels);
        json.key("ml").fraction(ml, 6);
        json.key("g").fraction(ml * info.materials[m].density_g_cm3, 6);
        json.end_object();
    }
    json.end_array();
    json.key("coarse").begin_object();
    for (const auto& [key, digest] : manifest.coarse) {
        json.key(key).begin_list().value(static_cast<int64_t>(digest.bytes));
        json.value(fmt::format("{:x}", digest.digest)).end_array();
    }
    json.end_object();
    json.end_object();
    return json.take() + "\n";
}

Result<std::optional<Manifest>> read_manifest(const Store& store) {
    const std::filesystem::path file = store.path() / kManifestFile;
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) return std::optional<Manifest>();
    const Result<std::string> text = read_text_file(file, kMostJsonBytes);
    if (!text) return text.error();
    const Result<JsonValue> root = parse_json(*text, file.string());
    if (!root) return root.error();
    const JsonValue* const hash = member_of(*root, "hash");
    const JsonValue* const coarse = member_of(*root, "coarse");
    Manifest manifest;
    if (hash == nullptr || coarse == nullptr || !read_coarse(*coarse, &manifest.coarse))
        return user_error(fmt::format(messages::kManifestDamaged, file.string()));
    manifest.totals.complete = true;
    std::from_chars(hash->text.data(), hash->text.data() + hash->text.size(), manifest.totals.hash,
                    16);
    return std::optional(std::move(manifest));
}

Result<void> complete_store(const std::filesystem::path& path) {
    const Result<Store> store = Store::open(path);
    if (!store) return store.error();
    const Result<std::vector<ShardList>> lists = store->lists();
    if (!lists) return lists.error();
    const std::optional<pipeline::PrintTotals> totals = totals_of(*lists, store->info().size.z);
    if (!totals) return {};
    const std::filesystem::path lock_file = path / kOwnFolder / "complete.lock";
    const Result<ListFile> lock = ListFile::open(lock_file);
    if (!lock) return backends::is_locked(lock_file.string()) ? Result<void>() : lock.error();
    const size_t slab_levels = store->slab_levels();
    std::vector<ShardDigest> finer;
    for (const ShardList& list : *lists)
        for (const std::vector<ShardDigest>& slab : list.slabs)
            finer.push_back(slab[slab_levels - 1]);
    Manifest manifest{*totals, {}};
    for (size_t level = slab_levels; level < store->levels().size(); ++level) {
        Result<std::vector<ShardDigest>> made = make_level(*store, level, finer);
        if (!made) return made.error();
        finer = std::move(*made);
        for (size_t shard = 0; shard < finer.size(); ++shard)
            manifest.coarse[shard_key(level, static_cast<int32_t>(shard))] = finer[shard];
    }
    if (Result<void> synced = lock->sync(); !synced) return synced;
    if (Result<void> written =
            write_store_file(path / kManifestFile, manifest_text(store->info(), manifest));
        !written)
        return written;
    return lock->sync();
}

}  // namespace openfab::zarr
