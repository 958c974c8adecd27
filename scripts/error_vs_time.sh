#!/usr/bin/env bash
# Measures error against run time for the scenes of data/ and writes docs/error-vs-time.md with its curves and raw
# numbers. Two to ten minutes on two cores. SIZE=N changes the pictures' size (default 100 x 100); PARTS="..." does only
# some of: curves samples bounces f32 povray page. The f32 part needs a second build, the povray part Debian's package povray.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release --quiet
exec python3 scripts/error_vs_time.py "$@"
