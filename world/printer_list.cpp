// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/printer_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>

#include <algorithm>

#include "base/text.h"

namespace openfab::world {

namespace {

using Json = rapidjson::PrettyWriter<rapidjson::StringBuffer>;

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

void key(Json& json, const char* name) {
    json.Key(name);
}

void put(Json& json, const std::string& text) {
    const std::string valid = valid_utf8(text);
    json.String(valid.c_str(), static_cast<rapidjson::SizeType>(valid.size()));
}

void put(Json& json, double number) {
    if (number > 0) {
        json.Double(number);
    } else {
        json.Null();
    }
}

template <typename Items>
void put_list(Json& json, const char* name, const Items& items) {
    key(json, name);
    json.StartArray();
    for (const auto& item : items)
        put(json, item);
    json.EndArray();
}

void put_printer(Json& json, const Printer& printer) {
    json.StartObject();
    for (const auto& [name, text] :
         {std::pair<const char*, const std::string&>{"name", printer.name},
          {"maker", printer.maker},
          {"model", printer.model}}) {
        key(json, name);
        put(json, text);
    }
    put_list(json, "pitch_mm",
             std::array{printer.pitch_mm.x, printer.pitch_mm.y, printer.pitch_mm.z});
    put_list(json, "layers_um", printer.layers_um);
    const Vec3d& room = printer.build_volume_mm;
    put_list(json, "build_volume_mm", std::array{room.x, room.y, room.z});
    key(json, "max_materials");
    json.Int(printer.max_materials);
    key(json, "native_format");
    put(json, printer.native_format);
    put_list(json, "formats", formats_of(printer));
    key(json, "mesh_colors");
    json.Bool(printer.mesh_colors);
    key(json, "makes_support");
    json.Bool(printer.makes_support);
    key(json, "layer_time_s");
    put(json, printer.layer_time_s);
    key(json, "inks");
    json.StartArray();
    for (const Ink& ink : printer.inks) {
        json.StartObject();
        key(json, "name");
        put(json, ink.name);
        key(json, "density_g_cm3");
        put(json, ink.density_g_cm3);
        json.EndObject();
    }
    json.EndArray();
    key(json, "handoff");
    put(json, printer.handoff);
    key(json, "sources");
    json.StartArray();
    for (const PrinterSource& source : printer.sources) {
        json.StartObject();
        key(json, "document");
        put(json, source.document);
        key(json, "url");
        put(json, source.url);
        key(json, "seen");
        put(json, std::string(word_of(source.seen)));
        put_list(json, "gives", source.gives);
        json.EndObject();
    }
    json.EndArray();
    key(json, "unknown");
    json.StartObject();
    for (const auto& [figure, why] : printer.unknown) {
        put(json, figure);  // a string in the place of a key is one
        put(json, why);
    }
    json.EndObject();
    json.EndObject();
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
    rapidjson::StringBuffer buffer;
    Json json(buffer);
    json.SetIndent(' ', 2);
    json.SetFormatOptions(rapidjson::kFormatSingleLineArray);
    json.StartArray();
    for (const Printer& printer : printers)
        put_printer(json, printer);
    json.EndArray();
    return std::string(buffer.GetString(), buffer.GetSize()) + "\n";
}

}  // namespace openfab::world
