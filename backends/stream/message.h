// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What goes over a line between a print and a printer's front end: docs/streaming.md has all of it.
// A message is a kind, a length and that many bytes.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "backends/stream/address.h"
#include "backends/stream/tls.h"
#include "base/result.h"

namespace openfab::stream {

constexpr std::array<uint8_t, 8> kMagic{0x89, 'O', 'F', 'L', '\r', '\n', 0x1a, '\n'};
constexpr uint32_t kVersion = 1;

/// Four letters each, in the order in which they are written.
enum class Kind : uint32_t {
    kOpen = 0x4e45504f,         ///< "OPEN": what is printed, and who sends it
    kBack = 0x4b434142,         ///< "BACK": a slice that the receiver has kept
    kReady = 0x59444552,        ///< "REDY": which slice is next
    kSlice = 0x45434c53,        ///< "SLCE": a slice
    kAcknowledge = 0x4e4b4341,  ///< "ACKN": all slices up to this one are kept
    kDone = 0x454e4f44,         ///< "DONE": the index; the answer: all of it is kept
    kAlive = 0x56494c41,        ///< "ALIV": nothing new
    kStop = 0x504f5453,         ///< "STOP": why the line is closed
};

enum class Mode : uint32_t {
    kAnew = 0,      ///< from the first slice
    kGoOn = 1,      ///< the same sender after its line was cut
    kSendBack = 2,  ///< another sender of the same print: it wants the slices that are kept
};

enum class StopCode : uint32_t {
    kBye = 0,         ///< the sender has heard that all is kept
    kToken = 1,       ///< the token is wrong or missing
    kBusy = 2,        ///< another sender is printing
    kOtherPrint = 3,  ///< what is kept is of another print, or complete
    kAgain = 4,       ///< a slice came damaged or out of order: send it again
    kDisk = 5,        ///< the receiver cannot keep any more
    kProtocol = 6,    ///< the message makes no sense
};

// Bounds of time, in seconds, and of sizes.
constexpr double kConnectSeconds = 5;
constexpr double kOpenSeconds = 10;    ///< for all of OPEN, from the connection on
constexpr double kAliveSeconds = 5;    ///< who has nothing to say says so this often
constexpr double kSilentSeconds = 30;  ///< a line that is silent for so long is cut
constexpr double kLostSeconds = 60;    ///< a sender looks for a receiver for so long
constexpr uint32_t kMostWindow = 64;   ///< slices that wait for their acknowledgement
constexpr size_t kHeadBytes = 8;

struct Message {
    Kind kind{};
    std::vector<uint8_t> bytes;
};

struct Open {
    Mode mode = Mode::kAnew;
    uint64_t sender = 0;  ///< chosen at random by each process that sends
    std::string token;
    std::vector<uint8_t> header;  ///< of an .ofr file, from its magic to its checksum
};

struct Ready {
    int32_t next = 0;
    uint32_t window = 1;
    uint32_t complete = 0;  ///< 1: all slices and the index are kept
};

/// Frames a message.
std::vector<uint8_t> frame(Kind kind, std::span<const uint8_t> bytes);
std::vector<uint8_t> frame_open(const Open& open);
std::vector<uint8_t> frame_ready(const Ready& ready);
std::vector<uint8_t> frame_acknowledge(int32_t z);
std::vector<uint8_t> frame_stop(StopCode code, const std::string& text);

/// Parse the bytes of a message; errors are user errors without a name.
Result<Open> read_open(std::span<const uint8_t> bytes);
Result<Ready> read_ready(std::span<const uint8_t> bytes);
Result<int32_t> read_acknowledge(std::span<const uint8_t> bytes);
struct Stop {
    StopCode code = StopCode::kProtocol;
    std::string text;  ///< printable
};
Stop read_stop(std::span<const uint8_t> bytes);

/// Most bytes of OPEN: all that a stranger may send.
constexpr size_t kMostOpenBytes = (1U << 20) + 1024;

/// A connection that bytes are read from until they make messages. Memory is bounded by the
/// longest message that is allowed at the time.
class Line {
  public:
    /// `tls`: null where bytes go as they are.
    explicit Line(Socket socket, std::unique_ptr<TlsSession> tls = nullptr);
    Line(Line&&) = default;
    Line& operator=(Line&& other) noexcept;

    int fd() const { return socket_.fd(); }
    bool is_open() const { return socket_.is_open(); }
    void close();
    /// Sets the longest message.
    void allow(size_t bytes) { most_ = bytes; }
    /// Reads what has arrived; returns whether the line is still there.
    bool receive();
    /// Takes the next whole message; false where there is none yet. Fails for one that is longer
    /// than allowed.
    Result<bool> next(Message* message);
    /// Sends what the socket takes at once and returns how much, or -1 where the line is cut. Where
    /// is_mid_send() is true afterwards, the next call must begin with the rest of these bytes.
    int64_t send_some(std::span<const uint8_t> bytes);
    bool is_mid_send() const { return tls_ != nullptr && tls_->must_repeat(); }
    /// Sends all; false where the line is cut, or takes nothing for `silent_seconds`.
    bool send_all(std::span<const uint8_t> bytes, double silent_seconds = kSilentSeconds);
    /// Waits for the next message, which others than ALIV are; false where the line is cut or
    /// silent for `silent_seconds`.
    Result<bool> wait(Message* message, double silent_seconds = kSilentSeconds);
    /// Returns when something arrived last, by seconds_now.
    double heard() const { return heard_; }

  private:
    /// Reads at most what fits; 0: nothing now, -1: the line is cut.
    int64_t read_some(std::span<uint8_t> bytes);

    Socket socket_;
    std::unique_ptr<TlsSession> tls_;  ///< after the socket, which it uses until it is destroyed
    std::vector<uint8_t> buffer_;
    size_t begin_ = 0;  ///< of what is not taken yet
    size_t most_ = kMostOpenBytes;
    double heard_ = 0;
};

}  // namespace openfab::stream
