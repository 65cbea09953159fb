// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a part's elements come from: a world, printed as mixtures or codes, and what its materials are like.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mechanics/command/options.h"
#include "mechanics/model/print_world.h"
#include "mechanics/part/surface.h"
#include "mechanics/stand/contact.h"

namespace openfab::mechanics {

struct PartInput {
    Voxels voxels;
    std::vector<Material> materials;
    std::vector<ObjectVoxels> objects;  ///< that the case names
    std::vector<std::string> doubts;    ///< of the materials' numbers
};

class PartSource {
  public:
    /// `options` outlive it; `folder` is scratch.
    static Result<PartSource> open(const CommonOptions& options,
                                   const std::filesystem::path& folder);
    /// `--voxel`; of codes the printer's voxels, else a 96th of the longest side.
    Result<Vec3> pitch_mm() const;
    /// `bytes`: what is needed of a grid, checked before anything is read.
    Result<PartInput> read(const Vec3& pitch_mm, const std::vector<std::string>& objects,
                           const std::function<int64_t(const Grid&)>& bytes) const;
    Result<PartInput> read(const Vec3& pitch_mm, const LoadCase& load_case,
                           const std::function<int64_t(const Grid&)>& bytes) const {
        return read(pitch_mm, load_case.objects(), bytes);
    }
    /// The same at half the pitch: printed at that; or, as dithered, each voxel in eight elements, for a
    /// finer print is another one.
    Result<PartInput> read_halved(const Vec3& pitch_mm, const LoadCase& load_case,
                                  const std::function<int64_t(const Grid&)>& bytes) const;
    /// What the part stands on, finer than elements of `pitch_mm`, of a part up to `height_mm` above where its
    /// elements begin.
    Result<FootLayers> read_foot(const Vec3& pitch_mm, double height_mm) const;
    /// Of a case with gravity: whether all densities are known.
    Result<void> check_gravity(const PartInput& input, const LoadCase& load_case) const;
    /// Voxels come with what conducts such flows as their conductivity.
    void conduct(CaseKind kind) { conducts_ = kind; }
    /// Voxels come with the share of each material.
    void keep_shares() { keeps_shares_ = true; }
    /// A texture of the world is another volume from now on.
    void set_field(FieldTexture field) { field_ = std::move(field); }
    const Properties& properties() const { return properties_; }
    /// How elements are as stiff as they are, in words.
    std::string law() const;

  private:
    PartSource(const CommonOptions& options, std::filesystem::path folder, Properties properties)
        : o_(options), folder_(std::move(folder)), properties_(std::move(properties)) {}
    Result<PrintRequest> request(const Vec3& pitch_mm) const;
    /// Whether what is built fits in memory at a pitch, before it is printed.
    Result<void> check_size(const Vec3& pitch_mm,
                            const std::function<int64_t(const Grid&)>& bytes) const;
    Result<BuildSize> size() const;
    Result<std::vector<Material>> materials_of(const VoxelFile& file) const;
    Result<ObjectVoxels> object(const std::string& name, const PrintRequest& request) const;

    const CommonOptions& o_;
    std::filesystem::path folder_;
    Properties properties_;
    bool keeps_shares_ = false;
    CaseKind conducts_ = CaseKind::kForces;
    std::optional<FieldTexture> field_;
    mutable std::optional<BuildSize> size_;  ///< where it was asked for
};

}  // namespace openfab::mechanics
