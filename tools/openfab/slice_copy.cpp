// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/slice_copy.h"

#include <fmt/format.h>

#include "backends/common/tee_sink.h"
#include "backends/formats/formats.h"
#include "backends/ofr/slice_codec.h"
#include "base/units.h"
#include "program/output_check.h"
#include "program/outputs.h"
#include "runtime/pipeline/print_hash.h"
#include "tools/openfab/known_printer.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

/// Checks the memory for writing besides the reader's slice: a mesher's columns, and previews.
Result<void> check_memory(const ExportOptions& options, const std::string& input,
                          const pipeline::PrintInfo& info, int64_t memory_bytes) {
    const backends::Format* format = backends::find_format(options.print.format);
    const int64_t columns = int64_t{info.size.x} * info.size.y;
    const auto slice_bytes = static_cast<int64_t>(
        backends::packed_row_bytes(info.size.x, info.bits) * static_cast<size_t>(info.size.y));
    // A compressed slice takes at most as much as its packed rows, and twice that while it is
    // assembled.
    const int64_t rows = slice_bytes * (program::is_mesh_format(format) ? 1 : 3);
    const int64_t bytes =
        rows + columns * program::output_bytes_per_column(format, info.materials.size()) +
        program::preview_bytes(options.print);
    if (bytes <= memory_bytes) return {};
    return user_error(fmt::format(
        messages::kSlicesTakeToWrite, input, info.size.x, info.size.y, format_bytes(bytes),
        format == nullptr ? "" : fmt::format(messages::kWrittenAs, format->name),
        format_bytes(memory_bytes)));
}

}  // namespace

Result<int64_t> prepare_copy(ExportOptions* options) {
    options->print.png_indexed = options->png == "indexed";
    for (const std::string& text : options->previews) {
        Result<preview::PreviewSpec> spec = preview::parse_preview(text);
        if (!spec) return spec.error();
        options->print.previews.push_back(*spec);
    }
    if (options->print.output.empty() && options->previews.empty())
        return usage_error(messages::kNoOutputGiven);
    return parse_memory_option(options->memory);
}

Result<void> check_copy(ExportOptions* options, const std::vector<std::string>& inputs,
                        const pipeline::PrintInfo& info, int64_t memory_bytes) {
    const bool one_slice = options->slice >= 0;
    world::Printer printer = printer_of(info);
    printer.native_format = "png";
    if (one_slice) {
        const std::string& output = options->print.output;
        const bool is_picture = output.empty() || output == "-" || output.ends_with(".png");
        if (!is_picture || (!options->print.format.empty() && options->print.format != "png"))
            return usage_error(messages::kSliceMakesPicture);
        options->print.format = "png";
    } else {
        const Result<const backends::Format*> format =
            program::choose_format(options->print, printer);
        if (!format) return format.error();
        options->print.format = *format == nullptr ? "" : std::string((*format)->name);
    }
    if (Result<void> fits = check_memory(*options, inputs.front(), info, memory_bytes); !fits)
        return fits;
    std::vector<std::filesystem::path> files;
    for (const std::string& input : inputs)
        files.emplace_back(input == "-" ? "/dev/stdin" : input);
    // With `--slice`, `-o` is a file.
    return program::check_outputs(
        options->print, one_slice ? nullptr : backends::find_format(options->print.format),
        info.materials, files);
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

Result<pipeline::PrintTotals> copy_slices(const prints::PrintFile& print,
                                          pipeline::SliceSink* sink) {
    const pipeline::PrintInfo& info = print.info();
    pipeline::PrintTotals totals;
    totals.voxels_by_code.resize(info.materials.size() + 1);
    totals.tight = {{0, 0, info.slice_begin}, {info.size.x, info.size.y, info.slice_end}};
    prints::SliceBuffers buffers;
    for (int32_t z = info.slice_begin; z < info.slice_end; ++z) {
        if (Result<void> read = print.read_slice(z, &buffers); !read) return read.error();
        const std::array<int64_t, 256> counts = ofr::count_codes(buffers.rows, info.bits);
        for (size_t code = 0; code < totals.voxels_by_code.size(); ++code) {
            totals.voxels_by_code[code] += counts[code];
            totals.voxels_solid += code > 0 ? counts[code] : 0;
        }
        totals.hash += pipeline::slice_hash(z, buffers.rows.data(), print.row_bytes(), info.size.y);
        const pipeline::SliceView slice{z, buffers.rows.data(), print.row_bytes(), info.size.x,
                                        info.size.y};
        if (Result<void> done = sink->commit(z, sink->encode(slice)); !done) return done.error();
    }
    if (const auto known = print.totals()) totals.tight = known->tight;
    totals.complete = true;
    return totals;
}

void add_slices_read(const ofr::OfrReader& reader, pipeline::PrintTotals* totals) {
    totals->voxels_by_code.resize(reader.counts().size());
    for (size_t code = 0; code < reader.counts().size(); ++code) {
        totals->voxels_by_code[code] += reader.counts()[code];
        if (code > 0) totals->voxels_solid += reader.counts()[code];
    }
    totals->hash += reader.hash();
}

}  // namespace openfab::tools
