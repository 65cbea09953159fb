// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a cell of the table is tried: the worlds of a row and of its twin, and the commands that take them.

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/crossings/rows.h"
#include "tests/crossings/voxels.h"
#include "tests/support/process/process.h"

namespace openfab::testing {

/// What a cell turned out to be.
enum class Verdict : uint8_t { kEqual, kBounded, kRefused, kDocumented, kWrong };

struct Cell {
    Verdict verdict = Verdict::kWrong;
    std::string why;          ///< how it differs, or what was said
    bool ends_alike = false;  ///< as the twin, with results
};

/// What a tool made of a world, to be compared with what it makes of the twin: one of these.
struct Made {
    Outcome outcome{};  ///< of the last command
    Voxels voxels{};
    std::map<std::string, double> numbers{};
    std::string wrong{};  ///< what the column found wrong by itself
};

/// The world of a row, `w.fab.json`, and all that it names.
std::map<std::string, std::string> files_of(const Kind& kind, Form form, const Change& change);

/// A folder with one world, in which commands run.
class Bench {
  public:
    Bench(const Kind& kind, Form form, const Change& change);

    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    std::string world() const { return path("w.fab.json"); }
    /// Runs `openfab COMMAND …`, which takes the options of the row where `prints`.
    Outcome openfab(std::vector<std::string> arguments, bool prints = true) const;
    /// Prints the world in this process, with the column's options.
    Made print_here() const;
    /// Prints the world to a file, with the column's options.
    Outcome print(const std::string& output, const std::vector<std::string>& more = {}) const;
    const Change& change() const { return change_; }
    /// Of every command that prints the row.
    const std::vector<std::string>& options() const { return kind_.options; }
    /// The folder of compiled kernels, which all cells share.
    static std::string cache();
    void write(const std::string& name, const std::string& text) const {
        scratch_.write(name, text);
    }

  private:
    ScratchFolder scratch_;
    const Kind& kind_;
    const Change& change_;
};

/// The bound of voxels: the share of those at borders that may differ, and no others.
constexpr double kShare = 0.03;
/// The bound of numbers, relative.
constexpr double kNumbers = 0.03;

/// `expected`: of the twin.
Cell compare(const Made& made, const Made& expected);

}  // namespace openfab::testing
