// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab export FILE.ofr -o OUT`: another format of the same slices, meshes or pictures of them,
// or one slice as a picture.

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "backends/common/output_file.h"
#include "backends/ofr/ofr_reader.h"
#include "backends/raster/png_sink.h"
#include "base/units.h"
#include "program/output_check.h"
#include "program/outputs.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/known_printer.h"
#include "tools/openfab/memory_option.h"

namespace openfab::tools {

namespace {

pipeline::PrintTotals totals_so_far(const ofr::OfrReader& reader) {
    pipeline::PrintTotals totals;
    totals.voxels_by_code = reader.counts();
    for (size_t code = 1; code < totals.voxels_by_code.size(); ++code)
        totals.voxels_solid += totals.voxels_by_code[code];
    totals.hash = reader.hash();
    return totals;
}

Result<void> export_slice(const ExportOptions& options, ofr::OfrReader* reader) {
    raster::PngOptions png;
    png.indexed = options.png == "indexed";
    png.flip_x = options.print.flip_x;
    for (;;) {
        Result<bool> more = reader->next();
        if (!more) return more.error();
        if (!*more) {
            return user_error(fmt::format("{} has the slices {} to {}, not {}", options.file,
                                          reader->info().slice_begin, reader->info().slice_end - 1,
                                          options.slice));
        }
        if (reader->slice().z != options.slice) continue;
        const std::vector<uint8_t> bytes =
            raster::encode_slice(reader->slice(), reader->info(), png);
        return backends::write_whole_file(options.print.output, bytes);
    }
}

Result<void> copy_slices(ofr::OfrReader* reader, pipeline::SliceSink* sink) {
    for (;;) {
        Result<bool> more = reader->next();
        if (!more) return more.error();
        if (!*more) return {};
        const pipeline::SliceView& slice = reader->slice();
        if (Result<void> done = sink->commit(slice.z, sink->encode(slice)); !done) return done;
    }
}

Result<void> export_all(const ExportOptions& options, ofr::OfrReader* reader) {
    Result<std::unique_ptr<pipeline::SliceSink>> sink =
        program::open_output(options.print, printer_of(reader->info()));
    if (!sink) return sink.error();
    Result<void> done = (*sink)->begin(reader->info());
    if (!done) return done;
    done = copy_slices(reader, sink->get());
    // Complete slices stay; the output is marked as incomplete.
    Result<void> finished = (*sink)->finish(done ? reader->totals() : totals_so_far(*reader));
    return done ? finished : done;
}

/// Checks the memory for writing besides the reader's slice: a mesher's columns, and previews.
Result<void> check_memory(const ExportOptions& options, const ofr::OfrReader& reader,
                          int64_t memory_bytes) {
    const pipeline::PrintInfo& info = reader.info();
    const std::string& format = options.print.format;
    const int64_t columns = int64_t{info.size.x} * info.size.y;
    // A compressed slice takes at most as much as its packed rows, and twice that while it is
    // assembled.
    const int64_t rows = reader.slice_bytes() * (format == "ofr" || format == "png" ? 3 : 1);
    const int64_t bytes = rows + columns * program::output_bytes_per_column(format) +
                          program::preview_bytes(options.print);
    if (bytes <= memory_bytes) return {};
    return user_error(fmt::format(
        "{}: slices of {} x {} voxels take {} to write{}, and `--memory` allows {}; raise it if "
        "you trust the file",
        options.file, info.size.x, info.size.y, format_bytes(bytes),
        format.empty() ? "" : " as " + format, format_bytes(memory_bytes)));
}

/// Checks the outputs before any is opened. With `--slice`, `-o` is a file.
Result<void> check_apart(const ExportOptions& options, const pipeline::PrintInfo& info) {
    const std::string format = options.slice >= 0 ? "" : options.print.format;
    return program::check_outputs(options.print, format, info.materials,
                                  {options.file == "-" ? "/dev/stdin" : options.file});
}

}  // namespace

Result<void> run_export(ExportOptions options) {
    options.print.png_indexed = options.png == "indexed";
    for (const std::string& text : options.previews) {
        Result<preview::PreviewSpec> spec = preview::parse_preview(text);
        if (!spec) return spec.error();
        options.print.previews.push_back(*spec);
    }
    if (options.print.output.empty() && options.previews.empty()) {
        return usage_error("no output given; write `-o FOLDER` or `--preview FILE.png`");
    }
    if (options.slice >= 0) {
        if (options.print.output.empty() || !options.previews.empty())
            return usage_error("`--slice` writes one picture; write `--slice N -o FILE.png`");
        options.print.format = "png";
    }
    const Result<int64_t> memory = memory_of(options.memory);
    if (!memory) return memory.error();
    Result<std::unique_ptr<ofr::OfrReader>> reader = ofr::OfrReader::open(options.file, *memory);
    if (!reader) return reader.error();
    world::Printer printer = printer_of((*reader)->info());
    if (options.slice < 0) {
        printer.native_format = "png";
        Result<std::string> format = program::choose_format(options.print, printer);
        if (!format) return format.error();
        options.print.format = *format;
    }
    if (Result<void> fits = check_memory(options, **reader, *memory); !fits) return fits;
    if (Result<void> apart = check_apart(options, (*reader)->info()); !apart) return apart;
    if (options.slice >= 0) return export_slice(options, reader->get());
    return export_all(options, reader->get());
}

}  // namespace openfab::tools
