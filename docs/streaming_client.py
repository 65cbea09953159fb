#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Sends an .ofr file to a receiver: streaming_client.py FILE.ofr tcp://HOST:PORT|tls://HOST:PORT|unix:PATH

A sender's side of the protocol (streaming.md), with Python's standard library alone. The token comes from OPENFAB_TOKEN;
trusted certificates for tls:// come from the file OPENFAB_TLS_CA, or else from the system.
"""
import os
import secrets
import socket
import ssl
import struct
import sys
import time

MAGIC, VERSION = b"\x89OFL\r\n\x1a\n", 1
ANEW, GO_ON = 0, 1
AGAIN = 4  # STOP: send it again
LOST_SECONDS = 60


def read_print(path):
    """Returns the header, the slices by z, and the index of an .ofr file, as bytes."""
    with open(path, "rb") as file:
        data = file.read()
    at = 16 + struct.unpack_from("<I", data, 12)[0] + 8
    header, slices = data[:at], {}
    while data[at : at + 4] == b"SLCE":
        z, frame = struct.unpack_from("<iI", data, at + 4)
        slices[z] = data[at : at + 32 + frame]
        at += 32 + frame
    if data[at : at + 4] != b"INDX":
        sys.exit(f"{path}: is not complete")
    return header, slices, data[at:]


class Line:
    """A connection for messages: four letters, a length, and that many bytes."""

    def __init__(self, address):
        if address.startswith("unix:"):
            self.socket = socket.socket(socket.AF_UNIX)
            self.socket.connect(address[5:])
        else:
            host, port = address[6:].rsplit(":", 1)
            self.socket = socket.create_connection((host.strip("[]"), int(port)), 5)
            if address.startswith("tls:"):
                trusted = ssl.create_default_context(cafile=os.environ.get("OPENFAB_TLS_CA"))
                self.socket = trusted.wrap_socket(self.socket, server_hostname=host.strip("[]"))
        self.socket.settimeout(30)

    def send(self, kind, data=b""):
        self.socket.sendall(kind + struct.pack("<I", len(data)) + data)

    def read(self, size):
        data = b""
        while len(data) < size:
            more = self.socket.recv(size - len(data))
            if not more:
                raise ConnectionError("the line was cut")
            data += more
        return data

    def hear(self):
        """Returns the next message that is not `ALIV`, which is answered."""
        while True:
            head = self.read(8)
            data = self.read(struct.unpack_from("<I", head, 4)[0])
            if head[:4] == b"STOP":
                code, text = struct.unpack_from("<I", data)[0], data[8:].decode(errors="replace")
                raise ConnectionError(text) if code == AGAIN else SystemExit(f"the receiver says: {text}")
            if head[:4] != b"ALIV":
                return head[:4], data
            self.send(b"ALIV")


def send_print(line, mode, sender, header, slices, index):
    """Sends the slices that the receiver does not have; at most a window of them waits for acknowledgement."""
    token = os.environ.get("OPENFAB_TOKEN", "").encode()
    line.send(b"OPEN", MAGIC + struct.pack("<IIQI", VERSION, mode, sender, len(token)) + token
              + struct.pack("<I", len(header)) + header)
    kind, data = line.hear()
    acknowledged, window, complete = struct.unpack("<iII", data)
    next_z, end = acknowledged, max(slices) + 1
    while acknowledged < end:
        if next_z < min(end, acknowledged + window):
            line.send(b"SLCE", slices[next_z])
            next_z += 1
            continue
        kind, data = line.hear()
        if kind == b"ACKN":
            acknowledged = struct.unpack("<i", data)[0] + 1
    if not complete:
        line.send(b"DONE", index)
        while line.hear()[0] != b"DONE":
            pass
    line.send(b"STOP", struct.pack("<II", 0, 0))


def main(path, address):
    header, slices, index = read_print(path)
    sender, mode, lost = secrets.randbits(64), ANEW, time.monotonic()
    while True:
        try:
            line = Line(address)
            lost = time.monotonic()
            return send_print(line, mode, sender, header, slices, index)
        except OSError as error:
            if time.monotonic() - lost > LOST_SECONDS:
                sys.exit(f"{address}: {error}")
            mode = GO_ON
            time.sleep(0.2)


if __name__ == "__main__":
    main(*sys.argv[1:])
