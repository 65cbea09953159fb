// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab merge PART… -o OUT`: the parts, `.ofr` files or stores of Zarr, of one print that were made by `--slices`, as the one
// print: what a run of the whole would have written.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "backends/ofr/ofr_reader.h"
#include "backends/read/print_file.h"
#include "backends/zarr/store.h"
#include "base/say.h"
#include "program/outputs.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/known_printer.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/slice_copy.h"
#include "tools/openfab/verify_store.h"

namespace openfab::tools {

namespace {

/// A part of a print: some of its slices in a file of their own.
struct Shard {
    std::string file;
    pipeline::PrintInfo info;
    pipeline::PrintTotals totals;
    std::unique_ptr<prints::PrintFile> store;  ///< null for an .ofr file
};

Error with_resume_hint(Error error) {
    error.help = messages::kCompleteItWithResume;
    return error;
}

Result<Shard> open_store(const std::string& path, int64_t memory_bytes) {
    Result<std::unique_ptr<prints::PrintFile>> print = prints::PrintFile::open(path, memory_bytes);
    if (!print) return print.error();
    const auto totals = (*print)->totals();
    if (totals) return Shard{path, (*print)->info(), *totals, std::move(*print)};
    const Result<std::string> missing = missing_in_store(path);
    if (!missing) return missing.error();
    return user_error(fmt::format(messages::kStoreLacksSlices, path, *missing));
}

Result<std::vector<Shard>> open_shards(const std::vector<std::string>& files,
                                       int64_t memory_bytes) {
    std::vector<Shard> shards;
    for (const std::string& file : files) {
        if (file == "-") return usage_error(messages::kMergeReadsFiles);
        if (zarr::is_store(file)) {
            Result<Shard> store = open_store(file, memory_bytes);
            if (!store) return store.error();
            shards.push_back(std::move(*store));
            continue;
        }
        Result<std::unique_ptr<ofr::OfrReader>> reader = ofr::OfrReader::open(file, memory_bytes);
        if (!reader) return reader.error();
        Result<pipeline::PrintTotals> totals = ofr::OfrReader::read_totals(file);
        if (!totals) return with_resume_hint(totals.error());
        shards.push_back({file, (*reader)->info(), std::move(*totals), nullptr});
    }
    std::stable_sort(shards.begin(), shards.end(), [](const Shard& a, const Shard& b) {
        return a.info.slice_begin < b.info.slice_begin;
    });
    return shards;
}

/// Names slices in a message; `end` is one past the last.
std::string slices(int32_t begin, int32_t end) {
    return end - begin == 1 ? fmt::format(messages::kOneSlice, begin)
                            : fmt::format(messages::kSlicesTo, begin, end - 1);
}

/// Fails where two parts are not of one print, or its slices are not each in one of them.
Result<void> check_neighbours(const Shard& below, const Shard& above) {
    pipeline::PrintInfo moved = above.info;
    moved.slice_begin = below.info.slice_begin;
    moved.slice_end = below.info.slice_end;
    if (ofr::write_header(moved) != ofr::write_header(below.info)) {
        return user_error(fmt::format(messages::kNotPartsOfOnePrint, below.file, above.file));
    }
    const int32_t end = below.info.slice_end;
    const int32_t begin = above.info.slice_begin;
    if (begin > end) {
        return user_error(fmt::format(messages::kNoFileHasSlices, slices(end, begin), end, begin));
    }
    if (begin < end) {
        return user_error(fmt::format(messages::kBothHaveSlices, below.file, above.file,
                                      slices(begin, std::min(end, above.info.slice_end))));
    }
    return {};
}

/// Names what of the whole print is in none of the parts, with the range to print; empty where nothing is.
std::string missing_slices(const pipeline::PrintInfo& info) {
    std::vector<std::string> missing, ranges;
    for (const auto& [begin, end] :
         {std::pair(0, info.slice_begin), std::pair(info.slice_end, info.size.z)}) {
        if (begin == end) continue;
        missing.push_back(slices(begin, end));
        ranges.push_back(fmt::format("`--slices {}:{}`", begin, end));
    }
    return missing.empty() ? std::string()
                           : fmt::format(messages::kPartsMissing, info.size.z,
                                         fmt::join(missing, " and "), fmt::join(ranges, " and "));
}

pipeline::PrintTotals sum(const std::vector<Shard>& shards) {
    pipeline::PrintTotals totals = shards.front().totals;
    for (size_t i = 1; i < shards.size(); ++i)
        totals.add(shards[i].totals);
    return totals;
}

/// Returns the totals of what was written; not complete after an error, which `done` gets.
pipeline::PrintTotals copy_shards(const std::vector<Shard>& shards, int64_t memory_bytes,
                                  pipeline::SliceSink* sink, Result<void>* done) {
    pipeline::PrintTotals so_far;
    for (const Shard& shard : shards) {
        if (shard.store != nullptr) {
            const Result<pipeline::PrintTotals> copied = copy_slices(*shard.store, sink);
            if (!copied) {
                *done = copied.error();
                return so_far;
            }
            so_far.add(*copied);
            continue;
        }
        Result<std::unique_ptr<ofr::OfrReader>> reader =
            ofr::OfrReader::open(shard.file, memory_bytes);
        if (!reader) {
            *done = reader.error();
            return so_far;
        }
        *done = copy_slices(reader->get(), sink);
        add_slices_read(**reader, &so_far);
        if (!*done) return so_far;
    }
    return sum(shards);
}

}  // namespace

Result<void> run_merge(MergeOptions options) {
    const Result<int64_t> memory = prepare_copy(&options.output);
    if (!memory) return memory.error();
    Result<std::vector<Shard>> shards = open_shards(options.files, *memory);
    if (!shards) return shards.error();
    for (size_t i = 1; i < shards->size(); ++i)
        if (Result<void> fine = check_neighbours((*shards)[i - 1], (*shards)[i]); !fine)
            return fine;
    pipeline::PrintInfo info = shards->front().info;
    info.slice_end = shards->back().info.slice_end;
    const std::string missing = missing_slices(info);
    if (!missing.empty() && options.whole) return user_error(missing);
    if (Result<void> fine = check_copy(&options.output, options.files, info, *memory); !fine)
        return fine;
    if (!missing.empty()) warn(missing);
    Result<std::unique_ptr<pipeline::SliceSink>> sink =
        program::open_output(options.output.print, printer_of(info));
    if (!sink) return sink.error();
    Result<void> done = (*sink)->begin(info);
    if (!done) return done;
    const pipeline::PrintTotals totals = copy_shards(*shards, *memory, sink->get(), &done);
    Result<void> finished = (*sink)->finish(totals);
    return done ? finished : done;
}

}  // namespace openfab::tools
