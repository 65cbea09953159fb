// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Prints over a line: what is cut, killed, slow, full or hostile; the bytes must be those of an
// undisturbed print.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <thread>

#include "backends/stream/messages.h"
#include "program/messages.h"
#include "runtime/pipeline/messages.h"
#include "tests/programs/stream/proxy.h"
#include "tests/programs/stream/stream_fixture.h"
#include "tests/support/places/places.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
namespace fs = std::filesystem;

std::map<std::string, std::string> files_of(const fs::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(folder))
        files[entry.path().filename().string()] = read_file(entry.path());
    return files;
}

TEST_F(Stream, TheReceiverKeepsWhatAFileWouldHold) {
    for (const std::string& where : {std::string(kAnyPort), unix_address()}) {
        Running receiver(receiving(where, "a.ofr"));
        const Outcome sent = run(printing(address_of(&receiver)));
        EXPECT_EQ(sent.exit_code, 0) << sent.err;
        EXPECT_EQ(receiver.end().exit_code, 0) << receiver.end().err;
        EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
        EXPECT_THAT(receiver.end().err,
                    testing::Says(tools::messages::kLinesCut, "*", "0", "0", "0"));
        fs::remove(path("a.ofr"));
    }
    Running receiver(receiving(kAnyPort, "slices"));
    EXPECT_EQ(run(printing(address_of(&receiver))).exit_code, 0);
    EXPECT_EQ(receiver.end().exit_code, 0) << receiver.end().err;
    ASSERT_EQ(run(printing(path("direct"), {"--format", "png"})).exit_code, 0);
    std::map<std::string, std::string> sent = files_of(path("slices"));
    for (const auto& [name, bytes] : files_of(path("direct"))) {
        if (name.ends_with(".png")) {
            EXPECT_TRUE(sent[name] == bytes) << name;
        } else {
            EXPECT_EQ(sent[name], bytes) << name;
        }
        sent.erase(name);
    }
    EXPECT_THAT(sent, IsEmpty());
}

TEST_F(Stream, ALineThatIsCutAtRandomMomentsIsTakenUpAgain) {
    constexpr int kCuts = 20;
    const auto bytes = static_cast<int64_t>(undisturbed().size());
    std::vector<int64_t> cuts;
    for (int i = 0; i < kCuts; ++i)
        cuts.push_back(std::uniform_int_distribution<int64_t>(1, bytes)(random_));
    std::sort(cuts.begin(), cuts.end());
    Running receiver(receiving(kAnyPort, "a.ofr"));
    const Proxy proxy(*stream::parse_address(address_of(&receiver)), cuts);
    const Outcome sent = run(printing(proxy.address()));
    EXPECT_EQ(sent.exit_code, 0) << sent.err;
    EXPECT_EQ(proxy.cuts_made(), kCuts);
    EXPECT_EQ(receiver.end().exit_code, 0) << receiver.end().err;
    EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
    EXPECT_THAT(receiver.end().err, testing::Says(tools::messages::kLinesCut, "*", "*", "0", "0"));
}

TEST_F(Stream, ADamagedSliceIsSentAgain) {
    const auto bytes = static_cast<int64_t>(undisturbed().size());
    Running receiver(receiving(kAnyPort, "a.ofr"));
    const Proxy proxy(*stream::parse_address(address_of(&receiver)), {}, bytes / 2);
    const Outcome sent = run(printing(proxy.address()));
    EXPECT_EQ(sent.exit_code, 0) << sent.err << receiver.err();
    EXPECT_EQ(receiver.end().exit_code, 0);
    EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
    EXPECT_THAT(receiver.end().err, testing::Says(tools::messages::kLinesCut, "*", "*", "*", "1"));
}

TEST_F(Stream, AReceiverThatIsKilledIsFoundAgain) {
    auto receiver = std::make_unique<Running>(receiving(unix_address(), "a.ofr", kSlow));
    ASSERT_TRUE(receiver->says(tools::messages::kListeningAt));
    Running sender(printing(unix_address()));
    for (int kills = 0; kills < 3; ++kills) {
        ASSERT_TRUE(receiver->says(tools::messages::kPrintFromSlice))
            << receiver->err() << sender.err();
        std::this_thread::sleep_for(std::chrono::milliseconds(100 + random_() % 300));
        receiver->kill();
        receiver = std::make_unique<Running>(receiving(unix_address(), "a.ofr", kSlow));
    }
    EXPECT_EQ(sender.end().exit_code, 0) << sender.end().err;
    EXPECT_EQ(receiver->end().exit_code, 0) << receiver->end().err;
    EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
}

TEST_F(Stream, ASenderThatIsKilledIsResumed) {
    for (const bool restarted : {false, true}) {
        for (const char* output : {"a.ofr", "slices"}) {
            SCOPED_TRACE(output);
            auto receiver = std::make_unique<Running>(receiving(unix_address(), output, kSlow));
            ASSERT_TRUE(receiver->says(tools::messages::kListeningAt));
            for (int kills = 0; kills < 2; ++kills) {
                Running sender(printing(unix_address(), {kills == 0 ? "--progress" : "--resume",
                                                         kills == 0 ? "none" : "--progress=none"}));
                wait_for_slices(output);
                std::this_thread::sleep_for(std::chrono::milliseconds(random_() % 300));
                sender.kill();
                // Who looks at the receiver is told how the print goes on.
                ASSERT_TRUE(receiver->says(tools::messages::kLineCut)) << receiver->err();
                EXPECT_THAT(receiver->err(), HasSubstr("its command with `--resume`"));
                if (!restarted) continue;
                receiver->kill();
                receiver = std::make_unique<Running>(receiving(unix_address(), output, kSlow));
                ASSERT_TRUE(receiver->says(tools::messages::kListeningAt));
            }
            const Outcome sent = run(printing(unix_address(), {"--resume"}));
            EXPECT_EQ(sent.exit_code, 0) << sent.err;
            EXPECT_THAT(sent.err, Says(program::messages::kSummaryResumed));
            EXPECT_EQ(receiver->end().exit_code, 0) << receiver->end().err;
            if (fs::path(output).extension() == ".ofr") {
                EXPECT_TRUE(read_file(path(output)) == undisturbed());
            } else {
                ASSERT_EQ(run(printing(path("direct"), {"--format", "png"})).exit_code, 0);
                EXPECT_TRUE(files_of(path(output)) == files_of(path("direct")));
            }
            fs::remove_all(path(output));
        }
    }
}

TEST_F(Stream, ASlowPrinterHoldsThePrintBackInFlatMemory) {
    // Without a bound most of the 20 MB would wait.
    write_world("block.fab.json", R"({"box": [100, 100, 12]})", "Tint");
    const auto to = [&](const std::string& output) {
        return printing(output, {"--threads", "2"}, "block.fab.json");
    };
    const Outcome file = run(to(path("file.ofr")));
    ASSERT_EQ(file.exit_code, 0) << file.err;
    Running receiver(receiving(unix_address(), "a.ofr", kSlow));
    ASSERT_TRUE(receiver.says(tools::messages::kListeningAt));
    const Outcome sent = run(to(unix_address()));
    EXPECT_EQ(sent.exit_code, 0) << sent.err;
    EXPECT_EQ(receiver.end().exit_code, 0) << receiver.end().err;
    EXPECT_THAT(receiver.end().err, testing::Says(tools::messages::kPrinterWaited));
    EXPECT_TRUE(read_file(path("a.ofr")) == read_file(path("file.ofr")));
    EXPECT_GT(fs::file_size(path("a.ofr")), 15'000'000u);
#ifndef OPENFAB_SANITIZED
    EXPECT_LT(sent.peak_rss_bytes, file.peak_rss_bytes + 8'000'000);
    EXPECT_LT(receiver.end().peak_rss_bytes, 60'000'000);
#endif
}

TEST_F(Stream, APrintThatWaitsForASlowPrinterCanBeInterrupted) {
    Running receiver(receiving(unix_address(), "a.ofr", {"--layer-time", "10s", "--buffer", "2"}));
    ASSERT_TRUE(receiver.says(tools::messages::kListeningAt));
    RunOptions options;
    options.interrupt_when = [](int elapsed_ms, const Outcome& so_far) {
        return elapsed_ms > 500 && so_far.err.find("slice 1 of") != std::string::npos;
    };
    const Outcome sent = run(printing(unix_address()), options);
    EXPECT_EQ(sent.exit_code, 130) << sent.err;
    // The second is that of a goodbye that takes more than a second.
    EXPECT_THAT(sent.err, ::testing::AnyOf(testing::Says(stream::messages::kInterruptedNoRoom),
                                           testing::Says(pipeline::messages::kInterruptedAfter)));
    EXPECT_THAT(sent.err, HasSubstr("`--resume`"));
}

TEST_F(Stream, AReceiverChecksItsOutputBeforeItListens) {
    fs::create_directories(path("photos"));
    scratch_.write("photos/a.txt", "mine");
    fs::create_directories(path("folder.ofr"));
    struct Refused {
        const char* output;
        int exit_code;
        const char* message;
    };
    for (const auto& [output, exit_code, message] :
         {Refused{"none/x.ofr", 3, "No such file or directory"},
          Refused{"rx.gcvf", 2, tools::messages::kReceiveFormats},
          Refused{"rx.bmp", 2, "--format bmp"}, Refused{"photos", 1, "a.txt"},
          Refused{"folder.ofr", 1, "is a folder"}}) {
        const Outcome refused = run(receiving(unix_address(), output));
        EXPECT_EQ(refused.exit_code, exit_code) << refused.err;
        EXPECT_THAT(refused.err, testing::Says(message));
        EXPECT_THAT(refused.err, Not(HasSubstr("listening")));
    }
    EXPECT_EQ(read_file(path("photos/a.txt")), "mine");
}

TEST_F(Stream, AFullDiskOfTheReceiverEndsBothAndIsGoneOnWith) {
    RunOptions full;
    full.largest_file_bytes = static_cast<int64_t>(undisturbed().size() / 2);
    Running receiver(receiving(unix_address(), "a.ofr"), full);
    ASSERT_TRUE(receiver.says(tools::messages::kListeningAt));
    const Outcome sent = run(printing(unix_address()));
    EXPECT_EQ(sent.exit_code, 3) << sent.err;
    EXPECT_THAT(sent.err, testing::Says(tools::messages::kCannotWriteOutput));
    EXPECT_THAT(sent.err, HasSubstr("`--resume`"));
    EXPECT_EQ(receiver.end().exit_code, 3);
    EXPECT_THAT(receiver.end().err, HasSubstr("File too large"));
    Running again(receiving(unix_address(), "a.ofr"));
    ASSERT_TRUE(again.says(tools::messages::kListeningAt));
    EXPECT_EQ(run(printing(unix_address(), {"--resume"})).exit_code, 0);
    EXPECT_EQ(again.end().exit_code, 0);
    EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
}

TEST_F(Stream, AWrongTokenIsRefused) {
    const Outcome open_to_all = run(receiving("tcp://0.0.0.0:0", "a.ofr"));
    EXPECT_EQ(open_to_all.exit_code, 2);
    EXPECT_THAT(open_to_all.err, testing::Says(tools::messages::kTokenNeeded));
    Running receiver(receiving(kAnyPort, "a.ofr", {"--token-file", path("token")}));
    const std::string address = address_of(&receiver);
    for (const std::vector<std::string>& given :
         {std::vector<std::string>{}, std::vector<std::string>{"--token-file", path("wrong")}}) {
        const Outcome refused = run(printing(address, given));
        EXPECT_EQ(refused.exit_code, 1);
        EXPECT_THAT(refused.err, testing::Says(tools::messages::kTokenWrong));
    }
    RunOptions environment;
    environment.environment = {{"OPENFAB_TOKEN", "open sesame"}};
    const Outcome sent = run(printing(address), environment);
    EXPECT_EQ(sent.exit_code, 0) << sent.err;
    EXPECT_EQ(receiver.end().exit_code, 0);
    EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
}

TEST_F(Stream, StrangersNeitherDelayNorDamageAPrint) {
    Running receiver(receiving(kAnyPort, "a.ofr", {"--layer-time", "100ms"}));
    const std::string address = address_of(&receiver);
    Running sender(printing(address));
    ASSERT_TRUE(receiver.says(tools::messages::kPrintFromSlice));
    std::vector<stream::Line> strangers;
    // Garbage, and a message that is too long: both are told so and cut off.
    for (int i = 0; i < 2; ++i) {
        strangers.push_back(connect(address));
        std::vector<uint8_t> bytes(i == 0 ? 5000 : 8, 0xff);
        if (i == 0) std::generate(bytes.begin(), bytes.end(), std::ref(random_));
        ASSERT_TRUE(strangers.back().send_all(bytes));
        stream::Message answer;
        const Result<bool> heard = strangers.back().wait(&answer, 60);
        EXPECT_TRUE(heard && *heard && answer.kind == stream::Kind::kStop);
        const Result<bool> more = strangers.back().wait(&answer, 60);
        EXPECT_TRUE(more && !*more);
    }
    // A crowd that says nothing; and one that sends a byte now and then.
    for (int i = 0; i < 40; ++i)
        strangers.push_back(connect(address));
    stream::Line slow = connect(address);
    const std::vector<uint8_t> head = stream::frame(stream::Kind::kOpen, std::vector<uint8_t>(900));
    // It is cut off after stream::kOpenSeconds, before its message is whole.
    size_t sent = 0;
    bool cut = false;
    for (; !cut && sent < head.size(); std::this_thread::sleep_for(50ms))
        cut = slow.send_some(std::span(head).subspan(sent++, 1)) < 0 || !slow.receive();
    EXPECT_TRUE(cut);
    EXPECT_EQ(sender.end().exit_code, 0) << sender.end().err;
    EXPECT_EQ(receiver.end().exit_code, 0) << receiver.end().err;
    EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
    EXPECT_THAT(receiver.end().err, testing::Says(tools::messages::kLinesCut, "*", "0"));
}

TEST_F(Stream, ASecondSenderIsRefused) {
    Running receiver(receiving(unix_address(), "a.ofr", kSlow));
    ASSERT_TRUE(receiver.says(tools::messages::kListeningAt));
    Running first(printing(unix_address()));
    ASSERT_TRUE(receiver.says(tools::messages::kPrintFromSlice));
    for (const char* world : {"ball.fab.json", "other.fab.json"}) {
        for (const char* how : {"--progress=none", "--resume"}) {
            const Outcome second = run(printing(unix_address(), {how}, world));
            EXPECT_EQ(second.exit_code, 3) << second.err;
            EXPECT_THAT(second.err, testing::Says(tools::messages::kAnotherPrint));
            EXPECT_THAT(second.err, HasSubstr("with `--resume`"));
        }
    }
    EXPECT_EQ(first.end().exit_code, 0) << first.end().err;
    EXPECT_EQ(receiver.end().exit_code, 0) << receiver.end().err;
    EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
}

TEST_F(Stream, AWholePrintIsNotReplaced) {
    undisturbed();
    fs::copy_file(path("undisturbed.ofr"), path("a.ofr"));
    Running receiver(receiving(unix_address(), "a.ofr"));
    ASSERT_TRUE(receiver.says(tools::messages::kListeningAt));
    for (const char* world : {"ball.fab.json", "other.fab.json"}) {
        const Outcome refused = run(printing(unix_address(), {}, world));
        EXPECT_EQ(refused.exit_code, 1) << refused.err;
        EXPECT_THAT(refused.err, testing::Says(tools::messages::kHoldsAnotherPrint));
    }
    EXPECT_EQ(run(printing(unix_address(), {"--resume"}, "other.fab.json")).exit_code, 1);
    // The same one has nothing left to send.
    EXPECT_EQ(run(printing(unix_address(), {"--resume"})).exit_code, 0);
    EXPECT_EQ(receiver.end().exit_code, 0);
    EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
}

TEST_F(Stream, AddressesThatAreNoneAreRefused) {
    for (const char* address : {"tcp://", "tcp://host", "tcp://host:", "tcp://host:70000",
                                "tcp://:80", "unix:", "tcp://host:http"}) {
        const Outcome refused = run(printing(address));
        EXPECT_EQ(refused.exit_code, 2) << address << refused.err;
    }
    const Outcome nobody = run(printing("unix:" + path("nobody")));
    EXPECT_EQ(nobody.exit_code, 3);
    EXPECT_THAT(nobody.err, testing::Says(stream::messages::kCannotConnect));
    EXPECT_THAT(nobody.err, Not(HasSubstr("--resume"))) << "nothing was sent";
    EXPECT_EQ(run(printing(kAnyPort, {"--format", "png"})).exit_code, 2);
}

TEST_F(Stream, TheClientInPythonIsUnderstood) {
    undisturbed();
    Running receiver(receiving(kAnyPort, "a.ofr", {"--token-file", path("token")}));
    RunOptions environment;
    environment.environment = {{"OPENFAB_TOKEN", "open sesame"}};
    const std::string address = address_of(&receiver);
    const Outcome sent = run({"/usr/bin/python3", source_dir() / "docs/streaming_client.py",
                              path("undisturbed.ofr"), address},
                             environment);
    EXPECT_EQ(sent.exit_code, 0) << sent.err;
    EXPECT_EQ(receiver.end().exit_code, 0) << receiver.end().err;
    EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
}

TEST_F(Stream, TheClientInPythonTakesUpALineThatWasCut) {
    const auto bytes = static_cast<int64_t>(undisturbed().size());
    Running receiver(receiving(kAnyPort, "a.ofr"));
    const Proxy proxy(*stream::parse_address(address_of(&receiver)), {bytes / 4, bytes / 2});
    const Outcome sent = run({"/usr/bin/python3", source_dir() / "docs/streaming_client.py",
                              path("undisturbed.ofr"), proxy.address()});
    EXPECT_EQ(sent.exit_code, 0) << sent.err;
    EXPECT_EQ(proxy.cuts_made(), 2);
    EXPECT_EQ(receiver.end().exit_code, 0) << receiver.end().err;
    EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
}

std::string tls_file(const std::string& name) {
    return source_dir() / "tests/programs/stream/tls" / name;
}
std::vector<std::string> certificate(const std::string& name) {
    return {"--tls-cert", tls_file(name + ".pem"), "--tls-key", tls_file(name + ".key.pem")};
}

TEST_F(Stream, TlsChangesNoByte) {
    const std::vector<std::string> trusted{"--tls-ca", tls_file("authority.pem")};
    for (const char* output : {"a.ofr", "slices"}) {
        Running receiver(receiving(kAnyTlsPort, output, certificate("loopback")));
        const Outcome sent = run(printing(address_of(&receiver), trusted));
        EXPECT_EQ(sent.exit_code, 0) << sent.err;
        EXPECT_EQ(receiver.end().exit_code, 0) << receiver.end().err;
    }
    EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
    ASSERT_EQ(run(printing(path("direct"), {"--format", "png"})).exit_code, 0);
    EXPECT_TRUE(files_of(path("slices")) == files_of(path("direct")));
    fs::remove(path("a.ofr"));

    // Cut within records, and damaged: what TLS does not take for its own cuts the line.
    const auto bytes = static_cast<int64_t>(undisturbed().size());
    Running receiver(receiving(kAnyTlsPort, "a.ofr", certificate("loopback")));
    const Proxy proxy(*stream::parse_address(address_of(&receiver)),
                      {5000, bytes / 3, 3 * bytes / 4}, bytes / 2);
    const Outcome sent = run(printing("tls" + proxy.address().substr(3), trusted));
    ASSERT_EQ(sent.exit_code, 0) << sent.err << receiver.err();
    EXPECT_EQ(proxy.cuts_made(), 3);
    EXPECT_EQ(receiver.end().exit_code, 0) << receiver.end().err;
    EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
}

TEST_F(Stream, TlsSendsNothingToWhomItDoesNotTrust) {
    const auto refused = [&](const std::string& address, const std::vector<std::string>& options) {
        const Outcome sent = run(printing(address, options));
        EXPECT_NE(sent.exit_code, 0);
        return sent.err;
    };
    const std::vector<std::string> trusted{"--tls-ca", tls_file("authority.pem")};
    {
        Running receiver(receiving(kAnyTlsPort, "a.ofr", certificate("loopback")));
        const std::string address = address_of(&receiver);
        EXPECT_THAT(refused(address, {}), testing::Says(stream::messages::kNotTrusted));
        EXPECT_THAT(refused(address, {"--tls-ca", tls_file("other.pem")}),
                    testing::Says(stream::messages::kNotTrustedHelp));
        // Neither end takes the other for what it is not.
        EXPECT_NE(refused("tcp" + address.substr(3), {}), "");
        EXPECT_FALSE(fs::exists(path("a.ofr")));
        const Outcome sent = run(printing(address, trusted));
        EXPECT_EQ(sent.exit_code, 0) << sent.err;
        EXPECT_EQ(receiver.end().exit_code, 0);
    }
    {
        Running receiver(receiving(kAnyTlsPort, "b.ofr", certificate("elsewhere")));
        EXPECT_THAT(refused(address_of(&receiver), trusted), HasSubstr("IP address mismatch"));
    }
    Running plain(receiving(kAnyPort, "c.ofr"));
    EXPECT_NE(refused("tls" + address_of(&plain).substr(3), trusted), "");
}

TEST_F(Stream, TlsNeedsItsFiles) {
    const auto refusal = [&](const std::string& address, const std::vector<std::string>& options) {
        const Outcome outcome = run(receiving(address, "a.ofr", options));
        EXPECT_THAT(outcome.exit_code, ::testing::AnyOf(1, 2));
        return outcome.err;
    };
    EXPECT_THAT(refusal(kAnyTlsPort, {}), testing::Says(tools::messages::kTlsNeedsKeys));
    EXPECT_THAT(refusal(kAnyPort, certificate("loopback")),
                testing::Says(tools::messages::kTlsNeedsKeys));
    EXPECT_THAT(refusal(kAnyTlsPort, {"--tls-cert", path("token"), "--tls-key", path("token")}),
                testing::Says(stream::messages::kCannotReadFrom, stream::messages::kACertificate));
    EXPECT_THAT(
        refusal(kAnyTlsPort, {"--tls-cert", tls_file("loopback.pem"), "--tls-key",
                              tls_file("elsewhere.key.pem")}),
        testing::Says(stream::messages::kCannotReadFrom, stream::messages::kKeyOfCertificate));
    EXPECT_THAT(run(printing("tls://127.0.0.1:1", {"--tls-ca", path("token")})).err,
                testing::Says(stream::messages::kCannotReadFrom, "certificates"));
}

TEST_F(Stream, TheClientInPythonSpeaksTls) {
    undisturbed();
    Running receiver(receiving(kAnyTlsPort, "a.ofr", certificate("loopback")));
    RunOptions environment;
    environment.environment = {{"OPENFAB_TLS_CA", tls_file("authority.pem")}};
    const Outcome sent = run({"/usr/bin/python3", source_dir() / "docs/streaming_client.py",
                              path("undisturbed.ofr"), address_of(&receiver)},
                             environment);
    EXPECT_EQ(sent.exit_code, 0) << sent.err;
    EXPECT_EQ(receiver.end().exit_code, 0) << receiver.end().err;
    EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
}

}  // namespace
}  // namespace openfab::testing
