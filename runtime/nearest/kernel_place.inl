// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// A block of voxels in part space, and linear functions over it. Part of kernel.inl.

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
