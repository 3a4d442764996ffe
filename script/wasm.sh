# Sourced after lib.sh: a Rust compiler with a standard library for browsers, and the sources of that library for other systems.

WASM_TARGET=wasm32-unknown-unknown

# Debian packages that make up a private compiler where the system's own has no such library. They are of one version;
# the library serves no other compiler.
WASM_PACKAGES="rustc rust-src libstd-rust-dev-wasm32"

# Whether the compiler $1 knows the target and has its library, which `--print` does not look for.
compiles_wasm() {
    local folder
    folder=$("$1" --print target-libdir --target "$WASM_TARGET" </dev/null 2>/dev/null) || return 1
    [ -n "$(find "$folder" -name 'libcore-*.rlib' 2>/dev/null)" ]
}

# Whether the compiler $1 is as new as Lumivox needs.
rustc_is_new_enough() {
    local version oldest
    version=$("$1" --version </dev/null 2>/dev/null | cut -d' ' -f2) || return 1
    case $version in [0-9]*.[0-9]*) ;; *) return 1 ;; esac
    oldest=$(printf '%s\n%s\n' "$RUST_VERSION" "${version%%-*}" | sort -t. -k1,1n -k2,2n | head -n 1)
    [ "$oldest" = "$RUST_VERSION" ]
}

# Sets and exports RUSTC: the one that is asked for, the system's, or a private one from Debian.
need_wasm_rust() {
    local help="Install the library for your own compiler with
    rustup target add $WASM_TARGET
and run this again."
    if [ -n "${RUSTC:-}" ]; then
        compiles_wasm "$RUSTC" || die "RUSTC=$RUSTC has no standard library for $WASM_TARGET. $help"
        export RUSTC
        return 0
    fi
    RUSTC=rustc
    export RUSTC
    ! compiles_wasm "$RUSTC" || return 0
    need_debian_rust "$WASM_TARGET" "$help"
}

# Sets and exports RUSTC: a private one from Debian. $1 is what the system's own has no library for, $2 how it would get one.
need_debian_rust() {
    local help=$2 folder=${CARGO_TARGET_DIR:-target}/wasm-rust
    case $folder in /*) ;; *) folder=$PWD/$folder ;; esac
    RUSTC=$folder/rustc
    export RUSTC
    [ -e "$folder/root/usr/lib/rustlib/src" ] && [ -x "$RUSTC" ] && rustc_is_new_enough "$RUSTC" && compiles_wasm "$RUSTC" && return 0
    [ "$(uname -s) $(uname -m)" = "Linux x86_64" ] && command -v apt-get >/dev/null 2>&1 &&
        command -v dpkg-deb >/dev/null 2>&1 || die "This Rust has no standard library for $1. $help"
    [ -e "$DEBIAN_KEYRING" ] || die "This Rust has no standard library for $1. $help
One can be fetched from Debian, too, once 'debian-archive-keyring' is installed."
    local mirrors mirror fetched=
    mirrors=$(debian_mirrors)
    [ -n "$mirrors" ] || die "This Rust has no standard library for $1, and apt's sources name no mirror of Debian to fetch one from. $help
Or name a mirror, as apt's sources would:
    DEBIAN_MIRROR=URI $0"
    say "This Rust has no standard library for $1: fetching one from Debian, with its compiler, into $folder (nothing is installed)"
    for mirror in $mirrors; do
        if fetch_wasm_rust "$folder" "$mirror"; then
            fetched=1
            break
        fi
    done
    [ -n "$fetched" ] || die "The compiler could not be fetched from $mirror (see $folder/log). $help
Or name another mirror of Debian:
    DEBIAN_MIRROR=URI $0"
    compiles_wasm "$RUSTC" || die "The compiler from Debian does not run here (see $folder/log). $help"
    rustc_is_new_enough "$RUSTC" || die "Debian's compiler is older than Rust $RUST_VERSION. $help"
}

# Unpacks Debian's compiler from the mirror $2 into the folder $1.
fetch_wasm_rust() (
    # Nothing is left to `set -e`, which nothing heeds where the caller looks at the outcome.
    # Unquoted on purpose: a list of words.
    # shellcheck disable=SC2086
    fetch_debian "$1" "$2 forky" $WASM_PACKAGES && cd "$1" || exit 1
    # With its own loader and libraries, so that the system's age does not matter.
    cat >rustc <<'RUN' || exit 1
#!/bin/sh
root=$(cd "$(dirname "$0")" && pwd)/root
exec "$root/usr/lib64/ld-linux-x86-64.so.2" --argv0 rustc --library-path "$root/usr/lib/x86_64-linux-gnu" \
    "$root/usr/bin/rustc" --sysroot "$root/usr" "$@"
RUN
    chmod +x rustc
)
