// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What tests of prints over a line share: programs beside the test, and worlds to print.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "backends/stream/message.h"
#include "base/clock.h"
#include "tests/support/memory/meter.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {

/// A program that runs beside the test.
class Running {
  public:
    explicit Running(std::vector<std::string> argv, RunOptions options = {}, int signal = SIGKILL) {
        options.signal = signal;
        options.interrupt_when = [this](int, const Outcome& so_far) {
            const std::lock_guard lock(mutex_);
            err_ = so_far.err;
            return kill_.load();
        };
        thread_ = std::thread([this, argv = std::move(argv), options] {
            outcome_ = run(argv, options);
            ended_ = true;
        });
    }
    ~Running() { kill(); }
    std::string err() {
        const std::lock_guard lock(mutex_);
        return err_;
    }
    bool ended() const { return ended_; }
    /// Waits until it has said a message; returns whether it has.
    bool says(const std::string& message, double seconds = kHangSeconds) {
        for (const double start = seconds_now(); seconds_now() - start < seconds;) {
            if (testing::says(err(), message)) return true;
            if (ended_) return testing::says(outcome_.err, message);
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        return false;
    }
    /// Kills it, or sends it another signal that was asked for, unless it has ended; and waits for its end.
    void kill() {
        kill_ = true;
        if (thread_.joinable()) thread_.join();
    }
    /// Waits for its own end.
    const Outcome& end() {
        if (thread_.joinable()) thread_.join();
        return outcome_;
    }

  private:
    std::mutex mutex_;
    std::string err_;
    std::atomic<bool> kill_{false}, ended_{false};
    Outcome outcome_;
    std::thread thread_;
};

class Stream : public ::testing::Test {
  protected:
    Stream() {
        scratch_.write("f.fl", "fablet Skin {}\nfablet Tint {}\n");
        write_world("ball.fab.json", R"({"sphere": 12})");
        write_world("other.fab.json", R"({"sphere": 11})");
        scratch_.write("token", "open sesame\n");
        scratch_.write("wrong", "open barley\n");
    }
    void write_world(const std::string& name, const std::string& mesh,
                     const std::string& fablet = "Skin") {
        scratch_.write(name, fmt::format(R"({{
  "openfab": 1, "printer": "generic",
  "fablets": {{"f": {{"source": "f.fl", "fablet": "{}"}}}},
  "materials": {{"white": {{"key": "#ffffff"}}, "black": {{"key": "#000000"}}}},
  "meshes": {{"mesh": {}}},
  "objects": {{"thing": {{"mesh": "mesh", "fablet": "f", "uniforms": {{"a": "white", "b": "black"}}}}}},
  "build": [{{"object": "thing"}}]
}}
)",
                                         fablet, mesh));
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    std::vector<std::string> printing(const std::string& output,
                                      const std::vector<std::string>& more = {},
                                      const std::string& world = "ball.fab.json") const {
        std::vector<std::string> argv{test_program("openfab_test_print_4"),
                                      path(world),
                                      "--voxel",
                                      "0.1mm",
                                      "--dither",
                                      "decorrelated",
                                      "-o",
                                      output};
        argv.insert(argv.end(), more.begin(), more.end());
        return argv;
    }
    std::vector<std::string> receiving(const std::string& address, const std::string& output,
                                       const std::vector<std::string>& more = {}) const {
        std::vector<std::string> argv{program("openfab"), "receive", "--listen", address, "-o",
                                      path(output)};
        argv.insert(argv.end(), more.begin(), more.end());
        return argv;
    }
    /// The file of an undisturbed print.
    const std::string& undisturbed() {
        if (undisturbed_.empty()) {
            EXPECT_EQ(run(printing(path("undisturbed.ofr"))).exit_code, 0);
            undisturbed_ = read_file(path("undisturbed.ofr"));
            EXPECT_GT(undisturbed_.size(), 50'000u);
        }
        return undisturbed_;
    }
    /// Where a receiver listens, by what it says.
    static std::string address_of(Running* receiver) {
        const std::string_view row = tools::messages::kListeningAt;
        EXPECT_TRUE(receiver->says(std::string(row)));
        const std::string err = receiver->err();
        const std::string_view before = row.substr(0, row.find('{'));
        const size_t at = err.find(before);
        if (at == std::string::npos) return "";
        const size_t from = at + before.size();
        return err.substr(from, err.find('\n', from) - from);
    }
    stream::Line connect(const std::string& address) {
        Result<stream::Socket> socket = stream::connect_to(*stream::parse_address(address), 5);
        EXPECT_TRUE(socket);
        return stream::Line(socket ? std::move(*socket) : stream::Socket());
    }
    /// Waits until the receiver has kept some slices.
    void wait_for_slices(const std::string& output) const {
        std::error_code none;
        for (const double start = seconds_now(); seconds_now() - start < kHangSeconds;) {
            if (std::filesystem::exists(path(output + "/slice_0003.png"), none)) return;
            if (std::filesystem::is_regular_file(path(output), none) &&
                std::filesystem::file_size(path(output)) > 4000)
                return;
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        ADD_FAILURE() << output << " gets no slices";
    }
    std::string unix_address() const { return "unix:" + path("line"); }

    ScratchFolder scratch_;
    std::string undisturbed_;
    std::mt19937 random_{20};
};

inline constexpr const char* kAnyPort = "tcp://127.0.0.1:0";
inline constexpr const char* kAnyTlsPort = "tls://127.0.0.1:0";
/// A printer that is slow enough for a test to happen: 120 slices take more than 2 s.
inline const std::vector<std::string> kSlow{"--layer-time", "20ms", "--buffer", "4"};

}  // namespace openfab::testing
