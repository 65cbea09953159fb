// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// A receiver of prints among senders that are cut, slow, wrong or hostile.

#include <fmt/format.h>
#include <sys/stat.h>

#include <csignal>
#include <cstring>
#include <span>

#include "backends/job/messages.h"
#include "backends/job/record.h"
#include "backends/ofr/format.h"
#include "backends/ofr/slice_codec.h"
#include "base/json_text.h"
#include "tests/programs/stream/stream_fixture.h"
#include "tests/support/places/places.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
namespace fs = std::filesystem;
using Receiver = Stream;

/// The parts of an .ofr file, as a sender of our own making sends them.
class Parts {
  public:
    explicit Parts(const std::string& file) : bytes_(file.begin(), file.end()) {
        uint32_t fields = 0;
        std::memcpy(&fields, &bytes_[12], 4);
        size_t at = 16 + fields + 8;
        header.assign(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(at));
        info = *ofr::read_header(header);
        for (int32_t z = info.slice_begin; z < info.slice_end; ++z) {
            const std::span<const uint8_t> rest = std::span<const uint8_t>(bytes_).subspan(at);
            const size_t size = ofr::kSliceHeadBytes +
                                ofr::read_slice_head(rest.first(ofr::kSliceHeadBytes))->frame_bytes;
            slices.emplace_back(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(size));
            at += size;
        }
    }
    std::vector<uint8_t> header;
    pipeline::PrintInfo info;
    std::vector<std::vector<uint8_t>> slices;

  private:
    std::vector<uint8_t> bytes_;
};

/// Opens a print and returns the receiver's answer.
stream::Message open_print(stream::Line* line, const Parts& parts, stream::Mode mode,
                           uint64_t sender, const std::string& token = "") {
    line->allow(1 << 24);
    EXPECT_TRUE(line->send_all(stream::frame_open({mode, sender, token, parts.header})));
    stream::Message answer;
    const Result<bool> heard = line->wait(&answer);
    EXPECT_TRUE(heard && *heard);
    return answer;
}

void send_slices(stream::Line* line, const Parts& parts, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
        ASSERT_TRUE(line->send_all(stream::frame(stream::Kind::kSlice, parts.slices[i])));
    for (stream::Message answer; end > begin;) {
        const Result<bool> heard = line->wait(&answer);
        ASSERT_TRUE(heard && *heard && answer.kind == stream::Kind::kAcknowledge);
        if (*stream::read_acknowledge(answer.bytes) + 1 ==
            parts.info.slice_begin + static_cast<int32_t>(end))
            return;
    }
}

TEST_F(Receiver, CodesThatNoMaterialHasAreDamage) {
    const Parts parts(undisturbed());
    ASSERT_EQ(parts.info.bits, 4);
    for (const char* output : {"a.ofr", "slices"}) {
        Running receiver(receiving(unix_address(), output));
        ASSERT_TRUE(receiver.says(tools::messages::kListeningAt));
        stream::Line line = connect(unix_address());
        ASSERT_EQ(open_print(&line, parts, stream::Mode::kAnew, 1).kind, stream::Kind::kReady);
        const auto width = static_cast<size_t>(parts.info.size.x + 1) / 2;
        std::vector<uint8_t> rows(width * static_cast<size_t>(parts.info.size.y));
        rows[rows.size() / 2] = 3;  // two materials
        const std::vector<uint8_t> slice = ofr::encode_slice(
            {parts.info.slice_begin, rows.data(), width, parts.info.size.x, parts.info.size.y});
        ASSERT_TRUE(line.send_all(stream::frame(stream::Kind::kSlice, slice)));
        stream::Message answer;
        ASSERT_TRUE(*line.wait(&answer));
        EXPECT_EQ(answer.kind, stream::Kind::kStop);
        EXPECT_EQ(stream::read_stop(answer.bytes).code, stream::StopCode::kAgain);
        EXPECT_TRUE(receiver.says(fmt::format(tools::messages::kCodesBeyondMaterials, 2)));
    }
}

TEST_F(Receiver, SlicesThatDoNotFitTheMemoryWithAllTheirCopiesAreRefused) {
    const Parts small(undisturbed());
    for (const char* output : {"a.ofr", "slices"}) {
        for (const int64_t megabytes : {300, 400}) {
            SCOPED_TRACE(fmt::format("{} {}", output, megabytes));
            Running receiver(
                receiving(unix_address(), output, {"--memory", fmt::format("{}MB", megabytes)}));
            ASSERT_TRUE(receiver.says(tools::messages::kListeningAt));
            // Noise does not get smaller, so that each copy has the size of the rows. It is made
            // here: what this process takes counts for those that it starts.
            Parts parts = small;
            parts.info.size = {9000, 9000, 2};
            parts.info.bits = 8;
            parts.info.slice_begin = 0;
            parts.info.slice_end = 2;
            parts.info.materials.resize(60, small.info.materials[0]);
            parts.header = ofr::write_header(parts.info);
            std::vector<uint8_t> rows(81'000'000);
            for (uint8_t& code : rows)
                code = static_cast<uint8_t>(random_() % 61);
            parts.slices.clear();
            for (const int32_t z : {0, 1})
                parts.slices.push_back(ofr::encode_slice({z, rows.data(), 9000, 9000, 9000}));
            stream::Line line = connect(unix_address());
            const bool fits = megabytes == 400;
            const stream::Message answer = open_print(&line, parts, stream::Mode::kAnew, 1);
            EXPECT_EQ(answer.kind, fits ? stream::Kind::kReady : stream::Kind::kStop);
            if (fits) send_slices(&line, parts, 0, 2);
            EXPECT_TRUE(receiver.says(fits ? tools::messages::kPrintFromSlice
                                           : tools::messages::kPrintRefusedMemory));
            receiver.kill();
#ifndef OPENFAB_SANITIZED
            EXPECT_LT(receiver.end().peak_rss_bytes, megabytes * 1'000'000);
#endif
        }
        fs::remove_all(path(output));
    }
}

TEST_F(Receiver, APrintThatWasCutIsHeldWhoeverTriesToResumeIt) {
    const Parts parts(undisturbed());
    ASSERT_EQ(run(printing(path("o.ofr"), {}, "other.fab.json")).exit_code, 0);
    const Parts other(read_file(path("o.ofr")));
    Running receiver(receiving(unix_address(), "a.ofr"));
    ASSERT_TRUE(receiver.says(tools::messages::kListeningAt));
    {
        stream::Line line = connect(unix_address());
        ASSERT_EQ(open_print(&line, parts, stream::Mode::kAnew, 1).kind, stream::Kind::kReady);
        send_slices(&line, parts, 0, 50);
    }
    ASSERT_TRUE(receiver.says(tools::messages::kLineCut));
    const auto refused = [&](const Parts& print, stream::Mode mode, uint64_t sender) {
        stream::Line line = connect(unix_address());
        const stream::Message answer = open_print(&line, print, mode, sender);
        EXPECT_EQ(answer.kind, stream::Kind::kStop);
        return stream::read_stop(answer.bytes).code;
    };
    {
        // Another resumes it, and is cut while it gets the slices.
        stream::Line line = connect(unix_address());
        EXPECT_EQ(open_print(&line, parts, stream::Mode::kSendBack, 2).kind, stream::Kind::kBack);
    }
    EXPECT_EQ(refused(other, stream::Mode::kAnew, 3), stream::StopCode::kBusy);
    EXPECT_EQ(refused(other, stream::Mode::kSendBack, 4), stream::StopCode::kBusy);
    EXPECT_EQ(refused(parts, stream::Mode::kAnew, 5), stream::StopCode::kBusy);
    const Outcome sent = run(printing(unix_address(), {"--resume"}));
    EXPECT_EQ(sent.exit_code, 0) << sent.err;
    EXPECT_THAT(sent.err, HasSubstr("(50 resumed)"));
    EXPECT_EQ(receiver.end().exit_code, 0) << receiver.end().err;
    EXPECT_TRUE(read_file(path("a.ofr")) == undisturbed());
}

TEST_F(Receiver, WhoReadsBackSlowlyDelaysNobody) {
    // More than what the sockets hold.
    write_world("block.fab.json", R"({"box": [60, 60, 12]})", "Tint");
    ASSERT_EQ(run(printing(path("b.ofr"), {}, "block.fab.json")).exit_code, 0);
    const Parts parts(read_file(path("b.ofr")));
    Running receiver(receiving(unix_address(), "a.ofr"));
    ASSERT_TRUE(receiver.says(tools::messages::kListeningAt));
    {
        stream::Line line = connect(unix_address());
        ASSERT_EQ(open_print(&line, parts, stream::Mode::kAnew, 1).kind, stream::Kind::kReady);
        for (size_t begin = 0; begin < 100; begin += 50)
            send_slices(&line, parts, begin, begin + 50);
    }
    ASSERT_TRUE(receiver.says(tools::messages::kLineCut));
    stream::Line slow = connect(unix_address());
    EXPECT_EQ(open_print(&slow, parts, stream::Mode::kSendBack, 2).kind, stream::Kind::kBack);
    // It takes nothing more for now. Others are answered.
    for (uint64_t i = 0; i < 3; ++i) {
        stream::Line line = connect(unix_address());
        EXPECT_EQ(open_print(&line, parts, stream::Mode::kAnew, 10 + i).kind, stream::Kind::kStop);
    }
    stream::Message answer;
    size_t back = 1;
    while (*slow.wait(&answer) && answer.kind == stream::Kind::kBack)
        EXPECT_TRUE(answer.bytes == parts.slices[back++]);
    EXPECT_EQ(back, 100u);
    ASSERT_EQ(answer.kind, stream::Kind::kReady);
    EXPECT_EQ(stream::read_ready(answer.bytes)->next, parts.info.slice_begin + 100);
}

TEST_F(Receiver, LargeSlicesThatAreSentBackDoNotEndTheLine) {
    // Noise of more bytes than answers may wait with.
    Parts parts(undisturbed());
    parts.info.size = {700, 700, 3};
    parts.info.slice_begin = 0;
    parts.info.slice_end = 3;
    parts.header = ofr::write_header(parts.info);
    parts.slices.clear();
    std::vector<uint8_t> rows(350 * 700);
    for (uint8_t& codes : rows)
        codes = static_cast<uint8_t>(random_() % 3 + 16 * (random_() % 3));
    for (const int32_t z : {0, 1, 2})
        parts.slices.push_back(ofr::encode_slice({z, rows.data(), 350, 700, 700}));
    ASSERT_GT(parts.slices[0].size(), 80'000u);
    Running receiver(receiving(unix_address(), "a.ofr"));
    ASSERT_TRUE(receiver.says(tools::messages::kListeningAt));
    {
        stream::Line line = connect(unix_address());
        ASSERT_EQ(open_print(&line, parts, stream::Mode::kAnew, 1).kind, stream::Kind::kReady);
        send_slices(&line, parts, 0, 2);
    }
    ASSERT_TRUE(receiver.says(tools::messages::kLineCut));
    stream::Line line = connect(unix_address());
    EXPECT_EQ(open_print(&line, parts, stream::Mode::kSendBack, 2).kind, stream::Kind::kBack);
    stream::Message answer;
    ASSERT_TRUE(*line.wait(&answer));
    EXPECT_EQ(answer.kind, stream::Kind::kBack);
    ASSERT_TRUE(*line.wait(&answer));
    EXPECT_EQ(answer.kind, stream::Kind::kReady);
    send_slices(&line, parts, 2, 3);
}

TEST_F(Receiver, AnOutputThatIsDeletedEndsThePrint) {
    const Parts parts(undisturbed());
    for (const char* output : {"a.ofr", "slices"}) {
        Running receiver(receiving(unix_address(), output));
        ASSERT_TRUE(receiver.says(tools::messages::kListeningAt));
        stream::Line line = connect(unix_address());
        ASSERT_EQ(open_print(&line, parts, stream::Mode::kAnew, 1).kind, stream::Kind::kReady);
        send_slices(&line, parts, 0, 5);
        std::this_thread::sleep_for(1500ms);  // it is looked for once a second
        fs::remove_all(path(output));
        stream::Message answer;
        ASSERT_TRUE(*line.wait(&answer));
        EXPECT_EQ(stream::read_stop(answer.bytes).code, stream::StopCode::kDisk);
        EXPECT_EQ(receiver.end().exit_code, 3);
        EXPECT_THAT(receiver.end().err, testing::Says(tools::messages::kOutputDeletedMeanwhile));
    }
}

TEST_F(Receiver, TokensCannotBeTriedOutQuickly) {
    const Parts parts(undisturbed());
    Running receiver(receiving(kAnyPort, "a.ofr", {"--token-file", path("token")}));
    const std::string address = address_of(&receiver);
    const double start = seconds_now();
    constexpr int kTries = 4;  // 0.25 + 0.5 + 1 + 2 s
    std::vector<stream::Line> lines;
    for (int i = 0; i < kTries; ++i) {
        lines.push_back(connect(address));
        lines.back().send_all(stream::frame_open({stream::Mode::kAnew, 1, "guess", parts.header}));
    }
    for (stream::Line& line : lines) {
        stream::Message answer;
        ASSERT_TRUE(*line.wait(&answer));
        EXPECT_EQ(stream::read_stop(answer.bytes).code, stream::StopCode::kToken);
    }
    EXPECT_GT(seconds_now() - start, 3.5);
    EXPECT_TRUE(receiver.says(fmt::format(tools::messages::kWrongTokenFrom, "127.0.0.1:{}")));
    stream::Line right = connect(address);
    EXPECT_EQ(open_print(&right, parts, stream::Mode::kAnew, 2, "open sesame").kind,
              stream::Kind::kReady);
    EXPECT_TRUE(receiver.says(fmt::format(tools::messages::kSenderCame, "127.0.0.1:{}")));
}

/// The story beside the output, and the log of who came, over a killed receiver.
TEST_F(Receiver, TellsWhatItTookAndFromWhom) {
    const std::vector<std::string> more{"--token-file", path("token"), "--log", path("audit")};
    std::vector<std::string> slow = more;
    slow.insert(slow.end(), kSlow.begin(), kSlow.end());
    Running receiver(receiving(kAnyPort, "a.ofr", slow));
    const std::string address = address_of(&receiver);
    EXPECT_NE(run(printing(address, {"--token-file", path("wrong")})).exit_code, 0);
    Running sender(printing(address, {"--token-file", path("token")}));
    wait_for_slices("a.ofr");
    receiver.kill();
    EXPECT_THAT(run({program("openfab"), "info", path("a.ofr")}).out,
                testing::Says(job::messages::kNobodyWrites));
    Running again(receiving(address, "a.ofr", more));
    EXPECT_EQ(again.end().exit_code, 0);
    EXPECT_EQ(sender.end().exit_code, 0);
    EXPECT_EQ(read_file(path("a.ofr")), undisturbed());
    const Result<JsonValue> record = job::read_record(path("a.ofr.job.json"));
    ASSERT_TRUE(record) << record.error().text();
    std::string events;
    for (const JsonValue& event : member_of(*record, "events")->items)
        events += member_of(event, "event")->text + " ";
    EXPECT_EQ(events, "start resume complete ");
    EXPECT_THAT(member_of(member_of(*record, "events")->items[0], "from")->text,
                HasSubstr("127.0.0.1"));

    const Result<JsonValue> schema =
        parse_json(read_file(source_dir() / "backends/job/fab_receive_log.schema.json"), "schema");
    ASSERT_TRUE(schema) << schema.error().text();
    std::string log = read_file(path("audit")), said;
    for (size_t at = 0; at < log.size();) {
        const size_t end = log.find('\n', at);
        ASSERT_NE(end, std::string::npos);
        const Result<JsonValue> line = parse_json(log.substr(at, end - at), "audit");
        ASSERT_TRUE(line) << line.error().text();
        for (const JsonValue& name : member_of(*schema, "required")->items)
            EXPECT_NE(line->find(name.text), nullptr) << name.text;
        EXPECT_EQ(line->members.size(), member_of(*schema, "properties")->members.size());
        bool known = false;
        for (const JsonValue& one :
             member_of(*member_of(*member_of(*schema, "properties"), "event"), "enum")->items)
            known = known || one.text == member_of(*line, "event")->text;
        EXPECT_TRUE(known) << member_of(*line, "event")->text;
        said += member_of(*line, "event")->text + ", ";
        at = end + 1;
    }
    EXPECT_THAT(said, HasSubstr("wrong token, "));
    EXPECT_THAT(said, HasSubstr("sender, print, sender, print, complete, "));
    EXPECT_EQ(std::filesystem::status(path("audit")).permissions(),
              std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

/// A receiver that is stopped says so: on standard error, beside the output, in its log.
TEST_F(Receiver, ItsOwnStopIsInItsStory) {
    std::signal(SIGHUP, SIG_DFL);  // `nohup` has it ignored
    for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
        for (const std::string output : {"a.ofr", "slices"}) {
            SCOPED_TRACE(fmt::format("{} {}", output, signal));
            std::error_code ignored;
            for (const std::string& name : {output, output + ".job.json", std::string("audit")})
                fs::remove_all(path(name), ignored);
            const Parts parts(undisturbed());
            Running receiver(receiving(unix_address(), output, {"--log", path("audit")}), {},
                             signal);
            ASSERT_TRUE(receiver.says(tools::messages::kListeningAt));
            stream::Line line = connect(unix_address());
            EXPECT_EQ(open_print(&line, parts, stream::Mode::kAnew, 1).kind, stream::Kind::kReady);
            send_slices(&line, parts, 0, 7);
            receiver.kill();
            const Outcome& outcome = receiver.end();
            EXPECT_EQ(outcome.exit_code, 130);
            EXPECT_THAT(outcome.err,
                        HasSubstr("error: " + fmt::format(tools::messages::kInterruptedBeforeSlice,
                                                          parts.info.slice_begin + 7)));
            const std::string name = signal == SIGTERM  ? "SIGTERM"
                                     : signal == SIGINT ? "SIGINT"
                                                        : "SIGHUP";
            const Result<JsonValue> record = job::read_record(path(output + ".job.json"));
            ASSERT_TRUE(record) << record.error().text();
            EXPECT_EQ(member_of(*record, "state")->text, "stopped");
            const JsonValue& stop = member_of(*record, "events")->items.back();
            EXPECT_EQ(member_of(stop, "event")->text, "stop");
            EXPECT_EQ(member_of(stop, "by")->text, "signal");
            EXPECT_EQ(member_of(stop, "signal")->text, name);
            EXPECT_EQ(member_of(stop, "sender")->number, ::getpid());
            EXPECT_EQ(member_of(stop, "slice")->number, parts.info.slice_begin + 7);
            std::string log = read_file(path("audit"));
            log = log.substr(log.rfind('\n', log.size() - 2) + 1);
            const Result<JsonValue> last = parse_json(log, "audit");
            ASSERT_TRUE(last) << last.error().text();
            EXPECT_EQ(member_of(*last, "event")->text, "stop");
            EXPECT_EQ(member_of(*last, "slice")->number, parts.info.slice_begin + 7);
            EXPECT_EQ(member_of(*last, "text")->text,
                      fmt::format(tools::messages::kStoppedBySignal, name) +
                          fmt::format(tools::messages::kSentByProcess, ::getpid()));
        }
    }
}

/// So does one whose output fails.
TEST_F(Receiver, AnErrorOfItsOutputIsInItsStory) {
    const Parts parts(undisturbed());
    RunOptions options;
    options.largest_file_bytes = static_cast<int64_t>(undisturbed().size() / 2);
    Running receiver(receiving(unix_address(), "a.ofr", {"--log", path("audit")}), options);
    ASSERT_TRUE(receiver.says(tools::messages::kListeningAt));
    stream::Line line = connect(unix_address());
    EXPECT_EQ(open_print(&line, parts, stream::Mode::kAnew, 1).kind, stream::Kind::kReady);
    for (const std::vector<uint8_t>& slice : parts.slices)
        line.send_all(stream::frame(stream::Kind::kSlice, slice));
    const Outcome& outcome = receiver.end();
    EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
    const Result<JsonValue> record = job::read_record(path("a.ofr.job.json"));
    ASSERT_TRUE(record) << record.error().text();
    const JsonValue& stop = member_of(*record, "events")->items.back();
    EXPECT_EQ(member_of(stop, "by")->text, "error");
    EXPECT_THAT(member_of(stop, "error")->text, HasSubstr("a.ofr"));
    EXPECT_THAT(read_file(path("audit")), HasSubstr(R"("event":"stop")"));
}

/// The print goes on where the log's disk is full; each line of the log is whole, and those that are lost
/// are counted.
TEST_F(Receiver, ALogOnAFullDiskTellsWhatItLost) {
    std::string why_not;
    const std::unique_ptr<SmallDisk> disk = SmallDisk::create(256 << 10, &why_not);
    if (disk == nullptr) GTEST_SKIP() << why_not;
    const std::string log = disk->path("audit");
    Running receiver(
        receiving(unix_address(), "a.ofr", {"--token-file", path("token"), "--log", log}));
    ASSERT_TRUE(receiver.says(tools::messages::kListeningAt));
    // It fills until lines are refused, in the middle of one if the page ends there.
    disk->fill("more", 4096);
    const Parts parts(undisturbed());
    const auto try_one = [&](const std::string& token) {
        stream::Line line = connect(unix_address());
        return open_print(&line, parts, stream::Mode::kAnew, 1, token).kind;
    };
    while (!testing::says(receiver.err(), tools::messages::kLogNotWritten)) {
        ASSERT_FALSE(receiver.ended());
        ASSERT_EQ(try_one("open sesame"), stream::Kind::kReady);
    }
    ASSERT_EQ(try_one("open sesame"), stream::Kind::kReady);
    fs::remove(disk->path("more"));
    ASSERT_EQ(try_one("open sesame"), stream::Kind::kReady);
    receiver.kill();
    const std::string text = read_file(log);
    int lost = 0, torn = 0;
    for (size_t at = 0; at < text.size();) {
        const size_t end = text.find('\n', at);
        ASSERT_NE(end, std::string::npos);
        const Result<JsonValue> line = parse_json(text.substr(at, end - at), "audit");
        torn += line ? 0 : 1;
        if (line && member_of(*line, "event")->text == "lost") ++lost;
        at = end + 1;
    }
    EXPECT_EQ(lost, 1) << text;
    EXPECT_LE(torn, 1) << text;
}

TEST_F(Receiver, PipesAreRefusedWhereFilesAreMeant) {
    const std::string pipe = path("pipe.ofr");
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    for (const std::vector<std::string>& argv : std::vector<std::vector<std::string>>{
             {program("openfab"), "info", pipe},
             {program("openfab"), "verify", pipe},
             receiving(unix_address(), "pipe.ofr"),
             receiving(kAnyTlsPort, "q.ofr", {"--tls-cert", pipe, "--tls-key", pipe}),
             printing("tls://localhost:1", {"--tls-ca", pipe}),
             printing(pipe)}) {
        const Outcome refused = run(argv);
        EXPECT_EQ(refused.exit_code, 1) << refused.err;
        EXPECT_THAT(refused.err, HasSubstr("pipe"));
    }
}

}  // namespace
}  // namespace openfab::testing
