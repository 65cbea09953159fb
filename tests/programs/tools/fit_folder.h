// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Runs `openfab fit` on a world in a folder.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/json.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"

namespace openfab::testing {

/// A folder with a world `w.fab.json`, and what `openfab fit` says of it.
class FitFolder : public ::testing::Test {
  protected:
    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    Outcome openfab(std::vector<std::string> words, RunOptions options = {}) const {
        words.insert(words.begin(), program("openfab"));
        options.environment.emplace_back("XDG_CACHE_HOME", path("cache"));
        return run(words, options);
    }
    void write_goals(const std::string& unknowns, const std::string& goals) const {
        folder_.write("goals.json",
                      fmt::format("{{\"openfab_fit\": 1,\n\"unknowns\": {{{}}},\n\"goals\": [{}]}}",
                                  unknowns, goals));
    }
    /// Fits, and returns what it says for programs.
    JsonValue fit(const std::string& unknowns, const std::string& goals,
                  const std::vector<std::string>& more = {}, int32_t code = 0) {
        write_goals(unknowns, goals);
        std::vector<std::string> words{"fit", path("w.fab.json"), path("goals.json"), "--json",
                                       path("fit.json")};
        words.insert(words.end(), more.begin(), more.end());
        last_ = openfab(words);
        EXPECT_EQ(last_.exit_code, code) << last_.err << last_.out;
        const Result<JsonValue> value = parse_json(read_file(folder_ / "fit.json"), "fit.json");
        EXPECT_TRUE(value);
        return value ? *value : JsonValue();
    }
    static double unknown(const JsonValue& fit, const std::string& name) {
        return fit.find("unknowns")->value.find(name)->value.number;
    }
    static double goal(const JsonValue& fit, const std::string& key, size_t index = 0) {
        return fit.find("goals")->value.items.at(index).find(key)->value.number;
    }

    ScratchFolder folder_;
    Outcome last_;
};

}  // namespace openfab::testing
