// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What the parts of the live loop promise where several threads use them.

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tools/viewer/change_signal.h"
#include "tools/viewer/set_values.h"

namespace openfab::viewer {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLong(60'000);

TEST(ChangeSignalTest, APageWaitsForAChangeAndTheLoopForAnAsk) {
    ChangeSignal signal;
    const int64_t known = signal.counts().change;
    std::thread page([&] { signal.wait_for_change(known, kLong); });
    std::thread loop([&] { signal.wait_until_asked(kLong); });
    const int64_t change = signal.ask();
    page.join();
    loop.join();
    EXPECT_EQ(change, known + 1);
    EXPECT_TRUE(signal.counts().asked);
    EXPECT_EQ(signal.counts().details, 1);
    signal.begin_what_was_asked();
    EXPECT_FALSE(signal.counts().asked);
    EXPECT_EQ(signal.counts().change, change);
}

TEST(ChangeSignalTest, WhatIsToldOfDetailsIsAChangeToo) {
    ChangeSignal signal;
    signal.tell();
    EXPECT_EQ(signal.counts().details, 0);
    signal.tell_of_details();
    EXPECT_EQ(signal.counts().details, 1);
    EXPECT_EQ(signal.counts().change, 2);
    EXPECT_FALSE(signal.counts().asked);
}

TEST(ChangeSignalTest, StopEndsAllWaits) {
    ChangeSignal signal;
    std::thread page([&] { signal.wait_for_change(0, kLong); });
    std::thread loop([&] { signal.wait_until_asked(kLong); });
    signal.stop();
    page.join();
    loop.join();
    EXPECT_TRUE(signal.stopped());
}

TEST(SetValuesTest, TheLastValueOfAUniformHolds) {
    SetValues values;
    values.set("ball", "r", "1");
    values.set("ball", "depth", "3");
    values.set("ball", "r", "2");
    const std::vector<std::string> right{"ball.depth=3", "ball.r=2"};
    EXPECT_EQ(values.list().settings(), right);
    EXPECT_EQ(values.list().find("ball", "r")->value, "2");
    EXPECT_EQ(values.list().find("cube", "r"), nullptr);
}

TEST(SetValuesTest, AValueThatIsSetWhileOthersAreWrittenStays) {
    SetValues values;
    values.set("ball", "r", "1");
    values.set("ball", "depth", "3");
    const SetValues::List written = values.list();
    values.set("ball", "r", "2");
    EXPECT_NE(values.list().edition, written.edition);
    values.forget(written);
    EXPECT_EQ(values.list().settings(), std::vector<std::string>{"ball.r=2"});
}

TEST(SetValuesTest, TroubleIsOfTheValueThatAPrintRefused) {
    SetValues values;
    values.set("ball", "r", "-1");
    const client::PrintWords others = values.note_troubles(
        {"a warning\n", {{"ball.r=-1", "too small"}, {"ball.r=7", "of an older print"}}});
    EXPECT_EQ(values.list().find("ball", "r")->trouble, "too small");
    ASSERT_EQ(others.settings.size(), 1u);
    EXPECT_EQ(others.settings[0].text, "of an older print");
    EXPECT_EQ(others.text, "a warning\n");
    values.note_troubles({});
    EXPECT_EQ(values.list().find("ball", "r")->trouble, "");
}

TEST(SetValuesTest, AUniformThatIsRenamedKeepsItsValue) {
    SetValues values;
    values.set("ball", "r", "1");
    values.rename("cube", "r", "radius");
    values.rename("ball", "r", "radius");
    EXPECT_EQ(values.list().settings(), std::vector<std::string>{"ball.radius=1"});
}

}  // namespace
}  // namespace openfab::viewer
