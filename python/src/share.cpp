// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "python/src/share.h"

#include <fmt/format.h>

#include <numeric>
#include <utility>

#include "backends/formats/formats.h"
#include "backends/ofr/format.h"
#include "base/clock.h"
#include "program/cost.h"
#include "program/job.h"
#include "program/output_check.h"
#include "program/outputs.h"
#include "program/statistics.h"
#include "world/printer.h"
#include "world/world.h"

namespace openfab::python {

namespace {

/// Keeps encoded slices, and the totals.
class Gatherer : public pipeline::SliceSink {
  public:
    Gatherer(pipeline::SliceSink* encoder, Share* share) : encoder_(encoder), share_(share) {}
    Result<void> begin(const pipeline::PrintInfo& info) override { return encoder_->begin(info); }
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override {
        return encoder_->encode(slice);
    }
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override {
        if (bytes.empty()) return internal_error(fmt::format("slice {} could not be encoded", z));
        share_->bytes.insert(share_->bytes.end(), bytes.begin(), bytes.end());
        share_->lengths.push_back(static_cast<int64_t>(bytes.size()));
        return {};
    }
    Result<void> finish(const pipeline::PrintTotals& totals) override {
        share_->totals = totals;
        return {};
    }

  private:
    pipeline::SliceSink* encoder_;
    Share* share_;
};

}  // namespace

Result<std::shared_ptr<SharePrinter>> SharePrinter::create(std::shared_ptr<const Program> program,
                                                           const program::Options& options,
                                                           const std::string& format) {
    std::shared_ptr<SharePrinter> made(new SharePrinter(std::move(program)));
    program::PrintHooks hooks{.interrupt = made->interrupt_};
    hooks.began_seconds = process_age_seconds();
    Result<program::PreparedPrint> ready =
        program::prepare_print(options, made->program_->fablets(), hooks);
    if (!ready) return ready.error();
    made->ready_ = std::move(*ready);
    program::Job& job = made->ready_.job;
    Result<std::unique_ptr<pipeline::SliceSink>> encoder =
        program::make_encoder(options, job.printer, *backends::find_format(format));
    if (!encoder) return encoder.error();
    made->encoder_ = std::move(*encoder);
    made->warnings_ = job.input.warnings;
    const std::vector<std::string>& more = made->ready_.print->warnings();
    made->warnings_.insert(made->warnings_.end(), more.begin(), more.end());
    made->sizes_ = made->ready_.print->part_sizes();
    job.input = {};
    return made;
}

Result<Share> SharePrinter::print(int32_t first, int32_t end) {
    const Vec2<int32_t> all = slabs();
    if (first < all.x || end > all.y || first >= end) {
        return internal_error(fmt::format("slabs {} to {} are not of the print's, {} to {}", first,
                                          end, all.x, all.y));
    }
    std::vector<int32_t> slabs(static_cast<size_t>(end - first));
    std::iota(slabs.begin(), slabs.end(), first);
    Share share;
    Gatherer gatherer(encoder_.get(), &share);
    pipeline::PrintStatistics statistics;
    const Result<pipeline::SlabsRun> run =
        ready_.print->run_slabs(slabs, gatherer, interrupt_, &statistics);
    if (!run) return run.error();
    share.seconds = run->end - run->begin;
    share.processor_seconds = run->processor_seconds;
    share.statistics = program::statistics_json(statistics, info());
    return share;
}

Result<std::shared_ptr<ShareWriter>> ShareWriter::create(const Settings& settings) {
    Result<pipeline::PrintInfo> info = ofr::read_header(settings.header);
    if (!info) return info.error();
    info->support_code = settings.support_code;
    program::Options options = settings.options;
    const Result<world::Printer> printer =
        world::load_printer(settings.printer.empty() ? info->printer : settings.printer);
    if (!printer) return printer.error();
    const Result<const backends::Format*> format = program::choose_format(options, *printer);
    if (!format) return format.error();
    if (Result<void> apart =
            program::check_outputs(options, *format, info->materials, settings.inputs);
        !apart)
        return apart.error();
    if (!settings.output.empty()) {
        options.output = settings.output;
        options.format = (*format)->name;
    }
    Result<std::unique_ptr<pipeline::SliceSink>> sink = program::open_output(options, *printer);
    if (!sink) return sink.error();
    std::shared_ptr<ShareWriter> made(new ShareWriter());
    made->info_ = std::move(*info);
    made->next_ = made->info_.slice_begin;
    made->sink_ = std::move(*sink);
    made->printer_ = *printer;
    if (Result<void> begun = made->sink_->begin(made->info_); !begun) return begun.error();
    return made;
}

ShareWriter::~ShareWriter() {
    if (!finished_) (void)sink_->finish(totals_);
}

Result<void> ShareWriter::write(std::span<const uint8_t> bytes, std::span<const int64_t> lengths,
                                const pipeline::PrintTotals& totals) {
    const int64_t sum = std::accumulate(lengths.begin(), lengths.end(), int64_t{0});
    const bool whole = sum == static_cast<int64_t>(bytes.size()) &&
                       static_cast<int64_t>(lengths.size()) <= info_.slice_end - next_;
    if (!whole) return internal_error(fmt::format("slices from {} came damaged", next_));
    for (const int64_t length : lengths) {
        const std::span<const uint8_t> slice = bytes.first(static_cast<size_t>(length));
        Result<void> done = sink_->commit(next_, {slice.begin(), slice.end()});
        if (!done) return done;
        bytes = bytes.subspan(slice.size());
        bytes_ += length;
        ++next_;
    }
    totals_.add(totals);
    return {};
}

Result<void> ShareWriter::finish() {
    if (finished_) return {};
    finished_ = true;
    totals_.complete = is_complete();
    return sink_->finish(totals_);
}

std::string ShareWriter::statistics() const {
    pipeline::PrintStatistics s;
    s.complete = totals_.complete;
    s.hash = totals_.hash;
    s.voxels_by_code = totals_.voxels_by_code;
    s.voxels_by_code.resize(info_.materials.size() + 1);
    if (info_.support_code != 0)
        s.voxels_support = s.voxels_by_code[static_cast<size_t>(info_.support_code)];
    s.voxels_solid = totals_.voxels_solid - s.voxels_support;
    s.tight = totals_.tight;
    if (!s.tight.empty()) {
        const Vec3i size = s.tight.size();
        s.voxels_total = int64_t{size.x} * size.y * size.z;
    }
    s.slices = next_ - info_.slice_begin;
    s.sink_bytes = bytes_;
    program::add_cost(printer_, info_, &s);
    return program::statistics_json(s, info_);
}

Result<std::string> output_format(const program::Options& options, const std::string& printer) {
    const Result<world::Printer> known = world::load_printer(printer.empty() ? "generic" : printer);
    if (!known) return known.error();
    const Result<const backends::Format*> format = program::choose_format(options, *known);
    if (!format) return format.error();
    // Whether it can be made by several, before any of them begins.
    const auto encoder = program::make_encoder(options, *known, **format);
    if (!encoder) return encoder.error();
    return std::string((*format)->name);
}

Result<std::vector<std::filesystem::path>> world_files(const program::Options& options) {
    Result<world::World> world =
        world::load_world(options.input, world::rules_of(options.allow, options.memory_bytes));
    if (!world) return world.error();
    std::vector<std::filesystem::path> files = std::move(world->files);
    if (options.printer.ends_with(".json")) files.emplace_back(options.printer);
    return files;
}

Result<std::optional<std::pair<std::string, std::string>>> world_dither(
    const program::Options& options) {
    const Result<std::optional<world::DitherRef>> rule = program::load_rule(options);
    if (!rule) return rule.error();
    std::optional<std::pair<std::string, std::string>> out;
    if (*rule) out.emplace((*rule)->source.string(), (*rule)->rule);
    return out;
}

std::vector<uint8_t> header_of(const pipeline::PrintInfo& info) {
    return ofr::write_header(info);
}

}  // namespace openfab::python
