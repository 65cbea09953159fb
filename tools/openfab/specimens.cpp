// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/specimens.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "base/json.h"
#include "base/json_text.h"
#include "base/near_miss.h"
#include "base/say.h"
#include "base/units.h"
#include "tools/openfab/machine_materials.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/stock.h"
#include "tools/specimens/measured.h"
#include "tools/specimens/tables.h"
#include "tools/specimens/trays.h"
#include "world/printer.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr int kMostSpecimens = 1000, kMostCopies = 100, kMostSteps = 100;
constexpr size_t kMostSourceBytes = 1'000'000;
constexpr double kThinnestMm = 0.2, kThickestMm = 50;

std::vector<std::string> parts_of(std::string_view text, char between) {
    std::vector<std::string> out;
    while (true) {
        const size_t end = text.find(between);
        out.emplace_back(text.substr(0, end));
        if (end == std::string_view::npos) return out;
        text.remove_prefix(end + 1);
    }
}

bool is_number(const std::string& text, double* out) {
    const auto end = std::from_chars(text.data(), text.data() + text.size(), *out);
    return end.ec == std::errc() && end.ptr == text.data() + text.size();
}

/// A number or a list as it is, all else as a text: the name of a material.
std::string json_of(const std::string& text) {
    return parse_json(text, "value") ? text : json_string(text);
}

Result<std::pair<std::string, std::string>> named_value(const std::string& text,
                                                        const char* option) {
    const size_t mark = text.find('=');
    if (mark == std::string::npos || mark == 0 || mark + 1 == text.size())
        return usage_error(fmt::format(messages::kNameAndValue, option, text));
    return std::pair(text.substr(0, mark), text.substr(mark + 1));
}

Result<double> share_of(const std::string& text) {
    double out = 0;
    if (!is_number(text, &out) || !(out >= 0 && out <= 1))
        return usage_error(fmt::format(messages::kShareOutside, text));
    return out;
}

/// Returns the shares of each mixture that is wanted.
Result<std::vector<std::vector<double>>> mixtures_of(const SpecimenTrayArguments& arguments) {
    std::vector<std::vector<double>> out;
    const size_t n = arguments.materials.size();
    for (const std::string& text : arguments.mixtures) {
        std::vector<double> shares;
        double sum = 0;
        for (const std::string& part : parts_of(text, ',')) {
            const Result<double> share = share_of(part);
            if (!share) return share.error();
            shares.push_back(*share);
            sum += *share;
        }
        if (shares.size() != n || std::abs(sum - 1) > 1e-6)
            return usage_error(fmt::format(messages::kMixtureShares, text, n));
        out.push_back(std::move(shares));
    }
    if (!out.empty()) return out;
    if (n == 1) return std::vector<std::vector<double>>{{1}};
    if (n > 2) return usage_error(fmt::format(messages::kMixturesWanted, n));
    for (int i = 0; i < arguments.steps; ++i) {
        const double share =
            arguments.steps == 1 ? 0.5 : static_cast<double>(i) / (arguments.steps - 1);
        out.push_back({1 - share, share});
    }
    return out;
}

/// Sets kinds of pieces that differ in their mixture.
Result<void> set_mixtures(const SpecimenTrayArguments& arguments, specimens::Trays* trays) {
    const Result<std::vector<std::vector<double>>> mixtures = mixtures_of(arguments);
    if (!mixtures) return mixtures.error();
    trays->source = "specimen.fl";
    trays->fablet = "Specimen";
    std::vector<std::string> names;
    for (const std::string& name : arguments.materials) {
        names.push_back(json_string(name));
        trays->columns.push_back(std::string(specimens::kShareOf) + name);
    }
    trays->uniforms = {{"materials", fmt::format("[{}]", fmt::join(names, ", "))}};
    for (const std::vector<double>& shares : *mixtures) {
        trays->variants.push_back({{"shares", fmt::format("[{}]", fmt::join(shares, ", "))}});
        std::vector<std::string> texts;
        for (const double share : shares)
            texts.push_back(fmt::format("{}", share));
        trays->values.push_back(std::move(texts));
    }
    return {};
}

/// A fablet of the user's and the modules beside it that it imports.
struct Source {
    std::string fablet;
    std::map<std::string, std::string> files;
};

void add_modules(const fs::path& folder, const std::string& text, Source* out) {
    constexpr std::string_view kImport = "import ";
    for (size_t at = text.find(kImport); at != std::string::npos; at = text.find(kImport, at + 1)) {
        const size_t begin = at + kImport.size(), end = text.find(';', begin);
        if (end == std::string::npos) return;
        const std::string file = text.substr(begin, end - begin) + ".fl";
        if (out->files.contains(file) || file.find('/') != std::string::npos) continue;
        const Result<std::string> module = read_text_file(folder / file, kMostSourceBytes);
        if (!module) continue;  // of the library
        out->files[file] = *module;
        add_modules(folder, *module, out);
    }
}

Result<Source> source_of(const std::string& words) {
    const size_t mark = words.rfind(".fl:");
    const fs::path file = mark == std::string::npos ? words : words.substr(0, mark + 3);
    Source out;
    if (mark != std::string::npos) out.fablet = words.substr(mark + 4);
    const Result<std::string> text = read_text_file(file, kMostSourceBytes);
    if (!text) return text.error();
    std::vector<std::string> fablets;
    constexpr std::string_view kFablet = "fablet ";
    for (size_t at = text->find(kFablet); at != std::string::npos;
         at = text->find(kFablet, at + 1)) {
        if (at > 0 && (*text)[at - 1] != '\n') continue;
        const size_t begin = at + kFablet.size();
        fablets.push_back(text->substr(begin, text->find_first_of(" {\n\r", begin) - begin));
    }
    if (out.fablet.empty() && fablets.size() == 1) out.fablet = fablets.front();
    if (std::ranges::find(fablets, out.fablet) == fablets.end()) {
        return usage_error(fmt::format(messages::kWhichFablet, file.string(),
                                       fmt::join(fablets, ", "), file.filename().string()));
    }
    out.files[file.filename().string()] = *text;
    add_modules(file.parent_path(), *text, &out);
    return out;
}

/// Sets kinds of pieces that differ in one uniform of the user's fablet.
Result<void> set_sweep(const SpecimenTrayArguments& arguments, specimens::Trays* trays) {
    trays->mixtures = false;
    for (const std::string& text : arguments.settings) {
        const auto setting = named_value(text, "--set");
        if (!setting) return setting.error();
        trays->uniforms.emplace_back(setting->first, json_of(setting->second));
    }
    if (arguments.sweep.empty()) {
        trays->variants.emplace_back();
        trays->values.emplace_back();
        return {};
    }
    const auto sweep = named_value(arguments.sweep, "--sweep");
    if (!sweep) return sweep.error();
    trays->columns = {sweep->first};
    for (const std::string& value : parts_of(sweep->second, ',')) {
        trays->variants.push_back({{sweep->first, json_of(value)}});
        trays->values.push_back({value});
    }
    return {};
}

Result<void> check_names(const SpecimenTrayArguments& arguments, const world::Printer& printer) {
    std::vector<std::string> inks;
    for (const world::Ink& ink : printer.inks)
        inks.push_back(ink.name);
    if (arguments.materials.empty()) {
        return usage_error(fmt::format(messages::kSpecimenMaterials, printer.name,
                                       fmt::join(inks.empty() ? names_by_look() : inks, ", ")));
    }
    if (arguments.materials.size() > static_cast<size_t>(printer.max_materials))
        return usage_error(fmt::format(messages::kSpecimenManyMaterials, printer.name,
                                       printer.max_materials, arguments.materials.size()));
    const std::set<std::string> names(arguments.materials.begin(), arguments.materials.end());
    if (names.size() < arguments.materials.size())
        return usage_error(messages::kSpecimenMaterialTwice);
    const bool own = !arguments.fablet.empty();
    if (own && !arguments.mixtures.empty()) return usage_error(messages::kMixtureOfFablet);
    if (!own && (!arguments.settings.empty() || !arguments.sweep.empty()))
        return usage_error(messages::kSweepOfMixture);
    return {};
}

Result<specimens::Trays> trays_of(const SpecimenTrayArguments& arguments,
                                  const world::Printer& printer) {
    if (const Result<void> names = check_names(arguments, printer); !names) return names.error();
    specimens::Trays out;
    out.piece = specimens::find_piece(arguments.piece);
    if (out.piece == nullptr)
        return usage_error(fmt::format(messages::kSpecimenPiece, arguments.piece,
                                       suggest(arguments.piece, specimens::piece_names())));
    out.thickness_mm = out.piece->thickness_mm;
    for (const auto& [text, to] :
         {std::pair(&arguments.thickness, &out.thickness_mm), {&arguments.gap, &out.gap_mm}}) {
        if (text->empty()) continue;
        const Result<double> length = parse_length_mm(*text);
        if (!length) return length.error();
        *to = *length;
    }
    if (!(out.thickness_mm >= kThinnestMm && out.thickness_mm <= kThickestMm))
        return usage_error(
            fmt::format(messages::kSpecimenThickness, out.thickness_mm, kThinnestMm, kThickestMm));
    if (!(out.gap_mm >= 0)) return usage_error(messages::kSpecimenGap);
    out.along = !arguments.along.empty() ? arguments.along.front()
                : out.piece->is_disc()   ? 'z'
                                         : 'x';
    out.copies = arguments.copies;
    out.printer = fs::path(arguments.printer).filename().string();
    if (printer.knows_build_volume()) out.tray_mm = printer.build_volume_mm;
    out.materials = materials_text(arguments.materials, printer);
    // Digits of a clear material are hard to read.
    const auto seen = std::ranges::find_if_not(
        arguments.materials, [](const std::string& name) { return is_called(name, "clear"); });
    out.label_material = seen == arguments.materials.end() ? arguments.materials.front() : *seen;
    const Result<void> kinds =
        arguments.fablet.empty() ? set_mixtures(arguments, &out) : set_sweep(arguments, &out);
    if (!kinds) return kinds.error();
    if (static_cast<int>(out.variants.size()) * out.copies > kMostSpecimens)
        return usage_error(
            fmt::format(messages::kSpecimenCount, out.variants.size(), out.copies, kMostSpecimens));
    return out;
}

std::string with_parts(size_t n) {
    std::string out(stock_text("specimen.fl"));
    set_stock_constant("PARTS", n, &out);
    return out;
}

fs::path world_name(size_t tray) {
    return tray == 0 ? "specimens.fab.json" : fmt::format("specimens-{}.fab.json", tray + 1);
}

Result<std::pair<double, double>> range_of(const std::string& text) {
    const std::vector<std::string> parts = parts_of(text, ':');
    double from = 0, to = 0;
    if (parts.size() != 2 || !is_number(parts[0], &from) || !is_number(parts[1], &to) ||
        !(from >= 0 && to > from))
        return usage_error(fmt::format(messages::kStrainRange, text));
    return std::pair(from, to);
}

std::string scatter_text(const specimens::Scatter& scatter) {
    return fmt::format("{:.4g} +- {:.2g}", scatter.mean, scatter.deviation);
}

void show_kinds(const specimens::List& list, const specimens::Measurements& measured) {
    for (const specimens::Kind& kind : measured.kinds) {
        std::string name;
        for (size_t i = 0; i < kind.values.size(); ++i)
            name += fmt::format("{}{} {}", i == 0 ? "" : ", ", list.columns[i], kind.values[i]);
        show(fmt::format("{}{}E {} MPa, strength {} MPa, strain at break {}, of {}\n", name,
                         name.empty() ? "" : ": ", scatter_text(kind.modulus_MPa),
                         scatter_text(kind.strength_MPa), scatter_text(kind.strain_at_break),
                         kind.modulus_MPa.count));
    }
}

}  // namespace

Result<void> make_specimens(const SpecimenTrayArguments& arguments) {
    const Result<world::Printer> printer = world::load_printer(arguments.printer);
    if (!printer) return printer.error();
    if (arguments.copies < 1 || arguments.copies > kMostCopies || arguments.steps < 1 ||
        arguments.steps > kMostSteps)
        return usage_error(fmt::format(messages::kSpecimenNumbers, kMostCopies, kMostSteps));
    Result<specimens::Trays> trays = trays_of(arguments, *printer);
    if (!trays) return trays.error();
    const fs::path folder = arguments.folder;
    std::error_code status;
    if (fs::exists(folder, status))
        return user_error(fmt::format(messages::kNameExists, arguments.folder));
    std::map<std::string, std::string> files{{"label.fl", with_parts(1)}};
    if (arguments.fablet.empty()) {
        files["specimen.fl"] = with_parts(arguments.materials.size());
    } else {
        const Result<Source> source = source_of(arguments.fablet);
        if (!source) return source.error();
        trays->fablet = source->fablet;
        const fs::path words = arguments.fablet.substr(0, arguments.fablet.rfind(".fl") + 3);
        trays->source = words.filename().string();
        for (const auto& [name, text] : source->files)
            files[name] = text;
    }
    const Result<specimens::MadeTrays> made = specimens::make_trays(*trays);
    if (!made) return made.error();
    for (size_t i = 0; i < made->worlds.size(); ++i)
        files[world_name(i).string()] = made->worlds[i];
    files["specimens.csv"] = specimens::list_text(made->list);
    for (const auto& [name, text] : files)
        if (const Result<void> written = write_file(folder / name, text); !written) return written;
    if (const Result<void> written = copy_profile(arguments.printer, folder); !written)
        return written;
    show(fmt::format("{}\n",
                     fmt::format(messages::kSpecimensMade, made->list.specimens.size(),
                                 trays->piece->standard, made->worlds.size(), folder.string())));
    return {};
}

Result<void> read_specimens(const SpecimenReadArguments& arguments) {
    const fs::path folder = arguments.folder;
    const Result<specimens::List> list = specimens::read_list(folder / "specimens.csv");
    if (!list) return list.error();
    specimens::MeasuredOptions options;
    options.curve.strain = arguments.strain;
    options.curve.stress = arguments.stress;
    options.curve.length_mm = 0;
    if (!arguments.length.empty()) {
        const Result<double> length = parse_length_mm(arguments.length);
        if (!length) return length.error();
        if (!(*length > 0)) return usage_error(messages::kSpecimenLength);
        options.curve.length_mm = *length;
    }
    specimens::Origin origin{arguments.source, {}};
    if (arguments.temperature.empty() != arguments.rate.empty())
        return usage_error(messages::kTemperatureAndRate);
    const Result<Conditions> conditions = parse_conditions(arguments.temperature, arguments.rate);
    if (!conditions) return conditions.error();
    origin.conditions = *conditions;
    const auto range = range_of(arguments.range);
    if (!range) return range.error();
    std::tie(options.curve.from, options.curve.to) = *range;
    std::map<std::string, double> poisson;
    for (const std::string& text : arguments.poisson) {
        const auto ratio = named_value(text, "--nu");
        if (!ratio) return ratio.error();
        double nu = 0;
        if (!is_number(ratio->second, &nu) || !(nu > -1 && nu < 0.5))
            return usage_error(fmt::format(messages::kPoissonOutside, ratio->second));
        poisson[ratio->first] = nu;
    }
    const Result<specimens::Measurements> measured =
        specimens::measure(*list, arguments.curves, options);
    if (!measured) return measured.error();
    const Result<specimens::Tables> tables = specimens::tables(*list, *measured, origin, poisson);
    if (!tables) return tables.error();
    if (!measured->missing.empty())
        note(fmt::format(messages::kSpecimensMissing, fmt::join(measured->missing, ", ")));
    if (!measured->unmatched.empty())
        warn(fmt::format(messages::kCurvesUnmatched, fmt::join(measured->unmatched, ", ")));
    if (measured->extensions) note(messages::kStrainOfGrips);
    for (const std::string& text : tables->notes)
        note(text);
    Result<void> written =
        write_file(folder / "measured.csv", specimens::measured_text(*list, *measured));
    for (const specimens::DataFile& file : tables->files)
        if (written) written = write_file(folder / file.name, file.text);
    if (!written) return written;
    show_kinds(*list, *measured);
    return {};
}

}  // namespace openfab::tools
