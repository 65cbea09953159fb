// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What one world's slab kernel takes by schedule, in turn, in one process:
//   bench_schedules WORLD.fab.json ROUNDS CONTENDER … [-- options of the print]
// The built-in schedule comes first. A contender is a file of a schedule; `by_hand`, the kernel written
// in Halide (by_hand.h); or the path of another `openfab`, of an older checkout, whose whole prints
// are compared with those of this build. Of each round every contender prints the same slabs once;
// figures are medians over the rounds, with half the distance between quartiles, of processor time and
// of its ratio to that of the built-in schedule (or of this build) in the same round. A contender whose
// slabs have other voxels than the built-in schedule's is an error.

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "base/own_folder.h"
#include "base/say.h"
#include "bench/schedules/by_hand.h"
#include "compiler/lower/code/program.h"
#include "tools/tuner/machine.h"
#include "tools/tuner/stand.h"

namespace openfab::tuner {

namespace {

const std::atomic<bool> never{false};
constexpr std::string_view kByHand = "by_hand";

struct Row {
    std::string name;
    std::vector<double> seconds, ratios;

    void add(double run, double first) {
        seconds.push_back(run);
        ratios.push_back(run / first);
    }
    void show_figures() const {
        show(fmt::format("{:<40} {:>8.3f} +- {:.3f} s {:>8.3f} +- {:.3f}\n", name, median(seconds),
                         spread(seconds), median(ratios), spread(ratios)));
    }
};

Result<std::string> read(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (!in) return outside_error(fmt::format("cannot read `{}`", file));
    return text;
}

/// Puts the kernel written by hand into the contender's tables.
Result<by_hand::HandKernel> put_by_hand(const Contender& contender, openfab_isa isa) {
    const openfab_fablet_list& list = contender.program->fablets();
    if (list.count != 1) return user_error("a world of one fablet is wanted");
    Result<by_hand::HandKernel> hand = by_hand::compile(list.fablets[0]->name, isa);
    if (!hand) return hand.error();
    // The tables of a loaded program are its own memory; only the view of them is constant.
    auto& kernel = const_cast<openfab_kernel&>(list.fablets[0]->slab);
    kernel.fn[isa] = hand->loaded.function;
    kernel.arg_count = static_cast<int32_t>(hand->args.size());
    kernel.args = hand->args.data();
    return hand;
}

/// Whole prints of other programs beside those of this build.
class Programs {
  public:
    static Result<Programs> create(const std::vector<std::string>& paths,
                                   std::vector<std::string> print) {
        Programs out;
        if (paths.empty()) return out;
        auto folder = TemporaryFolder::create();
        if (!folder) return folder.error();
        out.folder_ = std::move(*folder);
        out.print_ = std::move(print);
        const auto own = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "openfab";
        out.rows_.push_back({own.string(), {}, {}});
        for (const std::string& path : paths)
            out.rows_.push_back({path, {}, {}});
        return out;
    }

    /// Prints once with each. `counts`: whether the figures are kept.
    Result<void> run(bool counts) {
        double first = 0;
        for (size_t k = 0; k < rows_.size(); ++k) {
            const Result<double> seconds = print(k);
            if (!seconds) return seconds.error();
            if (k == 0) first = *seconds;
            if (counts) rows_[k].add(*seconds, first);
        }
        return {};
    }

    void show_figures() const {
        if (rows_.empty()) return;
        show("whole prints:\n");
        for (const Row& row : rows_)
            row.show_figures();
    }

  private:
    static double children_seconds() {
        rusage usage{};
        ::getrusage(RUSAGE_CHILDREN, &usage);
        const auto seconds = [](const timeval& t) { return t.tv_sec + 1e-6 * t.tv_usec; };
        return seconds(usage.ru_utime) + seconds(usage.ru_stime);
    }

    /// Each has a cache of its own, which the first print fills.
    Result<double> print(size_t k) {
        const std::string output = (folder_->path() / fmt::format("{}.ofr", k)).string();
        std::vector<std::string> command = {
            "env", fmt::format("XDG_CACHE_HOME={}/cache{}", folder_->path().string(), k),
            rows_[k].name, "print"};
        command.insert(command.end(), print_.begin(), print_.end());
        command.insert(command.end(), {"-o", output});
        const double before = children_seconds();
        const std::string fault = lower::run_tool(command, folder_->path());
        if (!fault.empty()) return outside_error(fmt::format("{}: {}", rows_[k].name, fault));
        const double seconds = children_seconds() - before;
        std::filesystem::remove(output);
        return seconds;
    }

    std::unique_ptr<TemporaryFolder> folder_;
    std::vector<std::string> print_;
    std::vector<Row> rows_;
};

Result<void> compare(const std::vector<std::string>& words) {
    const auto dashes = std::find(words.begin(), words.end(), "--");
    if (dashes - words.begin() < 3)
        return usage_error("bench_schedules WORLD.fab.json ROUNDS CONTENDER … [-- options]");
    std::vector<std::string> print = {words[0]};
    if (dashes != words.end()) print.insert(print.end(), dashes + 1, words.end());
    const Result<program::Options> options = parse_print(print, "bench_schedules");
    if (!options) return options.error();
    auto workload = Workload::create(*options, {});
    if (!workload) return workload.error();
    auto stand = Stand::create(workload->get(), never);
    if (!stand) return stand.error();

    std::vector<Row> rows = {{"built-in", {}, {}}};
    std::vector<std::string> texts, programs;
    for (auto word = words.begin() + 2; word != dashes; ++word) {
        if (*word == kByHand) {
            texts.emplace_back("include \"slab.sched\"\n");
        } else if (word->ends_with(".sched")) {
            Result<std::string> text = read(*word);
            if (!text) return text.error();
            texts.push_back(std::move(*text));
        } else {
            programs.push_back(*word);
            continue;
        }
        rows.push_back({*word, {}, {}});
    }
    const std::vector<Contender> contenders = (*stand)->compile(texts);
    std::vector<by_hand::HandKernel> by_hand;
    for (size_t k = 0; k < contenders.size(); ++k) {
        if (!contenders[k].refused.empty())
            return user_error(fmt::format("{}: {}", rows[k + 1].name, contenders[k].refused));
        if (rows[k + 1].name != kByHand) continue;
        auto hand = put_by_hand(contenders[k], (*workload)->isa());
        if (!hand) return hand.error();
        by_hand.push_back(std::move(*hand));
    }
    Result<Programs> others = Programs::create(programs, print);
    if (!others) return others.error();
    constexpr double kSeconds = 0.5;
    const Result<int32_t> count = (*stand)->slabs_in(kSeconds, never);
    if (!count) return count.error();
    const std::vector<int32_t> slabs = spread_slabs((*stand)->slabs(), *count, 2, 0.25);
    const int rounds = std::atoi(words[1].c_str());
    // The first fills caches.
    for (int round = -1; round < rounds; ++round) {
        double built_in = 0;
        for (size_t k = 0; k < rows.size(); ++k) {
            const Result<double> run =
                (*stand)->run(k == 0 ? nullptr : &contenders[k - 1], slabs, never);
            if (!run) return run.error();
            if (k == 0) built_in = *run;
            if (round >= 0) rows[k].add(*run, built_in);
        }
        if (const Result<void> done = others->run(round >= 0); !done) return done.error();
    }
    show(fmt::format("{}: {} slabs, {} rounds, {} on {}\n", (*stand)->info().title, slabs.size(),
                     rounds, lower::isa_name((*workload)->isa()), processor_name()));
    for (const Row& row : rows)
        row.show_figures();
    others->show_figures();
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
