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

/// Mean weights below Lanes::kLight are played for, so that paths through dark materials end. Those that go on weigh so much:
/// more than kLight, so that they need not play at each collision.
constexpr double kPlayed = 0.2;
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

/// A lane that is not in use stays where nothing is.
void clear(int32_t lane, Lanes* lanes) {
    lanes->is_used[lane] = 0;
    lanes->depth[lane] = 0;
    for (int a = 0; a < 3; ++a) {
        lanes->at[a][lane] = 0.5;
        lanes->direction[a][lane] = lanes->step[a][lane] = lanes->weight[a][lane] = 0;
        lanes->cell[a][lane] = 0;
    }
}

}  // namespace

Tracer::Tracer(const Volume* volume, const Optics& optics, Scene scene, int32_t macro_blocks,
               int instruction_set)
    : volume_(*volume),
      scene_(std::move(scene)),
      surface_(optics.surface),
      skin_(volume),
      fly_(best_flight(instruction_set)) {
    std::vector<float> largest;
    for (const MaterialOptics& one : optics.by_code) {
        LaneMaterial material{};
        for (size_t c = 0; c < 3; ++c) {
            material.extinction[c] = static_cast<float>(one.extinction[c]);
            material.scattering[c] = static_cast<float>(one.extinction[c] * one.albedo[c]);
        }
        material.anisotropy = static_cast<float>(one.anisotropy);
        medium_.materials.push_back(material);
        largest.push_back(
            std::max({material.extinction[0], material.extinction[1], material.extinction[2]}));
    }
    const Vec3i blocks = volume_.blocks();
    OPENFAB_CHECK(macro_blocks == 1 || macro_blocks == 2 || macro_blocks == Volume::kGroup);
    medium_.cell_shift = 3;
    for (int32_t b = macro_blocks; b > 1; b /= 2)
        ++medium_.cell_shift;
    cell_count_ = {blocks.x / macro_blocks, blocks.y / macro_blocks, blocks.z / macro_blocks};
    const size_t cells = static_cast<size_t>(cell_count_.x) * static_cast<size_t>(cell_count_.y) *
                         static_cast<size_t>(cell_count_.z);
    std::vector<bool> is_new(cells, true);
    medium_.majorants.resize(cells);
    std::vector<Clearances::Kind> kinds(cells);
    for (int32_t z = 0; z < blocks.z; ++z) {
        for (int32_t y = 0; y < blocks.y; ++y) {
            for (int32_t x = 0; x < blocks.x; ++x) {
                const size_t i =
                    index_in(cell_count_, {x / macro_blocks, y / macro_blocks, z / macro_blocks});
                volume_.for_codes({x, y, z}, [&](uint8_t code) {
                    OPENFAB_DCHECK(code < largest.size());
                    medium_.majorants[i] = std::max(medium_.majorants[i], largest[code]);
                });
                const Clearances::Kind kind = skin_.clearances().kind({x, y, z});
                kinds[i] = is_new[i] || kind == kinds[i] ? kind : Clearances::Kind::kSurface;
                is_new[i] = false;
            }
        }
    }
    for (size_t i = 0; i < cells; ++i) {
        // The sign tells where a surface may be: -0, too, is below what is looked at there.
        constexpr float kLeast = 1e-30F;
        if (kinds[i] == Clearances::Kind::kSurface)
            medium_.majorants[i] = -std::max(medium_.majorants[i], kLeast);
    }
    for (int a = 0; a < 3; ++a) {
        medium_.cells[a] = cell_count_[a];
        medium_.blocks[a] = blocks[a];
        medium_.per_mm[a] = static_cast<float>(skin_.per_mm()[a]);
    }
    medium_.codes = volume_.codes();
    medium_.code_pool = volume_.code_pool();
    medium_.clearances = skin_.clearances().entries();
    medium_.clearance_pool = skin_.clearances().pool();
    medium_.meets = meets;
    medium_.tracer = this;
}

void Tracer::aim(const Vec3d& direction, Ray* ray) const {
    ray->direction = direction;
    ray->step = {direction.x * skin_.per_mm().x, direction.y * skin_.per_mm().y,
                 direction.z * skin_.per_mm().z};
}

Vec3i Tracer::cell_of(const Vec3d& at) const {
    Vec3i cell;
    for (int a = 0; a < 3; ++a)
        cell[a] =
            std::clamp(static_cast<int32_t>(at[a]) >> medium_.cell_shift, 0, cell_count_[a] - 1);
    return cell;
}

bool Tracer::meets(const void* tracer, Lanes* lanes, int32_t lane, float flown_mm) {
    const double mm = static_cast<double>(flown_mm);
    const auto& self = *static_cast<const Tracer*>(tracer);
    Ray ray;
    ray.inside = true;
    bool is_one_cell = true;
    for (int a = 0; a < 3; ++a) {
        ray.at[a] = lanes->at[a][lane];
        ray.step[a] = static_cast<double>(lanes->step[a][lane]);
        is_one_cell = is_one_cell && static_cast<int32_t>(ray.at[a] - 0.5) ==
                                         static_cast<int32_t>(ray.at[a] + ray.step[a] * mm - 0.5);
    }
    if (is_one_cell && self.skin_.coverage(ray.at + ray.step * mm) >= Volume::kSurface)
        return false;
    double surface = 0;
    if (!self.skin_.find(ray, 0, mm, &surface)) return false;
    for (int a = 0; a < 3; ++a)
        lanes->at[a][lane] += ray.step[a] * surface;
    return true;
}

bool Tracer::bounce(Ray* ray, Random* random) const {
    const double to_air = ray->inside ? 1 : -1;
    const Vec3d exact = skin_.slope(ray->at);
    if (dot(exact, exact) == 0) return false;
    const Vec3d flat = normalized(exact) * -1.0;  // into the air
    const Vec3d smooth = skin_.smooth_slope(ray->at);
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
    const Vec3d away = flat * (ray->inside ? -skin_.apart_mm() : skin_.apart_mm());
    ray->at = ray->at + Vec3d{away.x * skin_.per_mm().x, away.y * skin_.per_mm().y,
                              away.z * skin_.per_mm().z};
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
        if (skin_.walk(kFar, &shadow)) continue;
        // Balanced with the same directions drawn by their cosine.
        const double density = 1 / lamp.extent();
        const double drawn = cosine / kPi;
        for (size_t c = 0; c < 3; ++c)
            out[c] += lamp.radiance[c] * drawn / (density + drawn);
    }
    return out;
}

bool Tracer::play(Path* path) const {
    const double heavy = mean(path->weight);
    if (heavy >= static_cast<double>(Lanes::kLight)) return true;
    if (path->random.uniform() * kPlayed >= heavy) return false;
    path->weight = path->weight * (kPlayed / heavy);
    return true;
}

bool Tracer::meet_surface(Path* path) const {
    path->is_direct = false;
    path->diffuse = 0;
    path->met = true;
    if (!bounce(&path->ray, &path->random)) return false;
    if (++path->surfaces > kManySurfaces) {
        if (path->random.uniform() >= kGoesOn) return false;
        path->weight = path->weight * (1 / kGoesOn);
    }
    return play(path);
}

void Tracer::take_sky(Path* path) const {
    if (path->is_direct) {
        path->light = scene_.backdrop.seen;
        return;
    }
    const Rgb sky = this->sky(path->ray.direction, path->diffuse);
    for (size_t c = 0; c < 3; ++c)
        path->light[c] += path->weight[c] * sky[c];
}

bool Tracer::enter_print(Path* path) const {
    while (!path->ray.inside) {
        const double plane = distance_to_backdrop(path->ray);
        if (skin_.walk(plane, &path->ray)) {
            if (!meet_surface(path)) return false;
            continue;
        }
        if (plane == kFar) {
            take_sky(path);
            return false;
        }
        path->is_direct = false;
        for (size_t c = 0; c < 3; ++c)
            path->weight[c] *= scene_.backdrop.albedo[c];
        const Rgb more = lamp_light(path->ray, &path->random);
        for (size_t c = 0; c < 3; ++c)
            path->light[c] += path->weight[c] * more[c];
        const double cosine = std::sqrt(path->random.uniform());
        aim(path->random.around(scene_.backdrop.normal, cosine), &path->ray);
        path->diffuse = cosine / kPi;
        if (!play(path)) return false;
    }
    return true;
}

void Tracer::put(const Path& path, int32_t lane, Lanes* lanes) const {
    const Vec3i cell = cell_of(path.ray.at);
    for (int a = 0; a < 3; ++a) {
        lanes->at[a][lane] = path.ray.at[a];
        lanes->direction[a][lane] = static_cast<float>(path.ray.direction[a]);
        lanes->step[a][lane] = static_cast<float>(path.ray.step[a]);
        lanes->cell[a][lane] = cell[a];
    }
    for (size_t c = 0; c < 3; ++c)
        lanes->weight[c][lane] = static_cast<float>(path.weight[c]);
    for (size_t i = 0; i < 4; ++i)
        lanes->random[i][lane] = path.random.state[i];
    lanes->depth[lane] = -1;
    lanes->is_used[lane] = 1;
}

void Tracer::take(const Lanes& lanes, int32_t lane, Path* path) const {
    Vec3d direction;
    for (int a = 0; a < 3; ++a) {
        path->ray.at[a] = lanes.at[a][lane];
        direction[a] = static_cast<double>(lanes.direction[a][lane]);
    }
    aim(normalized(direction), &path->ray);
    for (size_t c = 0; c < 3; ++c)
        path->weight[c] = static_cast<double>(lanes.weight[c][lane]);
    for (size_t i = 0; i < 4; ++i)
        path->random.state[i] = lanes.random[i][lane];
}

bool Tracer::trace(int32_t count, const std::atomic<bool>& stop, const Start& start,
                   const Finish& finish) const {
    Lanes lanes;
    for (int32_t lane = 0; lane < Lanes::kCount; ++lane)
        clear(lane, &lanes);
    Path paths[Lanes::kCount];
    int32_t next = 0;
    int32_t used = 0;
    const auto begin = [&](int32_t lane) {
        Path& path = paths[lane];
        while (next < count && !stop) {
            path = {};
            path.number = next++;
            const PathStart from = start(path.number);
            path.random = from.random;
            for (int a = 0; a < 3; ++a)
                path.ray.at[a] = (from.from_mm[a] - volume_.origin_mm()[a]) * skin_.per_mm()[a];
            aim(from.direction, &path.ray);
            if (enter_print(&path)) {
                put(path, lane, &lanes);
                ++used;
                return;
            }
            finish(path.number, path.light, path.met);
        }
    };
    for (int32_t lane = 0; lane < Lanes::kCount; ++lane)
        begin(lane);
    while (used > 0) {
        fly_(medium_, &lanes);
        for (int32_t lane = 0; lane < Lanes::kCount; ++lane) {
            if (lanes.is_used[lane] == 0 || lanes.meeting[lane] == Meeting::kNothing) continue;
            Path& path = paths[lane];
            take(lanes, lane, &path);
            bool goes_on = false;
            switch (lanes.meeting[lane]) {
                case Meeting::kSurface:
                    goes_on = meet_surface(&path) && enter_print(&path);
                    break;
                case Meeting::kLight:
                    goes_on = play(&path);
                    break;
                case Meeting::kAway:
                    take_sky(&path);
                    break;
                default:
                    break;
            }
            if (goes_on) {
                put(path, lane, &lanes);
                continue;
            }
            finish(path.number, path.light, path.met);
            clear(lane, &lanes);
            --used;
            begin(lane);
        }
    }
    return next == count;
}

}  // namespace openfab::render
