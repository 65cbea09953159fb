// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Receives one print over a line (docs/streaming.md) into a sink. It is one poll, and a thread that
// reads back what was kept while a print is resumed: strangers can neither delay a sender nor take
// more than a bounded amount of memory, and nothing that a sender says names a file.

#include <atomic>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "backends/stream/message.h"
#include "runtime/pipeline/slice_sink.h"
#include "tools/openfab/audit_log.h"
#include "tools/openfab/kept_slices.h"
#include "tools/openfab/layer_clock.h"

namespace openfab::tools {

struct ReceiverOptions {
    std::string token;                        ///< empty: none is asked for
    std::shared_ptr<stream::TlsContext> tls;  ///< null: bytes go as they are
    int64_t memory_bytes = 0;
    bool keeps_frames = false;  ///< the sink is of .ofr, and takes slices as they come
    double layer_seconds = 0;
    std::shared_ptr<AuditLog> log;  ///< null: none is kept
    int32_t buffer = 20;            ///< slices, where there is a layer time
    /// Whether the output is still there while a print comes into it; may be empty.
    std::function<bool()> output_is_there;
    const std::atomic<bool>* interrupt = nullptr;  ///< set by a signal; null: none is asked about
    /// Hears why the print ends before it is whole, before its output is closed; may be empty. Returns
    /// that in words for the log.
    std::function<std::string(const Error&)> stopped;
};

class Receiver {
  public:
    /// Opens the output: replaced, or with `resumed` as an earlier print has left it.
    using OpenSink = std::function<Result<std::unique_ptr<pipeline::SliceSink>>(
        const pipeline::PrintInfo& info, bool resumed, const std::string& from)>;

    Receiver(stream::Socket listening, ReceiverOptions options, OpenSink open_sink);

    /// Serves until a whole print is kept and printed, and its sender knows; fails where the output
    /// does. What was kept stays.
    Result<void> run();

  private:
    struct Client {
        Client(stream::Line line, std::string from);
        stream::Line line;
        std::string from;  ///< its address, for messages
        double since = 0;  ///< when it came
        double said = 0;   ///< when something was sent to it last
        bool is_sender = false;
        bool closing = false;
        std::vector<uint8_t> out;  ///< what the socket has not taken yet
        stream::Message waiting;   ///< its OPEN, where that is looked at later
        double waits_until = 0;    ///< 0: it does not wait
        bool has_wrong_token = false;
    };

    /// Wrong tokens from one host, each of which makes the next answer wait longer.
    struct WrongTokens {
        int32_t count = 0;
        double until = 0;
    };

    void accept_clients();
    Result<void> turn();
    Result<void> hear(Client* client);
    void flush(Client* client);
    void tidy();
    void lose(Client* client);
    bool may_read(const Client& client) const;
    Result<void> handle(Client* client, stream::Message* message);
    Result<void> open(Client* client, stream::Message* message);
    Result<void> open_now(Client* client, const stream::Message& message);
    Result<void> answer_waiting();
    Result<void> begin_print(Client* client, const stream::Open& open,
                             const pipeline::PrintInfo& info);
    Result<void> open_output(Client* client, const stream::Open& open,
                             const pipeline::PrintInfo& info);
    Result<void> read_back();
    void get_ready(Client* client);
    Result<void> refuse_output(Client* client, const Error& error);
    Result<void> check_output();
    Result<void> take_slice(Client* client, std::vector<uint8_t> bytes);
    Result<void> take_index(Client* client, const std::vector<uint8_t>& bytes);
    void acknowledge();
    void send(Client* client, const std::vector<uint8_t>& message);
    void stop(Client* client, stream::StopCode code, const std::string& text);
    Client* sender();
    bool is_token(const std::string& given) const;
    void close_sink();
    static size_t slice_bytes(const pipeline::PrintInfo& info);
    /// The most that a print takes: a slice's message in the line's buffer and out of it, its rows, and
    /// what the sink makes of them; and each slice's place in the output.
    static int64_t most_bytes(const pipeline::PrintInfo& info);
    int32_t window() const;
    void summarise() const;
    Error interrupted() const;
    void end_early(const Error& why);
    /// Says something of a client, and keeps it in the log.
    void tell(const char* event, const std::string& from, const std::string& text) const;

    stream::Socket listening_;
    ReceiverOptions options_;
    OpenSink open_sink_;
    std::list<Client> clients_;

    std::map<std::string, WrongTokens> wrong_tokens_;  ///< by host

    // The print.
    std::unique_ptr<pipeline::SliceSink> sink_;
    std::unique_ptr<KeptSlices> kept_;  ///< after the sink, which it uses
    bool is_unfinished_ = false;        ///< the output holds a print that may be gone on with
    double looked_at_ = 0;              ///< when the output was seen to be there
    std::vector<uint8_t> header_;
    pipeline::PrintInfo info_;
    uint64_t sender_ = 0;       ///< who sends it
    double held_until_ = 0;     ///< until then it waits for this sender alone
    int32_t next_ = 0;          ///< first slice that is not kept
    int32_t acknowledged_ = 0;  ///< one past the last slice that was
    uint64_t hash_ = 0;         ///< of the slices that are kept
    bool complete_ = false;
    bool bye_ = false;  ///< the sender knows
    double complete_at_ = 0;
    std::vector<uint8_t> rows_;
    LayerClock clock_;
    int64_t received_ = 0, order_errors_ = 0, checksum_errors_ = 0, cuts_ = 0, refused_ = 0;
};

}  // namespace openfab::tools
