// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/check_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <map>
#include <utility>

#include "tools/inspection/components.h"
#include "tools/inspection/section.h"
#include "tools/inspection/thickness.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

using inspection::Bits;
using inspection::Box;
using inspection::Cluster;

/// Returns the diameter of the balls that tell what is thinner than a limit. Between voxel centres, walls of k machine
/// voxels are up to k and a part thick, and walls of the limit, at any angle, at least that less a
/// half of a part, wires 0.7. Of whole voxels no diameter is above the one and below the other.
double ball_of(double limit_mm, const Vec3d& pitch_mm, int32_t parts) {
    const double of_part = parts >= 3 ? -0.75 : parts == 2 ? -0.5 : 0.5;
    return limit_mm + of_part * std::max({pitch_mm.x, pitch_mm.y, pitch_mm.z});
}

class Finder {
  public:
    Finder(const CheckedPrint& print, const world::Checks& limits, std::vector<std::string>* notes)
        : print_(print), limits_(limits), notes_(notes) {
        const Vec3d& pitch = print.info.pitch_mm;
        voxel_mm3_ = pitch.x * pitch.y * pitch.z;
    }

    std::vector<Finding> run(const std::function<void(const char*, int, int)>& begins) {
        struct Look {
            const char* what;
            void (Finder::*look)();
        };
        constexpr Look kLooks[] = {{messages::kLooksForWalls, &Finder::walls},
                                   {messages::kLooksForGaps, &Finder::gaps},
                                   {messages::kLooksForIslands, &Finder::islands},
                                   {messages::kLooksForTrapped, &Finder::trapped},
                                   {messages::kLooksForTouching, &Finder::touching}};
        constexpr auto kCount = static_cast<int>(std::size(kLooks));
        for (int i = 0; i < kCount; ++i) {
            begins(kLooks[i].what, i + 1, kCount);
            (this->*kLooks[i].look)();
        }
        std::stable_sort(found_.begin(), found_.end(), [](const Finding& a, const Finding& b) {
            if (a.fault != b.fault) return a.fault < b.fault;
            const bool larger = a.fault >= Fault::kTrappedVoid;
            return larger ? a.measure > b.measure : a.measure < b.measure;
        });
        return std::move(found_);
    }

  private:
    /// Returns the code of a material, 0 where there is none, which is told once.
    uint8_t code_of(const std::string& name) {
        const auto& materials = print_.info.materials;
        for (size_t m = 0; m < materials.size(); ++m) {
            if (materials[m].name == name || materials[m].channel == name)
                return static_cast<uint8_t>(m + 1);
        }
        const std::string text = fmt::format(messages::kNoSuchMaterialToCheck, name);
        if (std::find(notes_->begin(), notes_->end(), text) == notes_->end())
            notes_->push_back(text);
        return 0;
    }

    template <typename Is>
    Bits bits_of(const Is& is) const {
        Bits bits(print_.codes.size);
        std::transform(print_.codes.values.begin(), print_.codes.values.end(), bits.values.begin(),
                       [&](uint8_t code) { return is(code) ? uint8_t{1} : uint8_t{0}; });
        return bits;
    }
    /// Support goes away: it is neither wall nor what fills a gap.
    bool is_solid(uint8_t code) const {
        return code != 0 && code != static_cast<uint8_t>(print_.info.support_code);
    }
    Bits solid() const {
        return bits_of([&](uint8_t code) { return is_solid(code); });
    }

    /// Calls `with` for each limit: the material's name, empty for all, its voxels, and the limit.
    template <typename With>
    void for_limits(const world::ByMaterial& limits, const With& with) {
        if (limits.others && *limits.others > 0) with("", solid(), *limits.others);
        for (const auto& [name, limit] : limits.named) {
            const uint8_t code = code_of(name);
            if (code == 0 || !(limit > 0)) continue;
            with(name, bits_of([&](uint8_t c) { return c == code; }), limit);
        }
    }

    void add(Fault fault, const std::string& material, double measure, double limit,
             const Cluster& where, std::vector<Vec3i> voxels) {
        found_.push_back({fault, material, measure, limit, where, std::move(voxels)});
    }

    std::vector<inspection::Thin> thin(Bits bits, int outside, double limit) const {
        return find_thin(std::move(bits), outside, print_.info.pitch_mm,
                         ball_of(limit, print_.info.pitch_mm, print_.parts));
    }

    void walls() {
        for_limits(limits_.wall_mm, [&](const std::string& name, Bits bits, double limit) {
            for (inspection::Thin& one : thin(std::move(bits), 0, limit))
                add(Fault::kWall, name, one.thickness_mm, limit, one.where, std::move(one.voxels));
        });
    }

    void gaps() {
        // A limit for all and one for the gaps within a material are looked at alike.
        std::map<std::string, std::array<double, 2>> all;
        const auto take = [&](const world::ByMaterial& limits, size_t kind) {
            if (limits.others) all[""][kind] = *limits.others;
            for (const auto& [name, limit] : limits.named)
                all[name][kind] = limit;
        };
        take(limits_.gap_mm, 0);
        take(limits_.hole_mm, 1);
        for (const auto& [name, limit] : all) {
            const uint8_t code = name.empty() ? 0 : code_of(name);
            if (!name.empty() && code == 0) continue;
            gaps_of(name, code, limit[0], limit[1]);
        }
    }

    /// What is narrower than the limit for holes is one, or a gap; what is narrower than that for gaps is one, whatever
    /// its shape, unless it is a hole already.
    void gaps_of(const std::string& name, uint8_t code, double gap, double hole) {
        const auto is_open = [&](uint8_t c) { return code == 0 ? !is_solid(c) : c != code; };
        const std::function<bool(const Vec3i&)> open_at = [&](const Vec3i& p) {
            return !print_.codes.holds(p.x, p.y, p.z) ||
                   is_open(print_.codes.values[print_.codes.at(p.x, p.y, p.z)]);
        };
        std::vector<Vec3i> in_holes;
        std::vector<inspection::Thin> gaps;
        if (hole > 0) {
            for (inspection::Thin& one : thin(bits_of(is_open), 1, hole)) {
                if (is_mostly_hole(one, open_at, hole)) {
                    in_holes.insert(in_holes.end(), one.voxels.begin(), one.voxels.end());
                    add(Fault::kHole, name, one.thickness_mm, hole, one.where,
                        std::move(one.voxels));
                } else if (gap == hole) {
                    gaps.push_back(std::move(one));
                }
            }
        }
        if (gap > 0 && gap != hole) {
            std::sort(in_holes.begin(), in_holes.end(), before);
            gaps = thin(bits_of(is_open), 1, gap);
            std::erase_if(gaps, [&](const inspection::Thin& one) {
                const auto count =
                    std::count_if(one.voxels.begin(), one.voxels.end(), [&](const Vec3i& p) {
                        return std::binary_search(in_holes.begin(), in_holes.end(), p, before);
                    });
                return 2 * count > static_cast<ptrdiff_t>(one.voxels.size());
            });
        }
        for (inspection::Thin& one : gaps)
            add(Fault::kGap, name, one.thickness_mm, gap, one.where, std::move(one.voxels));
    }
    static bool before(const Vec3i& a, const Vec3i& b) {
        return std::array{a.z, a.y, a.x} < std::array{b.z, b.y, b.x};
    }
    bool is_mostly_hole(const inspection::Thin& thin,
                        const std::function<bool(const Vec3i&)>& open_at, double limit) const {
        // The diagonal of a square hole is longer than its side.
        constexpr double kLonger = 1.5;
        const auto count =
            std::count_if(thin.middles.begin(), thin.middles.end(), [&](const Vec3i& p) {
                return inspection::is_hole(open_at, print_.info.pitch_mm, p, kLonger * limit);
            });
        return 2 * count >= static_cast<ptrdiff_t>(thin.middles.size());
    }

    /// Returns the voxels of clusters that are wanted, in order of z, y, x.
    static std::vector<std::vector<Vec3i>> voxels_of(const Box<int32_t>& labels,
                                                     const std::vector<Cluster>& all,
                                                     const std::vector<bool>& wanted) {
        std::vector<std::vector<Vec3i>> out(wanted.size());
        const auto look = [&](const Box3i& where, const auto& is) {
            for (int32_t z = where.lo.z; z < where.hi.z; ++z) {
                for (int32_t y = where.lo.y; y < where.hi.y; ++y) {
                    for (int32_t x = where.lo.x; x < where.hi.x; ++x) {
                        const int32_t label = labels.values[labels.at(x, y, z)];
                        if (label > 0 && is(static_cast<size_t>(label - 1)))
                            out[static_cast<size_t>(label - 1)].push_back({x, y, z});
                    }
                }
            }
        };
        // In their boxes, unless these overlap so much that all together are more than the whole.
        double voxels = 0;
        for (size_t i = 0; i < wanted.size(); ++i) {
            const Vec3i size = all[i].box.size();
            if (wanted[i]) voxels += double{1} * size.x * size.y * size.z;
        }
        if (voxels > static_cast<double>(labels.values.size())) {
            look({{0, 0, 0}, labels.size}, [&](size_t of) { return wanted[of]; });
            return out;
        }
        for (size_t i = 0; i < wanted.size(); ++i) {
            if (wanted[i]) look(all[i].box, [&](size_t of) { return of == i; });
        }
        return out;
    }

    /// Whether a cluster is less than a voxel of the machine, and touches a larger one with an edge or a corner: that
    /// is how parts of voxels show a sharp tip.
    bool is_tip(const Box<int32_t>& labels, const std::vector<Cluster>& all, size_t cluster,
                const std::vector<Vec3i>& voxels) const {
        const int64_t whole = int64_t{print_.parts} * print_.parts * print_.parts;
        if (all[cluster].voxels >= whole) return false;
        return std::any_of(voxels.begin(), voxels.end(), [&](const Vec3i& p) {
            for (int32_t i = 0; i < 27; ++i) {
                const Vec3i q = p + Vec3i{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
                if (!labels.holds(q.x, q.y, q.z)) continue;
                const int32_t other = labels.values[labels.at(q.x, q.y, q.z)] - 1;
                if (other >= 0 && all[static_cast<size_t>(other)].voxels > all[cluster].voxels)
                    return true;
            }
            return false;
        });
    }

    void islands() {
        for_limits(limits_.island_mm3, [&](const std::string& name, const Bits& bits,
                                           double limit) {
            Box<int32_t> labels;
            const std::vector<Cluster> all = components(bits, inspection::Touch::kFaces, &labels);
            std::vector<bool> small;
            for (const Cluster& one : all)
                small.push_back(static_cast<double>(one.voxels) * voxel_mm3_ < limit);
            std::vector<std::vector<Vec3i>> voxels = voxels_of(labels, all, small);
            for (size_t i = 0; i < all.size(); ++i)
                small[i] = small[i] && !is_tip(labels, all, i, voxels[i]);
            for (size_t i = 0; i < all.size(); ++i) {
                if (!small[i]) continue;
                add(Fault::kIsland, name, static_cast<double>(all[i].voxels) * voxel_mm3_, limit,
                    all[i], std::move(voxels[i]));
            }
        });
    }

    void trapped() {
        if (!limits_.trapped_mm3) return;
        Box<int32_t> labels;
        const std::vector<Cluster> all = components(
            bits_of([&](uint8_t c) { return !is_solid(c); }), inspection::Touch::kFaces, &labels);
        // The box has a margin of void, so that what is outside is one of them.
        std::vector<bool> inside;
        for (const Cluster& one : all)
            inside.push_back(!one.at_border);
        std::vector<std::vector<Vec3i>> voxels = voxels_of(labels, all, inside);
        for (size_t i = 0; i < all.size(); ++i) {
            if (!inside[i]) continue;
            const bool has_support =
                std::any_of(voxels[i].begin(), voxels[i].end(), [&](const Vec3i& p) {
                    return print_.codes.values[print_.codes.at(p.x, p.y, p.z)] != 0;
                });
            const double mm3 = static_cast<double>(all[i].voxels) * voxel_mm3_;
            if (!(mm3 > *limits_.trapped_mm3)) continue;
            const Fault fault = has_support ? Fault::kTrappedSupport : Fault::kTrappedVoid;
            add(fault, "", mm3, *limits_.trapped_mm3, all[i], std::move(voxels[i]));
        }
    }

    void touching() {
        for (const auto& [one, other] : limits_.apart) {
            const uint8_t a = code_of(one), b = code_of(other);
            if (a == 0 || b == 0 || a == b) continue;
            const Box<uint8_t>& codes = print_.codes;
            Bits bits(codes.size);
            for (int32_t z = 0; z < codes.size.z; ++z) {
                for (int32_t y = 0; y < codes.size.y; ++y) {
                    for (int32_t x = 0; x < codes.size.x; ++x) {
                        const uint8_t here = codes.values[codes.at(x, y, z)];
                        if (here != a && here != b) continue;
                        for (const Vec3i& d : {Vec3i{1, 0, 0}, Vec3i{0, 1, 0}, Vec3i{0, 0, 1}}) {
                            if (!codes.holds(x + d.x, y + d.y, z + d.z)) continue;
                            const size_t next = codes.at(x + d.x, y + d.y, z + d.z);
                            if (codes.values[next] != (here == a ? b : a)) continue;
                            bits.values[bits.at(x, y, z)] = bits.values[next] = 1;
                        }
                    }
                }
            }
            Box<int32_t> labels;
            const std::vector<Cluster> all = components(bits, inspection::Touch::kCorners, &labels);
            std::vector<std::vector<Vec3i>> voxels =
                voxels_of(labels, all, std::vector<bool>(all.size(), true));
            for (size_t i = 0; i < all.size(); ++i)
                add(Fault::kTouch, fmt::format("{}` and `{}", one, other),
                    static_cast<double>(all[i].voxels), 0, all[i], std::move(voxels[i]));
        }
    }

    const CheckedPrint& print_;
    const world::Checks& limits_;
    std::vector<std::string>* notes_;
    double voxel_mm3_;
    std::vector<Finding> found_;
};

}  // namespace

const char* name_of(Fault fault) {
    switch (fault) {
        case Fault::kWall:
            return "wall";
        case Fault::kGap:
            return "gap";
        case Fault::kHole:
            return "hole";
        case Fault::kIsland:
            return "island";
        case Fault::kTrappedVoid:
            return messages::kTrappedVoid;
        case Fault::kTrappedSupport:
            return messages::kTrappedSupport;
        case Fault::kTouch:
            return "touch";
    }
    return "";
}

const char* unit_of(Fault fault) {
    switch (fault) {
        case Fault::kWall:
        case Fault::kGap:
        case Fault::kHole:
            return "mm";
        case Fault::kIsland:
        case Fault::kTrappedVoid:
        case Fault::kTrappedSupport:
            return "mm3";
        case Fault::kTouch:
            return "voxels";
    }
    return "";
}

int64_t check_bytes(const Vec3i& size, const Vec3d& pitch_mm, int32_t parts,
                    const world::Checks& limits) {
    double largest = 0;
    for (const world::ByMaterial* of : {&limits.gap_mm, &limits.hole_mm}) {
        largest = std::max(largest, of->others.value_or(0));
        for (const auto& [name, limit] : of->named)
            largest = std::max(largest, limit);
    }
    int64_t larger = 1, voxels = 1;
    const Vec3i margin =
        inspection::thin_margin(1, pitch_mm, std::max(ball_of(largest, pitch_mm, parts), 0.0));
    for (int axis = 0; axis < 3; ++axis) {
        voxels *= int64_t{size[axis]} + 2;
        larger *= int64_t{size[axis]} + 2 + (largest > 0 ? 2 * int64_t{margin[axis]} : 2);
    }
    return voxels + larger * (kCheckBytesPerVoxel - 1);
}

Result<std::vector<Finding>> find_faults(const CheckedPrint& print, const world::Checks& limits,
                                         std::vector<std::string>* notes,
                                         const std::function<void(const char*, int, int)>& begins) {
    return Finder(print, limits, notes).run(begins);
}

}  // namespace openfab::tools
