#!/usr/bin/env bash
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# `openflc fmt` as a program: what it writes, what it leaves alone, and how it ends.
set -euo pipefail
openflc=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "fmt_command: $1" >&2; exit 1; }
expect() { [ "$2" = "$3" ] || fail "$1: expected '$3', got '$2'"; }
code_of() { local code=0; "$@" > "$folder/out" 2> "$folder/err" || code=$?; echo "$code"; }

printf 'const   float a=1;\n' > "$folder/a.fl"
chmod 640 "$folder/a.fl"
ln -s a.fl "$folder/link.fl"
expect "--check of an unformatted file" "$(code_of "$openflc" fmt --check "$folder/a.fl")" 1
grep -q 'a.fl: error: is not formatted' "$folder/err" || fail "--check does not name the file"
expect "--check writes nothing" "$(cat "$folder/a.fl")" 'const   float a=1;'
expect "fmt" "$(code_of "$openflc" fmt "$folder/link.fl")" 0
expect "fmt rewrites" "$(cat "$folder/a.fl")" 'const float a = 1;'
expect "the mode stays" "$(stat -c %a "$folder/a.fl")" 640
[ -L "$folder/link.fl" ] || fail "the link is gone"
expect "--check of a formatted file" "$(code_of "$openflc" fmt --check "$folder/a.fl")" 0
touch -d 2001-01-01 "$folder/a.fl"
expect "fmt of a formatted file" "$(code_of "$openflc" fmt "$folder/a.fl")" 0
expect "a formatted file is not written" "$(stat -c %y "$folder/a.fl" | cut -c1-4)" 2001

expect "standard input" "$(printf 'const float b=2;' | "$openflc" fmt -)" 'const float b = 2;'

printf 'const float a=;\n' > "$folder/wrong.fl"
printf 'const float c=3;\n' > "$folder/c.fl"
expect "a syntax error" "$(code_of "$openflc" fmt "$folder/wrong.fl" "$folder/c.fl")" 1
grep -q 'wrong.fl:1:15: error: ' "$folder/err" || fail "a syntax error has no place"
expect "a file with a syntax error stays" "$(cat "$folder/wrong.fl")" 'const float a=;'
expect "the others are formatted" "$(cat "$folder/c.fl")" 'const float c = 3;'
expect "a file that is not there" "$(code_of "$openflc" fmt "$folder/none.fl")" 3
expect "no file" "$(code_of "$openflc" fmt)" 2
expect "nothing is left over" "$(ls "$folder" | tr '\n' ' ')" 'a.fl c.fl err link.fl out wrong.fl '
