// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/cube_bounds.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "abi/looks.h"
#include "base/check.h"
#include "base/infinity.h"

namespace openfab::volume {

namespace {

/// Tolerance of the distance at a centre, in halves of the cube's diagonal: tighter costs more than
/// what it culls.
constexpr float kCenterTolerance = 0.03f;

/// Reaches that are tried: powers of 2^(1/8), up to eight times half a block's diagonal, beyond which
/// a query would search no less.
constexpr int32_t kReaches = 64;
float reach_of(const PlacedPart& part, int32_t step) {
    return 4 * part.voxel_diagonal_mm * std::exp2(static_cast<float>(step + 1 - kReaches) / 8 + 3);
}

}  // namespace

int64_t CubeBounds::most_bytes(const PlacedPart& part, int64_t cubes) {
    // Values of an entry: its corner and distances; low and high of every component, as produced
    // and as transposed for the kernel; low and high of every weight; whether it looks. Twice for lists that double.
    const int64_t components = part.nearest.floats() + part.nearest.ints();
    const int64_t numbers = 2 * 5 + components * (2 * 2 + 2) + 2 * int64_t{part.slots()} + 1;
    constexpr int64_t kPoint =
        (2 * sizeof(nearest::PointPacket) + sizeof(nearest::PointBounds)) / 8 + 4;
    return int64_t{kBlocks * sizeof(nearest::BlockBounds) +
                   3 * kCachedCenters * sizeof(CenterDistance)} +
           cubes * ((nearest::BoxBounds::kMaxCases + 1) * 4 * numbers +
                    int64_t{2 * sizeof(size_t)} + 2 * (kPoint + int64_t{sizeof(CenterDistance)}));
}

CubeBounds::CenterDistance& CubeBounds::cached_center(int32_t size, const Vec3i& lowest) {
    const auto level = static_cast<size_t>(std::countr_zero(static_cast<uint32_t>(size / 16)));
    const auto x = static_cast<uint32_t>(lowest.x) / static_cast<uint32_t>(size),
               y = static_cast<uint32_t>(lowest.y) / static_cast<uint32_t>(size);
    static_assert(kCachedCenters == 1 << 10);
    return cached_[level * kCachedCenters + ((y & 15) << 6 | (x & 63))];
}

// Finds approximate distances of the cubes' centres, in the order of operations of a voxel's
// centre. Every slab that crosses a cube asks for it, so results are cached.
void CubeBounds::find_centers(const PlacedPart& part, int32_t size, std::span<const Vec3i> lowest,
                              nearest::Engine::Scratch* scratch) {
    cached_.resize(3 * kCachedCenters);
    centers_.resize(lowest.size());
    missing_.clear();
    for (size_t i = 0; i < lowest.size(); ++i) {
        const CenterDistance& cached = cached_center(size, lowest[i]);
        if (cached.part == &part && cached.lowest == lowest[i]) {
            centers_[i] = cached;
        } else {
            missing_.push_back(i);
        }
    }
    const size_t packets = (missing_.size() + 7) / 8;
    points_.resize(packets);
    near_.resize(packets);
    bounds_.resize(packets);
    const float half = 0.5f * static_cast<float>(size);
    for (size_t i = 0; i < 8 * packets; ++i) {
        // Unused lanes repeat the last query.
        const Vec3i& corner = lowest[missing_[std::min(i, missing_.size() - 1)]];
        const float x = static_cast<float>(corner.x) + half;
        const float y = static_cast<float>(corner.y) + half;
        const float z = static_cast<float>(corner.z) + half;
        for (size_t a = 0; a < 3; ++a) {
            points_[i / 8].p[a][i % 8] = ((x * part.frame[OPENFAB_FRAME_STEP_I + a] +
                                           y * part.frame[OPENFAB_FRAME_STEP_J + a]) +
                                          z * part.frame[OPENFAB_FRAME_STEP_K + a]) +
                                         part.frame[OPENFAB_FRAME_ORIGIN + a];
        }
        // The cached entry is mostly that of the cube below.
        const CenterDistance& below = cached_center(size, corner);
        for (size_t a = 0; a < 3; ++a)
            near_[i / 8].p[a][i % 8] =
                below.part == &part ? below.point[static_cast<int>(a)] : kInfinity;
    }
    part.engine().bound_points(points_, near_, kCenterTolerance * half * part.voxel_diagonal_mm,
                               scratch, bounds_.data());
    for (size_t i = 0; i < missing_.size(); ++i) {
        const nearest::PointBounds& b = bounds_[i / 8];
        const size_t l = i % 8;
        CenterDistance& found = centers_[missing_[i]];
        found = {&part, lowest[missing_[i]], b.low[l], b.high[l], {}, {}};
        for (int a = 0; a < 3; ++a) {
            found.at[a] = points_[i / 8].p[a][l];
            found.point[a] = b.point[a][l];
        }
        cached_center(size, found.lowest) = found;
    }
}

// Bounds the distances of the voxels of a cube, whose outermost ones are `voxels` from its centre:
// none is farther than its distance to the surface point that was found, which is largest at a
// corner.
CubeBounds::Range CubeBounds::distance_range(const PlacedPart& part, const CenterDistance& center,
                                             float voxels) {
    const float low = center.low, high = center.high;
    // The slack is for the rounding of these distances and of a voxel's own.
    const float slack = high * 0x1p-13f + part.largest_coordinate_mm * 0x1p-17f;
    const Vec3f way = center.at - center.point;
    float square = dot(way, way);
    for (const size_t step : {OPENFAB_FRAME_STEP_I, OPENFAB_FRAME_STEP_J, OPENFAB_FRAME_STEP_K}) {
        const float* s = &part.frame[step];
        const Vec3f step_mm{s[0], s[1], s[2]};
        const float along = dot(way, step_mm), length2 = dot(step_mm, step_mm);
        square += voxels * (2 * std::fabs(along) + voxels * length2);
    }
    const float reach = voxels * part.voxel_diagonal_mm + slack;
    // The smaller; the first where the point is not known.
    return {low > reach ? low - reach : 0.0f, std::min(high + reach, std::sqrt(square) + slack)};
}

// Takes unsigned distances; only voxels inside the part count, where the distance is negative.
void CubeBounds::add_entry(const Vec3i& corner, const nearest::NearestCase& of, float distance_lo,
                           float distance_hi) {
    corners_.insert(corners_.end(), {corner.x, corner.y, corner.z});
    distance_lo_.push_back(0.0f - distance_hi);
    distance_hi_.push_back(0.0f - distance_lo);
    if (!of.float_lo.empty()) {
        for (const std::vector<float>* v : {&of.float_lo, &of.float_hi})
            case_floats_.insert(case_floats_.end(), v->begin(), v->end());
    }
    if (!of.int_lo.empty()) {
        for (const std::vector<int32_t>* v : {&of.int_lo, &of.int_hi})
            case_ints_.insert(case_ints_.end(), v->begin(), v->end());
    }
}

// Transposes from entry-major to component-major order.
void CubeBounds::transpose_entries(const PlacedPart& part) {
    const size_t n = distance_lo_.size();
    const auto transpose = [n](size_t components, const auto& source, auto* lo, auto* hi) {
        lo->resize(components * n);
        hi->resize(components * n);
        for (size_t i = 0; i < n && !source.empty(); ++i) {
            for (size_t c = 0; c < components; ++c) {
                (*lo)[c * n + i] = source[2 * components * i + c];
                (*hi)[c * n + i] = source[2 * components * i + components + c];
            }
        }
    };
    transpose(static_cast<size_t>(part.nearest.floats()), case_floats_, &float_lo_, &float_hi_);
    transpose(static_cast<size_t>(part.nearest.ints()), case_ints_, &int_lo_, &int_hi_);
}

void CubeBounds::begin(const PlacedPart& part) {
    first_entry_.assign(1, 0);
    first_blind_ = kNone;
    corners_.clear();
    distance_lo_.clear();
    distance_hi_.clear();
    case_floats_.clear();
    case_ints_.clear();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (std::vector<float>* v : {&unknown_.float_lo, &unknown_.float_hi})
        v->assign(static_cast<size_t>(part.nearest.floats()), nan);
    unknown_.int_lo.assign(static_cast<size_t>(part.nearest.ints()),
                           std::numeric_limits<int32_t>::min());
    unknown_.int_hi.assign(static_cast<size_t>(part.nearest.ints()),
                           std::numeric_limits<int32_t>::max());
}

void CubeBounds::add_centers(const PlacedPart& part, int32_t size, std::span<const Vec3i> lowest,
                             nearest::Engine::Scratch* scratch) {
    find_centers(part, size, lowest, scratch);
    for (size_t i = 0; i < lowest.size(); ++i) {
        const Range d = distance_range(part, centers_[i], 0.5f * static_cast<float>(size - 1));
        add_entry(lowest[i], unknown_, d.low, d.high);
        first_entry_.push_back(distance_lo_.size());
    }
}

void CubeBounds::add_cases(const PlacedPart& part, int32_t size, std::span<const Vec3i> lowest,
                           std::span<const Known> known, nearest::Engine::Scratch* scratch) {
    for (size_t cube = 0; cube < lowest.size(); ++cube) {
        const Vec3i& corner = lowest[cube];
        if (!known.empty() && known[cube].distance.is_known()) {
            add_entry(corner, attributes_or_unknown(known, cube), known[cube].distance.low,
                      known[cube].distance.high);
            first_entry_.push_back(distance_lo_.size());
            continue;
        }
        box_.clear();
        box_.distance_hi = kInfinity;
        if (part.bounds.any()) part.engine().bounds(corner, size, scratch, &box_);
        for (int32_t k = 0; k < box_.count; ++k) {
            const nearest::NearestCase& one = box_.cases[k];
            add_entry(corner, one, one.distance_lo, box_.distance_hi);
        }
        if (box_.count == 0) add_entry(corner, unknown_, 0.0f, box_.distance_hi);
        first_entry_.push_back(distance_lo_.size());
    }
}

// Sets same_ to the attributes that have one value in all entries of a cube.
void CubeBounds::find_same_attributes(size_t cube) {
    const auto find = [&](size_t components, const auto& values, auto* lo, auto* hi) {
        for (size_t c = 0; c < components; ++c) {
            const size_t first = first_entry_[cube], end = first_entry_[cube + 1];
            const auto value = values[2 * components * first + c];
            bool same = true;
            for (size_t e = first; e < end; ++e) {
                const auto* of = &values[2 * components * e + c];
                // False for NaN, which is unknown.
                same = same && of[0] == value && of[components] == value;
            }
            if (same) (*lo)[c] = (*hi)[c] = value;
        }
    };
    same_ = unknown_;
    find(same_.float_lo.size(), case_floats_, &same_.float_lo, &same_.float_hi);
    find(same_.int_lo.size(), case_ints_, &same_.int_lo, &same_.int_hi);
}

void CubeBounds::add_blind_entries(std::span<const Vec3i> lowest, std::span<const Known> known) {
    const size_t first = distance_lo_.size();
    for (size_t cube = 0; cube < lowest.size(); ++cube) {
        float low = kInfinity, high = -kInfinity;
        for (size_t e = first_entry_[cube]; e < first_entry_[cube + 1]; ++e) {
            low = std::min(low, distance_lo_[e]);
            high = std::max(high, distance_hi_[e]);
        }
        if (!known.empty() && known[cube].looks_by_them) {
            add_entry(lowest[cube], attributes_or_unknown(known, cube), 0.0f - high, 0.0f - low);
            continue;
        }
        find_same_attributes(cube);
        add_entry(lowest[cube], same_, 0.0f - high, 0.0f - low);
    }
    first_blind_ = first;
}

bool CubeBounds::attributes_of(size_t cube, nearest::NearestCase* out) const {
    if (first_blind_ == kNone) return false;
    const size_t n = distance_lo_.size(), entry = first_blind_ + cube;
    bool any = false;
    *out = unknown_;
    const auto take = [&](const auto& from_lo, const auto& from_hi, auto* lo, auto* hi) {
        for (size_t c = 0; c < lo->size(); ++c) {
            if (!(from_lo[c * n + entry] == from_hi[c * n + entry])) continue;
            (*lo)[c] = (*hi)[c] = from_lo[c * n + entry];
            any = true;
        }
    };
    take(float_lo_, float_hi_, &out->float_lo, &out->float_hi);
    take(int_lo_, int_hi_, &out->int_lo, &out->int_hi);
    return any;
}

float CubeBounds::distance_of(size_t cube) const {
    const float distance = distance_lo_[entry_of(cube)];
    return std::isfinite(distance) ? distance : 0.0f;
}

CubeBounds::Range CubeBounds::range_of(size_t cube) const {
    const size_t entry = entry_of(cube);
    return {0.0f - distance_hi_[entry], 0.0f - distance_lo_[entry]};
}

// Bounds the query results in each cube, then the weights.
abi::KernelStatus CubeBounds::bound(const PlacedPart& part, int32_t size,
                                    std::span<const Vec3i> lowest, std::span<const Known> known,
                                    BoundSource source, const Tools& tools) {
    begin(part);
    if (source == BoundSource::kPerCase || !part.bounds.any()) {
        add_cases(part, size, lowest, known, tools.scratch);
        if (part.bounds_say_looks) add_blind_entries(lowest, known);
    } else if (size > 8) {
        add_centers(part, size, lowest, tools.scratch);
    } else {
        block_low_.resize(lowest.size());
        block_high_.resize(lowest.size());
        part.engine().bound_whole_blocks(lowest, tools.scratch, block_low_.data(),
                                         block_high_.data());
        for (size_t i = 0; i < lowest.size(); ++i) {
            add_entry(lowest[i], unknown_, block_low_[i], block_high_[i]);
            first_entry_.push_back(distance_lo_.size());
        }
    }
    transpose_entries(part);
    return run_kernel(part, size, tools);
}

abi::KernelStatus CubeBounds::bound_pieces(const PlacedPart& part, std::span<const Vec3i> blocks,
                                           std::span<const Known> known, const Tools& tools) {
    begin(part);
    const nearest::BlockPieces& pieces = part.engine().pieces();
    blocks_.resize(kBlocks);
    for (size_t first = 0; first < blocks.size(); first += kBlocks) {
        const auto some = blocks.subspan(first, std::min(kBlocks, blocks.size() - first));
        part.engine().bound_blocks(some, tools.scratch, blocks_.data());
        for (size_t i = 0; i < some.size(); ++i) {
            const nearest::NearestCase& at = attributes_or_unknown(known, first + i);
            for (size_t p = 0; p < kPieces; ++p) {
                add_entry(some[i] + pieces.lowest[p], at, blocks_[i].low[p], blocks_[i].high[p]);
                first_entry_.push_back(distance_lo_.size());
            }
        }
    }
    if (part.bounds_say_looks) first_blind_ = 0;
    transpose_entries(part);
    // The kernel takes cubes only; one that holds a piece is enough.
    return run_kernel(part, std::max({pieces.size.x, pieces.size.y, pieces.size.z}), tools);
}

abi::KernelStatus CubeBounds::find_reaches(const PlacedPart& part, std::span<const Vec3i> blocks,
                                           std::span<const Known> known, const Tools& tools,
                                           std::vector<float>* reaches) {
    // Farther than any voxel of the part is from its surface.
    const float farthest = 4 * part.largest_coordinate_mm;
    weights_.resize(static_cast<size_t>(part.slots()));
    steps_.assign(blocks.size(), {-1, kReaches});
    reaches->assign(blocks.size(), kInfinity);
    // The largest first: where a voxel looks however far the surface is, there is none.
    for (int32_t left = kReaches; left > 0; left /= 2) {
        begin(part);
        for (size_t i = 0; i < blocks.size(); ++i) {
            const auto [looking, blind] = steps_[i];
            const int32_t step = left == kReaches ? kReaches - 1 : (looking + blind) / 2;
            // With slack for the rounding of a voxel's own distance.
            const float reach = reach_of(part, std::max(step, 0)) * (1 - 0x1p-10f);
            add_entry(blocks[i], attributes_or_unknown(known, i), std::min(reach, farthest),
                      farthest);
            first_entry_.push_back(distance_lo_.size());
        }
        first_blind_ = 0;
        transpose_entries(part);
        if (const abi::KernelStatus status = run_kernel(part, 8, tools); !status.ok())
            return status;
        bool any = false;
        for (size_t i = 0; i < blocks.size(); ++i) {
            auto& [looking, blind] = steps_[i];
            const int32_t step = left == kReaches ? kReaches - 1 : (looking + blind) / 2;
            (looks(i) && !is_uniform(i, &weights_) ? looking : blind) = step;
            any |= blind < kReaches;
        }
        if (!any) return {};
    }
    for (size_t i = 0; i < blocks.size(); ++i) {
        const int32_t blind = steps_[i][1];
        if (blind < kReaches && reach_of(part, blind) < farthest)
            (*reaches)[i] = reach_of(part, blind);
    }
    return {};
}

abi::KernelStatus CubeBounds::run_kernel(const PlacedPart& part, int32_t size, const Tools& tools) {
    const size_t n = distance_lo_.size();
    if (first_blind_ == kNone || first_blind_ == 0) OPENFAB_CHECK_EQ(first_entry_.back(), n);
    // A slot that the fablet never sets may have no output; then it is 0.
    for (std::vector<float>* v : {&weight_lo_, &weight_hi_})
        v->assign(static_cast<size_t>(part.slots()) * n, 0.0f);
    looks_.assign(n, 1.0f);

    const openfab_kernel& kernel = part.part->fablet->volume_bounds;
    KernelArguments& arguments = *tools.arguments;
    arguments.begin(kernel, part, corners_.data(), static_cast<int32_t>(n), size);
    int32_t first_output = kernel.arg_count;
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        const openfab_arg& arg = kernel.args[i];
        const bool is_output =
            arg.kind == OPENFAB_ARG_WEIGHT_LO || arg.kind == OPENFAB_ARG_WEIGHT_HI;
        if (kernel.packed != 0 && is_output) {
            first_output = i;
            break;
        }
        const auto slot = abi::is_looks(arg) ? 0 : static_cast<size_t>(arg.a) * n;
        const bool lo = arg.kind == OPENFAB_ARG_NEAREST_LO;
        switch (arg.kind) {
            case OPENFAB_ARG_DISTANCE_LO:
                arguments.set_list(i, distance_lo_.data());
                break;
            case OPENFAB_ARG_DISTANCE_HI:
                arguments.set_list(i, distance_hi_.data());
                break;
            case OPENFAB_ARG_WEIGHT_LO:
                arguments.set_list(i, &weight_lo_[slot]);
                break;
            case OPENFAB_ARG_WEIGHT_HI:
                arguments.set_list(i, abi::is_looks(arg) ? looks_.data() : &weight_hi_[slot]);
                break;
            case OPENFAB_ARG_NEAREST_LO:
            case OPENFAB_ARG_NEAREST_HI: {
                const size_t first = part.nearest.index(arg.a, arg.b) * n;
                if (part.nearest.is_float(arg.a)) {
                    arguments.set_list(i, lo ? &float_lo_[first] : &float_hi_[first]);
                } else {
                    arguments.set_list(i, lo ? &int_lo_[first] : &int_hi_[first]);
                }
                break;
            }
            default:
                break;
        }
    }
    if (kernel.packed == 0) return arguments.run(tools.isa);
    const auto outputs = static_cast<size_t>(kernel.arg_count - first_output);
    packed_.resize(outputs * n);
    arguments.set_packed(first_output, packed_.data(), static_cast<int32_t>(outputs));
    const abi::KernelStatus status = arguments.run(tools.isa);
    for (size_t k = 0; k < outputs; ++k) {
        const openfab_arg& arg = kernel.args[static_cast<size_t>(first_output) + k];
        if (abi::is_looks(arg)) {
            std::memcpy(looks_.data(), &packed_[k * n], n * sizeof(float));
            continue;
        }
        std::vector<float>& to = arg.kind == OPENFAB_ARG_WEIGHT_LO ? weight_lo_ : weight_hi_;
        std::memcpy(&to[static_cast<size_t>(arg.a) * n], &packed_[k * n], n * sizeof(float));
    }
    return status;
}

bool CubeBounds::is_uniform(size_t cube, std::vector<float>* weights) const {
    const size_t n = distance_lo_.size();
    const size_t first = first_entry_[cube];
    for (size_t s = 0; s < weights->size(); ++s) {
        (*weights)[s] = weight_lo_[s * n + first];
        for (size_t e = first; e < first_entry_[cube + 1]; ++e) {
            // False for NaN, too.
            if (!(weight_lo_[s * n + e] == (*weights)[s] && weight_hi_[s * n + e] == (*weights)[s]))
                return false;
        }
    }
    return true;
}

}  // namespace openfab::volume
