// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <utility>
#include <vector>

#include "backends/common/tee_sink.h"
#include "backends/formats/formats.h"
#include "backends/preview/preview.h"
#include "backends/stream/stream_sink.h"
#include "base/text.h"
#include "program/grid_options.h"
#include "program/messages.h"

namespace openfab::program {

namespace {

using backends::Format;

backends::OutputSettings settings_of(const OutputOptions& options, const world::Printer& printer) {
    backends::OutputSettings settings;
    settings.path = options.output;
    settings.resume = options.resume;
    settings.png_indexed = options.png_indexed;
    settings.grey_material = options.grey_material;
    settings.flip_x = options.flip_x;
    settings.front_end_makes_support = printer.makes_support;
    settings.handoff = printer.handoff;
    return settings;
}

/// Encodes as the sink of a format does, and discards.
class Encoder : public backends::NullSink {
  public:
    Encoder(const Format& format, backends::OutputSettings settings)
        : format_(format), settings_(std::move(settings)) {}
    Result<void> begin(const pipeline::PrintInfo& info) override {
        info_ = info;
        return {};
    }
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override {
        return format_.encode(slice, info_, settings_);
    }

  private:
    const Format& format_;
    backends::OutputSettings settings_;
    pipeline::PrintInfo info_;
};

Result<std::unique_ptr<pipeline::SliceSink>> open_format(const OutputOptions& options,
                                                         const world::Printer& printer,
                                                         const Format* format,
                                                         const std::atomic<bool>* interrupt,
                                                         backends::MixtureInlet* mixtures) {
    if (format == nullptr)
        return std::unique_ptr<pipeline::SliceSink>(std::make_unique<backends::NullSink>());
    if (options.resume && !can_be_resumed(options, *format)) {
        return usage_error(fmt::format(
            messages::kCannotResume, options.output,
            format->not_resumed.empty() ? messages::kKeepsNothing : format->not_resumed));
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
    backends::OutputSettings settings = settings_of(options, printer);
    settings.mixtures = mixtures;
    return format->open(settings);
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

/// Says what `-o NAME.png` should be: slices fill a folder.
Error slices_fill_a_folder(const OutputOptions& options, const Format& format) {
    const std::string stem = std::filesystem::path(options.output).stem().string();
    const std::string picture =
        format.extension == ".png" ? fmt::format(messages::kOrAPicture, options.output) : "";
    return usage_error(
        fmt::format(messages::kSlicesFillAFolder, options.output, format.name, stem, picture));
}

/// Returns the format that a printer takes.
Result<const Format*> native_format(const world::Printer& printer) {
    if (const Format* format = backends::find_format(printer.native_format)) return format;
    return user_error(fmt::format(messages::kNativeFormatUnknown, printer.name,
                                  printer.native_format, backends::format_names()));
}

Result<const Format*> name_format(const OutputOptions& options, const world::Printer& printer) {
    if (options.output.empty()) return nullptr;
    if (!options.format.empty()) return backends::find_format(options.format);
    if (options.output == "-" || stream::is_address(options.output))
        return backends::find_format("ofr");
    Result<const Format*> native = native_format(printer);
    if (!native) return native;
    const std::filesystem::path path(options.output);
    const std::string extension = path.filename().has_filename() ? path.extension().string() : "";
    // A printer that wants painted triangles wants them in its 3MF.
    if (extension == (*native)->extension && (*native)->kind != backends::FormatKind::kFolder)
        return native;
    for (const Format* format : backends::formats()) {
        if (extension != format->extension) continue;
        if (format->kind == backends::FormatKind::kFolder)
            return slices_fill_a_folder(options, *format);
        return format;
    }
    if (extension == ".vdb") {
        return usage_error(fmt::format(messages::kOutputNoVdb, options.output,
                                       (path.parent_path() / path.stem()).string()));
    }
    std::error_code ignored;
    if (looks_like_file(extension) && !std::filesystem::is_directory(path, ignored)) {
        return usage_error(
            fmt::format(messages::kNoFormatOfExtension, options.output, extension.substr(1),
                        (path.parent_path() / path.stem()).string(), backends::file_extensions()));
    }
    return native;
}

}  // namespace

bool has_mesh_colors(const Format* format, const world::Printer& printer) {
    return format != nullptr && format->mixture_bytes_per_column != nullptr &&
           (printer.mesh_colors || format->needs_mixtures);
}

bool is_mesh_format(const Format* format) {
    return format != nullptr && format->kind == backends::FormatKind::kMesh;
}

std::string lost_mixtures(const pipeline::PrintStatistics& statistics, const std::string& dither,
                          const backends::Format* format, const world::Printer& printer) {
    if (statistics.voxels_mixed == 0 || !is_mesh_format(format) || format->needs_mixtures)
        return {};
    if (has_mesh_colors(format, printer))
        return fmt::format(messages::kColorsOfMixtures, printer.name);
    if (!dither.empty()) return {};
    const auto all =
        static_cast<double>(std::max(statistics.voxels_solid, statistics.voxels_mixed));
    return fmt::format(messages::kMixturesAreLost,
                       100 * static_cast<double>(statistics.voxels_mixed) / all);
}

std::string left_out_of_grey(const pipeline::PrintStatistics& statistics,
                             const pipeline::PrintInfo& info, const std::string& grey_material,
                             const backends::Format* format) {
    if (format == nullptr || !format->of_fractions || !grey_material.empty()) return {};
    std::string names;
    for (size_t m = 1; m < info.materials.size(); ++m) {
        const bool is_there = m + 1 < statistics.voxels_by_code.size() &&
                              statistics.voxels_by_code[m + 1] > 0 &&
                              static_cast<int32_t>(m + 1) != info.support_code;
        if (is_there)
            names +=
                fmt::format("{}`{}`", names.empty() ? "" : ", ", printable(info.materials[m].name));
    }
    if (names.empty()) return {};
    return fmt::format(messages::kLeftOutOfGrey, printable(info.materials.front().name), names);
}

Result<const Format*> choose_format(const OutputOptions& options, const world::Printer& printer) {
    Result<const Format*> format = name_format(options, printer);
    if (!format) return format;
    if (*format != nullptr && !(*format)->flips_x && options.flip_x) {
        return usage_error(fmt::format(
            messages::kNotMirrored,
            backends::format_names("and", [](const Format& each) { return each.flips_x; }),
            (*format)->name));
    }
    if (*format != nullptr && !(*format)->has_palette && options.png_indexed)
        return usage_error(fmt::format(messages::kNoPalette, (*format)->name));
    const bool to_receiver = stream::is_address(options.output);
    for (const auto& [option, file] :
         {std::pair("--token-file", &options.token_file), std::pair("--tls-ca", &options.tls_ca)}) {
        if (!file->empty() && !to_receiver)
            return usage_error(fmt::format(messages::kNoReceiver, option, options.output));
    }
    return format;
}

Result<void> check_mesh_pitch(const GridOptions& options, const Format* format) {
    if (!options.mesh_pitch_mm || is_mesh_format(format)) return {};
    return usage_error(fmt::format(
        messages::kMeshPitchOfSlices,
        backends::format_names("and", [](const Format& each) { return is_mesh_format(&each); })));
}

bool can_be_resumed(const OutputOptions& options, const Format& format) {
    if (stream::is_address(options.output)) return true;
    if (!format.not_resumed.empty()) return false;
    if (format.kind == backends::FormatKind::kFolder) return true;
    std::error_code ignored;
    const std::filesystem::file_status there = std::filesystem::status(options.output, ignored);
    return options.output != "-" &&
           (!std::filesystem::exists(there) || !std::filesystem::is_other(there));
}

std::string output_in(const std::filesystem::path& folder, const Format& format) {
    const bool is_folder = format.kind == backends::FormatKind::kFolder;
    return (folder / (is_folder ? "slices" : fmt::format("print{}", format.extension))).string();
}

int64_t output_bytes_per_column(const Format* format, size_t materials) {
    return format == nullptr || format->bytes_per_column == nullptr
               ? 0
               : format->bytes_per_column(materials);
}

Result<std::unique_ptr<pipeline::SliceSink>> open_output(const OutputOptions& options,
                                                         const world::Printer& printer,
                                                         const std::atomic<bool>* interrupt,
                                                         backends::MixtureInlet* mixtures) {
    const Result<const Format*> format = choose_format(options, printer);
    if (!format) return format.error();
    Result<std::unique_ptr<pipeline::SliceSink>> sink =
        open_format(options, printer, *format, interrupt, mixtures);
    if (!sink || options.previews.empty()) return sink;
    std::vector<std::unique_ptr<backends::SliceObserver>> observers;
    for (const preview::PreviewSpec& spec : options.previews)
        observers.push_back(preview::make_preview(spec));
    return std::unique_ptr<pipeline::SliceSink>(
        std::make_unique<backends::TeeSink>(std::move(*sink), std::move(observers)));
}

Result<std::unique_ptr<pipeline::SliceSink>> make_encoder(const OutputOptions& options,
                                                          const world::Printer& printer,
                                                          const Format& format) {
    if (format.encode == nullptr) {
        Error error = usage_error(fmt::format(messages::kNotSliceBySlice, format.name));
        error.help = fmt::format(messages::kNotSliceBySliceHelp, format.name);
        return error;
    }
    return std::unique_ptr<pipeline::SliceSink>(
        std::make_unique<Encoder>(format, settings_of(options, printer)));
}

int64_t queue_bytes(const OutputOptions& options) {
    return stream::is_address(options.output)
               ? static_cast<int64_t>(stream::StreamSink::kMostQueuedBytes)
               : 0;
}

int64_t preview_bytes(const OutputOptions& options) {
    // Pictures are drawn one after the other, so the memory for drawing counts once.
    int64_t bytes = options.previews.empty() ? 0 : preview::kDrawBytes;
    for (const preview::PreviewSpec& spec : options.previews)
        bytes += preview::gathered_bytes(spec);
    return bytes;
}

}  // namespace openfab::program
