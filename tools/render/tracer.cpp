// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/check.h"
#include "tools/render/dielectric.h"

namespace openfab::render {

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kPi = std::numbers::pi;

/// Weights below are played for, so that paths through dark materials end.
constexpr double kLight = 0.1;
/// From so many surfaces on, some paths end whatever they weigh: total reflection can catch light that
/// nothing absorbs.
constexpr int32_t kManySurfaces = 64;
constexpr double kGoesOn = 0.9;

double mean(const Rgb& rgb) {
    return (rgb[0] + rgb[1] + rgb[2]) * (1.0 / 3);
}

Rgb operator*(const Rgb& a, double s) {
    return {a[0] * s, a[1] * s, a[2] * s};
}

/// A cosine of Henyey and Greenstein's phase function.
double scattering_cosine(double g, double u) {
    if (std::abs(g) < 1e-3) return 1 - 2 * u;
    const double s = (1 - g * g) / (1 - g + 2 * g * u);
    return std::clamp((1 + g * g - s * s) / (2 * g), -1.0, 1.0);
}

double interpolate(const std::array<int32_t, 8>& c, double x, double y, double z) {
    const auto along = [&](size_t i) { return c[i] + x * (c[i + 1] - c[i]); };
    const double low = along(0) + y * (along(2) - along(0));
    const double high = along(4) + y * (along(6) - along(4));
    return low + z * (high - low);
}

}  // namespace

/// Where a ray leaves boxes; `inverse` is 1 / step.
struct Tracer::Exits {
    Vec3d inverse;
    explicit Exits(const Vec3d& step) {
        for (int a = 0; a < 3; ++a)
            inverse[a] = step[a] != 0 ? 1 / step[a] : kFar;
    }
    /// Returns the first of the three, in mm from `at`, and its axis.
    double next(const Vec3d& at, const Vec3d& step, const Vec3d& low, double side,
                int* axis) const {
        double first = kFar;
        for (int a = 0; a < 3; ++a) {
            if (step[a] == 0) continue;
            const double t = (low[a] + (step[a] > 0 ? side : 0) - at[a]) * inverse[a];
            if (t < first) {
                first = t;
                *axis = a;
            }
        }
        return first;
    }
};

Tracer::Tracer(const Volume* volume, const Optics& optics, Scene scene, int32_t macro_blocks)
    : volume_(*volume), scene_(std::move(scene)), surface_(optics.surface) {
    for (const MaterialOptics& one : optics.by_code) {
        Material material{};
        for (size_t c = 0; c < 3; ++c) {
            material.extinction[c] = one.extinction[c];
            material.scattering[c] = one.extinction[c] * one.albedo[c];
        }
        material.anisotropy = one.anisotropy;
        materials_.push_back(material);
    }
    std::vector<float> largest;
    for (const Material& one : materials_)
        largest.push_back(static_cast<float>(
            std::max({one.extinction[0], one.extinction[1], one.extinction[2]})));
    const Vec3i blocks = volume_.blocks();
    for (int32_t b = macro_blocks; b > 1; b /= 2)
        ++cell_shift_;
    OPENFAB_CHECK(macro_blocks == 1 || macro_blocks == 2 || macro_blocks == Volume::kGroup);
    cell_count_ = {blocks.x / macro_blocks, blocks.y / macro_blocks, blocks.z / macro_blocks};
    std::vector<bool> is_new(static_cast<size_t>(cell_count_.x) *
                                 static_cast<size_t>(cell_count_.y) *
                                 static_cast<size_t>(cell_count_.z),
                             true);
    cells_.resize(is_new.size());
    for (int32_t z = 0; z < blocks.z; ++z) {
        for (int32_t y = 0; y < blocks.y; ++y) {
            for (int32_t x = 0; x < blocks.x; ++x) {
                const size_t i =
                    (static_cast<size_t>(z / macro_blocks) * static_cast<size_t>(cell_count_.y) +
                     static_cast<size_t>(y / macro_blocks)) *
                        static_cast<size_t>(cell_count_.x) +
                    static_cast<size_t>(x / macro_blocks);
                Macrocell& cell = cells_[i];
                volume_.for_codes({x, y, z}, [&](uint8_t code) {
                    OPENFAB_DCHECK(code < largest.size());
                    cell.majorant = std::max(cell.majorant, largest[code]);
                });
                const Volume::Kind kind = volume_.kind({x, y, z});
                if (!is_new[i] && kind != cell.kind) {
                    cell.kind = Volume::Kind::kSurface;
                } else {
                    cell.kind = kind;
                }
                is_new[i] = false;
            }
        }
    }
    const Vec3d mm = volume_.pitch_mm();
    per_mm_ = {1 / mm.x, 1 / mm.y, 1 / mm.z};
    apart_mm_ = 1e-5 * std::min({mm.x, mm.y, mm.z});
}

void Tracer::aim(const Vec3d& direction, Ray* ray) const {
    ray->direction = direction;
    ray->step = {direction.x * per_mm_.x, direction.y * per_mm_.y, direction.z * per_mm_.z};
}

double Tracer::enter(const Ray& ray) const {
    double from = 0;
    double to = kFar;
    for (int a = 0; a < 3; ++a) {
        const double side = volume_.blocks()[a] * Volume::kSide;
        if (ray.step[a] == 0) {
            if (ray.at[a] < 0 || ray.at[a] >= side) return kFar;
            continue;
        }
        const double low = -ray.at[a] / ray.step[a];
        const double high = (side - ray.at[a]) / ray.step[a];
        from = std::max(from, std::min(low, high));
        to = std::min(to, std::max(low, high));
    }
    return from < to ? from : kFar;
}

double Tracer::coverage(const Vec3d& at) const {
    const double x = std::floor(at.x - 0.5);
    const double y = std::floor(at.y - 0.5);
    const double z = std::floor(at.z - 0.5);
    return interpolate(
        volume_.corners(static_cast<int32_t>(x), static_cast<int32_t>(y), static_cast<int32_t>(z)),
        at.x - 0.5 - x, at.y - 0.5 - y, at.z - 0.5 - z);
}

Vec3d Tracer::slope(const Vec3d& at) const {
    const double fx = std::floor(at.x - 0.5);
    const double fy = std::floor(at.y - 0.5);
    const double fz = std::floor(at.z - 0.5);
    const std::array<int32_t, 8> c = volume_.corners(
        static_cast<int32_t>(fx), static_cast<int32_t>(fy), static_cast<int32_t>(fz));
    const double x = at.x - 0.5 - fx;
    const double y = at.y - 0.5 - fy;
    const double z = at.z - 0.5 - fz;
    const auto blend = [](double a, double b, double t) { return a + t * (b - a); };
    const auto d = [&](size_t i, size_t j) { return static_cast<double>(c[j] - c[i]); };
    return {blend(blend(d(0, 1), d(2, 3), y), blend(d(4, 5), d(6, 7), y), z) * per_mm_.x,
            blend(blend(d(0, 2), d(1, 3), x), blend(d(4, 6), d(5, 7), x), z) * per_mm_.y,
            blend(blend(d(0, 4), d(1, 5), x), blend(d(2, 6), d(3, 7), x), y) * per_mm_.z};
}

Vec3d Tracer::smooth_slope(const Vec3d& at) const {
    Vec3d out;
    for (int a = 0; a < 3; ++a) {
        Vec3d high = at;
        Vec3d low = at;
        high[a] += 1;
        low[a] -= 1;
        out[a] = (coverage(high) - coverage(low)) * 0.5 * per_mm_[a];
    }
    return out;
}

/// Finds where, between two distances, the coverage passes to the other side.
bool Tracer::find_surface(const Ray& ray, const Exits& exits, double from, double to,
                          double* where) const {
    Vec3d at = ray.at + ray.step * from;
    Vec3d low;  // the dual cell
    for (int a = 0; a < 3; ++a) {
        low[a] = std::floor(at[a] - 0.5);
        // On its border it is the cell ahead.
        if (ray.step[a] < 0 && low[a] == at[a] - 0.5) low[a] -= 1;
    }
    const auto is_wrong = [&](double coverage) {
        return (coverage >= Volume::kSurface) != ray.inside;
    };
    for (double begin = from;;) {
        int axis = 0;
        const Vec3d corner = low + Vec3d{0.5, 0.5, 0.5};
        const double leaves = std::max(begin, exits.next(ray.at, ray.step, corner, 1, &axis));
        const double end = std::min(leaves, to);
        const std::array<int32_t, 8> c = volume_.corners(
            static_cast<int32_t>(low.x), static_cast<int32_t>(low.y), static_cast<int32_t>(low.z));
        int32_t full = 0;
        for (const int32_t one : c)
            full += one >= Volume::kSurface ? 1 : 0;
        const bool any = ray.inside ? full < 8 : full > 0;
        const auto value = [&](double t) {
            const Vec3d q = ray.at + ray.step * t - corner;
            return interpolate(c, q.x, q.y, q.z);
        };
        if (any && is_wrong(value(end))) {
            double right = begin;
            double wrong = end;
            for (int i = 0; i < 40 && !is_wrong(value(right)); ++i) {
                const double half = 0.5 * (right + wrong);
                (is_wrong(value(half)) ? wrong : right) = half;
                if (wrong - right < apart_mm_ * 1e-3) break;
            }
            *where = right;
            return true;
        }
        if (leaves >= to) return false;
        begin = leaves;
        low[axis] += ray.step[axis] > 0 ? 1 : -1;
    }
}

Tracer::Event Tracer::walk(double most_mm, Random* random, Ray* ray, double* majorant) const {
    double t = 0;
    const double side = 1 << cell_shift_;
    if (!ray->inside) {
        t = enter(*ray);
        if (t >= most_mm) {
            ray->at = ray->at + ray->step * std::min(most_mm, 1e9);
            return Event::kAway;
        }
    }
    const Exits exits(ray->step);
    Vec3i cell;
    Vec3d low;
    for (int a = 0; a < 3; ++a) {
        const double at = ray->at[a] + ray->step[a] * t;
        cell[a] = std::clamp(static_cast<int32_t>(at) >> cell_shift_, 0, cell_count_[a] - 1);
        low[a] = cell[a] * side;
    }
    double depth = random != nullptr ? random->exponential() : kFar;
    for (;;) {
        int axis = 0;
        const double leaves = std::max(t, exits.next(ray->at, ray->step, low, side, &axis));
        const Macrocell& here =
            cells_[(static_cast<size_t>(cell.z) * static_cast<size_t>(cell_count_.y) +
                    static_cast<size_t>(cell.y)) *
                       static_cast<size_t>(cell_count_.x) +
                   static_cast<size_t>(cell.x)];
        double end = std::min(leaves, most_mm);
        bool collides = false;
        double passed = 0;
        if (ray->inside) {
            passed = here.majorant * (end - t);
            if (passed >= depth) {
                collides = true;
                end = t + depth / here.majorant;
            }
        }
        double surface = 0;
        if (here.kind == Volume::Kind::kSurface && find_surface(*ray, exits, t, end, &surface)) {
            ray->at = ray->at + ray->step * surface;
            return Event::kSurface;
        }
        if (collides) {
            ray->at = ray->at + ray->step * end;
            *majorant = here.majorant;
            return Event::kCollision;
        }
        if (end == most_mm) {
            ray->at = ray->at + ray->step * end;
            return Event::kAway;
        }
        depth -= passed;
        t = end;
        cell[axis] += ray->step[axis] > 0 ? 1 : -1;
        if (cell[axis] < 0 || cell[axis] >= cell_count_[axis]) {
            ray->at = ray->at + ray->step * std::min(most_mm, 1e9);
            return Event::kAway;
        }
        low[axis] = cell[axis] * side;
    }
}

bool Tracer::bounce(Ray* ray, Random* random) const {
    const double to_air = ray->inside ? 1 : -1;
    const Vec3d exact = slope(ray->at);
    if (dot(exact, exact) == 0) return false;
    const Vec3d flat = normalized(exact) * -1.0;  // into the air
    const Vec3d smooth = smooth_slope(ray->at);
    // The side from which the ray comes.
    const auto facing = [&](const Vec3d& air) { return air * -to_air; };
    Vec3d normal = dot(smooth, smooth) > 0 ? normalized(smooth) * -1.0 : flat;
    const bool is_grazing = dot(ray->direction, facing(normal)) >= 0;
    if (is_grazing) normal = flat;
    Vec3d towards = facing(normal);
    // A ray along the surface, which rounding brought to its other side.
    if (dot(ray->direction, towards) >= 0) {
        aim(normalized(ray->direction - towards * (2 * dot(ray->direction, towards) + 1e-9)), ray);
    }
    Bounce next = bounce_at(surface_, ray->direction, towards, ray->inside, random);
    const auto leads_there = [&] {
        return dot(next.direction, facing(flat)) * (next.crosses ? -1 : 1) > 0;
    };
    if (!leads_there() && dot(ray->direction, facing(flat)) < 0) {
        // Interpolated normals can lead to the wrong side of what they were interpolated from.
        next = bounce_at({surface_.refractive_index, 0}, ray->direction, facing(flat), ray->inside,
                         random);
    }
    if (next.crosses) ray->inside = !ray->inside;
    aim(next.direction, ray);
    const Vec3d away = flat * (ray->inside ? -apart_mm_ : apart_mm_);
    ray->at = ray->at + Vec3d{away.x * per_mm_.x, away.y * per_mm_.y, away.z * per_mm_.z};
    return true;
}

bool Tracer::collide(const Ray& ray, double majorant, Random* random, Rgb* weight,
                     Vec3d* turned) const {
    const uint8_t code =
        volume_.code(static_cast<int32_t>(ray.at.x), static_cast<int32_t>(ray.at.y),
                     static_cast<int32_t>(ray.at.z));
    const Material& material = materials_[code];
    Rgb& w = *weight;
    double scatters = 0;
    double passes = 0;
    for (size_t c = 0; c < 3; ++c) {
        scatters += w[c] * material.scattering[c];
        passes += w[c] * (majorant - material.extinction[c]);
    }
    const double all = scatters + passes;
    if (!(all > 0)) return false;
    const bool is_scattered = random->uniform() * all < scatters;
    const double scale = all / (majorant * (is_scattered ? scatters : passes));
    for (size_t c = 0; c < 3; ++c)
        w[c] *= scale * (is_scattered ? material.scattering[c] : majorant - material.extinction[c]);
    if (is_scattered) {
        *turned = material.anisotropy == 0
                      ? random->on_sphere()
                      : random->around(ray.direction,
                                       scattering_cosine(material.anisotropy, random->uniform()));
    }
    return true;
}

double Tracer::distance_to_backdrop(const Ray& ray) const {
    const Backdrop& backdrop = scene_.backdrop;
    if (!backdrop.is_plane || ray.inside) return kFar;
    const double towards = -dot(ray.direction, backdrop.normal);
    if (towards <= 0) return kFar;
    const Vec3d& pitch = volume_.pitch_mm();
    const Vec3d mm =
        volume_.origin_mm() + Vec3d{ray.at.x * pitch.x, ray.at.y * pitch.y, ray.at.z * pitch.z};
    return std::max(0.0, dot(mm - backdrop.point_mm, backdrop.normal) / towards);
}

Rgb Tracer::sky(const Vec3d& direction, double diffuse) const {
    Rgb out = scene_.light.dome;
    for (const Lamp& lamp : scene_.light.lamps) {
        if (dot(direction, lamp.to_lamp) < lamp.cosine) continue;
        const double share = diffuse > 0 ? diffuse / (diffuse + 1 / lamp.extent()) : 1;
        for (size_t c = 0; c < 3; ++c)
            out[c] += lamp.radiance[c] * share;
    }
    return out;
}

Rgb Tracer::lamp_light(const Ray& ray, Random* random) const {
    Rgb out{};
    for (const Lamp& lamp : scene_.light.lamps) {
        const Vec3d direction =
            random->around(lamp.to_lamp, 1 - random->uniform() * (1 - lamp.cosine));
        const double cosine = dot(direction, scene_.backdrop.normal);
        if (cosine <= 0) continue;
        Ray shadow = ray;
        aim(direction, &shadow);
        double ignored = 0;
        if (walk(kFar, nullptr, &shadow, &ignored) != Event::kAway) continue;
        // Balanced with the same directions drawn by their cosine.
        const double density = 1 / lamp.extent();
        const double drawn = cosine / kPi;
        for (size_t c = 0; c < 3; ++c)
            out[c] += lamp.radiance[c] * drawn / (density + drawn);
    }
    return out;
}

Rgb Tracer::trace(const Vec3d& from_mm, const Vec3d& direction, Random* random, bool* met) const {
    Ray ray;
    for (int a = 0; a < 3; ++a)
        ray.at[a] = (from_mm[a] - volume_.origin_mm()[a]) * per_mm_[a];
    aim(direction, &ray);
    Rgb weight{1, 1, 1};
    Rgb light{};
    *met = false;
    bool direct = true;  // has met nothing
    double diffuse = 0;  // density of the direction, where it comes from the backdrop
    int32_t surfaces = 0;
    for (;;) {
        const double plane = distance_to_backdrop(ray);
        double majorant = 0;
        const Event event = walk(plane, random, &ray, &majorant);
        if (event == Event::kCollision) {
            Vec3d turned{};
            if (!collide(ray, majorant, random, &weight, &turned)) return light;
            if (dot(turned, turned) > 0) aim(turned, &ray);
        } else if (event == Event::kSurface) {
            direct = false;
            diffuse = 0;
            *met = true;
            if (!bounce(&ray, random)) return light;
            if (++surfaces > kManySurfaces) {
                if (random->uniform() >= kGoesOn) return light;
                weight = weight * (1 / kGoesOn);
            }
        } else if (plane < kFar) {
            direct = false;
            for (size_t c = 0; c < 3; ++c)
                weight[c] *= scene_.backdrop.albedo[c];
            const Rgb more = lamp_light(ray, random);
            for (size_t c = 0; c < 3; ++c)
                light[c] += weight[c] * more[c];
            const double cosine = std::sqrt(random->uniform());
            aim(random->around(scene_.backdrop.normal, cosine), &ray);
            diffuse = cosine / kPi;
        } else {
            if (direct) return scene_.backdrop.seen;
            const Rgb sky = this->sky(ray.direction, diffuse);
            for (size_t c = 0; c < 3; ++c)
                light[c] += weight[c] * sky[c];
            return light;
        }
        const double heavy = mean(weight);
        if (heavy < kLight) {
            if (random->uniform() * kLight >= heavy) return light;
            weight = weight * (kLight / heavy);
        }
    }
}

Rgb Tracer::trace_picture(double x, double y, Random* random, bool* met) const {
    return trace(scene_.camera.eye_mm, scene_.camera.direction(x, y), random, met);
}

}  // namespace openfab::render
