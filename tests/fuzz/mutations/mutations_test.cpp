// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Damaged worlds, meshes, pictures, printers and transform lists are loaded and, if they load,
// printed small: any result is fine except a crash, a hang, a leak, or more memory than the budget.
// OPENFAB_MUTATIONS: how many; OPENFAB_MUTATION_SEED: the first seed. A failure names its seed and
// keeps the file.

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "program/print_main.h"
#include "tests/fuzz/mutations/mutate.h"
#include "tests/fuzz/mutations/samples.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/prints/box_print.h"
#include "tests/support/prints/test_fablets.h"
#include "tests/support/process/process.h"
#include "texture/pyramid.h"
#include "tools/texture/convert.h"
#include "tools/texture/convert_volume.h"

namespace openfab::testing {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

#ifdef OPENFAB_SANITIZED
constexpr auto kHang = 600s;
constexpr auto kPatience = 5s;  ///< a print that is merely large is interrupted after this
constexpr long kMostKilobytes = 3'000'000;
constexpr uint64_t kMutations = 150;
#else
constexpr auto kHang = 300s;
constexpr auto kPatience = 1s;
constexpr long kMostKilobytes = 700'000;
constexpr uint64_t kMutations = 1000;
#endif
/// Memory budget of the print; the rest of kMostKilobytes is for reading.
constexpr int64_t kBudget = 300'000'000;
constexpr uint64_t kBatch = 25;

uint64_t from_environment(const char* name, uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

/// Message from the child to the parent.
struct Progress {
    std::atomic<uint64_t> seed;
    std::atomic<uint64_t> printed;  ///< that could be printed
    std::atomic<bool> too_much_memory;
};

void print_file(const std::string& file, Clock::duration patience, std::atomic<uint64_t>* printed) {
    const openfab_fablet* const fablets[] = {&skin_fablet()};
    program::Options options;
    options.input = file;
    options.progress = program::ProgressMode::kNone;
    options.stats_file = "/dev/null";
    options.memory_bytes = kBudget + kSanitizerBytes;
    options.threads = 2;
    options.slices = Vec2<int32_t>{0, 4};
    if (!file.ends_with(".json")) options.voxel_mm = 0.4;
    std::atomic<bool> interrupt{false}, over{false};
    std::thread clock([&] {
        for (const auto start = Clock::now(); !over && Clock::now() - start < patience;)
            std::this_thread::sleep_for(1ms);
        interrupt = true;
    });
    const Result<void> done = program::run_print(options, {1, fablets}, interrupt);
    over = true;
    clock.join();
    if (done) {
        ++*printed;
        return;
    }
    fmt::print(stderr, "{}\n", done.error().text());
    // Only a bug of ours causes these.
    if (done.error().code == ErrorCode::kInternal) std::abort();
}

void convert(const Sample& sample, const std::string& file, std::atomic<uint64_t>* printed) {
    const std::string out = file + ".oftx";
    const Result<void> made = sample.kind == Sample::Kind::kImage
                                  ? tools::make_pyramid_file(file, out, {})
                                  : tools::make_volume_file(file, out, {});
    if (!made) {
        fmt::print(stderr, "{}\n", made.error().text());
        return;
    }
    const auto opened = texture::Pyramid::open(out, 0, 0);
    if (opened && (*opened)->texels().size() >= static_cast<size_t>((*opened)->channels()))
        ++*printed;
}

/// Skips destructors of libraries, some of which wait for threads that fork does not copy.
[[noreturn]] void end_child() {
#ifdef __SANITIZE_ADDRESS__
    __lsan_do_leak_check();  // ends the process on a leak
#endif
    ::_exit(0);
}

class Mutations : public ::testing::Test {
  protected:
    Mutations() : samples_(samples()) {
        for (const auto& [name, content] : sound_files())
            folder_.write(name, content);
        for (const Sample& sample : samples_)
            folder_.write(sample.name, packed(sample, sample.content));
        void* shared = ::mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE,
                              MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        progress_ = new (shared) Progress{};
    }
    ~Mutations() override { ::munmap(progress_, sizeof(Progress)); }

    static std::string packed(const Sample& sample, const std::string& content) {
        return sample.pack ? sample.pack(content) : content;
    }
    std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

    /// Cycles through the kinds of samples.
    const Sample& sample_of(uint64_t seed) const {
        // Every third is a world, which covers most of the readers.
        return seed % 3 == 0 ? samples_[0] : samples_[seed / 3 % samples_.size()];
    }
    std::string content_of(uint64_t seed) const {
        std::mt19937_64 random(seed);
        const Sample& sample = sample_of(seed);
        return packed(sample, mutate(sample.content, sample.text, &random));
    }
    void use(const Sample& sample, Clock::duration patience) {
        if (sample.kind == Sample::Kind::kImage || sample.kind == Sample::Kind::kVolume) {
            convert(sample, path(sample.name), &progress_->printed);
        } else {
            print_file(path(sample.print.empty() ? sample.name : sample.print), patience,
                       &progress_->printed);
        }
    }
    /// In a child process, which may crash.
    void run_batch(uint64_t begin, uint64_t end) {
        for (uint64_t seed = begin; seed < end; ++seed) {
            progress_->seed = seed;
            const Sample& sample = sample_of(seed);
            folder_.write(sample.name, content_of(seed));
            use(sample, kPatience);
            folder_.write(sample.name, packed(sample, sample.content));
            rusage usage{};
            ::getrusage(RUSAGE_SELF, &usage);
            if (usage.ru_maxrss > kMostKilobytes) {
                progress_->too_much_memory = true;
                ::_exit(1);
            }
        }
    }
    /// Describes how a child ended; empty on success.
    std::string wait_for(pid_t child) const {
        int status = 0;
        uint64_t seed = progress_->seed;
        for (auto since = Clock::now(); ::waitpid(child, &status, WNOHANG) == 0;) {
            std::this_thread::sleep_for(5ms);
            if (seed != progress_->seed) since = Clock::now();
            seed = progress_->seed;
            if (Clock::now() - since < kHang) continue;
            ::kill(child, SIGKILL);
            ::waitpid(child, &status, 0);
            return "does not end";
        }
        if (progress_->too_much_memory) return "takes too much memory";
        if (WIFSIGNALED(status)) return fmt::format("ends with signal {}", WTERMSIG(status));
        if (WEXITSTATUS(status) == 0) return {};
        return fmt::format("ends with {} (of a leak the seed may be an earlier one)",
                           WEXITSTATUS(status));
    }

    std::vector<Sample> samples_;
    testing::TempFolder folder_;
    Progress* progress_ = nullptr;
};

TEST_F(Mutations, AnswerAndNothingWorse) {
    const uint64_t first = from_environment("OPENFAB_MUTATION_SEED", 1);
    const uint64_t count = from_environment("OPENFAB_MUTATIONS", kMutations);
    const std::string said = path("said.txt");
    for (uint64_t seed = first; seed < first + count;) {
        const uint64_t end = std::min(seed + kBatch, first + count);
        progress_->seed = seed;
        progress_->too_much_memory = false;
        std::fflush(nullptr);
        const pid_t child = ::fork();
        ASSERT_GE(child, 0);
        if (child == 0) {
            const int out = ::open(said.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
            ::dup2(out, STDERR_FILENO);
            run_batch(seed, end);
            end_child();
        }
        const std::string fault = wait_for(child);
        seed = progress_->seed + 1;
        if (fault.empty()) continue;
        const std::string words = testing::read_file(said);
        ADD_FAILURE() << "seed " << seed - 1 << ", " << sample_of(seed - 1).name << ": " << fault
                      << "\n"
                      << words.substr(words.size() - std::min<size_t>(words.size(), 6000))
                      << "\nthe file:\n"
                      << content_of(seed - 1).substr(0, 3000);
    }
    // If nothing survived, only the first check would be tested.
    EXPECT_GT(progress_->printed, count / 20);
    fmt::print("{} of {} were printed\n", progress_->printed.load(), count);
}

TEST_F(Mutations, TheSoundFilesAreFine) {
    for (const Sample& sample : samples_) {
        progress_->printed = 0;
        const pid_t child = ::fork();
        ASSERT_GE(child, 0);
        if (child == 0) {
            use(sample, kHang);
            end_child();
        }
        EXPECT_EQ(wait_for(child), "") << sample.name;
        EXPECT_EQ(progress_->printed, 1U) << sample.name;
    }
}

}  // namespace
}  // namespace openfab::testing
