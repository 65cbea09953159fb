// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/crossings/random_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "runtime/part/messages.h"
#include "tests/crossings/solid.h"

namespace openfab::testing {

namespace {

/// The kinds of geometry; each with its fablet.
enum class Made : uint8_t { kBox, kFile, kMoved, kDeclared, kUndeclared, kBeams, kGrown, kProgram };

class Maker {
  public:
    explicit Maker(uint64_t seed) : random_(seed) {}

    RandomWorld make() {
        world_.voxel_mm = std::array{0.15, 0.2, 0.25, 0.3}[pick(4)];
        world_.draft = chance(0.15) ? 2 : 1;
        turns_ = chance(0.6);
        const size_t objects = 1 + pick(3);
        const bool grouped = chance(0.4);
        std::string items;
        PoseStep outer;
        std::string placed;
        if (grouped) placed = pose(&outer, false);
        std::string group_uniforms;
        for (size_t k = 0; k < objects; ++k) {
            PoseStep own;
            const size_t first = world_.parts.size();
            const std::string item = object(k, &own, &group_uniforms, grouped);
            items += (k > 0 ? ", " : "") + item;
            for (size_t i = first; i < world_.parts.size(); ++i) {
                RandomPart& part = world_.parts[i];
                part.pose.push_back(own);
                if (grouped) part.pose.push_back(outer);
                for (const PoseStep& step : part.pose) {
                    for (int a = 0; a < 3; ++a)
                        part.stretch[a] *= std::fabs(step.scale[a]);
                }
                part.uneven = part.stretch.x != part.stretch.y || part.stretch.y != part.stretch.z;
            }
        }
        std::string build = items;
        if (grouped) {
            groups_ = fmt::format(R"(, "groups": {{"g": [{}]}})", items);
            build = fmt::format(
                R"({{"group": "g"{}{}}})", placed,
                group_uniforms.empty() ? "" : ", \"uniforms\": {" + group_uniforms.substr(2) + "}");
        }
        world_.text = fmt::format(
            R"({{"openfab": 1, "printer": "generic", "fablets": {{{}}},
"materials": {{"m1": {{"key": "#101010"}}, "m2": {{"key": "#c02020"}}, "m3": {{"key": "#2020c0"}}, "m4": {{"key": "#20c020"}}}},
"meshes": {{{}}},
"objects": {{{}}}{},
"build": [{}]}}
)",
            fablets_, meshes_, objects_, groups_, build);
        return std::move(world_);
    }

  private:
    size_t pick(size_t n) { return random_() % n; }
    bool chance(double p) { return static_cast<double>(random_() % 100000) < p * 100000; }
    /// With three decimals, so that text says it exactly.
    double number(double least, double most) {
        const double share = static_cast<double>(random_() % 1000001) * 1e-6;
        return std::round((least + share * (most - least)) * 1000) / 1000;
    }
    Vec3d point(double size) {
        const double x = number(-size, size), y = number(-size, size);
        return {x, y, number(-size, size)};
    }
    static std::string list(const Vec3d& v) {
        return fmt::format("[{:.10g}, {:.10g}, {:.10g}]", v.x, v.y, v.z);
    }

    /// Members of a placement, after a comma.
    std::string pose(PoseStep* step, bool stretches) {
        std::string out;
        if (chance(0.5)) {
            const double s = number(0.7, 1.4);
            step->scale = {s, s, s};
            if (stretches && chance(0.25)) step->scale = {s, number(0.7, 1.4), number(0.7, 1.4)};
            if (chance(0.3)) step->scale[static_cast<int>(pick(3))] *= -1;
            out += ", \"scale\": " + list(step->scale);
        }
        if (turns_ && chance(0.7)) {
            step->rotate_deg = {number(-180, 180), number(-180, 180), number(-180, 180)};
            if (chance(0.2)) step->rotate_deg = {0, 90, 180};
            out += ", \"rotate_deg\": " + list(step->rotate_deg);
        }
        step->translate_mm = point(1.5);
        return out + ", \"translate_mm\": " + list(step->translate_mm);
    }

    struct Sizes {
        int solid = 0;
        Vec3d from, to;
        double low = 0, high = 0;
        Vec3d least, most;  ///< its box
    };

    Sizes sizes(int solid) {
        Sizes s;
        s.solid = solid;
        s.from = point(1.2);
        if (solid == 0) {
            for (int a = 0; a < 3; ++a)
                s.to[a] = s.from[a] + number(0.9, 3);
            s.low = s.high = 0.1;
            s.least = s.from;
            s.most = s.to;
            return s;
        }
        s.to = s.from + Vec3d{number(0.8, 2), number(-1.5, 1.5), number(-1, 1)};
        s.low = number(0.5, 1.1);
        s.high = number(0.5, 1.1);
        if (solid == 2) {
            s.low = number(1, 1.8);
            s.high = number(0.4, 0.8);
            const double r = s.low + s.high;
            s.least = s.from - Vec3d{r, r, s.high};
            s.most = s.from + Vec3d{r, r, s.high};
            return s;
        }
        const double r = std::max(s.low, s.high);
        for (int a = 0; a < 3; ++a) {
            s.least[a] = std::min(s.from[a], s.to[a]) - r;
            s.most[a] = std::max(s.from[a], s.to[a]) + r;
        }
        return s;
    }

    static std::function<double(const Vec3d&)> distance_of(const Sizes& s) {
        if (s.solid == 0) {
            return [s](const Vec3d& p) {
                double outside = 0, most = -1e30;
                for (int a = 0; a < 3; ++a) {
                    const double d = std::max(s.from[a] - p[a], p[a] - s.to[a]);
                    outside += std::max(d, 0.0) * std::max(d, 0.0);
                    most = std::max(most, d);
                }
                return most < 0 ? most : std::sqrt(outside);
            };
        }
        if (s.solid == 2) {
            return [s](const Vec3d& p) {
                return std::hypot(std::hypot(p.x - s.from.x, p.y - s.from.y) - s.low,
                                  p.z - s.from.z) -
                       s.high;
            };
        }
        return [s](const Vec3d& p) {
            const double cone = hull_distance({s.from, s.to, s.low, s.high}, p);
            if (s.solid != 3) return cone;
            return std::min(cone, length(p - Vec3d{s.from.x, s.to.y, s.from.z}) - s.high);
        };
    }

    std::string box_around(const Sizes& s) {
        Vec3d low, high;
        for (int a = 0; a < 3; ++a) {
            low[a] = s.least[a] - number(0.05, chance(0.3) ? 2 : 0.3);
            high[a] = s.most[a] + number(0.05, chance(0.3) ? 2 : 0.3);
        }
        return fmt::format(R"("box_mm": [{}, {}])", list(low), list(high));
    }

    static std::string box_lines(const Sizes& s, const Vec3d& by, const char* vertex,
                                 const char* face, int first) {
        std::string out;
        for (int i = 0; i < 8; ++i) {
            out += fmt::format("{}{:.12g} {:.12g} {:.12g}\n", vertex,
                               ((i & 1) != 0 ? s.to.x : s.from.x) / by.x,
                               ((i & 2) != 0 ? s.to.y : s.from.y) / by.y,
                               ((i & 4) != 0 ? s.to.z : s.from.z) / by.z);
        }
        constexpr int kFaces[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                       {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                       {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
        for (const auto& f : kFaces)
            out += fmt::format("{}{} {} {}\n", face, f[0] + first, f[1] + first, f[2] + first);
        return out;
    }

    /// Lines of beams: with `strut` those of a file, else those of a program's answer.
    static std::string beam_lines(const Sizes& s, bool strut) {
        const Vec3d ball{s.from.x, s.to.y, s.from.z};
        if (!strut) {
            std::string out = fmt::format("beam {} {} {} {} {} {} {} {}\n", s.from.x, s.from.y,
                                          s.from.z, s.to.x, s.to.y, s.to.z, s.low, s.high);
            if (s.solid == 3)
                out += fmt::format("beam {0} {1} {2} {0} {1} {2} {3} {3}\n", ball.x, ball.y, ball.z,
                                   s.high);
            return out;
        }
        std::string out = fmt::format("node {} {} {} {}\nnode {} {} {} {}\n", s.from.x, s.from.y,
                                      s.from.z, s.low, s.to.x, s.to.y, s.to.z, s.high);
        if (s.solid == 3) out += fmt::format("node {} {} {} {}\n", ball.x, ball.y, ball.z, s.high);
        return out + "strut 0 1\n" + (s.solid == 3 ? "ball 2\n" : "");
    }

    /// Makes an object, and its item of a placement.
    std::string object(size_t k, PoseStep* own, std::string* group_uniforms, bool grouped) {
        const bool program = chance(0.04);
        const auto made = program ? Made::kProgram : static_cast<Made>(pick(7));
        const bool boxes = made == Made::kBox || made == Made::kFile || made == Made::kMoved;
        const bool shape = made == Made::kDeclared || made == Made::kUndeclared;
        Sizes s = sizes(boxes                    ? 0
                        : shape                  ? static_cast<int>(pick(4))
                        : made == Made::kProgram ? static_cast<int>(std::array{0, 1, 3}[pick(3)])
                                                 : (chance(0.5) ? 1 : 3));
        RandomPart part;
        std::string mesh, fablet = "Plain", values;
        switch (made) {
            case Made::kBox: {
                // It stands on z = 0, in the middle.
                const Vec3d size = s.to - s.from;
                s.from = {-size.x / 2, -size.y / 2, 0};
                s.to = {size.x / 2, size.y / 2, size.z};
                mesh = fmt::format(R"({{"box": {}}})", list(size));
                break;
            }
            case Made::kFile:
            case Made::kMoved: {
                Vec3d by{1, 1, 1};
                if (made == Made::kMoved) {
                    const Vec3d push = point(0.25);
                    by = by + push;
                    fablet = "Moved";
                    values = ", \"push\": " + list(push);
                }
                const std::string file = fmt::format("box{}.obj", k);
                world_.files[file] = box_lines(s, by, "v ", "f ", 1);
                mesh = fmt::format(R"({{"file": "{}", "unit": "mm"}})", file);
                break;
            }
            case Made::kBeams: {
                const std::string file = fmt::format("beams{}.txt", k);
                world_.files[file] = beam_lines(s, true);
                mesh = fmt::format(R"({{"beams": "{}"}})", file);
                break;
            }
            case Made::kProgram: {
                world_.programs = true;
                const std::string file = fmt::format("answer{}.txt", k);
                world_.files[file] =
                    (s.solid == 0 ? "mesh 8 12\n" + box_lines(s, {1, 1, 1}, "", "", 0)
                                  : beam_lines(s, false)) +
                    "done\n";
                mesh = fmt::format(
                    R"({{"program": ["sh", "-c", "while read line; do cat {}; done"], {}}})", file,
                    box_around(s));
                break;
            }
            default:
                fablet = made == Made::kDeclared     ? "Declared"
                         : made == Made::kUndeclared ? "Undeclared"
                                                     : "Grown";
                mesh = fmt::format(R"({{"{}": "f{}", {}}})",
                                   made == Made::kGrown ? "grow" : "shape", k, box_around(s));
                values =
                    fmt::format(R"(, "solid": {}, "from": {}, "to": {}, "low": {}, "high": {})",
                                s.solid, list(s.from), list(s.to), s.low, s.high);
        }
        part.distance = distance_of(s);
        part.pattern = static_cast<int>(pick(4));
        part.skin = number(0.15, 0.5);
        part.width = number(0.3, 1.2);
        part.along = point(1);
        for (uint8_t& code : part.codes)
            code = static_cast<uint8_t>(1 + pick(4));
        part.priority = static_cast<int>(pick(3)) - 1;
        if (made == Made::kUndeclared) {
            // Next to edges of a box cells are cut. Within a union the surface is farther than the deepest member's says,
            // so nothing is known.
            part.depth_voxels = s.solid == 3 ? 1e9 : s.solid == 0 ? 1 : 0.25;
            part.radius_mm = std::min(s.low, s.high);
        }
        values += fmt::format(R"(, "pattern": {}, "skin": {}, "along": {}, "width": {})",
                              part.pattern, part.skin, list(part.along), part.width);
        const std::string item =
            item_of(k, part, s, made, values, fablet, own, group_uniforms, grouped);
        const char* comma = k > 0 ? ", " : "";
        meshes_ += fmt::format(R"({}"s{}": {})", comma, k, mesh);
        return item;
    }

    /// Places it, and routes its values: by its object, fablet, placement, group or settings.
    std::string item_of(size_t k, RandomPart part, const Sizes& s, Made made,
                        const std::string& values, const std::string& fablet, PoseStep* own,
                        std::string* group_uniforms, bool grouped) {
        const size_t route = pick(grouped ? 4 : 3);
        const char* comma = k > 0 ? ", " : "";
        fablets_ +=
            fmt::format(R"({}"f{}": {{"source": "random_worlds.fl", "fablet": "{}"{}}})", comma, k,
                        fablet, route == 1 ? ", \"uniforms\": {" + values.substr(2) + "}" : "");
        std::string pieces;
        if (chance(0.3)) {
            part.normal = point(1);
            if (length(part.normal) < 0.3) part.normal = {0, 0, 1};
            const Vec3d unit = part.normal * (1 / length(part.normal));
            // Through the middle of the solid, or next to it.
            const Vec3d inside = s.solid == 0   ? (s.from + s.to) * 0.5
                                 : s.solid == 2 ? s.from + Vec3d{s.low, 0, 0}
                                                : s.from;
            part.at = std::round((dot(unit, inside) + number(-0.2, 0.2)) * 1000) / 1000;
            part.side = chance(0.5) ? 1 : -1;
            pieces = fmt::format(R"(, "pieces": {{"normal": {}, "at_mm": {}}})", list(part.normal),
                                 part.at);
            part.normal = unit;
        }
        objects_ += fmt::format(
            R"({}"o{}": {{"mesh": "s{}", "fablet": "f{}", "priority": {}, "uniforms": {{"shell": "m{}", "left": "m{}", "right": "m{}"{}}}{}}})",
            comma, k, k, k, part.priority, part.codes[0], part.codes[1], part.codes[2],
            route == 0 ? values : "", pieces);
        const std::string at = pose(own, true);
        if (route == 3) {
            std::string named = values;
            for (size_t i = 0; (i = named.find(", \"", i)) != std::string::npos; i += 3)
                named.insert(i + 3, fmt::format("o{}.", k));
            *group_uniforms += named;
        }
        const Vec3d& scale = own->scale;
        const bool even =
            std::fabs(scale.x) == std::fabs(scale.y) && std::fabs(scale.y) == std::fabs(scale.z);
        if (!even && (made == Made::kBeams || made == Made::kGrown || made == Made::kProgram))
            world_.refusals.push_back(part::messages::kUnevenStretch);
        world_.parts.push_back(part);
        return fmt::format(
            R"({{"object": "o{}"{}{}{}}})", k, at,
            part.side == 0 ? "" : fmt::format(R"(, "piece": "{}")", part.side < 0 ? 1 : 2),
            route == 2 ? ", \"uniforms\": {" + values.substr(2) + "}" : "");
    }

    std::mt19937_64 random_;
    RandomWorld world_;
    bool turns_ = false;
    std::string fablets_, meshes_, objects_, groups_;
};

/// Takes a step back.
Vec3d undo(const PoseStep& step, Vec3d p) {
    p = p - step.translate_mm;
    for (int axis = 2; axis >= 0; --axis) {
        const double turn = -step.rotate_deg[axis] * M_PI / 180;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const double pu = p[u], pv = p[v];
        p[u] = std::cos(turn) * pu - std::sin(turn) * pv;
        p[v] = std::sin(turn) * pu + std::cos(turn) * pv;
    }
    return {p.x / step.scale.x, p.y / step.scale.y, p.z / step.scale.z};
}

/// 1 inside, 0 outside, -1 too near to tell.
int inside(const RandomPart& part, const Vec3d& p, double pitch_mm) {
    const double least = std::min({part.stretch.x, part.stretch.y, part.stretch.z});
    const double margin = 0.012 * pitch_mm / least;
    const double d = part.distance(p);
    int in = d < -margin ? 1 : d > margin ? 0 : -1;
    if (part.side != 0 && in != 0) {
        const double over = part.side * (dot(part.normal, p) - part.at);
        if (over < -1e-6) return 0;
        if (over < 1e-6) in = -1;
    }
    return in;
}

int code_in(const RandomPart& part, const Vec3d& p, double pitch_mm) {
    if ((part.pattern & 1) != 0) {
        // Of a stretched solid other than a box the depth is not known.
        const double scale = part.stretch.x;
        const double over = -part.distance(p) * scale - part.skin;
        // The longest edge of a micropolygon is a diagonal of a cell.
        const double chord = 3 * pitch_mm * pitch_mm / (8 * part.radius_mm * scale);
        const double margin = (0.015 + part.depth_voxels) * pitch_mm + chord + 2e-3;
        if (part.uneven || std::fabs(over) < margin) {
            return part.codes[0] == part.codes[1] && part.codes[1] == part.codes[2] ? part.codes[0]
                                                                                    : -1;
        }
        if (over < 0) return part.codes[0];
    }
    if ((part.pattern & 2) == 0) return part.codes[2];
    const Vec3d there{p.x * part.stretch.x, p.y * part.stretch.y, p.z * part.stretch.z};
    const double stripes = dot(there, part.along) / part.width;
    if (std::fabs(stripes - std::round(stripes)) * part.width < 1e-4) return -1;
    return (static_cast<int64_t>(std::floor(stripes)) & 1) != 0 ? part.codes[1] : part.codes[2];
}

}  // namespace

RandomWorld random_world(uint64_t seed) {
    return Maker(seed).make();
}

int expected_code(const std::vector<RandomPart>& parts, const Vec3d& centre_mm, double pitch_mm) {
    const RandomPart* owner = nullptr;
    Vec3d at;
    int doubt = -1000;  // the highest priority of what may be there, too
    for (const RandomPart& part : parts) {
        Vec3d p = centre_mm;
        for (size_t i = part.pose.size(); i-- > 0;)
            p = undo(part.pose[i], p);
        const int in = inside(part, p, pitch_mm);
        if (in < 0) doubt = std::max(doubt, part.priority);
        if (in > 0 && (owner == nullptr || part.priority >= owner->priority)) {
            owner = &part;
            at = p;
        }
    }
    if (owner == nullptr) return doubt > -1000 ? -1 : 0;
    if (doubt >= owner->priority) return -1;
    return code_in(*owner, at, pitch_mm);
}

}  // namespace openfab::testing
