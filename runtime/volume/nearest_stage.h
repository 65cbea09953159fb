// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The runtime's side of the extern stage `nearest` (abi/nearest_stage.h): answers what the voxels of
// a batch read of their nearest surface points. One for each thread that calls kernels; a kernel's
// own threads call it at once, each with tools of its own.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "abi/nearest_stage.h"
#include "base/pool.h"
#include "runtime/volume/piece_cull.h"
#include "runtime/volume/placed_part.h"

namespace openfab::volume {

class NearestStage : private openfab_nearest_source {
  public:
    /// What one call of a kernel is about; it must outlive the call.
    struct Batch {
        const PlacedPart* part = nullptr;
        std::span<const Vec3i> blocks;        ///< lowest voxels
        std::span<const uint8_t> owned;       ///< 64 bytes a block: voxels that may query
        std::span<const int32_t> columns;     ///< that the call lists, 64 block + column, rising
        std::span<const CulledBlock> culled;  ///< for each block, or none at all
    };

    explicit NearestStage(size_t parts) : openfab_nearest_source{answer_request}, parts_(parts) {}

    void begin(const Batch& batch) { batch_ = batch; }
    openfab_nearest_source* source() { return this; }

    /// Returns scratch memory for other queries, between calls.
    nearest::Engine::Scratch* scratch(const PlacedPart& part);
    /// Return what was asked and how long it took, over all parts and threads.
    nearest::QueryCounts query_counts() const;
    double seconds() const;

  private:
    /// What one thread needs.
    struct Tools {
        explicit Tools(size_t parts) : scratch(parts) {}
        solid::Scratch* scratch_of(const PlacedPart& part);

        std::vector<std::unique_ptr<solid::Scratch>> scratch;  ///< by PlacedPart::owner
        std::vector<uint8_t> active;                           ///< 64 bytes a block of the request
        std::vector<Vec3i> asking;                             ///< blocks with an active voxel
        nearest::BlockAnswer answer;
        /// Results of one block, [component][512], and where the reader writes them; null where no
        /// field is read from there.
        std::vector<float> values, gradients;
        std::vector<uint32_t> flat;
        std::vector<float*> value_targets, gradient_targets;
        std::vector<uint32_t*> flat_targets;
        alignas(32) float distance[nearest::kBlockVoxels];
        std::vector<const float*> fields;  ///< of one block, in the order of the fablet's
        const PlacedPart* prepared = nullptr;
        double seconds = 0;
    };

    static int answer_request(openfab_nearest_source* source,
                              const openfab_nearest_request* request);
    void answer(const openfab_nearest_request& request, Tools* tools) const;
    static void prepare(const PlacedPart& part, Tools* tools);
    void find_active(std::span<const int32_t> columns, const openfab_nearest_request& request,
                     Tools* tools) const;
    void query(size_t block, const uint8_t* active, Tools* tools) const;
    void fill_culled(size_t block, Tools* tools) const;
    void fill_attributes(size_t block, bool answered, Tools* tools) const;

    Batch batch_;
    size_t parts_;
    Pool<Tools> tools_;
};

}  // namespace openfab::volume
