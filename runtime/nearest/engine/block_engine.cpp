// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The block-coherent engine: trees, the cache of diced patches, scratch. The inner loops are in
// kernel/.

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <memory>

#include "base/check.h"
#include "runtime/nearest/cache_period.h"
#include "runtime/nearest/engine.h"
#include "runtime/nearest/engine/patch_cache.h"
#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/tree/patch_units.h"
#include "runtime/nearest/tree/treelets.h"
#include "runtime/nearest/voxel_center.h"
#include "runtime/surface/crowding.h"
#include "simd/isa.h"

namespace openfab::nearest {

template <typename T>
void ScratchVector<T>::grow() {
    const size_t larger = capacity == 0 ? 256 : capacity * 2;
    // Not realloc: it would lose the alignment of Lanes.
    T* moved = static_cast<T*>(std::aligned_alloc(64, larger * sizeof(T)));
    OPENFAB_CHECK(moved != nullptr);
    std::copy(data, data + capacity, moved);
    std::free(data);
    data = moved;
    capacity = larger;
}
template struct ScratchVector<NodeRef>;
template struct ScratchVector<Lanes>;
template struct ScratchVector<float>;
template struct ScratchVector<FeatureAnswer>;
template struct ScratchVector<LeafLanes>;
template struct ScratchVector<NearLeaf>;
template struct ScratchVector<const float*>;
template struct ScratchVector<const TriangleDetail*>;
template struct ScratchVector<uint32_t>;
template struct ScratchVector<uint8_t>;

namespace {

/// Finds the axis along which one bit of a part's number moves its origin; there is only one, as
/// sizes are powers of two.
void find_half(const int32_t* origin, int32_t* axis, float* half) {
    for (int a = 0; a < 3; ++a) {
        if (origin[a] == 0) continue;
        *axis = a;
        *half = 0.5f * static_cast<float>(origin[a]);
    }
}

}  // namespace

BlockShape make_block_shape(const Vec3f& pitch_mm) {
    BlockShape shape{};
    int32_t size[3] = {8, 8, 8};
    const auto halve_longest = [&] {
        int longest = -1;
        for (int a = 0; a < 3; ++a) {
            if (size[a] == 1) continue;
            if (longest < 0 || static_cast<float>(size[a]) * pitch_mm[a] >
                                   static_cast<float>(size[longest]) * pitch_mm[longest]) {
                longest = a;
            }
        }
        size[longest] /= 2;
    };
    const auto origins = [](const int32_t* outer, const int32_t* inner, int32_t(*out)[3]) {
        int n = 0;
        for (int32_t y = 0; y < outer[1]; y += inner[1]) {
            for (int32_t x = 0; x < outer[0]; x += inner[0]) {
                for (int32_t z = 0; z < outer[2]; z += inner[2], ++n) {
                    out[n][0] = x;
                    out[n][1] = y;
                    out[n][2] = z;
                }
            }
        }
    };
    const int32_t block[3] = {8, 8, 8};
    for (int i = 0; i < 3; ++i)
        halve_longest();
    std::copy(size, size + 3, shape.sub_size);
    origins(block, size, shape.sub_origin);
    for (int k = 0; k < 3; ++k) {
        find_half(shape.sub_origin[1 << k], &shape.sub_axis[k], &shape.sub_half[k]);
        shape.sub_reach[k] = 0.5f * static_cast<float>(size[k] - 1);
    }
    for (int i = 0; i < 3; ++i)
        halve_longest();
    std::copy(size, size + 3, shape.packet_size);
    int32_t packets[8][3], lanes[8][3];
    origins(shape.sub_size, size, packets);
    for (int k = 0; k < 2; ++k)
        find_half(packets[2 << k], &shape.quarter_axis[k], &shape.quarter_half[k]);
    for (int a = 0; a < 3; ++a)
        shape.quarter_reach[a] = 0.5f * static_cast<float>(packets[1][a] + size[a] - 1);
    const int32_t one[3] = {1, 1, 1};
    origins(size, one, lanes);
    for (int l = 0; l < 8; ++l) {
        for (int a = 0; a < 3; ++a)
            shape.lane_offset[a][l] = static_cast<float>(lanes[l][a]);
    }
    for (int p = 0; p < 64; ++p) {
        for (int a = 0; a < 3; ++a)
            shape.packet_origin[p][a] = shape.sub_origin[p / 8][a] + packets[p % 8][a];
        for (int l = 0; l < 8; ++l) {
            const int32_t* o = shape.packet_origin[p];
            shape.voxel[p * 8 + l] = static_cast<int16_t>(
                ((o[1] + lanes[l][1]) * 8 + o[0] + lanes[l][0]) * 8 + o[2] + lanes[l][2]);
        }
    }
    for (int c = 0; c < 8; ++c) {
        for (int sub = 0; sub < 8; ++sub) {
            float d2 = 0;
            for (int a = 0; a < 3; ++a) {
                const auto low = static_cast<float>(shape.sub_origin[sub][a]) + 0.5f;
                const float high = low + static_cast<float>(shape.sub_size[a] - 1);
                const float far = ((c >> a & 1) != 0 ? 8 - low : high) * pitch_mm[a];
                d2 += far * far;
            }
            shape.farthest[c][sub] = std::sqrt(d2);
        }
    }
    shape.half_diagonal = 4 * length(pitch_mm);
    return shape;
}

namespace {

uint64_t next_serial() {
    static std::atomic<uint64_t> serial{0};
    return ++serial;
}

const KernelTable& best_kernels(simd::Isa widest) {
    if constexpr (simd::kWiderSets) {
        switch (simd::best_isa(widest)) {
            case simd::Isa::kAvx512:
                return avx512::kKernels;
            case simd::Isa::kAvx2Fma:
                return avx2_fma::kKernels;
            case simd::Isa::kAvx2:
            case simd::Isa::kSse41:
                break;
        }
    }
    return sse41::kKernels;
}

}  // namespace

/// The shared part of block engines: trees and the patch cache.
class BlockIndex {
  public:
    BlockIndex(const surface::Surface& surface, const BlockEngineOptions& options,
               std::span<const uint64_t> morton)
        : kernels_(best_kernels(options.widest)),
          surface_(surface),
          cache_(options.cache != nullptr ? options.cache : make_patch_cache(options.cache_bytes)),
          surface_id_(cache_->new_surface_id()),
          treelets_(surface, morton),
          boxes_(surface.patches().size()) {
        crowded_ = surface::crowding(surface.patches()) > surface::kCrowded;
        for (const InputPatch& box : treelets_.boxes())
            diced_patches_ += treelets_.has(box.patch) ? 0 : 1;
        units_ = std::make_unique<PatchUnits>(surface, &treelets_.boxes());
        root_ = build_tree(treelets_.triangles(), treelets_.boxes());
        ranges_ =
            std::make_unique<const NodeRanges>(root_, surface.ranges(), &treelets_, units_.get());
        treelets_.release_input();
        units_->release_input();
    }

    const KernelTable& kernels() const { return kernels_; }
    const Tree& root() const { return root_; }
    const NodeRanges& ranges() const { return *ranges_; }
    /// Returns whether there are more diced patches than treelets.
    bool mostly_diced() const { return diced_patches_ > treelets_.count(); }
    size_t estimated_bytes(size_t vertices) const {
        return treelets_.estimated_bytes(vertices) + diced_patches_ * (sizeof(Node) + 1);
    }
    TreeSources sources() const {
        const auto first = static_cast<size_t>(treelets_.first_id()) + treelets_.count();
        return {cache_.get(),
                &surface_,
                surface_id_,
                &treelets_,
                units_.get(),
                &boxes_,
                PieceIds::from(first, surface_.patches().size()),
                crowded_};
    }

  private:
    const KernelTable& kernels_;
    const surface::Surface& surface_;
    const std::shared_ptr<PatchCache> cache_;
    const int32_t surface_id_;
    LazyTreelets treelets_;
    std::unique_ptr<PatchUnits> units_;
    mutable PatchBoxes boxes_;
    size_t diced_patches_ = 0;  ///< patches that may get a cached box
    bool crowded_ = false;      ///< surface/crowding.h
    Tree root_;
    std::unique_ptr<const NodeRanges> ranges_;
};

namespace {

class BlockScratch final : public Engine::Scratch {
  public:
    BlockScratch() {
        if (corners_ == nullptr) throw std::bad_alloc();
        kernel.corner_cache = corners_.get();
        kernel.counts = &counts;
    }
    KernelScratch kernel;
    PatchPins pins;
    /// Empties the cache of block corners.
    void forget_corners() {
        std::fill_n(corners_.get(), kCornerEntries, CornerEntry{});
        kernel.warm.count = 0;
    }

  private:
    struct Free {
        void operator()(CornerEntry* entries) const { std::free(entries); }
    };
    // Zeroed by calloc: small parts touch few of its pages.
    std::unique_ptr<CornerEntry, Free> corners_{
        static_cast<CornerEntry*>(std::calloc(kCornerEntries, sizeof(CornerEntry)))};
};

/// Packets whose patches are pinned together: enough to amortize a call.
constexpr size_t kPacketsAtOnce = 16;
/// Packets between two looks at whether the print is to stop.
constexpr size_t kPacketsBetweenLooks = 4 * kPacketsAtOnce;

class BlockEngine final : public Engine {
  public:
    BlockEngine(std::shared_ptr<const BlockIndex> index,
                const std::array<float, OPENFAB_FRAME_COUNT>& frame)
        : index_(std::move(index)), kernels_(index_->kernels()), frame_(frame) {
        Vec3f pitch;
        for (int a = 0; a < 3; ++a)
            pitch[a] = length(Vec3f{frame_[a * 3], frame_[a * 3 + 1], frame_[a * 3 + 2]});
        shape_ = make_block_shape(pitch);
        for (size_t q = 0; q < pieces_.lowest.size(); ++q) {
            const int32_t* origin = shape_.packet_origin[2 * q];
            pieces_.lowest[q] = {origin[0], origin[1], origin[2]};
        }
        for (int a = 0; a < 3; ++a)
            pieces_.size[a] = static_cast<int32_t>(2 * shape_.quarter_reach[a]) + 1;
        const Tree& root = index_->root();
        if (!root.nodes.empty()) input_.root = root.view();
        input_.root.ranges = &index_->ranges();
        input_.traverse_per_packet = index_->mostly_diced();
        input_.frame = frame_.data();
        input_.shape = &shape_;
        input_.largest_coordinate = root.largest_coordinate;
        input_.engine = next_serial();
    }

    std::unique_ptr<Scratch> make_scratch() const override {
        return std::make_unique<BlockScratch>();
    }

    void prepare(std::span<const Vec3i> blocks, Scratch* scratch) const override {
        const auto run = [&](size_t first, size_t n, KernelScratch* kernel) {
            kernels_.prepare(input_, &blocks[first], n, kernel);
        };
        in_parts(blocks.size(), blocks.size(), scratch, run);
    }

    void query(const BlockQuery& query, Scratch* scratch, BlockAnswer* answer) const override {
        auto& s = static_cast<BlockScratch&>(*scratch);
        const auto run = [&](KernelScratch* kernel) {
            kernels_.query(input_, query, kernel, answer);
        };
        if (!hold(&s, false, run)) query_columns(query, &s, answer);
    }

    void query_points(std::span<const PointPacket> packets, float radius_mm, Scratch* scratch,
                      PointAnswer* answers) const override {
        for (const PointPacket& g : packets)
            scratch->counts.queried += std::popcount(g.mask & 0xffu);
        for (size_t first = 0; first < packets.size(); first += kPacketsBetweenLooks) {
            if (scratch->stopped()) return;
            const size_t n = std::min(kPacketsBetweenLooks, packets.size() - first);
            search_points(packets.subspan(first, n), radius_mm, scratch, answers + first);
        }
    }

    void bound_points(std::span<const PointPacket> packets, std::span<const PointPacket> hints,
                      float tolerance_mm, Scratch* scratch, PointBounds* bounds) const override {
        scratch->counts.queried += static_cast<int64_t>(8 * packets.size());
        const auto run = [&](size_t first, size_t n, KernelScratch* kernel) {
            kernels_.bound_points(input_, &packets[first], hints.empty() ? nullptr : &hints[first],
                                  n, tolerance_mm, kernel, bounds + first);
        };
        in_parts(packets.size(), kPacketsAtOnce, scratch, run);
    }

    const BlockPieces& pieces() const override { return pieces_; }

    void bound_blocks(std::span<const Vec3i> blocks, Scratch* scratch,
                      BlockBounds* bounds) const override {
        const auto run = [&](size_t first, size_t n, KernelScratch* kernel) {
            kernels_.bound_blocks(input_, &blocks[first], n, kernel, bounds + first);
        };
        in_parts(blocks.size(), blocks.size(), scratch, run);
    }

    void bounds(const Vec3i& lowest, int32_t size, Scratch* scratch,
                BoxBounds* out) const override {
        auto& s = static_cast<BlockScratch&>(*scratch);
        // Dices no patch.
        hold(&s, true, [&](KernelScratch* kernel) {
            out->clear();
            out->distance_hi = kernels_.bound_cube(input_, lowest, size, kernel);
            for (size_t i = 0; i < kernel->frontier.size; ++i)
                add_case(kernel->frontier.data[i], kernel->frontier_least.data[i], out);
        });
    }

  private:
    /// Runs a kernel call that may pin patches. Returns false if it needs more than may be pinned
    /// at once and not `all` are to be pinned: then its results are invalid and the cached corners
    /// are dropped.
    template <typename Run>
    bool hold(BlockScratch* s, bool all, const Run& run) const {
        const TreeSources sources = index_->sources();
        s->pins.begin(sources, all);
        s->kernel.patches = {&PatchPins::fetch, &s->pins, sources.boxes->pages(),
                             sources.treelets->first_id()};
        run(&s->kernel);
        if (s->pins.end()) return true;
        s->forget_corners();
        return false;
    }

    /// Calls run(first, count, kernel scratch) over [0, size), `at_once` items at a time, or one by
    /// one where these would pin too many patches.
    template <typename Run>
    void in_parts(size_t size, size_t at_once, Scratch* scratch, const Run& run) const {
        auto& s = static_cast<BlockScratch&>(*scratch);
        for (size_t first = 0; first < size; first += at_once) {
            const size_t n = std::min(at_once, size - first);
            if (hold(&s, n == 1, [&](KernelScratch* kernel) { run(first, n, kernel); })) continue;
            for (size_t i = first; i < first + n; ++i)
                hold(&s, true, [&](KernelScratch* kernel) { run(i, 1, kernel); });
        }
    }

    /// Queries packets a few at a time, to pin few patches: all packets of a call together may need
    /// most of a surface.
    void search_points(std::span<const PointPacket> packets, float radius_mm, Scratch* scratch,
                       PointAnswer* answers) const {
        const auto run = [&](size_t first, size_t n, KernelScratch* kernel) {
            kernels_.query_points(input_, &packets[first], n, radius_mm, kernel, answers + first);
        };
        in_parts(packets.size(), kPacketsAtOnce, scratch, run);
    }

    /// Queries the columns of a block as packets of points: fewer patches are near a column than
    /// near a block.
    void query_columns(const BlockQuery& query, BlockScratch* s, BlockAnswer* answer) const {
        std::array<PointPacket, 64> packets;
        std::array<PointAnswer, 64> answers;
        for (size_t c = 0; c < packets.size(); ++c) {
            PointPacket& packet = packets[c];
            const auto column = static_cast<int32_t>(c);
            for (int32_t z = 0; z < 8; ++z) {
                const Vec3f p = voxel_center(
                    frame_,
                    {query.block.x + column % 8, query.block.y + column / 8, query.block.z + z});
                for (int a = 0; a < 3; ++a)
                    packet.p[a][z] = p[a];
            }
            packet.mask = query.active == nullptr ? 0xffu : query.active[c];
        }
        search_points(packets, query.radius_mm, s, answers.data());
        for (size_t c = 0; c < packets.size(); ++c) {
            for (size_t z = 0; z < 8; ++z) {
                const size_t v = 8 * c + z;
                answer->distance2[v] = answers[c].distance2[z];
                answer->item[v] = answers[c].item[z];
                answer->in_patch.triangle[v] =
                    answers[c].item[z] < 0 ? -1 : answers[c].in_patch.triangle[z];
                answer->in_patch.bary1[v] = answers[c].in_patch.bary1[z];
                answer->in_patch.bary2[v] = answers[c].in_patch.bary2[z];
            }
        }
    }

    static void add_case(const NodeRef& e, float distance_lo, BoxBounds* out) {
        e.tree->ranges->add_case(e.node, distance_lo, out);
    }

    const std::shared_ptr<const BlockIndex> index_;
    const KernelTable& kernels_;
    std::array<float, OPENFAB_FRAME_COUNT> frame_;
    BlockShape shape_;
    BlockPieces pieces_;
    KernelInput input_;
};

}  // namespace

std::shared_ptr<PatchCache> make_patch_cache(size_t budget_bytes) {
    return std::make_shared<PatchCache>(budget_bytes);
}

void set_budget(PatchCache* cache, size_t bytes) {
    cache->set_budget(bytes);
}

void begin_period(PatchCache* cache, int64_t periods) {
    cache->begin_period(periods);
}

int64_t built_bytes(const PatchCache& cache) {
    return cache.built_bytes();
}

void set_max_pinned(PatchCache* cache, size_t bytes) {
    cache->set_max_pinned(bytes);
}

std::shared_ptr<const BlockIndex> make_block_index(const surface::Surface& surface,
                                                   const BlockEngineOptions& options,
                                                   std::span<const uint64_t> morton) {
    return std::make_shared<const BlockIndex>(surface, options, morton);
}

size_t estimated_bytes(const BlockIndex& index, size_t vertices) {
    return index.estimated_bytes(vertices);
}

std::unique_ptr<Engine> make_block_engine(std::shared_ptr<const BlockIndex> index,
                                          const std::array<float, OPENFAB_FRAME_COUNT>& frame) {
    return std::make_unique<BlockEngine>(std::move(index), frame);
}

std::unique_ptr<Engine> make_block_engine(const surface::Surface& surface,
                                          const std::array<float, OPENFAB_FRAME_COUNT>& frame,
                                          const BlockEngineOptions& options) {
    return make_block_engine(make_block_index(surface, options), frame);
}

}  // namespace openfab::nearest
