# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""A server with the part of S3 that file systems need for writing: objects, lists, multipart uploads."""

from __future__ import annotations

import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qs, unquote, urlsplit
from xml.sax.saxutils import escape


class S3Server:
    """Buckets in memory. `objects` are indexed by (bucket, key), open `uploads` by their number."""

    def __init__(self, *buckets: str) -> None:
        self.buckets = set(buckets)
        self.objects: dict[tuple[str, str], bytes] = {}
        self.uploads: dict[str, dict[int, bytes]] = {}
        self.in_parts = 0
        self.refuses = False
        """Whether every request to write is answered by an error."""
        self.lock = threading.Lock()
        handler = type("Handler", (_Handler,), {"store": self})
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
        self.url = "http://127.0.0.1:{}".format(self._server.server_address[1])
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def __enter__(self) -> S3Server:
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()
        self._server.server_close()


class _Handler(BaseHTTPRequestHandler):
    store: S3Server
    protocol_version = "HTTP/1.1"

    def log_message(self, *_: Any) -> None:
        pass

    def _answer(self, code: int, body: str = "", **headers: str) -> None:
        data = body.encode()
        self.send_response(code)
        length = headers.pop("length", str(len(data)))
        for name, value in {"Content-Type": "application/xml", "Content-Length": length, **headers}.items():
            self.send_header(name, value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(data)

    def _fail(self, code: int, name: str) -> None:
        self._answer(code, f"<Error><Code>{name}</Code><Message>{name} is what this server says</Message></Error>")

    def _body(self) -> bytes:
        data = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        if "aws-chunked" not in self.headers.get("Content-Encoding", ""):
            return data
        whole = b""
        while data:
            size, _, data = data.partition(b"\r\n")
            length = int(size.split(b";")[0], 16)
            if length == 0:
                break
            whole, data = whole + data[:length], data[length + 2 :]
        return whole

    def _any(self) -> None:
        address = urlsplit(self.path)
        bucket, _, key = unquote(address.path).lstrip("/").partition("/")
        query = parse_qs(address.query, keep_blank_values=True)
        body = self._body()
        store = self.store
        with store.lock:
            if not bucket:
                names = "".join(f"<Bucket><Name>{one}</Name></Bucket>" for one in sorted(store.buckets))
                self._answer(200, f"<ListAllMyBucketsResult><Buckets>{names}</Buckets></ListAllMyBucketsResult>")
            elif bucket not in store.buckets:
                self._fail(404, "NoSuchBucket")
            elif self.command in ("PUT", "POST") and store.refuses:
                self._fail(403, "AccessDenied")
            elif not key:
                self._list(bucket, query)
            elif "uploads" in query or "uploadId" in query:
                self._upload(bucket, key, query, body)
            elif self.command == "PUT":
                store.objects[bucket, key] = body
                self._answer(200, ETag='"0"')
            elif self.command == "DELETE":
                store.objects.pop((bucket, key), None)
                self._answer(204)
            elif (bucket, key) not in store.objects:
                self._fail(404, "NoSuchKey")
            else:
                self._answer(200, ETag='"0"', length=str(len(store.objects[bucket, key])))

    def _list(self, bucket: str, query: dict[str, list[str]]) -> None:
        prefix, delimiter = query.get("prefix", [""])[0], query.get("delimiter", [""])[0]
        keys, folders = [], set()
        for owner, key in sorted(self.store.objects):
            if owner != bucket or not key.startswith(prefix):
                continue
            rest = key[len(prefix) :]
            if delimiter and delimiter in rest:
                folders.add(prefix + rest.split(delimiter)[0] + delimiter)
            else:
                size = len(self.store.objects[owner, key])
                keys.append(f"<Contents><Key>{escape(key)}</Key><Size>{size}</Size><ETag>0</ETag></Contents>")
        common = "".join(f"<CommonPrefixes><Prefix>{escape(one)}</Prefix></CommonPrefixes>" for one in sorted(folders))
        self._answer(
            200,
            f"<ListBucketResult><Name>{bucket}</Name><IsTruncated>false</IsTruncated>"
            f"<KeyCount>{len(keys) + len(folders)}</KeyCount>{''.join(keys)}{common}</ListBucketResult>",
        )

    def _upload(self, bucket: str, key: str, query: dict[str, list[str]], body: bytes) -> None:
        store = self.store
        if "uploads" in query:
            number = str(len(store.uploads) + store.in_parts + 1)
            store.uploads[number] = {}
            self._answer(200, f"<InitiateMultipartUploadResult><UploadId>{number}</UploadId>"
                              f"</InitiateMultipartUploadResult>")
            return
        number = query["uploadId"][0]
        if self.command == "PUT":
            store.uploads[number][int(query["partNumber"][0])] = body
            self._answer(200, ETag='"0"')
        elif self.command == "DELETE":
            store.uploads.pop(number, None)
            self._answer(204)
        else:
            parts = store.uploads.pop(number)
            store.objects[bucket, key] = b"".join(parts[one] for one in sorted(parts))
            store.in_parts += 1
            self._answer(200, "<CompleteMultipartUploadResult><ETag>0</ETag></CompleteMultipartUploadResult>")

    do_GET = do_HEAD = do_PUT = do_POST = do_DELETE = _any
