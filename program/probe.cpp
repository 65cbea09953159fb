// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/probe.h"

#include <mutex>
#include <span>
#include <vector>

#include "backends/common/tee_sink.h"
#include "base/json_text.h"
#include "base/say.h"
#include "base/text.h"
#include "program/job.h"
#include "program/prepare.h"

namespace openfab::program {

namespace {

/// Keeps the fractions of a grid of one voxel.
class OneVoxel : public pipeline::FractionSink {
  public:
    Result<void> begin(const pipeline::PrintInfo&, int32_t materials) override {
        fractions_.assign(static_cast<size_t>(materials), 0.0f);
        return {};
    }
    void write(int32_t, int32_t, int32_t, std::span<const float> fractions) override {
        const std::lock_guard lock(mutex_);
        fractions_.assign(fractions.begin(), fractions.end());
    }
    Result<void> status() const override { return {}; }
    Result<void> finish(const pipeline::PrintTotals&) override { return {}; }

    const std::vector<float>& fractions() const { return fractions_; }

  private:
    std::mutex mutex_;
    std::vector<float> fractions_;
};

void write_vector(const char* name, const Vec3d& v, JsonText* out) {
    out->key(name).begin_array().value(v.x).value(v.y).value(v.z).end_array();
}

}  // namespace

Result<void> run_probe(const Options& options, const openfab_fablet_list& fablets,
                       const std::atomic<bool>& interrupt) {
    OneVoxel voxel;
    PrintHooks hooks{.interrupt = interrupt};
    hooks.fractions = &voxel;
    hooks.print_line = [](const std::string& line) { say(printable(line) + "\n"); };
    hooks.loaded = [](const Job& job) {
        for (const std::string& warning : job.input.warnings)
            warn(warning);
    };
    hooks.window_mm = Box3d{*options.probe_mm, *options.probe_mm};
    Result<PreparedPrint> ready = prepare_print(options, fablets, hooks);
    if (!ready) return ready.error();
    const pipeline::PrintInfo info = ready->print->info();
    backends::NullSink nowhere;
    pipeline::PrintStatistics statistics;
    if (Result<void> done = ready->print->run(nowhere, {}, interrupt, &statistics); !done)
        return done;
    JsonText out;
    out.begin_object();
    write_vector("mm", info.origin_mm + info.pitch_mm * 0.5, &out);
    write_vector("pitch_mm", info.pitch_mm, &out);
    out.key("fractions").begin_object();
    for (size_t m = 0; m < voxel.fractions().size(); ++m)
        out.member(info.materials[m].name, double{voxel.fractions()[m]});
    out.end_object().key("provenance").begin_object();
    for (const auto& [name, value] : info.provenance)
        out.member(name, value);
    out.end_object().end_object();
    show(out.take() + "\n");
    return {};
}

}  // namespace openfab::program
