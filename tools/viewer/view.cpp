// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/view.h"

#include <fmt/format.h>
#include <malloc.h>

#include "base/say.h"
#include "tools/viewer/http_server.h"
#include "tools/viewer/json_text.h"
#include "tools/viewer/print_api.h"
#include "tools/viewer/session.h"
#include "tools/viewer/viewer_page.h"

namespace openfab::viewer {

namespace {

/// Slices come and go in any order from many threads: their memory goes back to the system instead
/// of being kept in a heap for each thread.
void keep_memory_small() {
    constexpr int kLargeBlock = 1 << 20;
    constexpr int kMostHeaps = 4;
    ::mallopt(M_MMAP_THRESHOLD, kLargeBlock);
    ::mallopt(M_ARENA_MAX, kMostHeaps);
}

Answer state(Session* session) {
    session->look_again();
    JsonText out;
    out.begin_object();
    describe_prints(session->prints(), &out);
    out.end_object();
    return {200, "application/json", out.take()};
}

}  // namespace

Result<void> view(const ViewOptions& options) {
    keep_memory_small();
    Session session(options.memory_bytes);
    if (Result<void> opened = session.open(options.file); !opened) return opened;
    if (!options.compare.empty()) {
        if (Result<void> opened = session.open(options.compare); !opened) return opened;
    }
    const Handler handler = [&](const Request& request) -> Answer {
        if (request.path == "/api/state") return state(&session);
        if (std::optional<Answer> answer = answer_on_prints(session, {}, request)) return *answer;
        return refusal(404, "there is nothing at this address");
    };
    std::string url;
    Result<std::unique_ptr<HttpServer>> server =
        HttpServer::listen({options.address, options.port, kViewerPage}, handler, &url);
    if (!server) return server.error();
    show(fmt::format("{}\n", url));
    if (Result<void> written = written_out(); !written) return written;
    return (*server)->serve();
}

}  // namespace openfab::viewer
