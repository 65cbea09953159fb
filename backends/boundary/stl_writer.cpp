// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <system_error>
#include <utility>

#include "backends/boundary/mesh_sink.h"
#include "backends/boundary/messages.h"
#include "backends/boundary/stl_facet.h"
#include "backends/common/part_file.h"
#include "base/hash.h"
#include "base/text.h"

namespace openfab::boundary {

namespace {

constexpr int64_t kMostTriangles = UINT32_MAX;

/// A number that the files of a print share, and those of another do not.
uint64_t number_of(const pipeline::PrintInfo& info, const pipeline::PrintTotals& totals) {
    Hasher hash;
    const auto add = [&](const auto& value) { hash.add_bytes(&value, sizeof value); };
    add(totals.hash);
    for (int a = 0; a < 3; ++a) {
        add(info.pitch_mm[a]);
        add(info.origin_mm[a]);
        add(info.size[a]);
    }
    add(info.slice_begin);
    add(info.slice_end);
    for (const auto& [name, value] : info.provenance) {
        for (const std::string& text : {name, value}) {
            add(text.size());
            hash.add_bytes(text.data(), text.size());
        }
    }
    return hash.value();
}

class StlWriter final : public MeshWriter {
  public:
    explicit StlWriter(std::filesystem::path path) : path_(std::move(path)) {}

    Result<void> begin(const pipeline::PrintInfo& info) override {
        info_ = info;
        coordinates_ = Coordinates(info);
        std::error_code ignored;
        if (std::filesystem::is_directory(path_, ignored)) {
            return user_error(fmt::format(messages::kOutputIsFolder, path_.string(),
                                          (path_ / "part.stl").string()));
        }
        files_.resize(info.materials.size());
        return {};
    }

    bool identifies_by_position() const override { return true; }

    Result<void> take_vertices(uint8_t, std::span<const Vec3i>) override { return {}; }

    Result<void> take_triangles(uint8_t code, std::span<const MeshTriangle> triangles) override {
        File& file = files_[code - 1u];
        if (file.part == nullptr) {
            if (Result<void> opened = open(code - 1u); !opened) return opened;
        }
        file.triangles += static_cast<int64_t>(triangles.size());
        if (file.triangles > kMostTriangles) {
            return user_error(fmt::format(messages::kTooManyTriangles, file.part->path().string(),
                                          kMostTriangles));
        }
        facets_.resize(triangles.size() * kStlFacetBytes);
        uint8_t* at = facets_.data();
        for (const MeshTriangle& t : triangles) {
            put_stl_facet({coordinates_.at(t[0]), coordinates_.at(t[1]), coordinates_.at(t[2])},
                          at);
            at += kStlFacetBytes;
        }
        file.hash.add_bytes(facets_.data(), facets_.size());
        return file.part->write(facets_);
    }

    Result<void> end(const pipeline::PrintTotals& totals) override {
        for (File& file : files_) {
            if (file.part == nullptr) continue;
            Result<backends::OutputFile*> out = file.part->flushed();
            if (!out) return out.error();
            std::array header = stl_header(title_of(static_cast<size_t>(&file - files_.data())),
                                           static_cast<uint32_t>(file.triangles));
            put_stl_marks({file.hash.value(), number_of(info_, totals)}, &header);
            if (Result<void> put = (*out)->overwrite(0, header); !put) return put;
            if (Result<void> synced = file.part->sync(); !synced) return synced;
        }
        const bool any = std::any_of(files_.begin(), files_.end(),
                                     [](const File& file) { return file.part != nullptr; });
        if (!any) return user_error(messages::kNothingPrinted);
        // Those of an earlier print go first, and are gone on the disk, too: a power failure leaves no files of two
        // prints, and none of a material that this one lacks.
        bool removed = false;
        for (size_t m = 0; m < files_.size(); ++m) {
            std::error_code ignored;
            removed |= std::filesystem::remove(stl_path(path_, info_, m), ignored);
        }
        if (removed) backends::sync_folder(path_.parent_path());
        for (File& file : files_) {
            if (file.part == nullptr) continue;
            if (Result<void> kept = file.part->keep(); !kept) return kept;
        }
        return {};
    }

  private:
    struct File {
        std::unique_ptr<backends::PartFile> part;
        int64_t triangles = 0;
        Hasher hash;  ///< of the facets
    };

    std::string title_of(size_t material) const {
        const std::string& name = info_.materials[material].name;
        if (info_.slice_begin == 0 && info_.slice_end == info_.size.z)
            return fmt::format("STL in mm, material {}", name);
        return fmt::format("STL in mm, slices {}:{} of {}, {}", info_.slice_begin, info_.slice_end,
                           info_.size.z, name);
    }

    Result<void> open(size_t material) {
        Result<std::unique_ptr<backends::PartFile>> part =
            backends::PartFile::create(stl_path(path_, info_, material));
        if (!part) return part.error();
        files_[material].part = std::move(*part);
        return files_[material].part->write(stl_header(title_of(material), 0));
    }

    std::filesystem::path path_;
    pipeline::PrintInfo info_;
    Coordinates coordinates_;
    std::vector<File> files_;  ///< by material
    std::vector<uint8_t> facets_;
};

}  // namespace

std::unique_ptr<MeshWriter> make_stl_writer(const std::filesystem::path& path) {
    return std::make_unique<StlWriter>(path);
}

std::filesystem::path stl_path(const std::filesystem::path& path, const pipeline::PrintInfo& info,
                               size_t material) {
    const std::string name = safe_file_name(info.materials[material].name);
    // Names that are equal now, on case-insensitive file systems, are numbered.
    bool taken = false;
    for (size_t m = 0; m < info.materials.size() && !taken; ++m)
        taken = m != material &&
                lower_ascii(safe_file_name(info.materials[m].name)) == lower_ascii(name);
    const std::string suffix = taken ? fmt::format("{}_{}", name, material + 1) : name;
    return path.parent_path() /
           fmt::format("{}_{}{}", path.stem().string(), suffix,
                       path.has_extension() ? path.extension().string() : ".stl");
}

}  // namespace openfab::boundary
