// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/voxel/coverage.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <limits>
#include <mutex>

#include "base/clock.h"
#include "base/stage_timer.h"
#include "runtime/surface/transform_box.h"
#include "runtime/voxel/crossings.h"
#include "runtime/voxel/snapping.h"

namespace openfab::voxel {

namespace {

using surface::Patch;
using surface::PatchKind;

constexpr int32_t kSlabSlices = 8;
constexpr size_t kLocks = 64;
// Bounds are of positions rounded to float; the triangles of identity surfaces are not rounded. In
// 1/256 voxel, far more than the difference.
constexpr double kBoundsSlack = 1;

int32_t slab_of(int32_t k) {
    return k >> 3;
}

/// The crossings of one patch in all slabs that it touches, in order of slabs.
struct PatchCrossings {
    int32_t first_slab = 0;
    std::vector<int32_t> first;  ///< [slab - first_slab], and the end
    std::vector<Crossing> crossings;

    int64_t bytes() const {
        return static_cast<int64_t>(sizeof(*this) + first.capacity() * sizeof(int32_t) +
                                    crossings.capacity() * sizeof(Crossing));
    }
};

/// Crossings that wait for later slabs: a patch that spans several is diced and crossed once.
struct Waiting {
    std::shared_ptr<const PatchCrossings> kept;
    int32_t slabs_left = 0;  ///< slabs that still need them
};

/// Scratch memory of one call, reused from call to call.
struct Scratch {
    std::vector<Vec3i> snapped;
    std::vector<std::array<int32_t, 2>> rows;  ///< first_row of y and z
    std::vector<Crossing> crossings, sorted;
    std::vector<int32_t> row_first;
    std::vector<int32_t> patches;  ///< that meet the slab
};

}  // namespace

struct Voxeliser::Impl {
    const surface::Surface& surface;
    const Snapping snapping;
    const int64_t most_kept;
    Window grid;  ///< x, y, z of the print
    Box3i box;
    std::shared_ptr<const PatchIndex> index;
    mutable std::vector<Waiting> waiting;  ///< [patch]; none where no patch is displaced
    mutable std::array<std::mutex, kLocks> locks;
    mutable std::atomic<int64_t> kept_bytes{0};
    mutable std::mutex scratch_mutex;
    mutable std::vector<std::unique_ptr<Scratch>> idle;

    Impl(const part::Part& p, const surface::Surface& s, const part::Grid& g, size_t waiting_bytes,
         std::shared_ptr<const PatchIndex> shared)
        : surface(s),
          snapping(p, g, s.identity()),
          most_kept(static_cast<int64_t>(waiting_bytes)),
          index(std::move(shared)) {
        grid = {{0, 0, 0}, g.size};
        find_box();
        if (!surface.identity()) waiting.resize(surface.patches().size());
    }

    void find_box();
    std::unique_ptr<Scratch> take_scratch() const;
    void give_scratch(std::unique_ptr<Scratch> scratch) const;
    double take_patches(int32_t slab, Scratch* scratch, const std::atomic<bool>* stop) const;
    void find_patch(int32_t patch, const Window& window, Scratch* scratch,
                    std::vector<Crossing>* out) const;
    void take_patch(int32_t patch, int32_t slab, const Window& window, Scratch* scratch) const;
    std::shared_ptr<const PatchCrossings> cross_all_slabs(int32_t patch, Scratch* scratch) const;
    void fill(int32_t slab, Scratch* scratch, SlabMask* out) const;
    std::array<int32_t, 2> slabs_of(const Box3f& bounds) const;
    std::array<int32_t, 2> slabs_of(int32_t patch) const {
        return slabs_of(surface.patches()[patch].bounds);
    }
};

/// Returns the slabs [first, end) of the grid that the contents of a part-local box may cross.
std::array<int32_t, 2> Voxeliser::Impl::slabs_of(const Box3f& bounds) const {
    const Vec2<double> z = surface::transform_range(snapping.map(), bounds, 2);
    const int32_t first = std::max(first_row(snap(z.x - kBoundsSlack)), grid.lo.z);
    const int32_t end = std::min(first_row(snap(z.y + kBoundsSlack)), grid.hi.z);
    if (first >= end) return {0, 0};
    return {slab_of(first), slab_of(end - 1) + 1};
}

void Voxeliser::Impl::find_box() {
    for (int axis = 0; axis < 3; ++axis)
        box.lo[axis] = grid.hi[axis], box.hi[axis] = grid.lo[axis];
    const auto rows = [&](const Box3f& bounds) {
        const Box3d b = surface::transform_box(snapping.map(), bounds);
        Box3i out;
        for (int axis = 0; axis < 3; ++axis) {
            out.lo[axis] = std::max(first_row(snap(b.lo[axis] - kBoundsSlack)), grid.lo[axis]);
            out.hi[axis] = std::min(first_row(snap(b.hi[axis] + kBoundsSlack)), grid.hi[axis]);
        }
        return out;
    };
    const auto sticks_out = [&](const Box3f& bounds) {
        const Box3i b = rows(bounds);
        for (int axis = 0; axis < 3; ++axis) {
            if (b.lo[axis] < box.lo[axis] || b.hi[axis] > box.hi[axis]) return true;
        }
        return false;
    };
    index->find(sticks_out, [&](int32_t p) { box.add(rows(surface.patches()[p].bounds)); });
    if (box.lo.x >= box.hi.x || box.lo.y >= box.hi.y || box.lo.z >= box.hi.z)
        box = {{0, 0, 0}, {0, 0, 0}};
}

/// Appends the patch's crossings in the window.
void Voxeliser::Impl::find_patch(int32_t index, const Window& window, Scratch* scratch,
                                 std::vector<Crossing>* out) const {
    const Patch& patch = surface.patches()[index];
    if (patch.kind == PatchKind::kIdentity) {
        const std::array<Vec3i, 3> v = snapping.triangle(patch.triangle);
        add_crossings(v[0], v[1], v[2], snapping.turn(), window, out);
        return;
    }
    const std::shared_ptr<const surface::MicroMesh> mesh = surface.micro(index);
    const size_t count = mesh->positions.size();
    scratch->snapped.resize(count);
    scratch->rows.resize(count);
    for (size_t i = 0; i < count; ++i) {
        scratch->snapped[i] = snapping.point(mesh->positions[i]);
        scratch->rows[i] = {first_row(scratch->snapped[i].y), first_row(scratch->snapped[i].z)};
    }
    const std::array<int32_t, 2>* rows = scratch->rows.data();
    const Vec3i* snapped = scratch->snapped.data();
    for (const auto& triangle : mesh->triangles) {
        const size_t a = static_cast<size_t>(triangle[0]), b = static_cast<size_t>(triangle[1]),
                     c = static_cast<size_t>(triangle[2]);
        // Most micropolygons lie between two rows of centers.
        const int32_t y = (rows[a][0] ^ rows[b][0]) | (rows[a][0] ^ rows[c][0]);
        const int32_t z = (rows[a][1] ^ rows[b][1]) | (rows[a][1] ^ rows[c][1]);
        if (y != 0 && z != 0)
            add_crossings(snapped[a], snapped[b], snapped[c], snapping.turn(), window, out);
    }
}

std::shared_ptr<const PatchCrossings> Voxeliser::Impl::cross_all_slabs(int32_t patch,
                                                                       Scratch* scratch) const {
    const auto [first, end] = slabs_of(patch);
    auto made = std::make_shared<PatchCrossings>();
    made->first_slab = first;
    scratch->sorted.clear();
    find_patch(patch, grid, scratch, &scratch->sorted);
    made->first.assign(static_cast<size_t>(end - first) + 1, 0);
    for (const Crossing& x : scratch->sorted)
        ++made->first[static_cast<size_t>(slab_of(x.k) - first) + 1];
    for (size_t g = 1; g < made->first.size(); ++g)
        made->first[g] += made->first[g - 1];
    made->crossings.resize(scratch->sorted.size());
    std::vector<int32_t> at(made->first.begin(), made->first.end() - 1);
    for (const Crossing& x : scratch->sorted) {
        made->crossings[static_cast<size_t>(at[static_cast<size_t>(slab_of(x.k) - first)]++)] = x;
    }
    return made;
}

/// Adds the patch's crossings in one slab to scratch->crossings.
void Voxeliser::Impl::take_patch(int32_t patch, int32_t slab, const Window& window,
                                 Scratch* scratch) const {
    const PatchKind kind = surface.patches()[patch].kind;
    const auto [first, end] = slabs_of(patch);
    if (kind == PatchKind::kIdentity || end - first == 1) {
        find_patch(patch, window, scratch, &scratch->crossings);
        return;
    }
    std::shared_ptr<const PatchCrossings> found;
    Waiting& slot = waiting[patch];
    std::mutex& lock = locks[static_cast<size_t>(patch) % kLocks];
    {
        const std::lock_guard guard(lock);
        found = slot.kept;
        if (found && --slot.slabs_left <= 0) {
            kept_bytes -= found->bytes();
            slot.kept = nullptr;
        }
    }
    if (!found) {
        if (kept_bytes > most_kept) {
            find_patch(patch, window, scratch, &scratch->crossings);
            return;
        }
        found = cross_all_slabs(patch, scratch);
        const std::lock_guard guard(lock);
        if (!slot.kept) {
            slot.kept = found;
            slot.slabs_left = end - first - 1;
            kept_bytes += found->bytes();
        }
    }
    const size_t g = static_cast<size_t>(slab - found->first_slab);
    scratch->crossings.insert(scratch->crossings.end(), found->crossings.begin() + found->first[g],
                              found->crossings.begin() + found->first[g + 1]);
}

std::unique_ptr<Scratch> Voxeliser::Impl::take_scratch() const {
    const std::lock_guard lock(scratch_mutex);
    if (idle.empty()) return std::make_unique<Scratch>();
    std::unique_ptr<Scratch> scratch = std::move(idle.back());
    idle.pop_back();
    return scratch;
}

void Voxeliser::Impl::give_scratch(std::unique_ptr<Scratch> scratch) const {
    const std::lock_guard lock(scratch_mutex);
    idle.push_back(std::move(scratch));
}

/// Sets scratch->crossings to those of all patches in one slab. Threads that have nothing else to do
/// help: a slab that dices many patches, as the first one may, would keep them waiting. Returns their
/// seconds, less those that this thread waited, in which it may have worked at something else.
double Voxeliser::Impl::take_patches(int32_t slab, Scratch* scratch,
                                     const std::atomic<bool>* stop) const {
    // A task takes far longer than it costs to hand it out, where patches are diced or not.
    constexpr size_t kDicedTogether = 4, kPlainTogether = 2048;
    scratch->crossings.clear();
    scratch->patches.clear();
    const auto meets = [&](const Box3f& bounds) {
        const auto [first, end] = slabs_of(bounds);
        return first <= slab && slab < end;
    };
    index->find(meets, [&](int32_t patch) {
        if (meets(surface.patches()[patch].bounds)) scratch->patches.push_back(patch);
    });
    Window window = grid;
    window.lo.z = std::max(window.lo.z, slab * kSlabSlices);
    window.hi.z = std::min(window.hi.z, (slab + 1) * kSlabSlices);
    const auto take = [&](size_t first, size_t end, Scratch* own) {
        for (size_t i = first; i < end; ++i) {
            if (stop != nullptr && stop->load(std::memory_order_relaxed)) return;
            take_patch(scratch->patches[i], slab, window, own);
        }
    };
    const size_t count = scratch->patches.size();
    const size_t together = surface.identity() ? kPlainTogether : kDicedTogether;
    if (count <= together) {
        take(0, count, scratch);
        return 0;
    }
    // Any order of patches gives the same rows of crossings.
    std::mutex mutex;
    double seconds = 0;
    const double start = seconds_now();
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, together), [&](const auto& range) {
        double taken = 0;
        std::unique_ptr<Scratch> own = take_scratch();
        {
            const StageTimer timer(Stage::kCoverage, &taken);
            own->crossings.clear();
            take(range.begin(), range.end(), own.get());
        }
        {
            const std::lock_guard lock(mutex);
            seconds += taken;
            scratch->crossings.insert(scratch->crossings.end(), own->crossings.begin(),
                                      own->crossings.end());
        }
        give_scratch(std::move(own));
    });
    return seconds - (seconds_now() - start);
}

/// Turns crossings into bits: the inside state of each row is toggled where its winding number
/// passes between 0 and 1, and a running XOR along x spreads the toggles of all 8 slices at once.
void Voxeliser::Impl::fill(int32_t slab, Scratch* scratch, SlabMask* out) const {
    std::vector<Crossing>& all = scratch->crossings;
    out->x0 = out->y0 = out->width = out->height = 0;
    out->mask.clear();
    if (all.empty()) return;
    int32_t x_lo = all[0].c, x_hi = all[0].c, y_lo = all[0].j, y_hi = all[0].j;
    for (const Crossing& x : all) {
        x_lo = std::min(x_lo, x.c), x_hi = std::max(x_hi, x.c);
        y_lo = std::min(y_lo, x.j), y_hi = std::max(y_hi, x.j);
    }
    out->x0 = x_lo & ~7, out->y0 = y_lo & ~7;
    out->width = ((x_hi + 7) & ~7) - out->x0;
    out->height = ((y_hi + 8) & ~7) - out->y0;
    if (out->width == 0) {
        out->height = 0;
        return;
    }
    out->mask.assign(static_cast<size_t>(out->width) * static_cast<size_t>(out->height), 0);

    // Counting sort by row (y, slice), then each row by place.
    const auto row_of = [&](const Crossing& x) {
        return static_cast<size_t>((x.j - out->y0) * kSlabSlices + (x.k - slab * kSlabSlices));
    };
    scratch->row_first.assign(static_cast<size_t>(out->height) * kSlabSlices + 1, 0);
    std::vector<int32_t>& first = scratch->row_first;
    for (const Crossing& x : all)
        ++first[row_of(x) + 1];
    for (size_t r = 1; r < first.size(); ++r)
        first[r] += first[r - 1];
    scratch->sorted.resize(all.size());
    for (const Crossing& x : all)
        scratch->sorted[static_cast<size_t>(first[row_of(x)]++)] = x;
    // Filling has moved each `first` to the end of its row.
    size_t begin = 0;
    for (size_t r = 0; r + 1 < first.size(); ++r) {
        const size_t end = static_cast<size_t>(first[r]);
        Crossing* row = scratch->sorted.data() + begin;
        const size_t n = end - begin;
        begin = end;
        if (n == 0) continue;
        std::sort(row, row + n, [](const Crossing& a, const Crossing& b) { return a.c < b.c; });
        uint8_t* line =
            out->mask.data() + (r / kSlabSlices) * static_cast<size_t>(out->width) - out->x0;
        const uint8_t bit = static_cast<uint8_t>(1u << (r % kSlabSlices));
        int32_t winding = 0;
        for (size_t i = 0; i < n;) {
            const int32_t c = row[i].c;
            const bool before = winding > 0;
            for (; i < n && row[i].c == c; ++i)
                winding -= row[i].turn;
            if ((winding > 0) != before && c < out->x0 + out->width) line[c] ^= bit;
        }
    }
    for (int32_t y = 0; y < out->height; ++y) {
        uint8_t* line = out->mask.data() + static_cast<size_t>(y) * static_cast<size_t>(out->width);
        uint64_t carry = 0;
        for (int32_t x = 0; x < out->width; x += 8) {
            uint64_t v;
            std::memcpy(&v, line + x, 8);
            v ^= carry;
            v ^= v << 8;
            v ^= v << 16;
            v ^= v << 32;
            carry = v >> 56;
            std::memcpy(line + x, &v, 8);
        }
    }
}

Voxeliser::Voxeliser(const part::Part& part, const surface::Surface& surface,
                     const part::Grid& grid, size_t waiting_bytes,
                     std::shared_ptr<const PatchIndex> index)
    : impl_(new Impl(
          part, surface, grid, waiting_bytes,
          index != nullptr ? std::move(index) : std::make_shared<const PatchIndex>(surface))) {}

Voxeliser::~Voxeliser() {
    delete impl_;
}

void Voxeliser::coverage(int32_t slab, SlabMask* out, const std::atomic<bool>* stop,
                         double* seconds) const {
    const Impl& impl = *impl_;
    const double start = seconds_now();
    std::unique_ptr<Scratch> scratch = impl.take_scratch();
    const double others = impl.take_patches(slab, scratch.get(), stop);
    impl.fill(slab, scratch.get(), out);
    impl.give_scratch(std::move(scratch));
    if (seconds != nullptr) *seconds += seconds_now() - start + others;
}

void Voxeliser::drop_waiting() const {
    for (Waiting& slot : impl_->waiting)
        slot.kept = nullptr;
    impl_->kept_bytes = 0;
}

Box3i Voxeliser::voxel_box() const {
    return impl_->box;
}

size_t Voxeliser::bytes() const {
    return sizeof(Impl) + impl_->waiting.capacity() * sizeof(Waiting) +
           static_cast<size_t>(impl_->kept_bytes.load());
}

}  // namespace openfab::voxel
