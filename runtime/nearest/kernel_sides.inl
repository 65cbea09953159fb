// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The half-spaces of a leaf's features (nearest/leaf_features.h) against parts of a block, a
// feature a lane, in fixed point. Part of kernel.inl.

/// By so much, of the distance to a point of the feature, a half-space's bounding plane may be
/// turned by its values being rounded: less than half a unit in each.
constexpr float kTurned = 0x1p-15f;

/// What is the same for all features that are listed for a block.
struct SidePlace {
    const BlockShape* shape;
    float middle[3];  ///< of the block, part space
    /// Half of the block along x, y, z: three values each, and nothing.
    alignas(32) float half[16];
    bool aligned;  ///< those are along the axes of part space
    float half_diagonal;
    /// How far beyond a half-space what prunes must be: for what decides by itself that a feature
    /// is not met, and for what says that another is nearer.
    float limit, excess;
    // Parts of those halves, 2^-15: from the block's middle to a sub-block's, bit by bit of its
    // number, from there to a quarter's, and how far these reach to their outer centres.
    int32_t to_sub[3], to_quarter[2], sub_reach[3], quarter_reach[3];
};

OPENFAB_INLINE SidePlace make_side_place(const BlockPlace& place, float longest_edge) {
    constexpr float kHalf = 4;  // voxels
    const BlockShape& shape = *place.shape;
    SidePlace out;
    out.shape = place.shape;
    out.aligned = true;
    for (int a = 0; a < 3; ++a) {
        out.middle[a] = place.middle[a];
        for (int c = 0; c < 3; ++c) {
            const float step = place.step[3 * a + c];
            out.half[3 * a + c] = kHalf * step;
            out.aligned &= a == c || step == 0;
        }
    }
    for (int i = 9; i < 16; ++i)
        out.half[i] = 0;
    out.half_diagonal = shape.half_diagonal;
    const float farthest = longest_edge + place.reach;
    out.limit = place.slack + farthest * kTurned;
    const float rounded = farthest * kRounded;
    out.excess = rounded < place.excess ? rounded : place.excess;
    const auto part_of = [](float voxels) {
        return static_cast<int32_t>(voxels * (32768 / kHalf));
    };
    for (int i = 0; i < 3; ++i) {
        out.to_sub[i] = part_of(shape.sub_half[i]);
        out.sub_reach[i] = part_of(shape.sub_reach[i]);
        out.quarter_reach[i] = part_of(shape.quarter_reach[i]);
    }
    for (int i = 0; i < 2; ++i)
        out.to_quarter[i] = part_of(shape.quarter_half[i]);
    return out;
}

/// What is the same for all features of a leaf. The unit is such that no distance from its origin
/// to one of the block's voxels, and beyond that through the leaf, comes to more than kMost.
struct LeafPlace {
    int32_t middle[3];  ///< of the block, from the origin
    int32_t half[16];   ///< as in SidePlace
    int32_t step;       ///< 2^-15
    int32_t limit, enough;

    OPENFAB_INLINE LeafPlace(const SidePlace& place, const LeafFeatures& leaf) {
        float from_origin[3], far2 = 0;
        for (int c = 0; c < 3; ++c) {
            from_origin[c] = place.middle[c] - leaf.origin[c];
            far2 += from_origin[c] * from_origin[c];
        }
        const float size = leaf.step * HalfSpaces::kUnit;
        const float per_mm = kMost / (__builtin_sqrtf(far2) + (place.half_diagonal + size));
        for (int c = 0; c < 3; ++c)
            middle[c] = static_cast<int32_t>(from_origin[c] * per_mm);
        store_rounded(half, load(place.half) * set1(per_mm));
        store_rounded(half + 8, load(place.half + 8) * set1(per_mm));
        step = static_cast<int32_t>(size * per_mm);
        limit = limit_of(place.limit * per_mm);
        // What drops any of `excess` along the shortest side.
        const float drop = place.excess * larger(1.0f, place.excess * leaf.inv_reach);
        enough = limit_of((drop + place.limit) * per_mm);
    }

  private:
    static constexpr float kMost = 32000;
    /// Rounding, in units: of what is at the block's middle, one for each coordinate, which count
    /// no more than the root of 3 together, half of one for each product, two for offsets, 5.3; of
    /// its halves 2.4 each, and no quarter reaches farther from there along an axis than one; 1.5
    /// for each of the 8 parts of those in a quarter's sums.
    /// One more is what a limit loses.
    static constexpr float kRounding = 26;
    static OPENFAB_INLINE int32_t limit_of(float units) {
        const float limit = units + kRounding;
        return static_cast<int32_t>(limit < 32767 ? limit : 32767);
    }
};

/// The half-spaces of 16 features of a leaf.
class LeafTest {
  public:
    /// `stride` lanes are stored from `values` on, of which these are the first; those of faces
    /// end before `faces`, of edges before `edges`.
    OPENFAB_INLINE LeafTest(const SidePlace& place, const LeafPlace& leaf, const int16_t* values,
                            size_t stride, int32_t faces, int32_t edges) {
        const I16 lane = lane_numbers();
        const I16 own = splat_fixed(leaf.limit), enough = splat_fixed(leaf.enough);
        const I16 limits[2] = {select(splat_fixed(faces) > lane, own, enough),
                               select(splat_fixed(edges) > lane, own, enough)};
        for (int k = 0; k < kSides; ++k, values += 4 * stride) {
            const I16 d[3] = {load_fixed(values), load_fixed(values + stride),
                              load_fixed(values + 2 * stride)};
            at_middle_[k] = along(d, leaf.middle) +
                            times(load_fixed(values + 3 * stride), splat_fixed(leaf.step));
            I16 half[3];
            for (int a = 0; a < 3; ++a) {
                const int32_t* h = leaf.half + 3 * a;
                half[a] = place.aligned ? times(d[a], splat_fixed(h[a])) : along(d, h);
            }
            for (int i = 0; i < 3; ++i) {
                const I16 to = times(half[place.shape->sub_axis[i]], splat_fixed(place.to_sub[i]));
                to_sub_[k][i][0] = splat_fixed(0) - to;
                to_sub_[k][i][1] = to;
            }
            I16 sub_reach = splat_fixed(0), quarter_reach = splat_fixed(0);
            for (int a = 0; a < 3; ++a) {
                const I16 way = absolute(half[a]);
                sub_reach = sub_reach + times(way, splat_fixed(place.sub_reach[a]));
                quarter_reach = quarter_reach + times(way, splat_fixed(place.quarter_reach[a]));
            }
            const I16 limit = limits[k / 2];
            sub_limit_[k] = add_capped(sub_reach, limit);
            I16 to_quarter[2];
            for (int i = 0; i < 2; ++i)
                to_quarter[i] =
                    times(half[place.shape->quarter_axis[i]], splat_fixed(place.to_quarter[i]));
            for (int q = 0; q < 4; ++q) {
                I16 r = quarter_reach;
                for (int i = 0; i < 2; ++i)
                    r = (q >> i & 1) != 0 ? r - to_quarter[i] : r + to_quarter[i];
                quarter_limit_[k][q] = add_capped(r, limit);
            }
        }
    }
    /// Goes to the next sub-block. Bit l: the feature of lane l is not idle there.
    OPENFAB_INLINE uint32_t enter(int sub) {
        I16 idle = splat_fixed(0);
        for (int k = 0; k < kSides; ++k) {
            const auto& to = to_sub_[k];
            at_[k] = (at_middle_[k] + to[0][sub & 1]) + (to[1][sub >> 1 & 1] + to[2][sub >> 2]);
            idle = idle | (at_[k] > sub_limit_[k]);
        }
        return ~bits(idle);
    }
    /// The same for a quarter of that sub-block.
    OPENFAB_INLINE uint32_t left_in(int quarter) const {
        I16 idle = splat_fixed(0);
        for (int k = 0; k < kSides; ++k)
            idle = idle | (at_[k] > quarter_limit_[k][quarter]);
        return ~bits(idle);
    }

  private:
    static OPENFAB_INLINE I16 along(const I16* d, const int32_t* way) {
        return (times(d[0], splat_fixed(way[0])) + times(d[1], splat_fixed(way[1]))) +
               times(d[2], splat_fixed(way[2]));
    }

    I16 at_middle_[kSides];     ///< of the block
    I16 to_sub_[kSides][3][2];  ///< from there, by bits of its number
    I16 at_[kSides];            ///< in the middle of the sub-block
    I16 sub_limit_[kSides], quarter_limit_[kSides][4];
};
