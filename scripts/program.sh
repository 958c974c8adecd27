# To be sourced by the other scripts: sets `project`, and A2 to the program built here unless the caller chose another.
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [ -z "${A2:-}" ]; then
    cargo build --release --quiet --manifest-path "$project/Cargo.toml"
    A2=${CARGO_TARGET_DIR:-$project/target}/release/a2
fi
export A2
