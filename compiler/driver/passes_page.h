// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One HTML page with the IR of a fablet's stages after each pass that changed them, for people who read or write passes.

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/source/source_manager.h"

namespace openfab::driver {

class PassesPage {
  public:
    /// Begins with the stages as the front end made them. Both must outlive the page.
    PassesPage(const ir::Fablet& fablet, const source::SourceManager& sources);

    /// Notes a stage after a pass (passes::PipelineOptions::after). A stage is known by its address.
    void add(const std::string& pass, const ir::Stage& stage, const std::string& reason);
    /// Returns the page, which needs no other file.
    std::string html() const;

  private:
    /// A value by what computes it: stages share values, whatever their numbers are there.
    struct Value {
        std::string text;
        std::vector<int32_t> args;
        int32_t source = -1;
        int32_t line = 0;
    };
    struct Step {
        std::string pass, reason;
        std::vector<int32_t> values;                           ///< in order
        std::vector<std::pair<std::string, int32_t>> outputs;  ///< name, value
    };
    /// What became of a stage.
    struct Track {
        ir::StageKind kind = ir::StageKind::kVolume;
        std::string name;
        std::vector<Step> steps;
    };

    int32_t value_of(const ir::Instr& instr, const std::vector<int32_t>& before);
    int32_t source_of(uint32_t file);
    Step step_of(const std::string& pass, const ir::Stage& stage, const std::string& reason);
    Track& track_of(const ir::Stage& stage);

    const ir::Fablet& fablet_;
    const source::SourceManager& sources_;
    std::vector<Value> values_;
    std::map<std::string, int32_t> by_text_;  ///< with arguments
    std::vector<uint32_t> files_;
    std::vector<Track> tracks_;
    std::map<const ir::Stage*, size_t> by_stage_;
};

}  // namespace openfab::driver
