// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A file system that loses power: what a program does to the files of one folder is recorded, and any moment of it can
// be made again as a disk may have it then. What came before the last sync is there. Of what came after, each change of
// a name may be lost or late, and each file may have all, none or a part of what was written to it, with zeros where
// bytes are missing: what POSIX allows, and file systems without ordered metadata do.

#include <cstdint>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace openfab::testing {

/// By name.
using Files = std::map<std::string, std::string>;

class LossyDisk {
  public:
    /// Begins to record what this process does to files of the folder. One at a time.
    explicit LossyDisk(const std::filesystem::path& folder);
    /// Ends to record.
    ~LossyDisk();
    LossyDisk(const LossyDisk&) = delete;
    LossyDisk& operator=(const LossyDisk&) = delete;

    void stop();
    /// Returns the number of recorded steps: moments are 0 to this.
    size_t steps() const { return steps_.size(); }
    /// Returns the files after a power loss at this moment.
    Files after_loss(size_t moment, std::mt19937* random) const;

    static constexpr int kNames = -2;
    struct Step {
        enum class Kind { kCreate, kWrite, kTruncate, kRename, kRemove, kSync } kind;
        int file = -1;  ///< of kCreate, kWrite, kTruncate; of kSync: -1 is all, kNames all names
        std::string name, other;  ///< of names
        int64_t at = 0;           ///< of kWrite; the size of kTruncate
        std::string bytes;
    };
    /// For what records; a name's file.
    void add(Step step);
    int file_of(const std::string& name, bool creates);
    void rename(const std::string& from, const std::string& to);
    /// For what is written through a mapping: the file's bytes as they are now.
    void mapped(int file, const std::string& bytes);
    void remove(const std::string& name);

  private:
    struct Disk {
        std::map<std::string, int> names;
        std::map<int, std::string> files;
        void apply_name(const Step& step);
        void apply_bytes(const Step& step);
    };

    Disk before_;
    std::map<std::string, int> names_;  ///< now
    int next_ = 0;
    std::vector<Step> steps_;
};

/// Power failures that a test makes.
int count_of_cuts();

/// Replaces what a folder holds.
void put_files(const std::filesystem::path& folder, const Files& files);
Files files_in(const std::filesystem::path& folder);

}  // namespace openfab::testing
