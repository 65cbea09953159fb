// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/tuner/stand.h"

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "abi/kernel_call.h"
#include "backends/common/tee_sink.h"
#include "base/allowance.h"
#include "base/check.h"
#include "tools/tuner/messages.h"

namespace openfab::tuner {

Result<std::unique_ptr<Stand>> Stand::create(Workload* workload,
                                             const std::atomic<bool>& interrupt) {
    std::unique_ptr<Stand> out(new Stand(workload));
    for (auto* program : {&out->program_, &out->first_}) {
        auto loaded = workload->compile(workload->program_options());
        if (const auto* fault = std::get_if<lower::Fault>(&loaded)) return workload->report(*fault);
        *program = std::move(std::get<std::unique_ptr<lower::LoadedProgram>>(loaded));
    }
    auto job = workload->set_up(out->program_->fablets(), interrupt);
    if (!job) return job.error();
    out->job_ = std::move(*job);
    return out;
}

std::vector<Contender> Stand::compile(const std::vector<std::string>& texts) const {
    std::vector<Contender> out(texts.size());
    std::atomic<size_t> next{0};
    const lower::ProgramOptions base = workload_->program_options();
    const auto work = [&] {
        for (size_t k = next++; k < texts.size(); k = next++) {
            lower::ProgramOptions options = base;
            options.threads = 1;
            auto schedule = schedule::read({"candidate", texts[k]},
                                           {.target = abi::isa_name(workload_->isa())});
            if (const auto* fault = std::get_if<schedule::Fault>(&schedule)) {
                out[k].refused = fault->message;
                continue;
            }
            options.schedules[{"slab", workload_->isa()}] =
                std::get<schedule::Schedule>(std::move(schedule));
            auto loaded = workload_->compile(options);
            if (const auto* fault = std::get_if<lower::Fault>(&loaded)) {
                out[k].refused = fault->schedule ? fault->schedule->message : fault->trouble;
                continue;
            }
            out[k].program = std::move(std::get<std::unique_ptr<lower::LoadedProgram>>(loaded));
        }
    };
    const size_t threads = std::min<size_t>(texts.size(), static_cast<size_t>(usable_cores()));
    std::vector<std::thread> others;
    for (size_t k = 1; k < threads; ++k)
        others.emplace_back(work);
    work();
    for (std::thread& other : others)
        other.join();
    return out;
}

Result<pipeline::SlabsRun> Stand::print(const std::vector<int32_t>& slabs,
                                        const std::atomic<bool>& interrupt) {
    backends::NullSink nowhere;
    return job_->run_slabs(slabs, nowhere, interrupt, nullptr);
}

Result<double> Stand::run(const Contender* contender, const std::vector<int32_t>& slabs,
                          const std::atomic<bool>& interrupt) {
    // The clock of the processor's seconds, and threads that come and go, are a millisecond or two.
    constexpr double kLeastSeconds = 0.03;
    constexpr double kMostTimes = 50;
    const lower::LoadedProgram& program = contender != nullptr ? *contender->program : *first_;
    use_slab_kernels(program.fablets(), program_->fablets(), workload_->isa());
    auto known = known_.find(slabs);
    if (known == known_.end()) {
        OPENFAB_CHECK(contender == nullptr);
        // The first fills caches.
        const Result<pipeline::SlabsRun> cold = print(slabs, interrupt);
        if (!cold) return cold.error();
        const Result<pipeline::SlabsRun> warm = print(slabs, interrupt);
        if (!warm) return warm.error();
        const double times = kLeastSeconds / std::max(1e-6, warm->processor_seconds);
        known = known_
                    .emplace(slabs, Known{cold->hash, static_cast<int32_t>(std::clamp(
                                                          std::ceil(times), 1.0, kMostTimes))})
                    .first;
    }
    double seconds = 0;
    for (int32_t n = 0; n < known->second.times; ++n) {
        const Result<pipeline::SlabsRun> done = print(slabs, interrupt);
        if (!done) return done.error();
        if (known->second.hash != done->hash) return internal_error(messages::kVoxelsDiffer);
        seconds += done->processor_seconds;
    }
    return seconds / known->second.times;
}

Result<int32_t> Stand::slabs_in(double seconds, const std::atomic<bool>& interrupt) {
    const int32_t all = slabs().y - slabs().x;
    int32_t count = std::min(all, 4);
    for (;;) {
        const std::vector<int32_t> some = spread_slabs(slabs(), count, 2, 0.5);
        const Result<double> one = run(nullptr, some, interrupt);
        if (!one) return one.error();
        const double wanted = count * seconds / std::max(*one, 1e-4);
        if (count == all || wanted <= 2 * count)
            return static_cast<int32_t>(std::clamp(wanted, std::min(2.0, 1.0 * all), 1.0 * all));
        count = static_cast<int32_t>(std::min(1.0 * all, wanted / 2));
    }
}

Result<void> Stand::fits(const Contender& contender) const {
    static const std::atomic<bool> never{false};
    const auto job = workload_->set_up(contender.program->fablets(), never);
    if (!job) return job.error();
    return {};
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const size_t half = values.size() / 2;
    return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

}  // namespace openfab::tuner
