// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/tuner/machine.h"

#include <algorithm>
#include <atomic>
#include <fstream>
#include <functional>
#include <numeric>
#include <string_view>
#include <thread>
#include <vector>

#include "base/clock.h"
#include "base/text.h"

namespace openfab::tuner {

namespace {

/// Larger than last-level caches, so that all of it comes from memory.
constexpr size_t kFloats = size_t{8} << 20;
constexpr int kRounds = 3;

/// Runs `work(thread)`, which returns how much it did, in so many threads at once. Returns the sum of
/// what they do in a second of the processor, in the best round.
double best_rate(int32_t threads, const std::function<double(int32_t)>& work) {
    double best = 0;
    for (int round = 0; round < kRounds; ++round) {
        std::vector<double> rates(static_cast<size_t>(threads));
        const auto run = [&](int32_t t) {
            const double start = thread_processor_seconds();
            const double done = work(t);
            rates[static_cast<size_t>(t)] = done / (thread_processor_seconds() - start);
        };
        std::vector<std::thread> others;
        for (int32_t t = 1; t < threads; ++t)
            others.emplace_back(run, t);
        run(0);
        for (std::thread& other : others)
            other.join();
        best = std::max(best, std::accumulate(rates.begin(), rates.end(), 0.0));
    }
    return best;
}

void triad(const float* b, const float* c, float* a, size_t first, size_t end) {
    for (size_t i = first; i < end; ++i)
        a[i] = b[i] + 3.0f * c[i];
}

using Vector4 = float __attribute__((vector_size(16)));
using Vector8 = float __attribute__((vector_size(32)));

constexpr int kChains = 10;  // enough to hide the latency of either operation
constexpr int64_t kSteps = 4'000'000;

/// Returns the operations done. The result is used, so that none is left out.
template <typename Vector>
[[gnu::always_inline]] inline int64_t multiply_and_add(std::atomic<float>* used) {
    Vector chains[kChains];
    for (int k = 0; k < kChains; ++k)
        chains[k] = Vector{} + static_cast<float>(k);
    const Vector factor = Vector{} + 0.999f, term = Vector{} + 0.5f;
    for (int64_t step = 0; step < kSteps; ++step) {
#pragma GCC unroll 10
        for (int k = 0; k < kChains; ++k)
            chains[k] = chains[k] * factor + term;
    }
    float sum = 0;
    for (const Vector& chain : chains)
        sum += chain[0];
    used->store(sum, std::memory_order_relaxed);
    return 2 * kSteps * kChains * static_cast<int64_t>(sizeof(Vector) / sizeof(float));
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] int64_t operate_avx2(std::atomic<float>* used) {
    return multiply_and_add<Vector8>(used);
}
#endif
int64_t operate_sse41(std::atomic<float>* used) {
    return multiply_and_add<Vector4>(used);
}

}  // namespace

std::string processor_name() {
    std::ifstream file("/proc/cpuinfo");
    constexpr std::string_view kKey = "model name";
    for (std::string line; std::getline(file, line);) {
        const size_t colon = line.find(": ");
        if (line.starts_with(kKey) && colon != std::string::npos)
            return printable(line.substr(colon + 2));
    }
    return "an unknown processor";
}

Machine measure_machine(int32_t threads, [[maybe_unused]] openfab_isa isa) {
    Machine machine;
    machine.threads = threads;
    std::vector<float> a(kFloats), b(kFloats, 1.0f), c(kFloats, 2.0f);
    const auto copy = [&](int32_t workers) {
        return best_rate(workers, [&](int32_t t) {
            const auto part = [&](int32_t k) {
                return kFloats * static_cast<size_t>(k) / static_cast<size_t>(workers);
            };
            triad(b.data(), c.data(), a.data(), part(t), part(t + 1));
            return 3.0 * sizeof(float) * static_cast<double>(part(t + 1) - part(t));
        });
    };
    machine.bandwidth_one = copy(1);
    machine.bandwidth_all = threads > 1 ? copy(threads) : machine.bandwidth_one;
    std::atomic<float> used{0};
    auto* operate = operate_sse41;
#if defined(__x86_64__)
    if (isa == OPENFAB_ISA_AVX2) operate = operate_avx2;
#endif
    const auto compute = [&](int32_t workers) {
        return best_rate(workers, [&](int32_t) { return static_cast<double>(operate(&used)); });
    };
    machine.operations_one = compute(1);
    machine.operations_all = threads > 1 ? compute(threads) : machine.operations_one;
    return machine;
}

}  // namespace openfab::tuner
