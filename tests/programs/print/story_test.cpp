// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The record that a print keeps beside its slices: its story over signals, errors and restarts.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <set>

#include "backends/common/output_lock.h"
#include "backends/job/messages.h"
#include "backends/job/record.h"
#include "backends/ofr/ofr_reader.h"
#include "base/json_text.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;
namespace says = job::messages;

class Story : public ::testing::Test {
  protected:
    Story() {
        scratch_.write("f.fl", "fablet Skin {}\n");
        scratch_.write("world.fab.json", R"({
  "openfab": 1,
  "printer": "generic",
  "fablets": {"f": {"source": "f.fl", "fablet": "Skin"}},
  "materials": {
    "white": {"key": "#ffffff", "preview": "#f0f0f0ff", "density_g_cm3": 1.18},
    "black": {"key": "#000000", "preview": "#101010ff", "density_g_cm3": 1.18}
  },
  "meshes": {"ball": {"sphere": 26}},
  "objects": {"thing": {"mesh": "ball", "fablet": "f", "uniforms": {"a": "white", "b": "black"}}},
  "build": [{"object": "thing"}]
}
)");
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    std::vector<std::string> words(const std::string& out,
                                   const std::vector<std::string>& more) const {
        std::vector<std::string> argv{test_program("openfab_test_print_1"),
                                      path("world.fab.json"),
                                      "-o",
                                      path(out),
                                      "--voxel",
                                      "0.1mm",
                                      "--threads",
                                      "1"};
        argv.insert(argv.end(), more.begin(), more.end());
        return argv;
    }
    /// Sends a signal once a slice is written.
    Outcome stopped(const std::string& out, int signal, const std::vector<std::string>& more = {}) {
        std::vector<std::string> argv = words(out, more);
        argv.insert(argv.end(), {"--progress", "json"});
        RunOptions options;
        options.signal = signal;
        options.interrupt_when = [](int, const Outcome& so_far) {
            return so_far.err.find("\"slice") != std::string::npos;
        };
        return run(argv, options);
    }
    JsonValue record(const std::string& file) const {
        Result<JsonValue> read = job::read_record(path(file));
        EXPECT_TRUE(read) << read.error().text();
        return read ? *read : JsonValue();
    }
    static std::string text(const JsonValue& object, const char* name) {
        const JsonValue* value = member_of(object, name);
        return value == nullptr ? "" : value->text;
    }
    std::vector<std::string> events(const JsonValue& record) const {
        std::vector<std::string> names;
        for (const JsonValue& event : member_of(record, "events")->items)
            names.push_back(text(event, "event"));
        return names;
    }
    std::string info(const std::string& out) const {
        return run({program("openfab"), "info", path(out)}).out;
    }

    ScratchFolder scratch_;
};

/// Whether all members of a value, and of those in it, are in the schema: required ones are there, others are known.
void check_schema(const JsonValue& value, const JsonValue& rule, const JsonValue& root) {
    if (const JsonValue* other = member_of(rule, "$ref")) {
        const JsonValue* defs = member_of(root, "$defs");
        return check_schema(value, *member_of(*defs, other->text.substr(8)), root);
    }
    if (const JsonValue* items = member_of(rule, "items")) {
        for (const JsonValue& item : value.items)
            check_schema(item, *items, root);
    }
    if (const JsonValue* choices = member_of(rule, "enum")) {
        std::set<std::string> known;
        for (const JsonValue& choice : choices->items)
            known.insert(choice.text);
        EXPECT_EQ(known.count(value.text), 1U) << value.text;
    }
    const JsonValue* properties = member_of(rule, "properties");
    if (properties == nullptr) return;
    for (const JsonValue& name : member_of(rule, "required")->items)
        EXPECT_NE(value.find(name.text), nullptr) << name.text;
    for (const JsonMember& member : value.members) {
        const JsonValue* known = member_of(*properties, member.key);
        ASSERT_NE(known, nullptr) << member.key;
        check_schema(member.value, *known, root);
    }
}

TEST_F(Story, TellsWhoStoppedAPrintAndWhenItWentOn) {
    for (const bool folder : {false, true}) {
        const std::string out = folder ? "slices" : "ball.ofr";
        const std::string file = folder ? "slices.job.json" : "ball.ofr.job.json";
        const std::vector<std::string> format{"--format", folder ? "png" : "ofr"};
        ASSERT_EQ(stopped(out, SIGTERM, format).exit_code, 130);
        const JsonValue first = record(file);
        EXPECT_EQ(text(first, "state"), "stopped");
        ASSERT_EQ(events(first), (std::vector<std::string>{"start", "stop"}));
        const JsonValue stop = member_of(first, "events")->items[1];
        EXPECT_EQ(text(stop, "by"), "signal");
        EXPECT_EQ(text(stop, "signal"), "SIGTERM");
        EXPECT_EQ(member_of(stop, "sender")->number, ::getpid());
        const double slice = member_of(stop, "slice")->number;
        EXPECT_GT(slice, 0);
        EXPECT_THAT(info(out), HasSubstr(fmt::format(says::kBeforeSlice, slice)));

        std::vector<std::string> rest = format;
        rest.emplace_back("--resume");
        ASSERT_EQ(run(words(out, rest)).exit_code, 0);
        const JsonValue second = record(file);
        EXPECT_EQ(text(second, "state"), "complete");
        ASSERT_EQ(events(second),
                  (std::vector<std::string>{"start", "stop", "resume", "complete"}));
        EXPECT_EQ(member_of(member_of(second, "events")->items[2], "slices")->number, slice);
        EXPECT_THAT(info(out), HasSubstr(text(second, "hash")));
        const Result<std::string> schema_text =
            read_text_file(source_dir() / "backends/job/fab_job.schema.json", size_t{1} << 20);
        ASSERT_TRUE(schema_text);
        const Result<JsonValue> schema = parse_json(*schema_text, "schema");
        ASSERT_TRUE(schema) << schema.error().text();
        check_schema(second, *schema, *schema);
        // A new print begins a new story.
        ASSERT_EQ(run(words(out, format)).exit_code, 0);
        EXPECT_EQ(events(record(file)), (std::vector<std::string>{"start", "complete"}));
    }
}

/// The kernel's stop leaves no time for a word: who reads the record sees that nobody is at work.
TEST_F(Story, OfAPrintThatWasKilledSaysThatNobodyIsAtWork) {
    EXPECT_EQ(stopped("ball.ofr", SIGKILL).exit_code, 128 + SIGKILL);
    EXPECT_EQ(text(record("ball.ofr.job.json"), "state"), "running");
    EXPECT_EQ(job::state_of(record("ball.ofr.job.json"), path("ball.ofr")), "interrupted");
    EXPECT_THAT(info("ball.ofr"), HasSubstr(says::kNobodyWrites));
}

TEST_F(Story, OfARunningPrintSaysThatItRuns) {
    std::string seen;
    std::vector<std::string> argv = words("ball.ofr", {"--progress", "json"});
    RunOptions options;
    options.interrupt_when = [&](int, const Outcome& so_far) {
        if (so_far.err.find("\"slice") == std::string::npos) return false;
        seen = info("ball.ofr");
        return true;
    };
    EXPECT_EQ(run(argv, options).exit_code, 130);
    EXPECT_THAT(seen, HasSubstr(says::kRuns));
}

TEST_F(Story, TellsAFullDisk) {
    RunOptions options;
    options.largest_file_bytes = 200'000;
    ASSERT_EQ(run(words("ball.ofr", {}), options).exit_code, 3);
    const JsonValue stop = member_of(record("ball.ofr.job.json"), "events")->items.back();
    EXPECT_EQ(text(stop, "by"), "error");
    EXPECT_THAT(text(stop, "error"), HasSubstr("ball.ofr"));
    EXPECT_NE(member_of(stop, "slice"), nullptr);
}

/// The bytes of a print do not depend on what is recorded of it.
TEST_F(Story, LeavesThePrintAsItIs) {
    ASSERT_EQ(run(words("a.ofr", {})).exit_code, 0);
    ASSERT_EQ(stopped("b.ofr", SIGINT).exit_code, 130);
    ASSERT_EQ(run(words("b.ofr", {"--resume"})).exit_code, 0);
    EXPECT_EQ(read_file(path("a.ofr")), read_file(path("b.ofr")));
}

/// What stands beside a file may be of one that was there before.
TEST_F(Story, OfAnotherPrintIsNotTold) {
    ASSERT_EQ(run(words("a.ofr", {})).exit_code, 0);
    ASSERT_EQ(run(words("b.ofr", {"--seed", "9"})).exit_code, 0);
    fs::rename(path("b.ofr"), path("a.ofr"));
    EXPECT_THAT(info("a.ofr"), ::testing::Not(HasSubstr("story")));
}

/// A file that only has the record's name is somebody's.
TEST_F(Story, ReplacesNothingElse) {
    scratch_.write("a.ofr.job.json", "{\"mine\": 1}\n");
    const Outcome made = run(words("a.ofr", {}));
    EXPECT_EQ(made.exit_code, 0);
    EXPECT_EQ(read_file(path("a.ofr.job.json")), "{\"mine\": 1}\n");
    EXPECT_THAT(made.err, HasSubstr(fmt::format(says::kNoRecord, path("a.ofr.job.json"))));
    // Nor is what is no file: a pipe would be waited for, and a link leads elsewhere.
    scratch_.write("elsewhere", "");
    fs::remove(path("a.ofr.job.json"));
    ASSERT_EQ(::mkfifo(path("a.ofr.job.json").c_str(), 0600), 0);
    for (const bool link : {false, true}) {
        if (link) {
            fs::remove(path("a.ofr.job.json"));
            fs::create_symlink(path("elsewhere"), path("a.ofr.job.json"));
        }
        const Outcome beside = run(words("a.ofr", {}));
        EXPECT_EQ(beside.exit_code, 0) << beside.err;
        EXPECT_THAT(beside.err, HasSubstr(fmt::format(says::kNoRecord, path("a.ofr.job.json"))));
    }
    EXPECT_EQ(read_file(path("elsewhere")), "");
    fs::remove(path("a.ofr.job.json"));
    // What a power failure leaves of a record is replaced.
    scratch_.write("a.ofr.job.json", std::string(100, '\0'));
    EXPECT_EQ(run(words("a.ofr", {})).exit_code, 0);
    EXPECT_EQ(text(record("a.ofr.job.json"), "state"), "complete");
}

/// A refused resumption is no event of the print that it was refused for.
TEST_F(Story, IsNotTouchedByARefusal) {
    ASSERT_EQ(stopped("ball.ofr", SIGINT).exit_code, 130);
    const std::string before = read_file(path("ball.ofr.job.json"));
    EXPECT_EQ(run(words("ball.ofr", {"--resume", "--seed", "9"})).exit_code, 1);
    EXPECT_EQ(read_file(path("ball.ofr.job.json")), before);
}

TEST_F(Story, TellsWhatChangedBeforeItWentOn) {
    ASSERT_EQ(stopped("ball.ofr", SIGINT).exit_code, 130);
    scratch_.write("f.fl", "fablet Skin {} // as before\n");
    ASSERT_EQ(run(words("ball.ofr", {"--resume"})).exit_code, 0);
    EXPECT_THAT(info("ball.ofr"), HasSubstr(fmt::format(says::kChangedSince, "`f.fl`")));
}

}  // namespace
}  // namespace openfab::testing
