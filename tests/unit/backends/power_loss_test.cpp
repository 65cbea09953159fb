// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Prints whose disk loses power at any moment, over an earlier print in the same place: what is resumed has the bytes of
// one print, or is refused; what says that it is complete is.

#include <gtest/gtest.h>

#include <random>

#include "backends/ofr/ofr_reader.h"
#include "backends/ofr/ofr_sink.h"
#include "backends/raster/folder_sink.h"
#include "backends/raster/fraction_file.h"
#include "tests/support/long_run.h"
#include "tests/support/process/process.h"
#include "tests/unit/backends/lossy_disk.h"
#include "tests/unit/backends/sample_print.h"

namespace openfab::testing {
namespace {

namespace fs = std::filesystem;

/// A print of so many slices; `seed` makes another print of other voxels.
SamplePrint sample(uint64_t seed) {
    SamplePrint print = make_sample({21, 9, 12});
    print.info.seed = seed;
    print.info.provenance = {{"dither", "blue_noise"}};
    if (seed != 0) {
        for (size_t i = 0; i < print.codes.size(); i += 7)
            print.codes[i] = static_cast<uint8_t>(1 + (print.codes[i] + seed) % 3);
    }
    return print;
}

class PowerLoss : public ::testing::Test {
  protected:
    using Open = std::function<Result<std::unique_ptr<pipeline::SliceSink>>(bool resume)>;

    fs::path folder() const { return scratch_ / "disk"; }

    /// Resumes as a print does; an error where it is refused.
    static Result<void> resume(const SamplePrint& print, pipeline::SliceSink* sink, bool shows) {
        if (Result<void> begun = sink->begin(print.info); !begun) return begun;
        Result<int32_t> kept = 0;
        if (shows) {
            kept = sink->resume([&](const pipeline::SliceView& slice) {
                const std::vector<uint8_t> rows = print.rows(slice.z);
                EXPECT_TRUE(std::equal(rows.begin(), rows.end(), slice.data)) << slice.z;
                return true;
            });
        } else {
            kept = static_cast<raster::FolderSink*>(sink)->keep();
        }
        if (!kept) return kept.error();
        Result<void> done;
        for (int32_t z = *kept; z < print.info.slice_end && done; ++z) {
            const std::vector<uint8_t> rows = print.rows(z);
            done = sink->commit(z, sink->encode(print.view(z, rows)));
        }
        const Result<void> finished = sink->finish(print.totals());
        return done ? finished : done;
    }

    /// Prints one over the other, and cuts that at moments in turn, each with other losses. Returns how often resuming
    /// was refused.
    int cut(const Open& open, const std::function<bool(const Files&)>& check, bool shows = true) {
        const SamplePrint earlier = sample(1), print = sample(0);
        fs::create_directories(folder());
        put_files(folder(), {});
        EXPECT_TRUE(earlier.send(open(false)->get()));
        const Files before = files_in(folder());
        LossyDisk disk(folder());
        EXPECT_TRUE(print.send(open(false)->get()));
        disk.stop();
        const Files whole = files_in(folder());
        EXPECT_GT(disk.steps(), 12u);
        std::mt19937 random(7);
        int refused = 0;
        const int cuts = count_of_cuts();
        for (int i = 0; i < cuts; ++i) {
            const size_t moment = random() % (disk.steps() + 1);
            const Files left = disk.after_loss(moment, &random);
            put_files(folder(), left);
            EXPECT_TRUE(check(left)) << i << " at " << moment;
            Result<std::unique_ptr<pipeline::SliceSink>> sink = open(true);
            const Result<void> done =
                sink ? resume(print, sink->get(), shows) : Result<void>(sink.error());
            if (sink) sink->reset();
            if (!done) {
                ++refused;
                EXPECT_EQ(done.error().code, ErrorCode::kUserInput) << done.error().text();
                EXPECT_EQ(files_in(folder()), left);
                continue;
            }
            EXPECT_EQ(files_in(folder()), whole) << i << " at " << moment << " of " << disk.steps();
            if (HasFailure()) return refused;
        }
        std::printf("%d cuts at %zu moments, %d refused\n", cuts, disk.steps() + 1, refused);
        return refused;
    }

    ScratchFolder scratch_;
};

TEST_F(PowerLoss, FoldersOfSlices) {
    for (const raster::SliceFormat format :
         {raster::SliceFormat::kRgba, raster::SliceFormat::kBitmaps, raster::SliceFormat::kGrey8,
          raster::SliceFormat::kTiff16}) {
        raster::FolderOptions options;
        options.format = format;
        const bool grey =
            format == raster::SliceFormat::kGrey8 || format == raster::SliceFormat::kTiff16;
        const int refused = cut(
            [&](bool resume) {
                return resume ? raster::FolderSink::reopen(folder(), options)
                              : raster::FolderSink::create(folder(), options);
            },
            [&](const Files& files) {
                // A manifest that says that all are there is true, whichever print it is of.
                const auto manifest = files.find("manifest.json");
                if (manifest == files.end() || !raster::manifest_is_complete(manifest->second))
                    return true;
                const raster::Digests digests = raster::manifest_digests(manifest->second);
                if (raster::manifest_difference(manifest->second, sample(0).info, options) != "")
                    return true;  // of the earlier print, whose slices go
                return digests.size() == 12 * raster::files_a_slice(sample(0).info, options) &&
                       std::all_of(digests.begin(), digests.end(), [&](const auto& one) {
                           const auto file = files.find(one.first);
                           return file != files.end() && sha256(file->second) == one.second;
                       });
            },
            !grey);
        EXPECT_LT(refused, count_of_cuts());
    }
}

TEST_F(PowerLoss, Files) {
    const std::string file = (folder() / "a.ofr").string();
    cut(
        [&](bool resume) {
            return resume ? ofr::OfrSink::reopen(file) : ofr::OfrSink::create(file);
        },
        [](const testing::Files&) { return true; });
}

/// An array is the earlier one, whole, or the new one, or not there.
TEST_F(PowerLoss, Fractions) {
    const SamplePrint print = sample(0);
    const auto write = [&](float value) {
        raster::FractionFile file((folder() / "f.npy").string());
        EXPECT_TRUE(file.begin(print.info, 2));
        std::vector<float> row(static_cast<size_t>(print.info.size.x) * 2, value);
        for (int32_t z = 0; z < print.info.size.z; ++z) {
            for (int32_t y = 0; y < print.info.size.y; ++y)
                file.write(z, y, 0, row);
        }
        EXPECT_TRUE(file.finish(print.totals()));
    };
    fs::create_directories(folder());
    write(0.25f);
    const testing::Files before = files_in(folder());
    LossyDisk disk(folder());
    write(0.5f);
    disk.stop();
    const testing::Files after = files_in(folder());
    std::mt19937 random(8);
    for (int i = 0; i < count_of_cuts(); ++i) {
        const testing::Files left = disk.after_loss(random() % (disk.steps() + 1), &random);
        const auto array = left.find("f.npy");
        if (array == left.end()) continue;
        EXPECT_TRUE(array->second == before.at("f.npy") || array->second == after.at("f.npy")) << i;
    }
}

}  // namespace
}  // namespace openfab::testing
