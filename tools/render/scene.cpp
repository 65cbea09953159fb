// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/scene.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <numbers>

#include "backends/preview/picture.h"
#include "backends/preview/preview_spec.h"
#include "base/color.h"
#include "base/json_text.h"
#include "base/rotation.h"
#include "tools/render/messages.h"
#include "tools/render/random.h"

namespace openfab::render {

namespace {

constexpr double kHalfHeight = 0.2126;  ///< tangent of 12 degrees
constexpr double kFill = 0.92;          ///< share of the picture that the print's box takes

/// A lamp that gives a white diffuser which faces it the radiance `white`.
Lamp lamp_of(const Vec3d& to_lamp, double half_angle_deg, double white) {
    const SinCos angle = sin_cos_degrees(half_angle_deg);
    const double radiance = white / (angle.sin * angle.sin);
    return {normalized(to_lamp), angle.cos, {radiance, radiance, radiance}};
}

Result<void> turn_and_tilt(const std::string& text, double* turn, double* tilt) {
    const char* const end = text.data() + text.size();
    const auto [colon, bad] = std::from_chars(text.data(), end, *turn);
    if (bad == std::errc() && colon != end && *colon == ':') {
        const auto [rest, worse] = std::from_chars(colon + 1, end, *tilt);
        if (worse == std::errc() && rest == end && std::abs(*turn) <= 360 && std::abs(*tilt) <= 90)
            return {};
    }
    return usage_error(fmt::format(messages::kNoLight, text));
}

/// The frame of the camera: where it looks from, seen from the print, and what is up.
struct View {
    Vec3d back, up, ground;  ///< ground: the normal of what the print lies on
};

Result<View> view_of(const std::string& text) {
    // The views of --preview, and its words where there is none.
    Result<preview::PreviewSpec> spec = preview::parse_preview("x.png,view=" + text);
    const bool usable =
        spec && (spec->view == preview::View::kTop || spec->view == preview::View::kBottom ||
                 spec->view == preview::View::kModel);
    if (!usable || text.find(',') != std::string::npos) {
        return usage_error(fmt::format(messages::kNoView, text));
    }
    if (spec->view == preview::View::kTop) return View{{0, 0, 1}, {0, 1, 0}, {0, 0, 1}};
    if (spec->view == preview::View::kBottom) return View{{0, 0, -1}, {0, 1, 0}, {0, 0, -1}};
    const SinCos turn = sin_cos_degrees(spec->turn_deg);
    const SinCos tilt = sin_cos_degrees(spec->tilt_deg);
    // As backends/preview/model_view.h: 0 looks along +y, 90 along -x.
    const Vec3d back{turn.sin * tilt.cos, -turn.cos * tilt.cos, tilt.sin};
    const Vec3d up{-turn.sin * tilt.sin, turn.cos * tilt.sin, tilt.cos};
    return View{back, up, {0, 0, 1}};
}

Result<Light> light_of(const std::string& name, const Camera& camera) {
    const Vec3d back = camera.forward * -1.0;
    const auto from = [&](double right, double up, double behind_camera) {
        return camera.right * right + camera.up * up + back * behind_camera;
    };
    Light light;
    if (name == "studio") {
        // Large and soft: paths out of resin find lamps by chance alone.
        light.dome = {0.5, 0.5, 0.5};
        light.lamps.push_back(lamp_of(from(-0.55, 0.75, 0.65), 40, 0.45));
        light.lamps.push_back(lamp_of(from(0.8, 0.5, -0.55), 25, 0.15));
    } else if (name == "behind") {
        // As bright as what lies on a lamp has to be to show what it lets through.
        light.dome = {0.02, 0.02, 0.02};
        light.lamps.push_back(lamp_of(camera.forward, 50, 8));
    } else if (name == "dome") {
        light.dome = {1, 1, 1};
    } else {
        double turn = 0;
        double tilt = 0;
        if (Result<void> read = turn_and_tilt(name, &turn, &tilt); !read) return read.error();
        const SinCos across = sin_cos_degrees(turn);
        const SinCos above = sin_cos_degrees(tilt);
        light.dome = {0.1, 0.1, 0.1};
        light.lamps.push_back(
            lamp_of(from(-across.sin * above.cos, above.sin, across.cos * above.cos), 10, 0.8));
    }
    return light;
}

Result<Rgb> color_of(const std::string& text) {
    uint32_t value = 0;
    const char* const end = text.data() + text.size();
    if (text.size() == 7 && text[0] == '#') {
        const auto [rest, bad] = std::from_chars(text.data() + 1, end, value, 16);
        if (bad == std::errc() && rest == end) {
            Rgb color{};
            for (uint32_t c = 0; c < 3; ++c)
                color[c] = srgb_to_linear(((value >> (16 - 8 * c)) & 255) / 255.0);
            return color;
        }
    }
    return usage_error(fmt::format(messages::kNoColour, text));
}

/// What a diffuse plane sends back that only the lamps are above of.
Rgb lit(const Light& light, const Vec3d& normal, const Rgb& albedo) {
    Rgb out{};
    for (size_t c = 0; c < 3; ++c) {
        out[c] = light.dome[c];
        for (const Lamp& lamp : light.lamps) {
            const double sine_squared = 1 - lamp.cosine * lamp.cosine;
            out[c] += lamp.radiance[c] * sine_squared * std::max(0.0, dot(lamp.to_lamp, normal));
        }
        out[c] *= albedo[c];
    }
    return out;
}

/// Moves the camera back until all of the box is in the picture.
void frame_box(const Box3d& box, double zoom, Camera* camera) {
    const Vec3d center = box.center();
    double distance = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d at =
            Vec3d{(corner & 1) != 0 ? box.hi.x : box.lo.x, (corner & 2) != 0 ? box.hi.y : box.lo.y,
                  (corner & 4) != 0 ? box.hi.z : box.lo.z} -
            center;
        const double nearer = -dot(at, camera->forward);
        distance = std::max(
            {distance, nearer + std::abs(dot(at, camera->right)) / (kFill * camera->half_width),
             nearer + std::abs(dot(at, camera->up)) / (kFill * camera->half_height)});
    }
    camera->half_width /= zoom;
    camera->half_height /= zoom;
    camera->eye_mm = center - camera->forward * distance;
}

void write(const Vec3d& v, JsonText* out) {
    out->begin_array().value(v.x).value(v.y).value(v.z).end_array();
}
void write(const Rgb& c, JsonText* out) {
    write(Vec3d{c[0], c[1], c[2]}, out);
}

}  // namespace

double Lamp::extent() const {
    return 2 * std::numbers::pi * (1 - cosine);
}

Vec3d Camera::direction(double x, double y) const {
    return normalized(forward + right * ((2 * x - 1) * half_width) +
                      up * ((1 - 2 * y) * half_height));
}

Result<Scene> make_scene(const SceneOptions& options, const Box3d& solid_mm) {
    const Result<View> view = view_of(options.view);
    if (!view) return view.error();
    Scene scene;
    Camera& camera = scene.camera;
    camera.forward = view->back * -1.0;
    camera.up = view->up;
    camera.right = cross(camera.forward, camera.up);
    camera.half_width = kHalfHeight * std::max(1.0, options.aspect);
    camera.half_height = camera.half_width / options.aspect;
    frame_box(solid_mm, options.zoom, &camera);
    Result<Light> light = light_of(options.light, camera);
    if (!light) return light.error();
    scene.light = std::move(*light);
    Backdrop& backdrop = scene.backdrop;
    if (options.backdrop == "none") return scene;
    const Result<Rgb> albedo = color_of(options.backdrop);
    if (!albedo) return albedo.error();
    if (options.light == "behind") return scene;  // nothing may stand before that lamp
    backdrop.is_plane = true;
    backdrop.albedo = *albedo;
    backdrop.normal = view->ground;
    backdrop.point_mm = view->ground.z > 0 ? solid_mm.lo : solid_mm.hi;
    // It goes on behind what it lies under, like paper that is bent up far away.
    backdrop.seen = lit(scene.light, backdrop.normal, backdrop.albedo);
    return scene;
}

std::string describe_scene(const Scene& scene, const SurfaceOptics& surface) {
    JsonText out;
    out.begin_object().key("camera").begin_object().key("eye_mm");
    const Camera& camera = scene.camera;
    write(camera.eye_mm, &out);
    write(camera.forward, &out.key("forward"));
    write(camera.up, &out.key("up"));
    out.member("half_width", camera.half_width).member("half_height", camera.half_height);
    out.end_object().key("dome");
    write(scene.light.dome, &out);
    out.key("lamps").begin_array();
    for (const Lamp& lamp : scene.light.lamps) {
        out.begin_object().key("to_lamp");
        write(lamp.to_lamp, &out);
        out.member("cosine", lamp.cosine).key("radiance");
        write(lamp.radiance, &out);
        out.end_object();
    }
    out.end_array().key("backdrop");
    if (scene.backdrop.is_plane) {
        write(scene.backdrop.albedo, &out);
    } else {
        out.null();
    }
    out.member("refractive_index", surface.refractive_index).member("roughness", surface.roughness);
    out.end_object();
    return out.take() + "\n";
}

}  // namespace openfab::render
