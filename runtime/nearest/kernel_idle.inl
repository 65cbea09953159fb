// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Which features are idle in a sub-block, that is nearest to no point of it: those with a
// half-space that holds all of it (see features.h). One feature a lane. Part of kernel.inl.

/// A block of voxels in part space.
struct BlockPlace {
    float middle[3];
    const float* step;  ///< along x, y, z, three values each
    const BlockShape* shape;
    /// What is nearest to any of its voxels is no farther, mm.
    float reach;
    /// What float errors of positions and of all that is computed here may add up to, mm.
    float slack;
    /// Squared distances farther by its square are farther in float too, mm.
    float excess;
};

/// `reach2` is the reach, squared; as for rows, delta holds the errors of squared distances, of
/// which large triangles have the most.
inline BlockPlace make_place(const KernelInput& in, const Vec3i& block, float reach2, float delta) {
    const float* f = in.frame;
    BlockPlace place{};
    place.step = f;
    place.shape = in.shape;
    place.reach = __builtin_sqrtf(reach2) * kSlack + delta;
    place.slack = 3 * delta;
    place.excess = __builtin_sqrtf(row_slack(reach2, delta));
    for (int c = 0; c < 3; ++c) {
        double at = f[OPENFAB_FRAME_ORIGIN + c];
        for (int a = 0; a < 3; ++a)
            at += static_cast<double>(f[a * 3 + c]) * (block[a] + 4);
        place.middle[c] = static_cast<float>(at);
    }
    return place;
}

/// For triangles whose edges are no longer than some length, (length + reach) kRounded is an
/// excess, too: all that is computed of a feature starts from one of its corners, which is no
/// farther from the voxel than both together. This is the root of 2^-17; the roundings in two
/// squared distances come to some 80 of 2^-24 at most.
constexpr float kRounded = 0x1.7p-9f;

/// A linear function over the block.
template <typename V>
struct Slope {
    V middle;  ///< its value there
    V by[3];   ///< how it changes by a voxel along x, y, z
};

/// d . (p - v), where w leads from v to the middle of the block.
template <typename V>
OPENFAB_INLINE Slope<V> slope_along(const BlockPlace& place, const V* d, const V* w) {
    Slope<V> s;
    s.middle = (d[0] * w[0] + d[1] * w[1]) + d[2] * w[2];
    for (int a = 0; a < 3; ++a) {
        const float* step = place.step + 3 * a;
        s.by[a] = (d[0] * splat<V>(step[0]) + d[1] * splat<V>(step[1])) + d[2] * splat<V>(step[2]);
    }
    return s;
}

/// How far it is from its value at the middle of a part of the block, at its outer centres.
template <typename V>
OPENFAB_INLINE V reach_of(const Slope<V>& s, const float* half) {
    return (absolute(s.by[0]) * splat<V>(half[0]) + absolute(s.by[1]) * splat<V>(half[1])) +
           absolute(s.by[2]) * splat<V>(half[2]);
}

/// From the value at the middle of what is halved `bits` times to those at the middles of parts.
template <int bits, typename V>
OPENFAB_INLINE void middles_of(const Slope<V>& s, const int32_t* axis, const float* half, V* at) {
    for (int k = 0; k < bits; ++k) {
        const V by = s.by[axis[k]] * splat<V>(half[k]);
        for (int i = 0; i < 1 << k; ++i) {
            at[i + (1 << k)] = at[i] + by;
            at[i] = at[i] - by;
        }
    }
}

/// In which sub-blocks a half-space holds all centres.
template <typename V>
class IdleInSubBlocks {
  public:
    OPENFAB_INLINE explicit IdleInSubBlocks(const BlockShape& shape) : shape_(shape) {
        for (auto& mask : idle_)
            mask = splat<V>(0.0f) < splat<V>(0.0f);
    }
    OPENFAB_INLINE void below(const Slope<V>& s, V limit) {
        V at[8] = {s.middle};
        middles_of<3>(s, shape_.sub_axis, shape_.sub_half, at);
        const V most = limit - reach_of(s, shape_.sub_reach);
        for (int i = 0; i < 8; ++i)
            idle_[i] = idle_[i] | (at[i] < most);
    }
    OPENFAB_INLINE void above(const Slope<V>& s, V limit) {
        V at[8] = {s.middle};
        middles_of<3>(s, shape_.sub_axis, shape_.sub_half, at);
        const V least = limit + reach_of(s, shape_.sub_reach);
        for (int i = 0; i < 8; ++i)
            idle_[i] = idle_[i] | (least < at[i]);
    }
    /// Bit l: that of lane l is not idle in one of `subs` which has its bit in matters[l].
    OPENFAB_INLINE uint32_t not_everywhere(uint32_t subs, const uint8_t* matters) const {
        uint32_t lanes = 0;
        for (int i = 0; i < 8; ++i) {
            lanes |= ~bits(idle_[i]) & lanes_with_bit<V>(matters, i) & (0u - (subs >> i & 1u));
        }
        return lanes;
    }

  private:
    const BlockShape& shape_;
    MaskOf<V> idle_[8];
};

/// The same for quarters of sub-blocks: all half-spaces first, then one sub-block after the other.
template <typename V, int kSides>
class IdleInQuarters {
  public:
    OPENFAB_INLINE explicit IdleInQuarters(const BlockShape& shape) : shape_(shape) {}
    OPENFAB_INLINE void below(const Slope<V>& s, V limit) {
        V* at = at_[sides_];
        V* most = most_[sides_];
        ++sides_;
        at[0] = s.middle;
        middles_of<3>(s, shape_.sub_axis, shape_.sub_half, at);
        most[0] = limit - reach_of(s, shape_.quarter_reach);
        middles_of<2>(s, shape_.quarter_axis, shape_.quarter_half, most);
    }
    OPENFAB_INLINE void above(const Slope<V>& s, V limit) {
        const V zero = splat<V>(0.0f);
        below({zero - s.middle, {zero - s.by[0], zero - s.by[1], zero - s.by[2]}}, zero - limit);
    }
    /// Quarters count the other way round along an axis where `most` is the limit less the way from
    /// the sub-block's middle.
    OPENFAB_INLINE MaskOf<V> idle(int sub, int quarter) const {
        MaskOf<V> mask = at_[0][sub] < most_[0][3 - quarter];
        for (int i = 1; i < kSides; ++i)
            mask = mask | (at_[i][sub] < most_[i][3 - quarter]);
        return mask;
    }

  private:
    const BlockShape& shape_;
    V at_[kSides][8], most_[kSides][4];
    int sides_ = 0;
};

template <typename V>
OPENFAB_INLINE void from_middle(const BlockPlace& place, const V* v, V* w) {
    for (int c = 0; c < 3; ++c)
        w[c] = splat<V>(place.middle[c]) - v[c];
}

/// What drops any of `excess` along its reach.
template <typename V>
OPENFAB_INLINE V enough_for(V inv_reach, const BlockPlace& place) {
    const V x = splat<V>(place.excess);
    return x * max(splat<V>(1.0f), x * inv_reach) + splat<V>(place.slack);
}

// The half-spaces of features, whose floats lie in columns, and how many there are.

template <typename Feature>
constexpr int kSidesOf = 0;
template <>
constexpr int kSidesOf<TriangleFrame> = 3;
template <>
constexpr int kSidesOf<EdgeFeature> = 4;
template <>
constexpr int kSidesOf<VertexFeature> = VertexFeature::kMaxDirections;

/// Those in its first 16 floats, one line of memory.
template <typename Feature>
constexpr int kFirstSidesOf = kSidesOf<Feature>;
template <>
constexpr int kFirstSidesOf<VertexFeature> = 3;

template <int kSides, typename V, typename Idle>
OPENFAB_INLINE void test_sides(const TriangleFrame*, const V* f, const BlockPlace& place,
                               Idle* idle) {
    static_assert(kSides == 3 && offsetof(TriangleFrame, m) == 6 * sizeof(float) &&
                  offsetof(TriangleFrame, height0) == 15 * sizeof(float));
    V w[3];
    from_middle(place, f, w);
    const V beyond = splat<V>(-place.slack);
    for (int i = 0; i < 3; ++i) {
        Slope<V> s = slope_along(place, f + 6 + 3 * i, w);
        if (i == 1) s.middle = s.middle + f[15];
        idle->below(s, beyond);
    }
}

template <int kSides, typename V, typename Idle>
OPENFAB_INLINE void test_sides(const EdgeFeature*, const V* e, const BlockPlace& place,
                               Idle* idle) {
    static_assert(kSides == 4 && offsetof(EdgeFeature, ab) == 3 * sizeof(float) &&
                  offsetof(EdgeFeature, length2) == 6 * sizeof(float) &&
                  offsetof(EdgeFeature, wing) == 8 * sizeof(float) &&
                  offsetof(EdgeFeature, inv_reach) == 14 * sizeof(float));
    V w[3];
    from_middle(place, e, w);
    const V enough = enough_for(e[14], place);
    idle->above(slope_along(place, e + 8, w), enough);
    idle->above(slope_along(place, e + 11, w), enough);
    // No less than the slack times the length.
    const Slope<V> along = slope_along(place, e + 3, w);
    const V slack = splat<V>(place.slack) * (splat<V>(0.5f) + splat<V>(0.5f) * e[6]);
    idle->below(along, splat<V>(0.0f) - slack);
    idle->above(along, e[6] + slack);
}

template <int kSides, typename V, typename Idle>
OPENFAB_INLINE void test_sides(const VertexFeature*, const V* v, const BlockPlace& place,
                               Idle* idle) {
    static_assert(offsetof(VertexFeature, inv_reach) == 3 * sizeof(float) &&
                  offsetof(VertexFeature, direction) == 5 * sizeof(float));
    V w[3];
    from_middle(place, v, w);
    const V enough = enough_for(v[3], place);
    for (int i = 0; i < kSides; ++i)
        idle->above(slope_along(place, v + 5 + 3 * i, w), enough);
}
