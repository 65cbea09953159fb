// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// openfab._core.Options: what a print is asked for, field by field as in program/options.h. What is
// not here has a reason in tests/python/test_options.py.

#include "program/options.h"

#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "base/talking_program.h"
#include "base/units.h"
#include "program/option_texts.h"
#include "python/src/bindings.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace openfab::python {

namespace {

using program::Options;
using OptionsClass = nb::class_<Options>;

/// Binds a field of two numbers as a pair.
template <typename Owner, typename T>
void bind_pair(OptionsClass& to, const char* name, std::optional<Vec2<T>> Owner::*field) {
    using Pair = std::optional<std::array<T, 2>>;
    to.def_prop_rw(
        name,
        [field](const Options& o) {
            return o.*field ? Pair({(o.*field)->x, (o.*field)->y}) : std::nullopt;
        },
        [field](Options& o, const Pair& pair) {
            o.*field = pair ? std::optional(Vec2<T>{(*pair)[0], (*pair)[1]}) : std::nullopt;
        },
        nb::for_setter(nb::arg("value").none()));
}

/// Binds a field of three numbers as a triple.
template <typename Owner>
void bind_triple(OptionsClass& to, const char* name, std::optional<Vec3d> Owner::*field) {
    using Triple = std::optional<std::array<double, 3>>;
    to.def_prop_rw(
        name,
        [field](const Options& o) {
            return o.*field ? Triple({(o.*field)->x, (o.*field)->y, (o.*field)->z}) : std::nullopt;
        },
        [field](Options& o, const Triple& one) {
            o.*field = one ? std::optional(Vec3d{(*one)[0], (*one)[1], (*one)[2]}) : std::nullopt;
        },
        nb::for_setter(nb::arg("value").none()));
}

}  // namespace

void bind_options(nb::module_& m) {
    nb::class_<preview::PreviewSpec>(m, "View", "What a picture shows.");
    OptionsClass options(m, "Options",
                         "What a print is asked for; None and empty texts ask for nothing.");
    options.def(nb::init<>())
        .def_rw("input", &Options::input)
        .def_rw("allow", &Options::allow)
        .def_rw("settings", &Options::settings)
        .def_rw("printer", &Options::printer)
        .def_rw("process_file", &Options::process_file)
        .def_rw("effects", &Options::effects)
        .def_rw("support", &Options::support)
        .def_rw("dither", &Options::dither)
        .def_rw("seed", &Options::seed)
        .def_rw("voxel_mm", &Options::voxel_mm, nb::arg("value").none())
        .def_rw("layer_mm", &Options::layer_mm, nb::arg("value").none())
        .def_rw("mesh_pitch_mm", &Options::mesh_pitch_mm, nb::arg("value").none())
        .def_rw("draft", &Options::draft)
        .def_rw("crop_tray", &Options::crop_tray)
        .def_rw("output", &Options::output)
        .def_rw("format", &Options::format)
        .def_rw("token_file", &Options::token_file)
        .def_rw("tls_ca", &Options::tls_ca)
        .def_rw("png_indexed", &Options::png_indexed)
        .def_rw("grey_material", &Options::grey_material)
        .def_rw("flip_x", &Options::flip_x)
        .def_rw("previews", &Options::previews)
        .def_rw("fractions_supersample", &Options::fractions_supersample, nb::arg("value").none())
        .def_rw("sample_centres", &Options::sample_centres)
        .def_rw("inputs", &Options::inputs)
        .def_rw("memory_bytes", &Options::memory_bytes)
        .def_rw("memory_given", &Options::memory_given)
        .def_rw("threads", &Options::threads, nb::arg("value").none())
        .def_rw("culling", &Options::culling)
        .def_rw("slabs_in_flight", &Options::slabs_in_flight, nb::arg("value").none())
        .def(
            "validate", [](const Options& o) { return either(validate_options(o)); },
            "Returns what is wrong with it, as the command line words it.");
    bind_pair(options, "dpi", &Options::dpi);
    bind_pair(options, "z_range_mm", &Options::z_range_mm);
    bind_pair(options, "slices", &Options::slices);
    bind_triple(options, "pitch_mm", &Options::pitch_mm);

    m.attr("PROGRAMS_WORD") = kProgramsWord;
    m.def(
        "parse_length",
        [](const std::string& option, const std::string& text) {
            return either(program::parse_length(option, text));
        },
        "option"_a, "text"_a, "A length with its unit, in mm.");
    m.def(
        "parse_dpi",
        [](const std::string& text) -> std::variant<std::array<double, 2>, Error> {
            const Result<Vec2<double>> dpi = program::parse_dpi(text);
            if (!dpi) return dpi.error();
            return std::array{dpi->x, dpi->y};
        },
        "text"_a, "A resolution, as `600x300`.");
    m.def(
        "parse_memory", [](const std::string& text) { return either(parse_memory_option(text)); },
        "text"_a, "A size with its unit, in bytes.");
    m.def(
        "parse_view", [](const std::string& text) { return either(preview::parse_view(text)); },
        "text"_a, "As `--preview`, without the file.");
}

}  // namespace openfab::python
