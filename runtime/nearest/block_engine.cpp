// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The block-coherent engine: trees, the cache of diced patches, scratch. The loops are in
// kernel.inl.

#include <algorithm>
#include <bit>
#include <cmath>

#include "runtime/nearest/engine.h"
#include "runtime/nearest/kernel.h"
#include "runtime/nearest/patch_cache.h"

namespace openfab::nearest {

template <typename T>
void Growing<T>::grow() {
    const size_t larger = capacity == 0 ? 256 : capacity * 2;
    // Not realloc: it would lose the alignment of Lanes.
    T* moved = static_cast<T*>(std::aligned_alloc(64, larger * sizeof(T)));
    if (moved == nullptr) std::abort();
    std::copy(data, data + capacity, moved);
    std::free(data);
    data = moved;
    capacity = larger;
}
template struct Growing<Entry>;
template struct Growing<Lanes>;
template struct Growing<float>;
template struct Growing<TriangleRef>;

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
    for (int i = 0; i < 3; ++i)
        halve_longest();
    int32_t packets[8][3], lanes[8][3];
    origins(shape.sub_size, size, packets);
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
    return shape;
}

namespace {

const KernelTable& best_kernels(bool allow_avx2) {
    return allow_avx2 && __builtin_cpu_supports("avx2") != 0 ? avx2::kKernels : sse41::kKernels;
}

}  // namespace

class BlockIndex {
  public:
    BlockIndex(const surface::Surface& surface, const BlockEngineOptions& options)
        : kernels_(best_kernels(options.allow_avx2)),
          surface_(surface),
          cache_(surface, options.cache_bytes) {
        std::vector<InputTriangle> triangles;
        std::vector<InputPatch> patches;
        gather(&triangles, &patches);
        root_ = build_tree(triangles, patches);
        gather_ranges();
    }

    const KernelTable& kernels() const { return kernels_; }
    const Tree& root() const { return root_; }
    PatchCache* cache() const { return &cache_; }

    /// Adds to `out` what a node of the root may give.
    void add_case(size_t node, float distance_lo, BoxBounds* out) const {
        const auto floats = static_cast<size_t>(float_components_);
        const auto ints = static_cast<size_t>(int_components_);
        out->add(distance_lo, {float_lo_.data() + node * floats, floats},
                 {float_hi_.data() + node * floats, floats}, {int_lo_.data() + node * ints, ints},
                 {int_hi_.data() + node * ints, ints});
    }

  private:
    /// Identity patches come as triangles, all others as boxes.
    void gather(std::vector<InputTriangle>* triangles, std::vector<InputPatch>* patches) const {
        const std::vector<surface::Patch>& all = surface_.patches();
        for (size_t i = 0; i < all.size(); ++i) {
            if ((all[i].use & surface::kForQuery) == 0) continue;
            const auto patch = static_cast<int32_t>(i);
            if (all[i].kind == surface::PatchKind::kIdentity) {
                append_triangles(*surface_.micro(patch), patch, triangles);
            } else {
                patches->push_back({all[i].bounds, patch});
            }
        }
    }

    void gather_ranges() {
        const surface::PatchRanges& r = surface_.ranges();
        float_components_ = r.float_components;
        int_components_ = r.int_components;
        const auto floats = static_cast<size_t>(float_components_);
        const auto ints = static_cast<size_t>(int_components_);
        const size_t nodes = root_.nodes.size();
        float_lo_.assign(nodes * floats, std::numeric_limits<float>::infinity());
        float_hi_.assign(nodes * floats, -std::numeric_limits<float>::infinity());
        int_lo_.assign(nodes * ints, std::numeric_limits<int32_t>::max());
        int_hi_.assign(nodes * ints, std::numeric_limits<int32_t>::lowest());
        if (floats + ints == 0) return;
        const auto add = [&](size_t node, const float* flo, const float* fhi, const int32_t* ilo,
                             const int32_t* ihi) {
            for (size_t c = 0; c < floats; ++c) {
                float_lo_[node * floats + c] = std::min(float_lo_[node * floats + c], flo[c]);
                float_hi_[node * floats + c] = std::max(float_hi_[node * floats + c], fhi[c]);
            }
            for (size_t c = 0; c < ints; ++c) {
                int_lo_[node * ints + c] = std::min(int_lo_[node * ints + c], ilo[c]);
                int_hi_[node * ints + c] = std::max(int_hi_[node * ints + c], ihi[c]);
            }
        };
        const auto add_patch = [&](size_t node, int32_t patch) {
            const auto p = static_cast<size_t>(patch);
            add(node, r.float_lo.data() + p * floats, r.float_hi.data() + p * floats,
                r.int_lo.data() + p * ints, r.int_hi.data() + p * ints);
        };
        // Children come after their parents, so one pass backwards carries leaves up to the root.
        for (size_t n = nodes; n-- > 0;) {
            const Node& node = root_.nodes[n];
            if (!node.is_leaf()) {
                for (size_t c = node.child(); c < node.child() + 2u; ++c) {
                    add(n, float_lo_.data() + c * floats, float_hi_.data() + c * floats,
                        int_lo_.data() + c * ints, int_hi_.data() + c * ints);
                }
            } else if (node.count() == 0) {
                add_patch(n, static_cast<int32_t>(node.first()));
            } else {
                for (size_t t = node.first(); t < node.first() + node.count(); ++t)
                    add_patch(n, root_.details[t].patch);
            }
        }
    }

    const KernelTable& kernels_;
    const surface::Surface& surface_;
    mutable PatchCache cache_;
    Tree root_;
    int32_t float_components_ = 0, int_components_ = 0;
    std::vector<float> float_lo_, float_hi_;  // [node][component]
    std::vector<int32_t> int_lo_, int_hi_;
};

namespace {

class BlockScratch final : public Engine::Scratch {
  public:
    BlockScratch() { kernel.counts = &counts; }
    KernelScratch kernel;
    PatchPins pins;
};

class BlockEngine final : public Engine {
  public:
    BlockEngine(std::shared_ptr<const BlockIndex> index,
                const std::array<float, OPENFAB_FRAME_COUNT>& frame)
        : index_(std::move(index)), kernels_(index_->kernels()), frame_(frame) {
        Vec3f pitch;
        for (int a = 0; a < 3; ++a)
            pitch[a] = length(Vec3f{frame_[a * 3], frame_[a * 3 + 1], frame_[a * 3 + 2]});
        shape_ = make_block_shape(pitch);
        const Tree& root = index_->root();
        if (!root.nodes.empty()) input_.root = root.view();
        input_.frame = frame_.data();
        input_.shape = &shape_;
        input_.largest_coordinate = root.largest_coordinate;
    }

    std::unique_ptr<Scratch> make_scratch() const override {
        return std::make_unique<BlockScratch>();
    }

    void query(const BlockQuery& query, Scratch* scratch, BlockAnswer* answer) const override {
        auto& s = static_cast<BlockScratch&>(*scratch);
        begin(&s);
        int asked = kBlockVoxels;
        if (query.demand != nullptr) {
            asked = 0;
            for (int i = 0; i < kBlockVoxels / 8; ++i)
                asked += std::popcount(query.demand[i]);
        }
        s.counts.asked += asked;
        s.counts.skipped += kBlockVoxels - asked;
        kernels_.query(input_, query, &s.kernel, answer);
    }

    void query_points(std::span<const PointGroup> groups, float radius_mm, Scratch* scratch,
                      PointAnswer* answers) const override {
        auto& s = static_cast<BlockScratch&>(*scratch);
        begin(&s);
        for (const PointGroup& g : groups)
            s.counts.asked += std::popcount(g.mask & 0xffu);
        kernels_.points(input_, groups.data(), groups.size(), radius_mm, &s.kernel, answers);
    }

    void bounds(const Vec3i& lowest, int32_t size, Scratch* scratch,
                BoxBounds* out) const override {
        auto& s = static_cast<BlockScratch&>(*scratch);
        begin(&s);
        out->clear();
        out->distance_hi = kernels_.cube(input_, lowest, size, &s.kernel);
        for (size_t i = 0; i < s.kernel.list.size; ++i)
            index_->add_case(s.kernel.list.data[i].node, s.kernel.list_least.data[i], out);
    }

  private:
    void begin(BlockScratch* s) const {
        s->pins.reset(index_->cache());
        s->kernel.patches = {&PatchPins::fetch, &s->pins};
    }

    const std::shared_ptr<const BlockIndex> index_;
    const KernelTable& kernels_;
    std::array<float, OPENFAB_FRAME_COUNT> frame_;
    BlockShape shape_;
    KernelInput input_;
};

}  // namespace

std::shared_ptr<const BlockIndex> make_block_index(const surface::Surface& surface,
                                                   const BlockEngineOptions& options) {
    return std::make_shared<const BlockIndex>(surface, options);
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
