// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-text WORDS -o FILE`: a text as a mesh or a picture; `openfab text` executes this program.
// It is separate because it links what reads fonts.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "backends/common/output_file.h"
#include "base/clean_exit.h"
#include "base/command_line.h"
#include "base/run_main.h"
#include "base/say.h"
#include "base/units.h"
#include "tools/text/messages.h"
#include "tools/text/text_shapes.h"
#include "tools/texture/guarded.h"

namespace openfab::text {
namespace {

constexpr double kMmOfInch = 25.4;

struct Arguments {
    std::string words, output, font = "sans-serif", align = "center";
    std::string size = "10mm", depth = "2mm", margin = "0mm";
    double dpi = 600;
};

/// Reads a length of at least `least` mm.
Result<double> length(const char* option, const std::string& text, double least) {
    const Result<double> mm = parse_length_mm(text);
    if (!mm) return usage_error(fmt::format("`{}`: {}", option, mm.error().message));
    if (!(*mm >= least && *mm <= 1000))
        return usage_error(fmt::format(messages::kNotBetween, option, text, least));
    return *mm;
}

Result<void> run(const Arguments& a) {
    const bool picture = a.output.ends_with(".png");
    if (!picture && !a.output.ends_with(".obj")) return usage_error(messages::kNoOutput);
    const Result<double> size = length("--size", a.size, 0.01);
    const Result<double> depth = length("--depth", a.depth, 0.001);
    const Result<double> margin = length("--margin", a.margin, 0);
    for (const Result<double>* each : {&size, &depth, &margin}) {
        if (!*each) return each->error();
    }
    Result<std::unique_ptr<Font>> font = Font::open(a.font, *size);
    if (!font) return font.error();
    const Align align = a.align == "left"    ? Align::kLeft
                        : a.align == "right" ? Align::kRight
                                             : Align::kCenter;
    Result<Layout> layout = lay_out(font->get(), a.words, align);
    if (!layout) return layout.error();
    std::string made;
    if (picture) {
        const Result<Picture> drawn = draw_text(*layout, a.dpi / kMmOfInch, *margin);
        if (!drawn) return drawn.error();
        if (Result<void> written = backends::write_whole_file(a.output, drawn->png); !written)
            return written;
        made = fmt::format("{} x {} pixels, {:.6g} x {:.6g} mm", drawn->width, drawn->height,
                           drawn->width / a.dpi * kMmOfInch, drawn->height / a.dpi * kMmOfInch);
    } else {
        const Result<mesh::Mesh> mesh = make_text_mesh(*layout, *depth);
        if (!mesh) return mesh.error();
        if (Result<void> written = backends::write_whole_file(a.output, obj_text(*mesh)); !written)
            return written;
        made = fmt::format("{} triangles, {:.6g} x {:.6g} x {:.6g} mm", mesh->triangles.size(),
                           layout->size_mm.x, layout->size_mm.y, *depth);
    }
    show(fmt::format("{}: {}, {}\n", a.output, made, (*font)->name()));
    return {};
}

int text_main(int argc, char** argv) {
    prepare_streams();
    clean_up_on_signals();
    Arguments a;
    CLI::App app("Makes a mesh or a picture from a text.", "openfab text");
    app.add_option("WORDS", a.words, "the text; newlines end its lines")->required();
    app.add_option("-o,--output", a.output,
                   "an .obj mesh, in mm, standing on z = 0; or a .png picture, white on black")
        ->required();
    app.add_option("--size", a.size, "height of a capital letter (default: 10mm)")
        ->type_name("LENGTH");
    app.add_option("--depth", a.depth, "of the mesh (default: 2mm)")->type_name("LENGTH");
    app.add_option("--font", a.font,
                   "a font's file, or its name, such as \"DejaVu Serif:bold\" (default: "
                   "sans-serif); of a variable "
                   "font's file also settings: a.ttf:wght=700");
    app.add_option("--align", a.align, "of lines: left, center or right (default: center)")
        ->check(CLI::IsMember({"left", "center", "right"}));
    app.add_option("--dpi", a.dpi, "of the picture (default: 600)")
        ->check(CLI::Range(1.0, 100000.0));
    app.add_option("--margin", a.margin, "around the picture's text (default: none)")
        ->type_name("LENGTH");
    // The font may be anybody's.
    add_examples(&app, "  openfab text Ada -o name.obj --size 8mm\n");
    return run_command_line(&app, argc, argv, "openfab text", [&] {
        return tools::guarded(
            kDefaultMemoryBytes, a.font, [&] { return run(a); }, a.output);
    });
}

}  // namespace
}  // namespace openfab::text

int main(int argc, char** argv) {
    return openfab::run_main(openfab::text::text_main, argc, argv);
}
