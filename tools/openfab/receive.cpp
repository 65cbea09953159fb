// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab receive --listen ADDRESS -o OUT`: the other end of `print -o tcp://HOST:PORT`, and the
// reference for who writes a printer's front end.

#include <fmt/format.h>
#include <sys/stat.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "backends/job/recorded_sink.h"
#include "backends/ofr/ofr_reader.h"
#include "backends/raster/folder_sink.h"
#include "backends/stream/address.h"
#include "base/input_file.h"
#include "base/say.h"
#include "base/units.h"
#include "program/interrupt.h"
#include "program/outputs.h"
#include "program/stop_reason.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/known_printer.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/receiver.h"

namespace openfab::tools {

namespace {

/// Parses "10s" or "250ms"; empty is 0.
Result<double> parse_seconds(const std::string& text) {
    if (text.empty()) return 0.0;
    const Result<double> seconds = parse_duration(text);
    if (seconds && *seconds > 0 && *seconds <= 86400) return seconds;
    return usage_error(fmt::format(messages::kLayerTimeNotATime, text));
}

/// Returns whether the output is a whole print, which nobody who connects may replace.
bool is_complete(const program::OutputOptions& print) {
    if (print.format == "ofr") return ofr::OfrReader::read_totals(print.output).has_value();
    const Result<InputFile> file =
        InputFile::open(std::filesystem::path(print.output) / "manifest.json");
    const Result<std::string> text =
        file ? file->read_all(raster::kMostManifestBytes) : Result<std::string>(file.error());
    return text && raster::manifest_is_complete(*text);
}

/// Returns ofr or png, as the output's name says.
Result<const backends::Format*> format_of(const program::OutputOptions& print) {
    if (print.output == "-" || stream::is_address(print.output))
        return usage_error(messages::kReceiveNeedsOutput);
    world::Printer printer;
    printer.native_format = "png";
    Result<const backends::Format*> format = program::choose_format(print, printer);
    if (!format || (*format)->name == "ofr" || (*format)->name == "png") return format;
    return usage_error(fmt::format(messages::kReceiveFormats, (*format)->name));
}

/// Fails where the output could not be opened when a print comes.
Result<void> try_output(const program::OutputOptions& print) {
    std::error_code ignored;
    const bool is_there = std::filesystem::exists(print.output, ignored);
    {
        const auto sink = program::open_output(print, {});
        if (!sink) return sink.error();
    }
    if (!is_there) std::filesystem::remove(print.output, ignored);
    return {};
}

}  // namespace

Result<void> run_receive(const ReceiveArguments& a) {
    Result<stream::Address> address = stream::parse_address(a.listen);
    if (!address) return address.error();
    Result<std::string> token = stream::load_token(a.token_file);
    if (!token) return token.error();
    const Result<bool> local = stream::is_local(*address);
    if (!local) return local.error();
    if (!*local && token->empty()) {
        return usage_error(fmt::format(messages::kTokenNeeded, a.listen));
    }
    ReceiverOptions options;
    if (address->is_tls != (!a.tls_certificate.empty() || !a.tls_key.empty()) ||
        a.tls_certificate.empty() != a.tls_key.empty()) {
        return usage_error(messages::kTlsNeedsKeys);
    }
    if (address->is_tls) {
        auto tls = stream::TlsContext::for_receivers(a.tls_certificate, a.tls_key);
        if (!tls) return tls.error();
        options.tls = std::move(*tls);
    }
    const Result<double> layer_seconds = parse_seconds(a.layer_time);
    if (!layer_seconds) return layer_seconds.error();
    const Result<int64_t> memory = parse_memory_option(a.memory);
    if (!memory) return memory.error();

    program::OutputOptions print;
    print.output = a.output;
    const Result<const backends::Format*> format = format_of(print);
    if (!format) return format.error();
    print.format = (*format)->name;
    if (Result<void> opens = try_output(print); !opens) return opens;
    if (!a.log.empty()) {
        Result<std::unique_ptr<AuditLog>> log = AuditLog::open(a.log);
        if (!log) return log.error();
        options.log = std::move(*log);
    }
    options.token = *token;
    options.memory_bytes = *memory;
    options.keeps_frames = print.format == "ofr";
    options.layer_seconds = *layer_seconds;
    options.buffer = a.buffer;
    struct Identity {
        dev_t device = 0;
        ino_t number = 0;
    };
    const auto identity = [output = print.output]() -> std::optional<Identity> {
        struct stat there {};
        if (::stat(output.c_str(), &there) != 0) return {};
        return Identity{there.st_dev, there.st_ino};
    };
    const auto opened = std::make_shared<std::optional<Identity>>();
    options.output_is_there = [identity, opened] {
        const std::optional<Identity> now = identity();
        if (!*opened) *opened = now;  // some are made with the first slice
        return !*opened ||
               (now && now->device == (*opened)->device && now->number == (*opened)->number);
    };
    const auto record = std::make_shared<std::shared_ptr<job::Record>>();
    options.stopped = [record](const Error& why) {
        const job::StopReason reason = program::stop_reason(why);
        if (*record != nullptr) (*record)->stop(reason);
        if (reason.by != "signal") return reason.error;
        return fmt::format(messages::kStoppedBySignal, reason.signal) +
               (reason.sender > 0 ? fmt::format(messages::kSentByProcess, reason.sender) : "");
    };
    const auto open_sink =
        [print, opened, record](
            const pipeline::PrintInfo& info, bool resumed,
            const std::string& from) mutable -> Result<std::unique_ptr<pipeline::SliceSink>> {
        if (!resumed && is_complete(print)) {
            return user_error(fmt::format(messages::kHoldsWholePrint, print.output));
        }
        print.resume = resumed;
        opened->reset();
        Result<std::unique_ptr<pipeline::SliceSink>> sink =
            program::open_output(print, printer_of(info));
        const std::filesystem::path file = job::record_file(print.output);
        if (!sink || file.empty()) return sink;
        job::Facts facts;
        facts.format = print.format;
        facts.printer = info.printer;
        // The sink before it is gone by now.
        *record = std::make_shared<job::Record>(file, std::move(facts), resumed);
        job::StopReason cut;
        cut.by = "line";
        return std::unique_ptr<pipeline::SliceSink>(std::make_unique<job::RecordedSink>(
            std::move(*sink), record->get(), from, std::move(cut)));
    };
    Result<stream::Socket> listening = stream::listen_at(*address);
    if (!listening) return listening.error();
    options.interrupt =
        &program::install_interrupt(exit_code(ErrorCode::kInterrupted), messages::kInterruptedLine);
    const program::DeferredInterrupt deferred;
    say(fmt::format(messages::kListeningAt, stream::listening_text(*listening, *address)));
    return Receiver(std::move(*listening), std::move(options), open_sink).run();
}

}  // namespace openfab::tools
