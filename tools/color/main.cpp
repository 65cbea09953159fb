// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-color COMMAND`: charts, profiles and tables of inks; `openfab color` executes this
// program. It is separate because it links OpenImageIO and Little CMS.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "backends/common/output_file.h"
#include "base/clean_exit.h"
#include "base/color.h"
#include "base/command_line.h"
#include "base/run_main.h"
#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "program/output_check.h"
#include "tools/color/chart.h"
#include "tools/color/check_print.h"
#include "tools/color/ink_table.h"
#include "tools/color/messages.h"
#include "tools/color/nominal_inks.h"
#include "tools/color/patch_check.h"
#include "tools/color/picture.h"
#include "tools/color/print_inks.h"
#include "tools/color/printer_model.h"
#include "tools/color/profile.h"
#include "tools/texture/guarded.h"

namespace openfab::color {

namespace {

constexpr const char* kExamples = R"(  openfab color chart -o chart
  openfab color simulate inks.csv chart/chart.txt -o measured.ti3
  openfab color read scan.tif chart/chart.txt -o measured.ti3
  openfab color measurements measured.ti3 -o all.ti3
  openfab color profile measured.ti3 -o printer.icc --name "my printer"
  openfab color bake printer.icc -o inks.nrrd --intent perceptual
  openfab color proof sunset.png inks.nrrd printer.icc -o proof.png
  openfab color check chart.ofr chart/chart.txt printer.icc -o report.txt
)";

using backends::write_whole_file;

struct Arguments {
    std::string first, second, third, output, table,
        skin = "0.5mm", window = "0.3mm", intent = "perceptual", name, light = "D50", condition;
    std::vector<double> corners;
    double black = 0.5, limit = 100;
    int icc = 4;
    bool black_point = false, absolute = false, relative = false;
};

using Action = std::function<Result<void>()>;

/// Reads a table of measurements; says what was chosen in it.
Result<SampleTable> read_measured(const Arguments& a) {
    const Measure measure{a.light == "D65" ? Light::kD65 : Light::kD50, a.condition};
    Result<SampleTable> table = read_samples(a.first, measure);
    if (table && table->is_chart)
        return with_context(
            user_error(messages::kChartNotMeasured, messages::kChartNotMeasuredHelp),
            fmt::format("{}: ", a.first));
    if (table && !table->note.empty()) note(table->note);
    return table;
}

Result<void> make_chart(const Arguments& a) {
    const SampleTable chart = a.table.empty() ? ink_chart() : color_chart();
    if (Result<void> done = write_chart(a.output, chart, a.table); !done) return done;
    say(fmt::format("made a chart of {} patches\nprint it: openfab print {} -o chart.ofr\n",
                    chart.samples.size(), shell_word(a.output + "/chart.fab.json")));
    return {};
}

Result<void> simulate(const Arguments& a) {
    const Result<NominalInks> inks = NominalInks::read(a.first);
    if (!inks) return inks.error();
    Result<SampleTable> chart = read_samples(a.second);
    if (!chart) return chart.error();
    const Result<double> skin = parse_length_mm(a.skin);
    if (!skin) return skin.error();
    if (*skin <= 0) return usage_error(messages::kSkinAboveZero);
    if (!chart->has_inks) {
        return user_error(fmt::format(messages::kNoChartOfInks, a.second),
                          messages::kNoChartOfInksHelp);
    }
    chart->has_lab = true;
    for (Sample& sample : chart->samples)
        sample.lab = inks->predict(sample.inks, *skin);
    return write_whole_file(a.output,
                            format_samples(*chart, fmt::format(messages::kSimulatedFrom, a.first)));
}

Result<void> read_picture(const Arguments& a) {
    const Result<SampleTable> chart = read_samples(a.second);
    if (!chart) return chart.error();
    if (!chart->has_inks)
        return user_error(fmt::format(messages::kNoChartOfInks, a.second),
                          messages::kNoChartOfInksHelp);
    if (chart->columns == 0)
        return user_error(messages::kPatchLayoutUnknown, messages::kPatchLayoutUnknownHelp);
    const Result<Picture> picture = Picture::read(a.first);
    if (!picture) return picture.error();
    if (!picture->note().empty()) note(picture->note());
    PhotographOptions options;
    options.corners = a.corners;
    const std::optional<Xyz>& white = picture->input_white();
    if (!a.relative && !picture->by_camera()) options.white = white;
    Result<SampleTable> measured = read_photograph(*picture, *chart, options);
    if (!measured) return measured.error();
    if (options.white)
        note(fmt::format(messages::kAbsoluteBy, a.first, to_lab(*white).l));
    else if (white && !a.relative)
        note(fmt::format(messages::kRelativeTo, a.first));
    return write_whole_file(
        a.output, format_samples(*measured, fmt::format(messages::kPhotographed, a.first)));
}

/// Writes measurements as the table that `profile` would take of them.
Result<void> measurements(const Arguments& a) {
    const Result<SampleTable> table = read_measured(a);
    if (!table) return table.error();
    if (!table->has_lab)
        return user_error(fmt::format(messages::kNoColours, a.first), messages::kNoColoursHelp);
    return write_whole_file(
        a.output, format_samples(*table, fmt::format(messages::kMeasuredOf, a.first, a.light)));
}

Result<void> profile(const Arguments& a) {
    const Result<SampleTable> table = read_measured(a);
    if (!table) return table.error();
    const Result<PrinterModel> model = PrinterModel::fit(*table);
    if (!model) return with_context(model.error(), fmt::format("{}: ", a.first));
    ProfileOptions options;
    options.separation = {a.black, a.limit / 100};
    options.measurements = format_samples(*table, a.first);
    if (!a.name.empty()) options.description = a.name;
    options.version_two = a.icc == 2;
    const Result<std::string> made = make_profile(*model, options);
    if (!made) return made.error();
    if (Result<void> done = write_whole_file(a.output, *made); !done) return done;
    say(fmt::format(messages::kFitted, model->patches(), model->left_out_mean(),
                    model->left_out_worst()));
    for (const std::string& line : format_patches(check_patches(*table, *model), model->patches()))
        warn(line);
    return {};
}

Result<void> bake(const Arguments& a) {
    static const std::map<std::string, Intent> kIntents = {{"perceptual", Intent::kPerceptual},
                                                           {"relative", Intent::kRelative},
                                                           {"saturation", Intent::kSaturation},
                                                           {"absolute", Intent::kAbsolute}};
    const Result<PrinterProfile> profile = PrinterProfile::read(a.first);
    if (!profile) return profile.error();
    const BakeOptions options{kIntents.at(a.intent), a.black_point, a.limit / 100};
    const Result<InkTable> table = InkTable::bake(*profile, options);
    if (!table)
        return with_context(table.error(), fmt::format(messages::kCannotReadBefore, a.first));
    // Profiles made for voxels ask for a few percent more between their nodes.
    constexpr double kLittle = 1.1, kFew = 0.02;
    const InkTable::Excess& excess = table->excess();
    if (excess.most > kLittle && excess.share > kFew)
        note(fmt::format(messages::kPressProfile, a.first, excess.share * 100, excess.most * 100));
    return write_whole_file(a.output, table->format(fmt::format(
                                          "inks of `{}`, {}{}, limit {} %: cyan, magenta, yellow, "
                                          "black over sRGB",
                                          profile->description(), a.intent,
                                          a.black_point ? " with black point" : "", a.limit)));
}

/// Writes the colours of inks as a picture; where `is_there` says no, it is grey.
Result<void> write_proof(const Arguments& a, const std::string& profile_file, int width, int height,
                         const std::vector<Inks>& inks, const std::vector<bool>& is_there) {
    const Result<PrinterProfile> profile = PrinterProfile::read(profile_file);
    if (!profile) return profile.error();
    const Result<std::vector<Lab>> colours = profile->to_lab(inks, a.absolute);
    if (!colours)
        return with_context(colours.error(),
                            fmt::format(messages::kCannotReadBefore, profile_file));
    constexpr Rgb kNothing{0.2, 0.2, 0.2};
    std::vector<Rgb> pixels;
    pixels.reserve(colours->size());
    for (const Lab& lab : *colours) {
        const bool there = is_there.empty() || is_there[pixels.size()];
        pixels.push_back(there ? linear_of_xyz(to_xyz(lab)) : kNothing);
    }
    const Result<std::vector<uint8_t>> png = png_of(width, height, pixels);
    if (!png) return png.error();
    return write_whole_file(a.output, *png);
}

Result<void> proof_print(const Arguments& a) {
    const Result<double> window = parse_length_mm(a.window);
    if (!window) return window.error();
    const Result<double> skin = parse_length_mm(a.skin);
    if (!skin) return skin.error();
    if (*window <= 0 || *skin <= 0) return usage_error(messages::kWindowAndSkinAboveZero);
    const Result<PrintTop> top = read_print_top(a.first, *window, *skin, kDefaultMemoryBytes);
    if (!top) return top.error();
    return write_proof(a, a.second, top->width, top->height, top->windows, top->is_there);
}

Result<void> proof(const Arguments& a) {
    if (lower_ascii(a.first).ends_with(".ofr")) {
        if (a.third.empty()) return proof_print(a);
        return usage_error(messages::kProofOfPrint);
    }
    if (a.third.empty()) {
        return usage_error(messages::kProofOfPicture);
    }
    const Result<Picture> picture = Picture::read(a.first);
    if (!picture) return picture.error();
    if (!picture->note().empty()) note(picture->note());
    const Result<InkTable> table = InkTable::read(a.second);
    if (!table) return table.error();
    std::vector<Inks> inks;
    for (int y = 0; y < picture->height(); ++y) {
        for (int x = 0; x < picture->width(); ++x) {
            Rgb encoded = picture->at(x, y);
            for (double& channel : encoded)
                channel = linear_to_srgb(channel);
            inks.push_back(table->at(encoded));
        }
    }
    return write_proof(a, a.third, picture->width(), picture->height(), inks, {});
}

Result<void> check(const Arguments& a) {
    const Result<SampleTable> chart = read_samples(a.second);
    if (!chart) return chart.error();
    const Result<PrinterProfile> profile = PrinterProfile::read(a.third);
    if (!profile) return profile.error();
    const Result<double> skin = parse_length_mm(a.skin);
    if (!skin) return skin.error();
    const Result<PrintedChart> printed = read_print(a.first, *chart, *skin);
    if (!printed) return printed.error();
    const Result<PrintCheck> checked = check_print(*chart, *printed, *profile);
    if (!checked) return checked.error();
    show(format_check(*checked));
    if (a.output.empty()) return {};
    return write_whole_file(
        a.output, format_samples(checked->report,
                                 fmt::format("what {} is made of, and its colours", a.first)));
}

/// Runs a command whose output overwrites none of its inputs.
Result<void> run(Result<void> (*command)(const Arguments&), const Arguments& a) {
    if (!a.output.empty()) {
        std::vector<std::filesystem::path> inputs;
        for (const std::string& input : {a.first, a.second, a.third, a.table}) {
            if (!input.empty()) inputs.emplace_back(input);
        }
        Result<void> apart = program::check_outputs({{"-o", a.output}}, inputs);
        if (!apart) return apart;
    }
    // Profiles, photographs and measurements may be anybody's.
    const std::string& read = a.first.empty() ? a.table : a.first;
    return tools::guarded(
        kDefaultMemoryBytes, read, [&] { return command(a); }, a.output);
}

void add_chart(CLI::App& app, Action* action) {
    CLI::App* c = app.add_subcommand("chart", "make the world of a chart to print and measure");
    auto a = std::make_shared<Arguments>();
    c->add_option("-o,--output", a->output, "a folder")->required();
    c->add_option("--table", a->table,
                  "a table of inks: patches of colours that are printed through it, to judge it, "
                  "instead of patches of inks");
    c->callback([a, action] { *action = [a] { return run(make_chart, *a); }; });
}

void add_simulate(CLI::App& app, Action* action) {
    CLI::App* c = app.add_subcommand(
        "simulate", "predict the measurements of a chart of inks, from absorption and scattering");
    auto a = std::make_shared<Arguments>();
    c->add_option("INKS", a->first, "a .csv of the inks' coefficients in 1/mm")->required();
    c->add_option("CHART", a->second, "the chart.txt of a chart of inks")->required();
    c->add_option("-o,--output", a->output, "the table of measurements")->required();
    c->add_option("--skin", a->skin, "thickness of the inks over white (default: 0.5mm)");
    c->callback([a, action] { *action = [a] { return run(simulate, *a); }; });
}

void add_read(CLI::App& app, Action* action) {
    CLI::App* c = app.add_subcommand("read", "read a chart of inks from a photograph");
    auto a = std::make_shared<Arguments>();
    c->add_option("PHOTOGRAPH", a->first, "a picture, by its own profile or else sRGB")->required();
    c->add_option("CHART", a->second, "the chart.txt of the chart")->required();
    c->add_option("-o,--output", a->output, "the table of measurements")->required();
    c->add_option(
         "--corners", a->corners,
         "X,Y of the chart's corners in pixels from the top left of the picture as viewers "
         "show it: top left, top right, bottom right, bottom left (default: those of the "
         "picture)")
        ->delimiter(',')
        ->expected(8);
    c->add_flag("--relative", a->relative,
                "count the white of a scanner's profile as 100, not as its target reflects it");
    c->callback([a, action] { *action = [a] { return run(read_picture, *a); }; });
}

void add_measure_options(CLI::App* c, const std::shared_ptr<Arguments>& a) {
    c->add_option(
         "MEASURED", a->first,
         "a table, CGATS (.ti3), CSV or CxF: CMYK_C ... in percent, and spectra, LAB_L ... or "
         "XYZ_X ...")
        ->required();
    c->add_option("--light", a->light, "D50 or D65: what spectra are seen under (default: D50)")
        ->check(CLI::IsMember({"D50", "D65"}, CLI::ignore_case));
    c->add_option("--condition", a->condition,
                  "of several in a CxF, the measuring condition that counts (default: the first of "
                  "M1, M0, M2)")
        ->check(CLI::IsMember({"M0", "M1", "M2", "M3"}, CLI::ignore_case));
}

void add_measurements(CLI::App& app, Action* action) {
    CLI::App* c = app.add_subcommand("measurements",
                                     "show the colours of measured spectra, or of CxF, as a table");
    auto a = std::make_shared<Arguments>();
    add_measure_options(c, a);
    c->add_option("-o,--output", a->output, "the table, with LAB_L ...")->required();
    c->callback([a, action] { *action = [a] { return run(measurements, *a); }; });
}

void add_profile(CLI::App& app, Action* action) {
    CLI::App* c =
        app.add_subcommand("profile", "make an ICC profile from a measured chart of inks");
    auto a = std::make_shared<Arguments>();
    add_measure_options(c, a);
    c->add_option("-o,--output", a->output, "the .icc file")->required();
    c->add_option("--black", a->black,
                  "how much of grey black ink makes, 0 (as little as can be) to 1 (default: 0.5)")
        ->check(CLI::Range(0.0, 1.0));
    c->add_option("--limit", a->limit, "of the sum of inks, percent of the voxels (default: 100)")
        ->check(CLI::Range(10.0, 100.0));
    c->add_option("--name", a->name, "the profile's description");
    c->add_option("--icc", a->icc,
                  "the version of ICC, 4 or 2: for programs that read no 4 (default: 4)")
        ->check(CLI::IsMember({2, 4}));
    c->callback([a, action] { *action = [a] { return run(profile, *a); }; });
}

void add_bake(CLI::App& app, Action* action) {
    CLI::App* c = app.add_subcommand("bake", "make the table of inks that fablets look up");
    auto a = std::make_shared<Arguments>();
    c->add_option("PROFILE", a->first, "an .icc profile of a printer of CMYK")->required();
    c->add_option("-o,--output", a->output, "the .nrrd file")->required();
    c->add_option("--intent", a->intent,
                  "perceptual, relative, saturation or absolute (default: perceptual)")
        ->check(CLI::IsMember({"perceptual", "relative", "saturation", "absolute"}));
    c->add_flag("--black-point", a->black_point, "scale black, too, with --intent relative");
    c->add_option("--limit", a->limit, "of the sum of inks, percent of the voxels (default: 100)")
        ->check(CLI::Range(10.0, 100.0));
    c->callback([a, action] { *action = [a] { return run(bake, *a); }; });
}

void add_proof(CLI::App& app, Action* action) {
    CLI::App* c = app.add_subcommand(
        "proof", "show a picture as its print will look, or a print from its own voxels");
    auto a = std::make_shared<Arguments>();
    c->add_option("PICTURE", a->first,
                  "a picture, by its own profile or else sRGB; or a print, an .ofr file")
        ->required();
    c->add_option("TABLE", a->second,
                  "the table of inks a picture is printed with; of a print, the printer's profile")
        ->required();
    c->add_option("PROFILE", a->third, "the printer's .icc profile, of a picture");
    c->add_option(
        "--window", a->window,
        "of a print: the size of a pixel, of whose voxels it is the mean (default: 0.3mm)");
    c->add_option("--skin", a->skin,
                  "of a print: thickness of the inks over white (default: 0.5mm)");
    c->add_option("-o,--output", a->output, "the .png file, in sRGB")->required();
    c->add_flag("--absolute", a->absolute,
                "show the print's own white, not the screen's in its place");
    c->callback([a, action] { *action = [a] { return run(proof, *a); }; });
}

void add_check(CLI::App& app, Action* action) {
    CLI::App* c = app.add_subcommand("check", "compare a chart's print with the requested colours");
    auto a = std::make_shared<Arguments>();
    c->add_option("PRINT", a->first, "the .ofr file of the chart")->required();
    c->add_option("CHART", a->second, "its chart.txt")->required();
    c->add_option("PROFILE", a->third, "the printer's .icc profile")->required();
    c->add_option("-o,--output", a->output, "a table of the patches' means and colours");
    c->add_option("--skin", a->skin, "thickness of the inks over white (default: 0.5mm)");
    c->callback([a, action] { *action = [a] { return run(check, *a); }; });
}

int color_main(int argc, char** argv) {
    prepare_streams();
    clean_up_on_signals();
    CLI::App app("Colour by profiles: charts, measurements, ICC profiles, tables of inks, proofs.",
                 "openfab color");
    app.require_subcommand(1);
    Action action;
    add_chart(app, &action);
    add_simulate(app, &action);
    add_read(app, &action);
    add_measurements(app, &action);
    add_profile(app, &action);
    add_bake(app, &action);
    add_proof(app, &action);
    add_check(app, &action);
    add_examples(&app, kExamples);
    return run_command_line(&app, argc, argv, "openfab color", [&] { return action(); });
}

}  // namespace

}  // namespace openfab::color

int main(int argc, char** argv) {
    return openfab::run_main(openfab::color::color_main, argc, argv);
}
