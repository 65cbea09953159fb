// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <functional>
#include <utility>
#include <vector>

#include "backends/boundary/mesh_sink.h"
#include "backends/common/tee_sink.h"
#include "backends/gcvf/gcvf_sink.h"
#include "backends/ofr/ofr_sink.h"
#include "backends/ofr/slice_codec.h"
#include "backends/preview/preview.h"
#include "backends/raster/folder_sink.h"
#include "backends/raster/npy_sink.h"
#include "backends/raster/slice_files.h"
#include "backends/stream/stream_sink.h"

namespace openfab::program {

namespace {

raster::SliceFormat slice_format(const Options& options, const std::string& format) {
    return format == "bmp"       ? raster::SliceFormat::kBitmaps
           : options.png_indexed ? raster::SliceFormat::kIndexed
                                 : raster::SliceFormat::kRgba;
}

raster::FolderOptions folder_options(const Options& options, const world::Printer& printer,
                                     const std::string& format) {
    raster::FolderOptions folder;
    folder.format = slice_format(options, format);
    folder.flip_x = options.flip_x;
    folder.front_end_makes_support = printer.makes_support;
    folder.handoff = printer.handoff;
    return folder;
}

/// Encodes as the sink of a format does, and discards.
class Encoder : public backends::NullSink {
  public:
    using Encode = std::function<std::vector<uint8_t>(const pipeline::SliceView& slice,
                                                      const pipeline::PrintInfo& info)>;
    explicit Encoder(Encode encode) : encode_(std::move(encode)) {}
    Result<void> begin(const pipeline::PrintInfo& info) override {
        info_ = info;
        return {};
    }
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override {
        return encode_(slice, info_);
    }

  private:
    Encode encode_;
    pipeline::PrintInfo info_;
};

Result<std::unique_ptr<pipeline::SliceSink>> open_format(const Options& options,
                                                         const world::Printer& printer,
                                                         const std::string& format,
                                                         const std::atomic<bool>* interrupt) {
    if (format.empty())
        return std::unique_ptr<pipeline::SliceSink>(std::make_unique<backends::NullSink>());
    if (options.resume && !can_be_resumed(options, format)) {
        return usage_error(fmt::format(
            "`--resume` cannot continue `{}`: {}", options.output,
            is_mesh_format(format)
                ? "a mesh is closed by its last slice, so nothing is left of one that was cut "
                  "short; print an .ofr file, and make meshes of it with `openfab export`"
            : format == "gcvf"
                ? "a package is closed after its last slice, so nothing is left of one that was "
                  "cut short; print an .ofr file, and make a gcvf of it with `openfab export`"
            : format == "npy" ? "an array does not keep what it was made of; print an .ofr file, "
                                "and make an array of it with `openfab export`"
                              : "it is not a file that keeps what was written"));
    }
    if (stream::is_address(options.output)) {
        Result<stream::Address> address = stream::parse_address(options.output);
        if (!address) return address.error();
        Result<std::string> token = stream::load_token(options.token_file);
        if (!token) return token.error();
        std::unique_ptr<stream::TlsContext> tls;
        if (address->is_tls) {
            auto trusted = stream::TlsContext::for_senders(options.tls_ca);
            if (!trusted) return trusted.error();
            tls = std::move(*trusted);
        }
        return std::unique_ptr<pipeline::SliceSink>(std::make_unique<stream::StreamSink>(
            std::move(*address), std::move(*token), std::move(tls), options.resume, interrupt));
    }
    if (format == "ofr") {
        return options.resume ? ofr::OfrSink::reopen(options.output)
                              : ofr::OfrSink::create(options.output);
    }
    if (is_mesh_format(format)) {
        return std::unique_ptr<pipeline::SliceSink>(std::make_unique<boundary::MeshSink>(
            format == "stl"        ? boundary::make_stl_writer(options.output)
            : format == "filament" ? boundary::make_filament_writer(options.output)
                                   : boundary::make_threemf_writer(options.output)));
    }
    if (format == "gcvf") {
        return std::unique_ptr<pipeline::SliceSink>(
            std::make_unique<gcvf::GcvfSink>(options.output, options.flip_x));
    }
    if (format == "npy") return raster::NpySink::create(options.output);
    raster::FolderOptions folder = folder_options(options, printer, format);
    return options.resume ? raster::FolderSink::reopen(options.output, std::move(folder))
                          : raster::FolderSink::create(options.output, std::move(folder));
}

/// `.gcode`, `.tif`, `.7z`, but not the `.2` of `ball_v1.2`.
bool looks_like_file(const std::string& extension) {
    constexpr size_t kLongest = 1 + 6;
    const auto is_letter = [](unsigned char c) { return std::isalpha(c) != 0; };
    const auto is_word = [](unsigned char c) { return std::isalnum(c) != 0; };
    return extension.size() > 1 && extension.size() <= kLongest &&
           std::all_of(extension.begin() + 1, extension.end(), is_word) &&
           std::any_of(extension.begin() + 1, extension.end(), is_letter);
}

Result<std::string> name_format(const Options& options, const world::Printer& printer) {
    if (options.output.empty()) return std::string();
    if (!options.format.empty()) return options.format;
    if (options.output == "-" || stream::is_address(options.output)) return std::string("ofr");
    const std::filesystem::path path(options.output);
    const std::string extension = path.filename().has_filename() ? path.extension().string() : "";
    // A printer that wants painted triangles wants them in its 3MF.
    if (extension == ".3mf" && printer.native_format == "filament") return printer.native_format;
    for (const char* known : {".ofr", ".gcvf", ".npy", ".stl", ".3mf"}) {
        if (extension == known) return std::string(known + 1);
    }
    if (extension == ".png") {
        return usage_error(
            fmt::format("`-o {}`: png slices fill a folder; write `-o {}` with `--format png`, or "
                        "`--preview {}` for a "
                        "picture",
                        options.output, path.stem().string(), options.output));
    }
    if (extension == ".bmp") {
        return usage_error(
            fmt::format("`-o {}`: bmp slices fill a folder; write `-o {} --format bmp`",
                        options.output, path.stem().string()));
    }
    if (extension == ".vdb") {
        return usage_error(fmt::format(
            "`-o {0}`: OpenVDB is written by `openfab export`; write `-o {1}.ofr`, and then "
            "`openfab export {1}.ofr -o {0}`",
            options.output, (path.parent_path() / path.stem()).string()));
    }
    std::error_code ignored;
    if (looks_like_file(extension) && !std::filesystem::is_directory(path, ignored)) {
        return usage_error(fmt::format(
            "`-o {0}`: there is no output format `{1}`; choose from .ofr, .gcvf, .npy, .3mf, .stl, "
            "or "
            "a folder of png slices, `-o {2}`; a folder of this very name is `-o {0}/`",
            options.output, extension.substr(1), (path.parent_path() / path.stem()).string()));
    }
    return printer.native_format;
}

}  // namespace

bool is_folder_format(const std::string& format) {
    return format == "png" || format == "bmp";
}

bool is_mesh_format(const std::string& format) {
    return format == "stl" || format == "3mf" || format == "filament";
}

Result<std::string> choose_format(const Options& options, const world::Printer& printer) {
    Result<std::string> format = name_format(options, printer);
    if (format && options.mesh_pitch_mm && !is_mesh_format(*format)) {
        return usage_error(
            "`--mesh-pitch` is for the formats stl, 3mf and filament; `--voxel` sets the pitch of "
            "slices");
    }
    const bool has_pictures = format && (is_folder_format(*format) || *format == "gcvf");
    if (format && !format->empty() && !has_pictures && options.flip_x) {
        return usage_error(fmt::format(
            "`--flip-x` mirrors the pictures of png, bmp and gcvf; of an .ofr file `openfab export "
            "--flip-x` makes them, and {} is never mirrored",
            *format));
    }
    return format;
}

bool can_be_resumed(const Options& options, const std::string& format) {
    if (is_folder_format(format) || stream::is_address(options.output)) return true;
    std::error_code ignored;
    const std::filesystem::file_status there = std::filesystem::status(options.output, ignored);
    return format == "ofr" && options.output != "-" &&
           (!std::filesystem::exists(there) || !std::filesystem::is_other(there));
}

int64_t output_bytes_per_column(const std::string& format, size_t materials) {
    if (format == "filament") return boundary::kSolidMesherBytesPerColumn;
    if (is_mesh_format(format)) return boundary::kMesherBytesPerColumn;
    if (format == "gcvf") return gcvf::kBytesPerColumn;
    // What slices that wait for their turn take beyond their packed rows: a bit for each material, or
    // a byte, in the slabs of eight slices that two threads have in flight.
    constexpr int64_t kSlabs = 4;
    if (format == "bmp") return kSlabs * static_cast<int64_t>(materials);
    return format == "npy" ? kSlabs * 8 : 0;
}

Result<std::unique_ptr<pipeline::SliceSink>> open_output(const Options& options,
                                                         const world::Printer& printer,
                                                         const std::atomic<bool>* interrupt) {
    Result<std::string> format = choose_format(options, printer);
    if (!format) return format.error();
    Result<std::unique_ptr<pipeline::SliceSink>> sink =
        open_format(options, printer, *format, interrupt);
    if (!sink || options.previews.empty()) return sink;
    std::vector<std::unique_ptr<backends::SliceObserver>> observers;
    for (const preview::PreviewSpec& spec : options.previews)
        observers.push_back(preview::make_preview(spec));
    return std::unique_ptr<pipeline::SliceSink>(
        std::make_unique<backends::TeeSink>(std::move(*sink), std::move(observers)));
}

Result<std::unique_ptr<pipeline::SliceSink>> make_encoder(const Options& options,
                                                          const world::Printer& printer,
                                                          const std::string& format) {
    Encoder::Encode encode;
    if (format == "ofr") {
        encode = [](const pipeline::SliceView& slice, const pipeline::PrintInfo&) {
            return ofr::encode_slice(slice);
        };
    } else if (is_folder_format(format)) {
        encode = [folder = folder_options(options, printer, format)](
                     const pipeline::SliceView& slice, const pipeline::PrintInfo& info) {
            return raster::encode_slice(slice, info, folder);
        };
    } else {
        Error error = usage_error(
            fmt::format("the format {} is not made slice by slice, which a print over several "
                        "machines is",
                        format));
        error.help =
            fmt::format("print an .ofr file, and make {} of it with `openfab export`", format);
        return error;
    }
    return std::unique_ptr<pipeline::SliceSink>(std::make_unique<Encoder>(std::move(encode)));
}

int64_t queue_bytes(const Options& options) {
    return stream::is_address(options.output)
               ? static_cast<int64_t>(stream::StreamSink::kMostQueuedBytes)
               : 0;
}

int64_t preview_bytes(const Options& options) {
    // Pictures are drawn one after the other, so the memory for drawing counts once.
    int64_t bytes = options.previews.empty() ? 0 : preview::kDrawBytes;
    for (const preview::PreviewSpec& spec : options.previews)
        bytes += preview::gathered_bytes(spec);
    return bytes;
}

}  // namespace openfab::program
