// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Every file of the readers' corpora, and damaged forms of each: any result is fine except a crash,
// a minute, or too much memory. OPENFAB_MUTATIONS: how many for each reader; OPENFAB_MUTATION_SEED:
// the first seed. A failure names its seed and keeps the file.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/mutations/mutate.h"
#include "tests/fuzz/readers/readers.h"
#include "tests/support/memory/meter.h"

namespace openfab::testing {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMutations = 300;
/// In addition to the readers' memory: the file in the test, and messages.
constexpr int64_t kSlack = 10'000'000;

uint64_t from_environment(const char* name, uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

struct Sample {
    std::string name;
    std::string bytes;
};

std::vector<Sample> corpus(const Reader& reader) {
    std::vector<Sample> samples;
    const fs::path folder = fs::path("tests/fuzz/corpus") / reader.name;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        std::ifstream in(entry.path(), std::ios::binary);
        samples.push_back({entry.path().string(), {std::istreambuf_iterator<char>(in), {}}});
    }
    std::sort(samples.begin(), samples.end(),
              [](const Sample& x, const Sample& y) { return x.name < y.name; });
    return samples;
}

/// Returns whether they were read; checks the memory.
bool use(const Reader& reader, const std::string& bytes, const std::string& what) {
    const testing::Meter meter;
    const bool whole = reader.read(bytes);
    EXPECT_LE(meter.peak_bytes(), kReaderBytes + kSlack) << what;
    EXPECT_LT(meter.seconds(), testing::kHangSeconds) << what;
    return whole;
}

class Readers : public ::testing::TestWithParam<Reader> {
  protected:
    const Reader& reader_ = GetParam();
    const std::vector<Sample> samples_ = corpus(reader_);
};

TEST_P(Readers, ReplayTheirCorpora) {
    size_t whole = 0;
    for (const Sample& sample : samples_)
        whole += use(reader_, sample.bytes, sample.name);
    EXPECT_GT(whole, 0U) << "no sound file";
    // A schedule may be empty.
    EXPECT_EQ(use(reader_, "", "no bytes"), std::string_view(reader_.name) == "sched");
}

TEST_P(Readers, SealingChangesNoSoundFile) {
    if (reader_.seal == nullptr) return;
    for (const Sample& sample : samples_) {
        std::string sealed = sample.bytes;
        reader_.seal(&sealed);
        EXPECT_TRUE(sealed == sample.bytes || !reader_.read(sample.bytes)) << sample.name;
    }
}

TEST_P(Readers, AnswerWhateverTheyAreGiven) {
    const uint64_t first = from_environment("OPENFAB_MUTATION_SEED", 1);
    const uint64_t count = from_environment("OPENFAB_MUTATIONS", kMutations);
    const fs::path left =
        fs::temp_directory_path() / fmt::format("openfab-mutant-{}.{}", ::getpid(), reader_.name);
    ASSERT_FALSE(samples_.empty());
    uint64_t whole = 0;
    for (uint64_t seed = first; seed < first + count && !HasFailure(); ++seed) {
        std::mt19937_64 random(seed);
        const Sample& sample = samples_[random() % samples_.size()];
        std::string bytes = mutate(sample.bytes, reader_.text, &random);
        if (reader_.seal != nullptr && random() % 2 == 0) reader_.seal(&bytes);
        // There if the reader ends the program.
        std::ofstream(left, std::ios::binary) << bytes;
        whole += use(reader_, bytes,
                     fmt::format("seed {} of {}, in {}", seed, sample.name, left.string()));
    }
    // Damage that nothing survives would test the first check alone. Of bytes all may be summed.
    EXPECT_TRUE(whole > 0 || (!reader_.text && reader_.seal == nullptr));
    fmt::print("{}: {} of {} were read whole\n", reader_.name, whole, count);
    if (!HasFailure()) fs::remove(left);
}

INSTANTIATE_TEST_SUITE_P(All, Readers, ::testing::ValuesIn(readers()),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace openfab::testing
