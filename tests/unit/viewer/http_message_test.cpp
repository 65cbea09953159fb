// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/http_message.h"

#include <gmock/gmock.h>

namespace openfab::testing {
namespace {

using viewer::HeadRead;
using viewer::read_head;

std::string get(const std::string& target, const std::string& headers = "") {
    return "GET " + target + " HTTP/1.1\r\nHost: a\r\n" + headers + "\r\n";
}

TEST(HttpMessage, AHeadIsReadUpToItsEnd) {
    const std::string bytes =
        "POST /a%20b/%c3%a4?x=1&y=a%26b+c&empty&=z&x=2 HTTP/1.1\r\nHost: localhost:80\r\n"
        "X-Thing:  two words \t\r\nCONTENT-length: 12\r\n\r\nbody and more";
    for (size_t n = 0; n < bytes.find("\r\n\r\n") + 4; ++n) {
        const HeadRead part = read_head(std::string_view(bytes).substr(0, n));
        EXPECT_EQ(part.bytes, 0u) << n;
        EXPECT_EQ(part.status, 0) << n;
    }
    const HeadRead read = read_head(bytes);
    ASSERT_EQ(read.status, 0) << read.why;
    EXPECT_EQ(bytes.substr(read.bytes), "body and more");
    EXPECT_EQ(read.head.method, "POST");
    EXPECT_EQ(read.head.path, "/a b/ä");
    EXPECT_EQ(read.head.query, (std::map<std::string, std::string>{
                                   {"x", "1"}, {"y", "a&b c"}, {"empty", ""}, {"", "z"}}));
    EXPECT_EQ(read.head.header("x-thing"), "two words");
    EXPECT_EQ(read.head.header("none"), "");
    EXPECT_EQ(read.head.body_bytes, 12u);
    EXPECT_TRUE(read.head.keeps_alive);
}

TEST(HttpMessage, TheConnectionEndsWhereTheRequestSaysSo) {
    EXPECT_FALSE(read_head(get("/", "Connection: Close\r\n")).head.keeps_alive);
    EXPECT_TRUE(read_head(get("/", "Connection: keep-alive\r\n")).head.keeps_alive);
    EXPECT_FALSE(read_head("GET / HTTP/1.0\r\n\r\n").head.keeps_alive);
}

TEST(HttpMessage, WhatIsWrongOrUnusualIsRefused) {
    const std::string many = [] {
        std::string headers;
        for (int i = 0; i < 100; ++i)
            headers += "X-" + std::to_string(i) + ": y\r\n";
        return headers;
    }();
    const std::vector<std::pair<std::string, int>> wrong = {
        {"\r\n\r\n", 400},
        {"GET\r\n\r\n", 400},
        {"GET /\r\n\r\n", 400},
        {"GET / HTTP/2.0\r\n\r\n", 505},
        {"GET / http/1.1\r\n\r\n", 400},
        {"G T / HTTP/1.1\r\n\r\n", 400},
        {std::string("G\0T / HTTP/1.1\r\n\r\n", 18), 400},
        {get("*"), 400},
        {get("http://a/"), 400},
        {get("/%"), 400},
        {get("/%4"), 400},
        {get("/%4g"), 400},
        {get("/?a=%zz"), 400},
        {get("/", "no colon\r\n"), 400},
        {get("/", " folded: x\r\n"), 400},
        {get("/", "X : y\r\n"), 400},
        {get("/", ": y\r\n"), 400},
        {get("/", "X: a\nY: b\r\n"), 400},
        {get("/", "X: a\rb\r\n"), 400},
        {get("/", std::string("X: a\0b\r\n", 8)), 400},
        {get("/", "Host: b\r\n"), 400},
        {get("/", "Content-Length: 1\r\nContent-Length: 1\r\n"), 400},
        {get("/", "Content-Length: -1\r\n"), 400},
        {get("/", "Content-Length: +1\r\n"), 400},
        {get("/", "Content-Length: 1, 1\r\n"), 400},
        {get("/", "Content-Length:\r\n"), 400},
        {get("/", "Content-Length: 9999999999999999999\r\n"), 400},
        {get("/", "Transfer-Encoding: chunked\r\n"), 501},
        {get("/", "Expect: 100-continue\r\n"), 417},
        {get("/", many), 431},
        {get("/", "X: " + std::string(20000, 'y') + "\r\n"), 431},
        {"GET /" + std::string(20000, 'x'), 414},
        {std::string(20000, '\0'), 414}};
    for (const auto& [bytes, status] : wrong) {
        const HeadRead read = read_head(bytes);
        EXPECT_EQ(read.status, status) << bytes.substr(0, 80) << "\n" << read.why;
        EXPECT_EQ(read.bytes, 0u);
        EXPECT_NE(read.why, "");
    }
}

TEST(HttpMessage, AnAnswersHeadIsWhole) {
    EXPECT_EQ(viewer::answer_head(200, 5, true, {{"A", "b"}}),
              "HTTP/1.1 200 \r\nA: b\r\nContent-Length: 5\r\n\r\n");
    EXPECT_EQ(viewer::answer_head(204, 0, false, {}), "HTTP/1.1 204 \r\nConnection: close\r\n\r\n");
}

}  // namespace
}  // namespace openfab::testing
