#!/usr/bin/env bash
# Measures how often the stated error holds the true one: 100 seeds of every scene, sampler and number of samples, and
# scenes made to deceive. Writes docs/error-coverage.md. Some minutes on two cores.
set -euo pipefail
cd "$(dirname "$0")/.."
rows=$(cargo test --profile ci --test pictures -- --ignored --nocapture in_every_row)
{
    cat <<'HEAD'
# How often the stated error holds

Made by `scripts/error_coverage.sh`; do not edit. 100 seeds a row, 32 x 32 pixels. A row is right if 90% or more of the
true errors lie in the stated 95% interval. *Stated / true MSE* compares the means of both over the seeds. *Error of the
mean / expected* is 1 if the pictures are unbiased: the squared error of the mean of 100 pictures, as a multiple of what
their spread lets expect. Rows with `-time-limit` depend on how busy the machine is. How the error is estimated:
[error-estimate.md](error-estimate.md).

HEAD
    grep -E '^\||^Rows' <<<"$rows" | sed 's/^Rows/\nRows/'
} > docs/error-coverage.md
