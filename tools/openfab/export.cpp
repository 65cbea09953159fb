// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab export FILE.ofr -o OUT`: another format of the same slices, meshes or pictures of them,
// or one slice as a picture; OpenVDB of fractions; and worlds as functions of 3MF.

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <vector>

#include "backends/common/output_file.h"
#include "backends/ofr/ofr_reader.h"
#include "backends/raster/npy_sink.h"
#include "backends/raster/slice_files.h"
#include "backends/read/gcvf_print.h"
#include "base/say.h"
#include "base/start_program.h"
#include "program/output_check.h"
#include "program/outputs.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/export_functions.h"
#include "tools/openfab/known_printer.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/programs.h"
#include "tools/openfab/slice_copy.h"

namespace openfab::tools {

namespace {

Result<void> export_slice(const ExportOptions& options, ofr::OfrReader* reader) {
    raster::FolderOptions png;
    png.format =
        options.png == "indexed" ? raster::SliceFormat::kIndexed : raster::SliceFormat::kRgba;
    png.flip_x = options.print.flip_x;
    for (;;) {
        Result<bool> more = reader->next();
        if (!more) return more.error();
        if (!*more) {
            return user_error(fmt::format(messages::kNotAmongSlices, options.file,
                                          reader->info().slice_begin, reader->info().slice_end - 1,
                                          options.slice));
        }
        if (reader->slice().z != options.slice) continue;
        const std::vector<uint8_t> bytes =
            raster::encode_slice(reader->slice(), reader->info(), png);
        return backends::write_whole_file(options.print.output, bytes);
    }
}

/// Says what is to be known of a print in the format that was chosen.
void note_of_format(const ExportOptions& options, const pipeline::PrintInfo& info) {
    const Result<const backends::Format*> format =
        program::choose_format(options.print, printer_of(info));
    if (!format || *format == nullptr) return;
    if (const world::Printer printer = printer_of(info);
        program::is_mesh_format(*format) && printer.mesh_colors)
        note(fmt::format(messages::kNoMixturesLeft, printer.name));
    if ((*format)->note == nullptr) return;
    if (const std::string text = (*format)->note(info); !text.empty()) note(text);
}

Result<void> export_all(const ExportOptions& options, ofr::OfrReader* reader) {
    Result<std::unique_ptr<pipeline::SliceSink>> sink =
        program::open_output(options.print, printer_of(reader->info()));
    if (!sink) return sink.error();
    note_of_format(options, reader->info());
    Result<void> done = (*sink)->begin(reader->info());
    if (!done) return done;
    done = copy_slices(reader, sink->get());
    // Complete slices stay; the output is marked as incomplete.
    pipeline::PrintTotals totals;
    if (done) {
        totals = reader->totals();
    } else {
        add_slices_read(*reader, &totals);
    }
    Result<void> finished = (*sink)->finish(totals);
    return done ? finished : done;
}

/// Of folders and packages, which are whole or nothing here.
Result<void> export_print(ExportOptions options, int64_t memory_bytes) {
    if (options.slice >= 0) return usage_error(messages::kSliceOfOfr);
    const Result<std::unique_ptr<prints::PrintFile>> print =
        prints::PrintFile::open(options.file, memory_bytes);
    if (!print) return print.error();
    const pipeline::PrintInfo& info = (*print)->info();
    if (Result<void> fine = check_copy(&options, {options.file}, info, memory_bytes); !fine)
        return fine;
    const int32_t planned = info.slice_end - info.slice_begin;
    if ((*print)->whole_slices() < planned)
        return user_error(
            fmt::format(messages::kSlicesMissing, options.file, (*print)->whole_slices(), planned));
    Result<std::unique_ptr<pipeline::SliceSink>> sink =
        program::open_output(options.print, printer_of(info));
    if (!sink) return sink.error();
    note_of_format(options, info);
    Result<void> done = (*sink)->begin(info);
    if (!done) return done;
    const Result<pipeline::PrintTotals> totals = copy_slices(**print, sink->get());
    const Result<void> finished = (*sink)->finish(totals ? *totals : pipeline::PrintTotals());
    return totals ? finished : Result<void>(totals.error());
}

bool writes_vdb(const ExportOptions& options) {
    return options.print.format == "vdb" ||
           (options.print.format.empty() && options.print.output.ends_with(".vdb"));
}

/// Replaces the process by the program that links OpenVDB; returns only where that fails.
Error exec_vdb(const ExportOptions& options, int64_t memory_bytes) {
    Result<std::filesystem::path> folder = program_folder();
    if (!folder) return folder.error();
    const std::filesystem::path helper = *folder / "openfab-vdb";
    if (!std::filesystem::exists(helper)) {
        Error error = outside_error(messages::kBuiltWithoutOpenVdb);
        error.help = messages::kBuiltWithoutOpenVdbHelp;
        return error;
    }
    const std::string memory = fmt::format("--memory={}B", memory_bytes);
    const std::string output = "--output=" + options.print.output;
    const char* const argv[] = {helper.c_str(), output.c_str(),       memory.c_str(),
                                "--",           options.file.c_str(), nullptr};
    ::execv(helper.c_str(), const_cast<char* const*>(argv));
    return outside_error(
        fmt::format(messages::kCannotStartProgram, helper.string(), std::strerror(errno)));
}

Result<void> export_vdb(const ExportOptions& options, int64_t memory_bytes) {
    if (options.slice >= 0 || !options.previews.empty())
        return usage_error(messages::kPicturesApart);
    if (options.print.output.empty() || options.print.output == "-")
        return usage_error(messages::kVdbAlone);
    std::vector<std::filesystem::path> inputs{options.file == "-" ? "/dev/stdin" : options.file};
    if (options.file.ends_with(".npy")) inputs.emplace_back(raster::array_json_path(options.file));
    const std::filesystem::path output = options.print.output;
    if (Result<void> apart =
            program::check_outputs({{"-o", output}, {"-o", output.string() + ".part"}}, inputs);
        !apart)
        return apart;
    return exec_vdb(options, memory_bytes);
}

Result<void> export_world(const ExportOptions& options, int64_t memory_bytes) {
    if (options.slice >= 0 || !options.previews.empty())
        return usage_error(messages::kSlicesOfWorlds);
    if (!options.print.format.empty() && options.print.format != "3mf")
        return usage_error(fmt::format(messages::kWorldAs3mf, options.print.format));
    return export_functions({options.file, options.print.output, options.voxel, options.composite,
                             options.programs, options.settings, memory_bytes});
}

}  // namespace

Result<void> run_export(ExportOptions options) {
    const Result<int64_t> memory = prepare_copy(&options);
    if (!memory) return memory.error();
    if (options.file.ends_with(".json")) return export_world(options, *memory);
    if (options.composite || options.programs || !options.voxel.empty() ||
        !options.settings.empty())
        return usage_error(messages::kOptionsOfWorlds);
    if (writes_vdb(options)) return export_vdb(options, *memory);
    if (options.file.ends_with(".npy")) {
        return usage_error(messages::kFractionsAsVdb);
    }
    if (options.slice >= 0 && (options.print.output.empty() || !options.previews.empty()))
        return usage_error(messages::kSliceIsOnePicture);
    std::error_code ignored;
    if (prints::is_gcvf(options.file) || std::filesystem::is_directory(options.file, ignored))
        return export_print(std::move(options), *memory);
    Result<std::unique_ptr<ofr::OfrReader>> reader = ofr::OfrReader::open(options.file, *memory);
    if (!reader) return reader.error();
    if (Result<void> fine = check_copy(&options, {options.file}, (*reader)->info(), *memory); !fine)
        return fine;
    if (options.slice >= 0) return export_slice(options, reader->get());
    return export_all(options, reader->get());
}

}  // namespace openfab::tools
