// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The schedules that a command line names: files, folders of them, and values of parameters.

#include <map>
#include <string>
#include <vector>

#include "compiler/driver/options.h"
#include "compiler/lower/code/program.h"
#include "compiler/source/source_manager.h"

namespace openfab::driver {

class Schedules {
  public:
    Schedules(source::SourceManager* sources, const CommonOptions& common)
        : sources_(sources), common_(common) {}

    /// Reads the files and binds them for each instruction set. Returns an exit code; errors have
    /// been printed.
    int load(const ScheduleOptions& options, const std::vector<openfab_isa>& isas);

    /// Those in place of the built-in ones.
    const lower::ScheduleSet& bound() const { return bound_; }
    /// Returns the file of a pipeline for an instruction set: one that was loaded, else the built-in
    /// one, which every pipeline has; and the values of parameters in place of its own.
    const schedule::File& file(const std::string& pipeline, openfab_isa isa) const;
    const std::map<std::string, int64_t>& params() const { return params_; }

  private:
    /// A file for one pipeline.
    struct Loaded {
        std::string path;  ///< as named
        std::string pipeline;
        std::string target;  ///< empty: all
        schedule::File file;
    };

    int load_path(const std::string& path);
    int load_file(const std::string& path);
    int parse(const schedule::Source& source, schedule::File* out);
    int parse_params(const std::vector<std::string>& words);
    int bind(const std::string& pipeline, openfab_isa isa);
    const Loaded* choose(const std::string& pipeline, const std::string& target) const;
    int report(const schedule::Fault& fault) const;

    source::SourceManager* sources_;
    const CommonOptions& common_;
    std::vector<Loaded> files_;
    std::map<std::string, int64_t> params_;
    std::map<std::string, bool> param_is_known_;
    lower::ScheduleSet bound_;
};

}  // namespace openfab::driver
