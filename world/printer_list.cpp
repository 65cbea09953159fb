// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/printer_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/json_text.h"
#include "base/text.h"

namespace openfab::world {

namespace {

std::string length(double value) {
    return value > 0 ? fmt::format("{:.4g}", value) : "?";
}

std::string tray_of(const Printer& printer) {
    const Vec3d& room = printer.build_volume_mm;
    if (!printer.knows_build_volume()) return "?";
    return fmt::format("{} x {} x {}", length(room.x), length(room.y), length(room.z));
}

std::string pitch_of(const Printer& printer) {
    const Vec3d um = printer.pitch_mm * 1000.0;
    return fmt::format("{} x {} x {}", length(um.x), length(um.y), length(um.z));
}

/// The formats of its front end; what is printed without a format, where they are not listed.
std::vector<std::string> formats_of(const Printer& printer) {
    return printer.formats.empty() ? std::vector{printer.native_format} : printer.formats;
}

const char* word_of(Seen seen) {
    switch (seen) {
        case Seen::kRead:
            return "read";
        case Seen::kQuoted:
            return "quoted";
        case Seen::kUnread:
            return "unread";
    }
    return "";
}

void put(JsonText* json, const std::string& text) {
    json->value(text);
}

/// What is not known is 0.
void put(JsonText* json, double number) {
    if (number > 0) {
        json->value(number);
    } else {
        json->null();
    }
}

template <typename Items>
void put_list(JsonText* json, const char* name, const Items& items) {
    json->key(name).begin_array();
    for (const auto& item : items)
        put(json, item);
    json->end_array();
}

void put_printer(JsonText* json, const Printer& printer) {
    json->begin_object().member("name", printer.name).member("maker", printer.maker);
    json->member("model", printer.model);
    const Vec3d &pitch = printer.pitch_mm, &room = printer.build_volume_mm;
    put_list(json, "pitch_mm", std::array{pitch.x, pitch.y, pitch.z});
    put_list(json, "layers_um", printer.layers_um);
    put_list(json, "build_volume_mm", std::array{room.x, room.y, room.z});
    json->member("max_materials", printer.max_materials);
    json->member("native_format", printer.native_format);
    put_list(json, "formats", formats_of(printer));
    json->member("mesh_colors", printer.mesh_colors);
    json->member("makes_support", printer.makes_support);
    put(&json->key("layer_time_s"), printer.layer_time_s);
    json->key("inks").begin_array();
    for (const Ink& ink : printer.inks) {
        json->begin_object().member("name", ink.name);
        put(&json->key("density_g_cm3"), ink.density_g_cm3);
        json->end_object();
    }
    json->end_array().member("handoff", printer.handoff).key("sources").begin_array();
    for (const PrinterSource& source : printer.sources) {
        json->begin_object().member("document", source.document).member("url", source.url);
        json->member("seen", word_of(source.seen));
        put_list(json, "gives", source.gives);
        json->end_object();
    }
    json->end_array().key("unknown").begin_object();
    for (const auto& [figure, why] : printer.unknown)
        json->member(figure, why);
    json->end_object().end_object();
}

}  // namespace

std::string printer_table(const std::vector<Printer>& printers) {
    const std::array<std::string, 7> head = {"name",       "maker",     "model",  "tray (mm)",
                                             "voxel (um)", "materials", "formats"};
    std::vector<std::array<std::string, 7>> rows = {head};
    for (const Printer& printer : printers) {
        rows.push_back({printable(printer.name), printable(printer.maker), printable(printer.model),
                        tray_of(printer), pitch_of(printer),
                        fmt::format("{}", printer.max_materials),
                        printable(fmt::format("{}", fmt::join(formats_of(printer), ", ")))});
    }
    std::array<size_t, 7> width{};
    for (const auto& row : rows) {
        for (size_t i = 0; i < row.size(); ++i)
            width[i] = std::max(width[i], row[i].size());
    }
    std::string text;
    for (const auto& row : rows) {
        for (size_t i = 0; i + 1 < row.size(); ++i)
            text += fmt::format("{:<{}}  ", row[i], width[i]);
        text += row.back() + "\n";
    }
    return text;
}

std::string printer_sheet(const Printer& printer) {
    std::string text = fmt::format("{}: {} {}\n\n", printable(printer.name),
                                   printable(printer.maker), printable(printer.model));
    const auto row = [&](const char* name, const std::string& value) {
        text += fmt::format("{:<20}{}\n", name, value);
    };
    row("tray", tray_of(printer) + " mm");
    row("voxel", pitch_of(printer) + " um");
    if (printer.pitch_mm.x > 0) {
        row("resolution", fmt::format("{:.6g} x {:.6g} dpi", 25.4 / printer.pitch_mm.x,
                                      25.4 / printer.pitch_mm.y));
    }
    if (printer.layers_um.size() > 1)
        row("layers", fmt::format("{} um (`--layer`)", fmt::join(printer.layers_um, ", ")));
    row("materials at once", fmt::format("{}", printer.max_materials));
    row("formats", printable(fmt::format("{}", fmt::join(formats_of(printer), ", "))));
    row("support", printer.makes_support ? "made by the front end" : "in the slices");
    if (printer.layer_time_s > 0)
        row("time of a layer", fmt::format("{:.4g} s", printer.layer_time_s));
    text += "\n" + printable(printer.handoff) + "\n";
    if (!printer.inks.empty()) text += "\nInks:\n";
    for (const Ink& ink : printer.inks) {
        text += fmt::format("  {:<24}{}\n", printable(ink.name),
                            ink.density_g_cm3 > 0 ? fmt::format("{:.4g} g/cm3", ink.density_g_cm3)
                                                  : "density unknown");
    }
    if (!printer.sources.empty()) text += "\nTaken from:\n";
    for (const PrinterSource& source : printer.sources) {
        text += fmt::format("  {}\n    {}{}\n", printable(source.document),
                            printable(fmt::format("{}", fmt::join(source.gives, ", "))),
                            source.seen == Seen::kRead     ? ""
                            : source.seen == Seen::kQuoted ? " (as others quote it)"
                                                           : " (not opened here: check it)");
        if (!source.url.empty()) text += "    " + printable(source.url) + "\n";
    }
    if (!printer.unknown.empty()) text += "\nNot known:\n";
    for (const auto& [figure, why] : printer.unknown)
        text += fmt::format("  {}: {}\n", printable(figure), printable(why));
    return text;
}

std::string printers_json(const std::vector<Printer>& printers) {
    JsonText json(JsonText::Layout::kIndentedLists);
    json.begin_array();
    for (const Printer& printer : printers)
        put_printer(&json, printer);
    return json.end_array().take() + "\n";
}

}  // namespace openfab::world
