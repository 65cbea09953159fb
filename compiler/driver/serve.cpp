// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// `openflc lsp`: the server on standard input and output.

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <string>

#include "base/say.h"
#include "compiler/driver/commands.h"
#include "compiler/graph/service.h"
#include "compiler/server/server.h"
#include "compiler/server/transport.h"

namespace openfab::driver {

namespace {

bool send(const std::vector<std::string>& messages) {
    for (const std::string& message : messages)
        write_out(server::framed(message));
    return static_cast<bool>(written_out());
}

bool input_waits() {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    return ::poll(&input, 1, 0) > 0;
}

}  // namespace

int serve_editor() {
    server::Server server(graph::answer);
    server::MessageReader reader;
    std::string block(1 << 16, '\0');
    while (true) {
        while (const std::optional<std::string> message = reader.next()) {
            if (!send(server.handle(*message))) return kExitOutside;
            if (server.exited()) return server.exit_code();
        }
        if (reader.broken())
            return fail("standard input: not a message with a `Content-Length` of at most 32 MiB",
                        kExitUserInput);
        if (server.has_changes() && !input_waits() && !send(server.publish())) return kExitOutside;
        const ssize_t got = ::read(STDIN_FILENO, block.data(), block.size());
        if (got < 0 && errno == EINTR) continue;
        // A client that goes away without a word is gone all the same.
        if (got <= 0) return got == 0 ? server.exit_code() : kExitOutside;
        reader.add(std::string_view(block).substr(0, static_cast<size_t>(got)));
    }
}

}  // namespace openfab::driver
