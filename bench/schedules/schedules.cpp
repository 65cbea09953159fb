// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Schedules of one world's slab kernel against each other, in turn, in one process:
//   bench_schedules WORLD.fab.json ROUNDS FILE.sched … [-- options of the print]
// The built-in schedule comes first. Of each round every schedule prints the same slabs once; figures
// are medians over the rounds, with half the distance between quartiles, of processor time and of its
// ratio to the built-in schedule's in the same round. Voxels are compared, too.

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "base/say.h"
#include "tools/tuner/machine.h"
#include "tools/tuner/stand.h"

namespace openfab::tuner {

namespace {

const std::atomic<bool> never{false};

Result<void> compare(const std::vector<std::string>& words) {
    const auto dashes = std::find(words.begin(), words.end(), "--");
    if (dashes - words.begin() < 3)
        return usage_error("bench_schedules WORLD.fab.json ROUNDS FILE.sched … [-- options]");
    std::vector<std::string> print = {words[0]};
    if (dashes != words.end()) print.insert(print.end(), dashes + 1, words.end());
    const Result<program::Options> options = parse_print(print, "bench_schedules");
    if (!options) return options.error();
    auto workload = Workload::create(*options, {});
    if (!workload) return workload.error();
    auto stand = Stand::create(workload->get(), never);
    if (!stand) return stand.error();
    const std::vector<std::string> files(words.begin() + 2, dashes);
    std::vector<std::string> texts;
    for (const std::string& file : files) {
        std::ifstream in(file);
        texts.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
        if (!in) return outside_error(fmt::format("cannot read `{}`", file));
    }
    const std::vector<Contender> contenders = (*stand)->compile(texts);
    for (size_t k = 0; k < files.size(); ++k) {
        if (!contenders[k].refused.empty())
            return user_error(fmt::format("{}: {}", files[k], contenders[k].refused));
    }
    constexpr double kSeconds = 0.5;
    const Result<int32_t> count = (*stand)->slabs_in(kSeconds, never);
    if (!count) return count.error();
    const std::vector<int32_t> slabs = spread_slabs((*stand)->slabs(), *count, 2, 0.25);
    std::vector<std::vector<double>> seconds(files.size() + 1), ratios(files.size() + 1);
    const int rounds = std::atoi(words[1].c_str());
    // The first fills caches.
    for (int round = -1; round < rounds; ++round) {
        double built_in = 0;
        for (size_t k = 0; k <= files.size(); ++k) {
            const Result<double> run =
                (*stand)->run(k == 0 ? nullptr : &contenders[k - 1], slabs, never);
            if (!run) return run.error();
            if (k == 0) built_in = *run;
            if (round < 0) continue;
            seconds[k].push_back(*run);
            ratios[k].push_back(*run / built_in);
        }
    }
    show(fmt::format("{}: {} slabs, {} rounds, {} on {}\n", (*stand)->info().title, slabs.size(),
                     rounds, lower::isa_name((*workload)->isa()), processor_name()));
    for (size_t k = 0; k <= files.size(); ++k) {
        show(fmt::format("{:<40} {:>8.3f} +- {:.3f} s {:>8.3f} +- {:.3f}\n",
                         k == 0 ? "built-in" : files[k - 1], median(seconds[k]), spread(seconds[k]),
                         median(ratios[k]), spread(ratios[k])));
    }
    return {};
}

}  // namespace

}  // namespace openfab::tuner

int main(int argc, char** argv) {
    using namespace openfab;
    prepare_streams();
    const Result<void> done = tuner::compare({argv + 1, argv + argc});
    if (done) return 0;
    return done.error().message.empty() ? exit_code(done.error().code) : say_error(done.error());
}
