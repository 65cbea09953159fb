// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The connections of a server: one thread waits on all of them, so that one that is silent or slow
// costs a place and no thread. What is whole is answered by a pool.
//
//   reading     nothing, or a part of a request; a deadline for the whole of it
//   answering   the pool has it
//   sending     the answer goes out, by a deadline for its size
//   lingering   the last answer is out; what the other end still sends is dropped, or it would never
//               see the answer
//
// When all places are taken, a new connection gets that of one that is not answered right now: of
// the address that holds the most, idle ones before slow ones, the longest first.

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "base/result.h"
#include "tools/viewer/http_message.h"

namespace openfab::viewer {

struct Reply {
    int status = 200;
    std::vector<std::pair<std::string, std::string>> headers;
    std::string body;
    std::string_view lasting_body;  ///< in place of `body`: a text that outlives the server
};

struct Service {
    /// Answers what needs neither a body nor time, and what is refused; else nothing. Called by the
    /// thread that all connections wait for.
    std::function<std::optional<Reply>(const RequestHead&)> admit;
    /// Called from several threads at once.
    std::function<Reply(const RequestHead&, const std::string& body)> answer;
    /// What is wrong with a request, in the words that this server uses.
    std::function<Reply(int status, const std::string& why)> refuse;
};

struct ConnectionLimits {
    size_t connections = 256;
    size_t threads = 14;
    uint64_t body_bytes = 4 << 20;
    size_t answer_bytes = 64 << 20;  ///< of answers on their way; beyond that no other is begun
    double request_seconds = 10;     ///< from its first byte to its last
    double idle_seconds = 60;
    double linger_seconds = 5;
    double answer_seconds = 10;  ///< of an answer, and as long as this many bytes a second take
    double answer_bytes_a_second = 64 << 10;
};

class Connections {
  public:
    /// `listening` is a socket that listens, which becomes this one's.
    Connections(int listening, Service service, const ConnectionLimits& limits);
    ~Connections();
    Connections(const Connections&) = delete;
    Connections& operator=(const Connections&) = delete;

    /// Answers until stop() is called or the listening socket fails.
    Result<void> run();
    /// May be called from any thread.
    void stop();

  private:
    enum class Stage { kReading, kAnswering, kSending, kLingering };
    struct Connection {
        int socket = -1;
        std::string address;
        Stage stage = Stage::kReading;
        double since = 0, deadline = 0;
        std::string in;
        std::optional<HeadRead> request;  ///< once the head is there
        std::string head_out;
        Reply reply;
        size_t sent = 0;
        bool keeps_alive = true;

        std::string_view body_out() const {
            return reply.lasting_body.empty() ? std::string_view(reply.body) : reply.lasting_body;
        }
    };
    using ById = std::map<uint64_t, Connection>;
    struct Job {
        uint64_t id = 0;
        RequestHead head;
        std::string body;
    };

    void work();
    bool wait_for_events();
    bool accept_one();
    ById::iterator who_gives_way();
    void close(ById::iterator connection);
    /// These return false where the connection is to be closed.
    bool read(uint64_t id, Connection* connection);
    bool advance(uint64_t id, Connection* connection);
    bool begin_reply(uint64_t id, Connection* connection, Reply reply, bool keeps_alive);
    bool send(uint64_t id, Connection* connection);
    bool end_reply(uint64_t id, Connection* connection);
    bool pass_deadline(uint64_t id, Connection* connection);
    void drop_reply(Connection* connection);
    void begin_request(Connection* connection);
    void take_replies();

    int listening_;
    int wake_;  ///< an eventfd: replies are ready, or it is to stop
    Service service_;
    ConnectionLimits limits_;
    ById connections_;  ///< of run() alone
    uint64_t last_id_ = 0;
    Result<void> failed_;

    std::mutex mutex_;  ///< of all below
    std::condition_variable changed_;
    bool stopping_ = false;
    std::deque<Job> jobs_;
    std::vector<std::pair<uint64_t, Reply>> replies_;
    size_t bytes_out_ = 0;  ///< of bodies that are not sent
    std::vector<std::thread> threads_;
};

}  // namespace openfab::viewer
