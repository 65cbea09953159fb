// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Files that are made whole, on a disk that loses power at any moment: what is there afterwards under its name is the
// file of before, or the new one, or it is told from both by who reads it.

#include <gtest/gtest.h>

#include <random>

#include "backends/boundary/mesh_sink.h"
#include "backends/gcvf/gcvf_sink.h"
#include "base/json_text.h"
#include "base/replace_file.h"
#include "compiler/lower/code/kernel_cache.h"
#include "tests/support/long_run.h"
#include "tests/support/process/process.h"
#include "tests/unit/backends/lossy_disk.h"
#include "tests/unit/backends/sample_print.h"
#include "texture/pyramid_file.h"
#include "tools/openfab/audit_log.h"

namespace openfab::testing {
namespace {

namespace fs = std::filesystem;

/// A print without its last material, if `all` is false: it has other files.
SamplePrint sample(bool all) {
    SamplePrint print = make_sample({9, 7, 6});
    if (all) return print;
    for (uint8_t& code : print.codes)
        code = static_cast<uint8_t>((code + 1) % 3);
    return print;
}

class PowerLossFiles : public ::testing::Test {
  protected:
    using Check = std::function<void(const Files& left)>;

    fs::path folder() const { return scratch_ / "disk"; }

    /// Calls `first`, then `second` on a disk that loses power, and `check` for what is left of each of many moments.
    void cut(const std::function<void()>& first, const std::function<void()>& second,
             const Check& check) {
        fs::create_directories(folder());
        first();
        before_ = files_in(folder());
        LossyDisk disk(folder());
        second();
        disk.stop();
        after_ = files_in(folder());
        std::mt19937 random(11);
        const int cuts = count_of_cuts();
        for (int i = 0; i < cuts && !HasFailure(); ++i) {
            SCOPED_TRACE(i);
            check(disk.after_loss(random() % (disk.steps() + 1), &random));
        }
        std::printf("%d cuts at %zu moments\n", cuts, disk.steps() + 1);
    }

    void put(const Files& files) const { put_files(folder(), files); }

    ScratchFolder scratch_;
    Files before_, after_;
};

TEST_F(PowerLossFiles, Meshes) {
    using Make = std::unique_ptr<boundary::MeshWriter> (*)(const fs::path&);
    const std::pair<const char*, Make> formats[] = {{"part.stl", boundary::make_stl_writer},
                                                    {"part.3mf", boundary::make_threemf_writer},
                                                    {"inks.3mf", boundary::make_filament_writer}};
    for (const auto& [name, make] : formats) {
        SCOPED_TRACE(name);
        for (const bool all : {true, false}) {
            fs::remove_all(folder());
            const auto print = [&, make = make, name = name](bool which) {
                boundary::MeshSink sink(make(folder() / name));
                EXPECT_TRUE(sample(which).send(&sink));
            };
            int of_before = 0, of_after = 0;
            cut([&] { print(!all); }, [&] { print(all); },
                [&](const Files& left) {
                    bool old = false, fresh = false;
                    for (const auto& [file, bytes] : left) {
                        if (file.ends_with(".part")) continue;
                        const auto a = before_.find(file), b = after_.find(file);
                        const bool is_old = a != before_.end() && a->second == bytes;
                        const bool is_fresh = b != after_.end() && b->second == bytes;
                        EXPECT_TRUE(is_old || is_fresh) << file << " is neither";
                        old |= is_old && !is_fresh;
                        fresh |= is_fresh && !is_old;
                    }
                    EXPECT_FALSE(old && fresh) << "files of two prints";
                    of_before += old ? 1 : 0;
                    of_after += fresh ? 1 : 0;
                });
            EXPECT_GT(of_before, 0);
            EXPECT_GT(of_after, 0);
        }
    }
}

TEST_F(PowerLossFiles, Packages) {
    const auto print = [&](bool which) {
        gcvf::GcvfSink sink(folder() / "a.gcvf", false);
        EXPECT_TRUE(sample(which).send(&sink));
    };
    cut([&] { print(false); }, [&] { print(true); },
        [&](const Files& left) {
            const auto file = left.find("a.gcvf");
            if (file == left.end()) return;
            EXPECT_TRUE(file->second == before_.at("a.gcvf") ||
                        file->second == after_.at("a.gcvf"));
        });
}

/// A world that the page of the viewer changes.
TEST_F(PowerLossFiles, ReplacedFiles) {
    const std::string old(3000, 'a'), fresh(9000, 'b');
    cut([&] { scratch_.write("disk/w.fab.json", old); },
        [&] { EXPECT_TRUE(replace_file(folder() / "w.fab.json", fresh)); },
        [&](const Files& left) {
            ASSERT_TRUE(left.contains("w.fab.json"));
            EXPECT_TRUE(left.at("w.fab.json") == old || left.at("w.fab.json") == fresh);
        });
}

TEST_F(PowerLossFiles, KernelsOfTheCache) {
    const auto object = [](uint64_t number, char letter) {
        return std::make_shared<const lower::KernelObject>(
            lower::KernelObject{{number, ~number}, std::string(5000, letter), 7});
    };
    int found = 0, lost = 0;
    cut([&] { lower::KernelCache(folder()).insert(object(1, 'a')); },
        [&] {
            lower::KernelCache cache(folder());
            cache.insert(object(2, 'b'));
            cache.insert(object(3, 'c'));
        },
        [&](const Files& left) {
            put(left);
            lower::KernelCache cache(folder());
            for (const uint64_t number : {1, 2, 3}) {
                const auto kept = cache.find({number, ~number});
                ++(kept ? found : lost);
                const std::string code(5000, static_cast<char>('a' + number - 1));
                EXPECT_TRUE(!kept || kept->code == code);
            }
        });
    EXPECT_GT(found, 0);
    EXPECT_GT(lost, 0);
}

TEST_F(PowerLossFiles, PyramidsOfTheCache) {
    const auto write = [&](float value) {
        const Result<texture::PyramidLayout> layout = texture::pyramid_layout(20, 10, 3);
        ASSERT_TRUE(layout);
        auto writer = texture::PyramidWriter::create(folder() / "p.oftx", *layout, 5);
        ASSERT_TRUE(writer) << writer.error().text();
        for (int i = 0; i < 20 * 10 * 3; ++i)
            (*writer)->level0()[i] = value + static_cast<float>(i);
        EXPECT_TRUE((*writer)->finish());
    };
    int whole = 0, told = 0;
    cut([&] { write(1); }, [&] { write(2); },
        [&](const Files& left) {
            put(left);
            const auto kept = left.find("p.oftx");
            if (kept == left.end()) return;
            const Result<InputFile> file = InputFile::open(folder() / "p.oftx");
            const bool fine = file && texture::check_pyramid_file(*file);
            ++(fine ? whole : told);
            EXPECT_EQ(fine,
                      kept->second == before_.at("p.oftx") || kept->second == after_.at("p.oftx"));
        });
    EXPECT_GT(whole, 0);
    EXPECT_GT(told, 0);
}

/// Of `openfab receive --log`: no event that was written is lost, and a line that a failure tore spoils no other.
TEST_F(PowerLossFiles, LogsOfReceivers) {
    const auto add = [&](const char* event) {
        const auto log = tools::AuditLog::open((folder() / "log").string());
        ASSERT_TRUE(log) << log.error().text();
        (*log)->add(event, "here", "print", 3, "text");
    };
    const auto events = [](const std::string& text) {
        std::vector<std::string> out;
        for (size_t at = 0; at < text.size();) {
            const size_t end = std::min(text.find('\n', at), text.size());
            const Result<JsonValue> line = parse_json(text.substr(at, end - at), "log");
            if (line) out.push_back(member_of(*line, "event")->text);
            at = end + 1;
        }
        return out;
    };
    int torn = 0;
    cut([&] { add("first"); },
        [&] {
            add("second");
            add("third");
        },
        [&](const Files& left) {
            put(left);
            const std::vector<std::string> kept = events(left.at("log"));
            ASSERT_FALSE(kept.empty());
            EXPECT_EQ(kept[0], "first");
            torn += left.at("log").back() != '\n' ? 1 : 0;
            add("next");
            std::vector<std::string> more = kept;
            more.emplace_back("next");
            EXPECT_EQ(events(files_in(folder()).at("log")), more);
        });
    EXPECT_GT(torn, 0);
}

}  // namespace
}  // namespace openfab::testing
