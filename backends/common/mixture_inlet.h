// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The fractions of a print on their way to its output. Set-up asks who takes them before the output is open.

#include "runtime/pipeline/fraction_sink.h"

namespace openfab::backends {

class MixtureInlet : public pipeline::FractionSink {
  public:
    /// `also` takes them, too; may be null.
    explicit MixtureInlet(pipeline::FractionSink* also) : also_(also) {}

    /// Called by the output, which outlives the print.
    void set_output(pipeline::FractionSink* output) { output_ = output; }

    Result<void> begin(const pipeline::PrintInfo& info, int32_t materials) override {
        return each([&](FractionSink* to) { return to->begin(info, materials); });
    }
    void write(int32_t z, int32_t y, int32_t first_x, std::span<const float> fractions) override {
        if (output_ != nullptr) output_->write(z, y, first_x, fractions);
        if (also_ != nullptr) also_->write(z, y, first_x, fractions);
    }
    Result<void> status() const override {
        return each([](const FractionSink* to) { return to->status(); });
    }
    Result<void> finish(const pipeline::PrintTotals& totals) override {
        return each([&](FractionSink* to) { return to->finish(totals); });
    }

  private:
    template <typename Call>
    Result<void> each(Call call) const {
        Result<void> done;
        if (output_ != nullptr) done = call(output_);
        if (also_ == nullptr) return done;
        const Result<void> also = call(also_);
        return done ? also : done;
    }

    pipeline::FractionSink* output_ = nullptr;
    pipeline::FractionSink* const also_;
};

}  // namespace openfab::backends
