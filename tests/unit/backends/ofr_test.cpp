// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <thread>

#include "backends/common/messages.h"
#include "backends/ofr/messages.h"
#include "backends/ofr/ofr_reader.h"
#include "backends/ofr/ofr_sink.h"
#include "base/messages.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tests/unit/backends/sample_print.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

class Ofr : public ::testing::Test {
  protected:
    std::string file(const std::string& name = "print.ofr") const {
        return (scratch_ / name).string();
    }

    void write(const SamplePrint& print, bool complete = true) {
        Result<std::unique_ptr<pipeline::SliceSink>> sink = ofr::OfrSink::create(file());
        ASSERT_TRUE(sink) << sink.error().text();
        Result<void> done = print.send(sink->get(), complete);
        ASSERT_TRUE(done) << done.error().text();
    }

    struct Read {
        int32_t good = 0;
        std::string error;  ///< empty: complete
    };
    /// Reads a whole file; every slice must equal that of `print`.
    static Read read(const std::string& path, const SamplePrint& print) {
        Read result;
        Result<std::unique_ptr<ofr::OfrReader>> reader = ofr::OfrReader::open(path);
        if (!reader) {
            result.error = reader.error().text();
            EXPECT_EQ(reader.error().code, ErrorCode::kUserInput);
            return result;
        }
        for (;;) {
            Result<bool> more = (*reader)->next();
            if (!more) {
                EXPECT_EQ(more.error().code, ErrorCode::kUserInput);
                result.error = more.error().text();
                return result;
            }
            if (!*more) return result;
            const pipeline::SliceView& slice = (*reader)->slice();
            const std::vector<uint8_t> expected = print.rows(slice.z);
            const size_t bytes = slice.row_bytes * static_cast<size_t>(slice.height);
            EXPECT_EQ(slice.z, print.info.slice_begin + result.good);
            EXPECT_EQ(std::vector<uint8_t>(slice.data, slice.data + bytes), expected)
                << "slice " << slice.z;
            ++result.good;
        }
    }

    ScratchFolder scratch_;
};

TEST_F(Ofr, RoundTrip) {
    for (int32_t bits : {4, 8}) {
        SamplePrint print = make_sample({13, 6, 9}, bits);
        print.info.slice_begin = 2;
        print.info.slice_end = 7;
        write(print);
        const Read all = read(file(), print);
        EXPECT_EQ(all.error, "");
        EXPECT_EQ(all.good, 5);

        auto reader = ofr::OfrReader::open(file());
        ASSERT_TRUE(reader);
        const pipeline::PrintInfo& info = (*reader)->info();
        EXPECT_EQ(info.size, print.info.size);
        EXPECT_EQ(info.pitch_mm, print.info.pitch_mm);
        EXPECT_EQ(info.origin_mm, print.info.origin_mm);
        EXPECT_EQ(info.slice_begin, 2);
        EXPECT_EQ(info.slice_end, 7);
        EXPECT_EQ(info.bits, bits);
        EXPECT_EQ(info.printer, "j750");
        EXPECT_EQ(info.title, "sample");
        EXPECT_EQ(info.seed, 12345678901234567ULL);
        ASSERT_EQ(info.materials.size(), 3u);
        EXPECT_EQ(info.materials[2].name, "clear \"x\"");
        EXPECT_EQ(info.materials[2].key, print.info.materials[2].key);
        EXPECT_EQ(info.materials[2].preview, print.info.materials[2].preview);
        EXPECT_EQ(info.materials[1].density_g_cm3, 1.2);
        EXPECT_EQ(info.materials[1].channel, "B");

        Result<pipeline::PrintTotals> totals = ofr::OfrReader::read_totals(file());
        ASSERT_TRUE(totals) << totals.error().text();
        EXPECT_EQ(totals->voxels_solid, print.totals().voxels_solid);
        EXPECT_EQ(totals->voxels_by_code, print.totals().voxels_by_code);
        EXPECT_EQ(totals->hash, print.totals().hash);
        EXPECT_EQ(totals->tight, print.totals().tight);
    }
}

TEST_F(Ofr, AnInterruptedPrintHasItsSlicesAndNoIndex) {
    const SamplePrint print = make_sample({9, 5, 4});
    write(print, false);
    const Read all = read(file(), print);
    EXPECT_EQ(all.good, 4);
    EXPECT_THAT(all.error, testing::Says(ofr::messages::kIndexMissing));
    EXPECT_FALSE(ofr::OfrReader::read_totals(file()));
}

TEST_F(Ofr, EveryTruncationIsAnErrorAndKeepsWhatIsWhole) {
    const SamplePrint print = make_sample({9, 4, 5});
    write(print);
    const std::string bytes = read_file(file());
    int32_t good_before = 0;
    for (size_t n = 0; n < bytes.size(); ++n) {
        scratch_.write("cut.ofr", bytes.substr(0, n));
        const Read cut = read(file("cut.ofr"), print);
        ASSERT_NE(cut.error, "") << "cut to " << n << " of " << bytes.size();
        EXPECT_GE(cut.good, good_before);  // never less than from a shorter file
        good_before = cut.good;
        ASSERT_THAT(cut.error, HasSubstr("cut.ofr"));
    }
    EXPECT_EQ(good_before, 5);
}

TEST_F(Ofr, ATruncatedFileNamesTheSlice) {
    const SamplePrint print = make_sample({40, 40, 5});
    write(print);
    const std::string bytes = read_file(file());
    scratch_.write("cut.ofr", bytes.substr(0, bytes.size() / 2));
    EXPECT_THAT(
        read(file("cut.ofr"), print).error,
        testing::Says(ofr::messages::kWholeSlices, "2", ofr::messages::kSliceCutShort, "2", "5"));
}

TEST_F(Ofr, EveryFlippedBitIsAnErrorOrDoesNoHarm) {
    const SamplePrint print = make_sample({9, 4, 3});
    write(print);
    const std::string bytes = read_file(file());
    int32_t harmless = 0;
    // One bit of each byte or two; 7 and 8 have no common factor, so all bit positions occur.
    for (size_t bit = 0; bit < bytes.size() * 8; bit += 7) {
        std::string damaged = bytes;
        damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
        scratch_.write("bad.ofr", damaged);
        // read() compares the voxels of every slice.
        harmless += read(file("bad.ofr"), print).error.empty() ? 1 : 0;
        (void)ofr::OfrReader::read_totals(file("bad.ofr"));  // no crash
    }
    EXPECT_LE(harmless, 4);  // a few bits of zstd frames are unused
}

TEST_F(Ofr, TrailingBytesAreAnError) {
    const SamplePrint print = make_sample({9, 4, 3});
    write(print);
    scratch_.write("more.ofr", read_file(file()) + "x");
    EXPECT_THAT(read(file("more.ofr"), print).error, testing::Says(ofr::messages::kBytesAfterEnd));
}

TEST_F(Ofr, IsReadFromAPipe) {
    const SamplePrint print = make_sample({31, 17, 6});
    write(print);
    const std::string bytes = read_file(file());
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    std::thread writer([&] {
        // In pieces of odd size, so that reads are short.
        for (size_t at = 0; at < bytes.size(); at += 7) {
            const std::string piece = bytes.substr(at, 7);
            ASSERT_EQ(::write(ends[1], piece.data(), piece.size()),
                      static_cast<ssize_t>(piece.size()));
        }
        ::close(ends[1]);
    });
    const Read all = read("/dev/fd/" + std::to_string(ends[0]), print);
    writer.join();
    ::close(ends[0]);
    EXPECT_EQ(all.error, "");
    EXPECT_EQ(all.good, 6);
}

TEST_F(Ofr, AFullDiskIsTheOutsidesFault) {
    const SamplePrint print = make_sample({31, 17, 6});
    Result<std::unique_ptr<pipeline::SliceSink>> sink = ofr::OfrSink::create("/dev/full");
    ASSERT_TRUE(sink) << sink.error().text();
    Result<void> done = print.send(sink->get());
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::kOutside);
    EXPECT_THAT(done.error().text(), HasSubstr("/dev/full"));
    EXPECT_THAT(done.error().text(), HasSubstr("No space left"));
}

TEST_F(Ofr, RefusesAFolderAndAMissingFolder) {
    Result<std::unique_ptr<pipeline::SliceSink>> folder =
        ofr::OfrSink::create(scratch_.path().string());
    ASSERT_FALSE(folder);
    EXPECT_THAT(folder.error().text(), testing::Says(backends::messages::kOutputIsFolder));
    Result<std::unique_ptr<pipeline::SliceSink>> missing =
        ofr::OfrSink::create(file("no/such/print.ofr"));
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().code, ErrorCode::kOutside);
}

TEST_F(Ofr, OtherFilesAreNamedAsSuch) {
    const SamplePrint print = make_sample({4, 4, 1});
    scratch_.write("text.ofr", "this is no print at all, but long enough for a header");
    EXPECT_THAT(read(file("text.ofr"), print).error, testing::Says(ofr::messages::kNotOfr));
    EXPECT_THAT(read(scratch_.path().string(), print).error, HasSubstr("folder"));
    EXPECT_THAT(read(file("gone.ofr"), print).error, testing::Says(ofr::messages::kCannotOpen));
    EXPECT_THAT(read("/dev/zero", print).error,
                testing::Says(messages::kKindNotAFile, messages::kKindDevice));
}

}  // namespace
}  // namespace openfab::testing
