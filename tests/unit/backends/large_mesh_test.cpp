// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What files of meshes stand on: packages larger than a ZIP of old, and a mesher that keeps three slices.

#include <gmock/gmock.h>
#include <malloc.h>

#include <string>

#include "backends/boundary/mesher.h"
#include "backends/common/package.h"
#include "mesh/read/zip_file.h"
#include "tests/support/process/process.h"
#include "tests/unit/backends/sample_print.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;

/// Sizes that need ZIP64 are announced before they are known.
TEST(Package, TellsLargeSizesBeforeTheyAreKnown) {
    const ScratchFolder scratch;
    const std::string text(1000, 'x');
    {
        Result<backends::OutputFile> file =
            backends::OutputFile::create((scratch / "large.zip").string());
        ASSERT_TRUE(file);
        auto package = backends::Package::create(&*file);
        ASSERT_TRUE(package);
        ASSERT_TRUE((*package)->begin_packed("model", int64_t{5} << 30));
        backends::TextSum sum;
        for (bool last : {false, true}) {
            const auto packed = backends::deflate_text(text, last, &sum);
            ASSERT_TRUE((*package)->write_packed(packed));
        }
        ASSERT_TRUE((*package)->end_packed(sum));
        ASSERT_TRUE((*package)->close());
    }
    const std::string bytes = read_file(scratch / "large.zip");
    EXPECT_THAT(bytes, HasSubstr(std::string("\x01\x00\x10\x00", 4)));  // sizes of 8 bytes each
    Result<mesh::ZipFile> zip = mesh::ZipFile::open(bytes, "large.zip");
    ASSERT_TRUE(zip) << zip.error().text();
    Result<std::string> read = zip->read("model");
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_EQ(*read, text + text);
}

#ifndef OPENFAB_SANITIZED
/// A mesher that has seen three hundred slices holds what it held after fifty.
TEST(MeshMemory, DoesNotGrowWithSlices) {
    class Nothing : public boundary::MeshReceiver {
      public:
        Result<void> take_vertices(uint8_t, std::span<const Vec3i>) override { return {}; }
        Result<void> take_triangles(uint8_t, std::span<const boundary::MeshTriangle>) override {
            return {};
        }
    };
    const SamplePrint print = make_sample({64, 64, 8});
    Nothing nothing;
    boundary::Mesher mesher(64, 64, 0, &nothing);
    size_t early = 0;
    for (int32_t z = 0; z < 300; ++z) {
        const std::vector<uint8_t> rows = print.rows(z % 8);
        ASSERT_TRUE(mesher.add(print.view(z, rows), 4));
        if (z == 50) early = ::mallinfo2().uordblks;
    }
    EXPECT_LT(::mallinfo2().uordblks, early + 200'000);
}
#endif

}  // namespace
}  // namespace openfab::testing
