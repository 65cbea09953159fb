// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_paint.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <unordered_map>
#include <utility>
#include <vector>

#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

using Corners = std::array<int32_t, 3>;

/// Slicers stop at parts of a nozzle's width; halves of halves beyond this are damage.
constexpr int kMaxDepth = 32;
constexpr int kMostFilaments = 1000;

/// A part of a triangle that is of one filament.
struct Leaf {
    Corners corners{};
    int16_t filament = 0;
};

/// Decodes the paint of an object and divides its triangles.
class Painter {
  public:
    Painter(ThreemfObject* object, const std::string& place, int64_t* memory_bytes)
        : object_(*object), place_(place), memory_bytes_(*memory_bytes) {}

    Result<void> paint(ThreemfTold* told) {
        object_.filaments.assign(object_.triangles.size(), 0);
        take(object_.triangles.size() * sizeof(int16_t));
        const bool divided = std::any_of(object_.paints.begin(), object_.paints.end(),
                                         [](const auto& one) { return is_divided(one.second); });
        const bool interpolates = std::any_of(
            object_.triangles.begin(), object_.triangles.end(), [](const ThreemfTriangle& t) {
                return t.properties[0] != t.properties[1] || t.properties[0] != t.properties[2];
            });
        if (divided && !interpolates) weld();
        std::vector<std::pair<int32_t, std::vector<Leaf>>> leaves;
        for (const auto& [triangle, code] : object_.paints) {
            const Corners corners = object_.triangles[static_cast<size_t>(triangle)].vertices;
            triangle_ = triangle;
            code_ = code;
            if (!is_divided(code)) {
                const int filament = leaf(next());
                if (!wrong_.empty()) return error();
                object_.filaments[static_cast<size_t>(triangle)] = static_cast<int16_t>(filament);
            } else if (interpolates) {
                told->add(messages::kPaintAndColours, place_, messages::kPaintAndColoursHelp);
            } else if (corners[0] != corners[1] && corners[1] != corners[2] &&
                       corners[2] != corners[0]) {
                leaves.emplace_back(triangle, std::vector<Leaf>());
                decode(corners, 0, &leaves.back().second);
                if (!wrong_.empty()) return error();
            }
        }
        if (!leaves.empty()) divide(leaves);
        return wrong_.empty() ? Result<void>(Ok{}) : error();
    }

  private:
    Error error() const {
        return user_error(fmt::format(messages::kPaintWrong, place_, triangle_, wrong_));
    }

    static bool is_divided(const std::string& code) {
        return !code.empty() && (digit(code.back()) & 3) != 0;
    }

    static int digit(char c) {
        if (c >= '0' && c <= '9') return c - '0';
        if (c >= 'A' && c <= 'F') return c - 'A' + 10;
        if (c >= 'a' && c <= 'f') return c - 'a' + 10;
        return 0;
    }

    /// Digits are read from the last to the first.
    int next() {
        if (code_.empty()) {
            if (wrong_.empty()) wrong_ = messages::kPaintEndsTooEarly;
            return 0;
        }
        const char c = code_.back();
        if (digit(c) == 0 && c != '0' && wrong_.empty()) wrong_ = messages::kPaintNotHexadecimal;
        code_.pop_back();
        return digit(c);
    }

    /// The filament of a part that is not divided: 0 the volume's own. Those from 3 are another
    /// digit, where 15 means that more follow; or where 14 means two, the low one first, from 17.
    int leaf(int code) {
        if (code >> 2 != 3) return code >> 2;
        int filament = 3;
        if (object_.paint_escapes) {
            const int first = next();
            if (first != 14) return filament + first;
            const int low = next();
            return 17 + low + 16 * next();
        }
        for (int more = next();; more = next()) {
            filament += more;
            if (filament > kMostFilaments) wrong_ = messages::kPaintOfNoFilament;
            if (more != 15 || !wrong_.empty()) return filament;
        }
    }

    /// A digit's two low bits are the number of sides that are halved, the others the side that is
    /// special: that opposite of corner a if one is halved, and the one that is whole if two are.
    /// Children follow, the last first.
    void decode(const Corners& corners, int depth, std::vector<Leaf>* out) {
        const int code = next();
        const auto side = static_cast<size_t>(code >> 2);
        if (depth > kMaxDepth) wrong_ = messages::kPaintTooFine;
        if ((code & 3) != 0 && side == 3 && wrong_.empty()) wrong_ = messages::kPaintOfNoSide;
        if (!wrong_.empty()) return;
        if ((code & 3) == 0) {
            const int filament = leaf(code);
            if (!wrong_.empty()) return;
            take(sizeof(Leaf));
            out->push_back({corners, static_cast<int16_t>(filament)});
            return;
        }
        const int32_t a = corners[side], b = corners[(side + 1) % 3], c = corners[(side + 2) % 3];
        std::array<Corners, 4> children{};
        const auto count = static_cast<size_t>((code & 3) + 1);
        if (count == 2) {
            const int32_t bc = middle(b, c);
            children = {{{a, b, bc}, {bc, c, a}}};
        } else if (count == 3) {
            const int32_t ab = middle(a, b), ca = middle(c, a);
            children = {{{a, ab, ca}, {ab, b, ca}, {b, c, ca}}};
        } else {
            const int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            children = {{{a, ab, ca}, {ab, b, bc}, {bc, c, ca}, {ab, bc, ca}}};
        }
        for (size_t i = count; i-- > 0 && wrong_.empty();)
            decode(children[i], depth + 1, out);
    }

    static uint64_t key(int32_t a, int32_t b) {
        return static_cast<uint64_t>(std::min(a, b)) << 32 | static_cast<uint64_t>(std::max(a, b));
    }

    /// Adds the middle of an edge, which all triangles share.
    int32_t middle(int32_t a, int32_t b) {
        const auto [it, fresh] =
            middles_.try_emplace(key(a, b), static_cast<int32_t>(object_.vertices.size()));
        if (fresh) {
            constexpr size_t kNode = 64;
            take(sizeof(Vec3d) + kNode);
            object_.vertices.push_back((object_.vertices[static_cast<size_t>(a)] +
                                        object_.vertices[static_cast<size_t>(b)]) *
                                       0.5);
        }
        return it->second;
    }

    /// Lets triangles refer to the first of vertices at one place: neighbours need not share them.
    void weld() {
        const std::vector<Vec3d>& vertices = object_.vertices;
        const auto tuple = [&](int32_t v) {
            const Vec3d& p = vertices[static_cast<size_t>(v)];
            return std::array<double, 3>{p.x, p.y, p.z};
        };
        std::vector<int32_t> order(vertices.size());
        std::iota(order.begin(), order.end(), 0);
        std::stable_sort(order.begin(), order.end(),
                         [&](int32_t a, int32_t b) { return tuple(a) < tuple(b); });
        std::vector<int32_t> first(vertices.size());
        for (size_t i = 0; i < order.size(); ++i) {
            const bool same = i > 0 && tuple(order[i]) == tuple(order[i - 1]);
            first[static_cast<size_t>(order[i])] =
                same ? first[static_cast<size_t>(order[i - 1])] : order[i];
        }
        for (ThreemfTriangle& t : object_.triangles) {
            for (int32_t& v : t.vertices)
                v = first[static_cast<size_t>(v)];
        }
    }

    void divide(const std::vector<std::pair<int32_t, std::vector<Leaf>>>& leaves) {
        const std::vector<ThreemfTriangle> whole = std::exchange(object_.triangles, {});
        const std::vector<int16_t> filaments = std::exchange(object_.filaments, {});
        auto painted = leaves.begin();
        for (size_t t = 0; t < whole.size() && wrong_.empty(); ++t) {
            const auto number = static_cast<int32_t>(t);
            triangle_ = number;
            if (painted != leaves.end() && painted->first == number) {
                for (const Leaf& leaf : painted->second)
                    add(whole[t], number, leaf.corners, leaf.filament);
                ++painted;
            } else {
                add(whole[t], number, whole[t].vertices, filaments[t]);
            }
        }
    }

    /// Adds a triangle, divided at the middles of its edges that others use.
    void add(const ThreemfTriangle& whole, int32_t source, const Corners& corners,
             int16_t filament) {
        if (!wrong_.empty()) return;
        for (size_t side = 0; side < 3; ++side) {
            const int32_t a = corners[side], b = corners[(side + 1) % 3],
                          c = corners[(side + 2) % 3];
            const auto it = middles_.find(key(a, b));
            if (it == middles_.end()) continue;
            add(whole, source, {a, it->second, c}, filament);
            add(whole, source, {it->second, b, c}, filament);
            return;
        }
        take(sizeof whole + sizeof source + sizeof filament);
        object_.triangles.push_back(whole);
        object_.triangles.back().vertices = corners;
        object_.filaments.push_back(filament);
        object_.sources.push_back(source);
    }

    /// Lists double, and are copied then.
    void take(size_t bytes) {
        memory_bytes_ -= static_cast<int64_t>(3 * bytes);
        if (memory_bytes_ < 0 && wrong_.empty()) wrong_ = messages::kPaintTakesTooMuch;
    }

    ThreemfObject& object_;
    const std::string& place_;
    int64_t& memory_bytes_;
    int32_t triangle_ = 0;  ///< of the file
    std::string code_;
    std::string wrong_;
    std::unordered_map<uint64_t, int32_t> middles_;  ///< by edge
};

}  // namespace

Result<void> apply_threemf_paint(ThreemfObject* object, const std::string& place,
                                 int64_t* memory_bytes, ThreemfTold* told) {
    if (object->paints.empty()) return Ok{};
    return Painter(object, place, memory_bytes).paint(told);
}

}  // namespace openfab::mesh
