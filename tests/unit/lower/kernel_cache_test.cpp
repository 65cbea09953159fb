// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What the cache of kernels keeps, and what it does not believe.

#include "compiler/lower/code/kernel_cache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "compiler/schedule/schedule.h"
#include "tests/support/process/process.h"

namespace openfab::lower {
namespace {

namespace fs = std::filesystem;

using testing::read_file;
using testing::ScratchFolder;

std::shared_ptr<const KernelObject> object(uint64_t number, const std::string& code) {
    return std::make_shared<const KernelObject>(KernelObject{{number, ~number}, code, 7});
}

fs::path entry(const ScratchFolder& folder, uint64_t number) {
    return folder / (KernelKey{number, ~number}.text() + ".kernel");
}

void write(const fs::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
}

/// Another process's view: nothing in memory.
std::shared_ptr<const KernelObject> find(const ScratchFolder& folder, uint64_t number) {
    return KernelCache(folder.path()).find({number, ~number});
}

TEST(KernelCache, KeepsWhatItIsGiven) {
    const ScratchFolder folder;
    const std::string code("machine\0code\n", 13);
    EXPECT_EQ(find(folder, 1), nullptr);
    KernelCache(folder.path()).insert(object(1, code));
    const auto found = find(folder, 1);
    ASSERT_NE(found, nullptr);
    EXPECT_EQ(found->code, code);
    EXPECT_EQ(found->stored_bytes, 7);
    EXPECT_EQ(found->key, (KernelKey{1, ~uint64_t{1}}));
    EXPECT_EQ(find(folder, 2), nullptr);
}

TEST(KernelCache, KeepsInMemoryWithoutAFolder) {
    KernelCache cache;
    cache.insert(object(1, "code"));
    const auto found = cache.find({1, ~uint64_t{1}});
    ASSERT_NE(found, nullptr);
    EXPECT_EQ(found->code, "code");
    EXPECT_EQ(cache.find({2, ~uint64_t{1}}), nullptr) << "half of a key is none";
    cache.trim();
}

TEST(KernelCache, RemovesWhatIsDamaged) {
    const ScratchFolder folder;
    KernelCache(folder.path()).insert(object(1, "a kernel's code"));
    const std::string whole = read_file(entry(folder, 1));
    std::vector<std::string> damaged = {
        "",          whole.substr(0, 5), whole.substr(0, whole.size() - 1),
        whole + "x", "planted",          std::string(16, '\0')};
    for (size_t k = 0; k < whole.size(); ++k) {
        damaged.push_back(whole);
        damaged.back()[k] = static_cast<char>(damaged.back()[k] ^ 1);
    }
    for (const std::string& bytes : damaged) {
        write(entry(folder, 1), bytes);
        EXPECT_EQ(find(folder, 1), nullptr) << bytes;
        EXPECT_FALSE(fs::exists(entry(folder, 1))) << bytes;
    }
    // One kernel under the name of another.
    write(entry(folder, 2), whole);
    EXPECT_EQ(find(folder, 2), nullptr);
    write(entry(folder, 1), whole);
    EXPECT_NE(find(folder, 1), nullptr);
}

TEST(KernelCache, WhatIsNoFileIsNoKernel) {
    const ScratchFolder folder;
    fs::create_directory(entry(folder, 1));
    EXPECT_EQ(find(folder, 1), nullptr);
    fs::create_symlink("/dev/zero", entry(folder, 2));
    EXPECT_EQ(find(folder, 2), nullptr);
    KernelCache cache(folder / "not there");
    cache.insert(object(3, "code"));
    EXPECT_NE(cache.find({3, ~uint64_t{3}}), nullptr) << "it is in memory";
    cache.trim();
}

TEST(KernelCache, DropsWhatWasNotUsedForLongest) {
    const ScratchFolder folder;
    const std::string code(1000, 'k');
    constexpr uint64_t kCount = 8;
    const auto hours_ago = [](int hours) {
        return fs::file_time_type::clock::now() - std::chrono::hours(hours);
    };
    KernelCache(folder.path()).insert(object(0, code));
    const auto bytes = static_cast<int64_t>(fs::file_size(entry(folder, 0)));
    for (uint64_t k = 0; k < kCount; ++k) {
        KernelCache(folder.path()).insert(object(k, code));
        fs::last_write_time(entry(folder, k), hours_ago(100 - static_cast<int>(k)));
    }
    write(folder / "somebody's", code);
    write(folder / "1.kernel.tmp-abcdef", code);
    ASSERT_NE(find(folder, 1), nullptr);  // used now
    KernelCache(folder.path(), bytes * 5).trim();
    for (uint64_t k = 0; k < kCount; ++k)
        EXPECT_EQ(fs::exists(entry(folder, k)), k == 1 || k >= 4) << k;
    EXPECT_TRUE(fs::exists(folder / "somebody's"));
    EXPECT_FALSE(fs::exists(folder / "1.kernel.tmp-abcdef")) << "its writer is gone";
    KernelCache(folder.path(), bytes * 5).trim();
    EXPECT_TRUE(fs::exists(entry(folder, 4))) << "they fit";
    KernelCache(folder.path(), 0).trim();
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(KernelCache, ManyWriteAndReadAtOnce) {
    const ScratchFolder folder;
    constexpr uint64_t kCount = 20;
    const auto code = [](uint64_t k) { return std::string(10'000 + k, static_cast<char>(k)); };
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
        threads.emplace_back([&] {
            for (uint64_t k = 0; k < kCount; ++k) {
                KernelCache cache(folder.path());
                const auto found = cache.find({k, ~k});
                if (found != nullptr) {
                    EXPECT_EQ(found->code, code(k));
                }
                cache.insert(object(k, code(k)));
                cache.trim();
            }
        });
    }
    for (std::thread& thread : threads)
        thread.join();
    for (uint64_t k = 0; k < kCount; ++k) {
        const auto found = find(folder, k);
        ASSERT_NE(found, nullptr) << k;
        EXPECT_EQ(found->code, code(k));
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}),
              static_cast<std::ptrdiff_t>(kCount));
}

/// out = in_0 + `addend`, in the volume stage.
ir::Stage stage(float addend) {
    ir::Stage out;
    out.kind = ir::StageKind::kVolume;
    ir::Builder builder(&out);
    const ir::ValueId distance = builder.input(ir::Type::kFloat, OPENFAB_ARG_DISTANCE, 0, 0);
    const ir::ValueId sum = builder.binary(ir::Op::kAdd, distance, builder.constant(addend));
    out.outputs.push_back({"weight", OPENFAB_ARG_WEIGHT, 0, 0, sum});
    return out;
}

TEST(KernelKey, TellsApartAllThatDecidesTheCode) {
    const ir::Stage one = stage(1);
    ir::Stage elsewhere = stage(1);
    elsewhere.instrs[1].span = {7, 100, 120};
    const ir::Stage next = stage(std::nextafter(1.0f, 2.0f));
    const auto bound = [](const std::string& text, const schedule::Binding& to) {
        return std::get<schedule::Schedule>(schedule::read({"mine.sched", text}, to));
    };
    const schedule::Schedule mine = bound("slab.vectorize(z)", {});
    const schedule::Schedule commented = bound("# lanes\nslab . vectorize(z)\n", {});
    // What is in force decides, not what the file says.
    const std::string choices =
        "param batch = 8 in [4, 64]\nwhen avx2 { slab.vectorize(z) }\nslab.unroll(column, batch)";
    const schedule::Schedule eight = bound(choices, {});
    const schedule::Schedule sixteen = bound(choices, {.params = {{"batch", 16}}});
    const schedule::Schedule vectors = bound(choices, {.target = "avx2", .params = {}});
    const schedule::Schedule included = bound("include \"slab.sched\"\n", {.target = "avx2"});
    const schedule::Schedule& usual = schedule::default_schedule("slab", "avx2");
    const KernelRequest request{&one, {}, "f", OPENFAB_ISA_AVX2, nullptr};
    const KernelKey key = key_of(request);
    EXPECT_EQ(key_of({&one, {}, "another_name", OPENFAB_ISA_AVX2, nullptr}), key);
    EXPECT_EQ(key_of({&elsewhere, {}, "f", OPENFAB_ISA_AVX2, nullptr}), key);
    std::vector<KernelKey> others = {
        key_of({&next, {}, "f", OPENFAB_ISA_AVX2, nullptr}),
        key_of({&one, {}, "f", OPENFAB_ISA_SSE41, nullptr}),
        key_of({&one, {}, "f", OPENFAB_ISA_AVX2, &mine}),
        key_of({&one, {&next, nullptr}, "f", OPENFAB_ISA_AVX2, nullptr}),
        // The user's own copy of the built-in one is compiled with checks.
        key_of({&one, {}, "f", OPENFAB_ISA_AVX2, &usual}),
        key_of({&one, {}, "f", OPENFAB_ISA_AVX2, &eight}),
        key_of({&one, {}, "f", OPENFAB_ISA_AVX2, &sixteen}),
        key_of({&one, {}, "f", OPENFAB_ISA_AVX2, &vectors}),
    };
    EXPECT_EQ(key_of({&one, {}, "f", OPENFAB_ISA_AVX2, &commented}),
              key_of({&one, {}, "f", OPENFAB_ISA_AVX2, &mine}));
    EXPECT_EQ(key_of({&one, {}, "f", OPENFAB_ISA_AVX2, &included}),
              key_of({&one, {}, "f", OPENFAB_ISA_AVX2, &usual}));
    others.push_back(key);
    for (size_t a = 0; a < others.size(); ++a) {
        for (size_t b = 0; b < a; ++b)
            EXPECT_FALSE(others[a] == others[b]) << a << " " << b;
    }
}

TEST(FindOrCompile, CompilesOnce) {
    const ir::Stage one = stage(1);
    const KernelRequest request{&one, {}, "openfab_test", OPENFAB_ISA_SSE41, nullptr};
    const KernelKey key = key_of(request);
    KernelCache cache;
    std::string code;
    for (const bool first : {true, false}) {
        auto made = find_or_compile(request, key, &cache);
        ASSERT_TRUE(std::holds_alternative<MadeKernel>(made));
        EXPECT_EQ(std::get<MadeKernel>(made).compiled, first);
        if (first) code = std::get<MadeKernel>(made).object->code;
        EXPECT_TRUE(std::get<MadeKernel>(made).object->code == code);
    }
    auto without = find_or_compile(request, key, nullptr);
    ASSERT_TRUE(std::holds_alternative<MadeKernel>(without));
    EXPECT_TRUE(std::get<MadeKernel>(without).compiled);
    EXPECT_TRUE(std::get<MadeKernel>(without).object->code == code) << "the same every time";
}

}  // namespace
}  // namespace openfab::lower
