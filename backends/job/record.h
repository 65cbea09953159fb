// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The record of a print, beside its slices: what it was made from, and its story, an event for each start, stop and
// resumption. It is `OUT.job.json` beside a file or a folder of slices, by fab_job.schema.json. The slices and their
// digests know nothing of it.

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "backends/job/option_words.h"
#include "base/json.h"
#include "base/result.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::job {

/// A file that a print read, as it was when the print began.
struct Input {
    std::filesystem::path path;
    int64_t bytes = 0;
    std::string sha256;  ///< empty: it could not be read
    int64_t time = 0;    ///< of its last change, in ns; not recorded
};

/// What a record says of a print besides its story.
struct Facts {
    std::string format;
    std::filesystem::path folder;  ///< the working folder
    std::vector<OptionWords> options;
    std::optional<std::vector<OptionWords>>
        compilation;                                 ///< none: by whom it was compiled is not known
    std::string printer, printer_sha256;             ///< its name, and the digest of its profile
    std::vector<std::vector<std::string>> programs;  ///< commands that the world names
    std::vector<Input> inputs;
};

/// Why a print stopped.
struct StopReason {
    std::string by;      ///< signal, limit, line or error
    std::string signal;  ///< its name
    int64_t sender = 0;  ///< the process that sent it; 0: unknown
    std::string error;
};

/// Returns where the record of an output lies; empty for outputs that have none: streams, devices, meshes, arrays.
std::filesystem::path record_file(const std::string& output);

/// Writes the record of a running print. A record that cannot be written is no reason to end the print: `trouble` tells.
/// Thread-safe.
class Record {
  public:
    /// `resumed`: goes on with the story that is there.
    Record(std::filesystem::path file, Facts facts, bool resumed);

    /// Tells that slices are being made, after `kept` that were there; `from`: who sends them, if another machine does.
    void start(const pipeline::PrintInfo& info, int32_t kept, const std::string& from = {});
    /// Counts slices that were written.
    void add(int32_t slices) {
        const std::lock_guard lock(mutex_);
        written_ += slices;
    }
    /// Tells that the print stops. Called again, it replaces what it told before.
    void stop(const StopReason& reason);
    void complete(uint64_t hash);

    /// Whether a stop was told since the last start.
    bool has_stopped() const;
    /// Returns why the record could not be written; empty where it could.
    std::string trouble() const;

  private:
    void write(const std::string& state);
    std::string event(const char* what, const std::string& more) const;

    mutable std::mutex mutex_;
    const std::filesystem::path file_;
    const Facts facts_;
    bool resumed_ = false, started_ = false, stopped_ = false, ended_ = false;
    pipeline::PrintInfo info_;
    int32_t written_ = 0;              ///< kept ones among them
    std::vector<std::string> events_;  ///< as JSON
    int64_t forgotten_ = 0;            ///< events before these
    std::string hash_, trouble_;
};

/// Reads a record; a user error where it is none.
Result<JsonValue> read_record(const std::filesystem::path& file);

/// Returns the state of a print by its record: running, complete, stopped, or interrupted where it says that it runs and no
/// process of this machine does.
std::string state_of(const JsonValue& record, const std::filesystem::path& output);

/// Returns the record of an output, if it has one that is not of another print: `hash`, if the print is complete, is that of
/// its slices.
std::optional<JsonValue> record_of(const std::filesystem::path& output,
                                   std::optional<uint64_t> hash);

/// Returns the story for people, a line for each of the last events.
std::vector<std::string> story_lines(const JsonValue& record, const std::filesystem::path& output);

}  // namespace openfab::job
