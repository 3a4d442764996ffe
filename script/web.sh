# Sourced after lib.sh and wasm.sh: what is for browsers, the Studio as a page and the npm package, folders of static files.

# The program that binds WebAssembly to JavaScript is of one version with the library of that name, see Cargo.toml.
WASM_BINDGEN_VERSION=0.2.108

# Debian packages with that program, with what makes WebAssembly smaller, and with a linker.
WEB_PACKAGES="wasm-bindgen binaryen lld"

target_folder() {
    local folder=${CARGO_TARGET_DIR:-target}
    case $folder in /*) ;; *) folder=$PWD/$folder ;; esac
    printf '%s\n' "$folder"
}

# Whether the programs of WEB_PACKAGES are in the folder $1.
has_web_tools() {
    [ "$("$1/wasm-bindgen" --version </dev/null 2>/dev/null)" = "wasm-bindgen $WASM_BINDGEN_VERSION" ] &&
        "$1/wasm-opt" --version >/dev/null 2>&1 </dev/null && "$1/wasm-ld" --version >/dev/null 2>&1 </dev/null
}

# Sets WEB_TOOLS, a folder with wasm-bindgen, wasm-opt and wasm-ld: from Debian, private to this project.
need_web_tools() {
    WEB_TOOLS=${LUMIVOX_WEB_TOOLS:-$(target_folder)/web-tools}
    has_web_tools "$WEB_TOOLS" && return 0
    local help="Install wasm-bindgen $WASM_BINDGEN_VERSION, binaryen and lld, and name a folder with wasm-bindgen, wasm-opt and wasm-ld:
    LUMIVOX_WEB_TOOLS=FOLDER $0"
    [ -z "${LUMIVOX_WEB_TOOLS:-}" ] || die "The folder $LUMIVOX_WEB_TOOLS lacks some of them. $help"
    [ "$(uname -s) $(uname -m)" = "Linux x86_64" ] && command -v apt-get >/dev/null 2>&1 &&
        command -v dpkg-deb >/dev/null 2>&1 && [ -e "$DEBIAN_KEYRING" ] || die "Programs for WebAssembly are missing. $help"
    local mirrors mirror fetched=
    mirrors=$(debian_mirrors)
    [ -n "$mirrors" ] || die "Programs for WebAssembly are missing, and apt's sources name no mirror of Debian. $help"
    say "Fetching wasm-bindgen, binaryen and a linker from Debian into $WEB_TOOLS (nothing is installed)"
    for mirror in $mirrors; do
        if fetch_web_tools "$WEB_TOOLS" "$mirror"; then
            fetched=1
            break
        fi
    done
    [ -n "$fetched" ] || die "They could not be fetched (see $WEB_TOOLS/log). $help"
    has_web_tools "$WEB_TOOLS" || die "Those of Debian are others by now. $help"
}

# Unpacks them from the mirror $2 into the folder $1.
fetch_web_tools() (
    # Nothing is left to `set -e`, which nothing heeds where the caller looks at the outcome.
    # Unquoted on purpose: a list of words.
    # shellcheck disable=SC2086
    fetch_debian "$1" "$2 forky" $WEB_PACKAGES && cd "$1" || exit 1
    # With their own loader and libraries, so that the system's age does not matter.
    for program in wasm-bindgen wasm-opt wasm-ld; do
        cat >"$program" <<RUN || exit 1
#!/bin/sh
root=\$(cd "\$(dirname "\$0")" && pwd)/root
exec "\$root/usr/lib64/ld-linux-x86-64.so.2" --argv0 $program --library-path "\$root/usr/lib/x86_64-linux-gnu" \\
    "\$root/usr/bin/$program" "\$@"
RUN
        chmod +x "$program" || exit 1
    done
)

# What browsers that have WebGPU have, too, and the compiler uses.
WASM_FEATURES="--enable-bulk-memory --enable-nontrapping-float-to-int --enable-sign-ext --enable-mutable-globals --enable-multivalue --enable-reference-types"

# Refuses a folder $1 that holds something else than what is made there, which has a file $2.
need_own_folder() {
    # That file is made, and in no folder of the sources.
    [ ! -e "$1" ] || [ -e "$1/$2" ] || { [ -d "$1" ] && [ -z "$(ls -A "$1")" ]; } ||
        die "$1 holds something else; name another folder."
}

# What a version is known by: the hash of what is read.
fingerprint() {
    if command -v sha256sum >/dev/null 2>&1; then sha256sum; else shasum -a 256; fi | cut -c 1-16
}

# Cargo's word $1 for browsers, with more of its words. The compiler and WEB_TOOLS are there.
wasm_cargo() {
    local target
    target=$(target_folder)
    # In a folder of its own: what another compiler has made serves nobody else.
    # What is built lies within the sources mostly.
    CARGO_ENCODED_RUSTFLAGS=$(nameless "$PWD=/lumivox" "${CARGO_HOME:-$HOME/.cargo}/registry/src=/crates" "$target=/target") \
        CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=$WEB_TOOLS/wasm-ld CARGO_PROFILE_RELEASE_DEBUG=false \
        "${CARGO:-cargo}" "$1" ${CI:+--locked} --release --quiet --target "$WASM_TARGET" --target-dir "$target/wasm" --lib "${@:2}" </dev/null
}

# Compiles the package $1 for browsers, and binds it to JavaScript by the name $2 in the folder $3. Where AS_COMPILED says so, it is left as large
# and slow as it comes out of the compiler.
bind_wasm() {
    local target
    target=$(target_folder)
    need_wasm_rust
    need_web_tools
    wasm_cargo rustc --package "$1" --crate-type cdylib || die "$1 does not compile for $WASM_TARGET, see above."
    "$WEB_TOOLS/wasm-bindgen" --target web --no-typescript --out-dir "$3" --out-name "$2" \
        "$target/wasm/$WASM_TARGET/release/${1//-/_}.wasm" || die "wasm-bindgen fails, see above."
    [ -z "${AS_COMPILED:-}" ] || return 0
    # Unquoted on purpose: a list of words.
    # shellcheck disable=SC2086
    "$WEB_TOOLS/wasm-opt" -O2 $WASM_FEATURES "$3/$2_bg.wasm" -o "$3/$2_bg.wasm.small" || die "wasm-opt fails, see above."
    mv "$3/$2_bg.wasm.small" "$3/$2_bg.wasm"
}

# Puts what is in the folder $1 in place of an older $2 that has a file $3.
put_in_place() {
    # The folder itself stays: a server may look at it.
    need_own_folder "$2" "$3"
    mkdir -p "$2" && rm -rf "${2:?}"/* && mv "$1"/* "$2"
}

# Megabytes of the file $1 as browsers fetch it.
fetched_size() {
    gzip -9 -c "$1" | wc -c | awk '{ printf "%.1f MB", $1 / 1e6 }'
}

# Writes the page to the folder $1, in place of an older one once it is whole. By a shell of its own: the compiler for browsers is none for what runs here.
make_page() (
    # Nothing is left to `set -e`, which nothing heeds where the caller looks at the outcome.
    need_own_folder "$1" lumivox_studio_bg.wasm
    mkdir -p "$(target_folder)" && new=$(mktemp -d "$(target_folder)/studio-web.XXXXXX") || die "No folder can be made in $(target_folder)."
    trap 'rm -rf "$new"' EXIT
    bind_wasm lumivox-studio lumivox_studio "$new"
    # What pages that somebody shares show a scan with.
    mkdir "$new/viewer" && bind_wasm lumivox-js lumivox_wasm "$new/viewer" &&
        cp apps/studio/web/* "$new" && cp js/package/lumivox.js "$new/viewer" || die "The page cannot be put together in $new."
    # Another version is another cache.
    version=$(find "$new" -type f -exec cat {} + | fingerprint) && sed "s/VERSION/$version/" apps/studio/web/offline.js >"$new/offline.js" ||
        die "The page cannot be put together in $new."
    put_in_place "$new" "$1" lumivox_studio_bg.wasm || die "The page cannot be put into $1."
    say "The page is in $1: $(fetched_size "$1/lumivox_studio_bg.wasm") as browsers fetch its program"
)

# Writes the npm package to the folder $1, in the same way.
make_npm() (
    need_own_folder "$1" lumivox_wasm_bg.wasm
    mkdir -p "$(target_folder)" && new=$(mktemp -d "$(target_folder)/npm.XXXXXX") || die "No folder can be made in $(target_folder)."
    trap 'rm -rf "$new"' EXIT
    bind_wasm lumivox-js lumivox_wasm "$new"
    version=$(sed -n '/^\[workspace.package\]/,/^\[workspace.dep/s/^version = "\(.*\)"$/\1/p' Cargo.toml)
    [ -n "$version" ] && cp js/package/* js/README.md LICENSE-MIT LICENSE-APACHE "$new" &&
        sed "s/\"VERSION\"/\"$version\"/" js/package/package.json >"$new/package.json" || die "The package cannot be put together in $new."
    put_in_place "$new" "$1" lumivox_wasm_bg.wasm || die "The package cannot be put into $1."
    say "The npm package is in $1: $(fetched_size "$1/lumivox_wasm_bg.wasm") as browsers fetch its program"
)

# Prints a Chromium: the one that is named, the system's, or a private one from Debian of this system's own release.
find_chromium() {
    local program
    if [ -n "${LUMIVOX_CHROMIUM:-}" ]; then
        printf '%s\n' "$LUMIVOX_CHROMIUM"
        return 0
    fi
    for program in chromium google-chrome-stable google-chrome; do
        command -v "$program" && return 0
    done
    program=$(target_folder)/chromium/chromium
    [ ! -x "$program" ] || { printf '%s\n' "$program"; return 0; }
    local release mirror
    release=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release 2>/dev/null)
    if [ -e "$DEBIAN_KEYRING" ] && grep -qx 'ID=debian' /etc/os-release; then
        for mirror in $(debian_mirrors); do
            say "Fetching Chromium from Debian into ${program%/*} (nothing is installed)" >&2
            if fetch_chromium "${program%/*}" "$mirror $release"; then
                printf '%s\n' "$program"
                return 0
            fi
        done
    fi
    return 1
}

# Unpacks it from $2 into the folder $1.
fetch_chromium() (
    fetch_debian "$1" "$2" chromium && cd "$1" || exit 1
    cat >chromium <<'RUN' || exit 1
#!/bin/sh
root=$(cd "$(dirname "$0")" && pwd)/root
LD_LIBRARY_PATH=$root/usr/lib/x86_64-linux-gnu:$root/usr/lib/x86_64-linux-gnu/pulseaudio:$root/lib/x86_64-linux-gnu:$root/usr/lib/chromium \
    exec "$root/usr/lib/chromium/chromium" "$@"
RUN
    chmod +x chromium
)

# Prints the same, or says what to do where there is none.
need_chromium() {
    find_chromium || die "There is no Chromium. Install one, or name one:
    LUMIVOX_CHROMIUM=PROGRAM $0 ..."
}

# Tries what is in the folder $1 in a browser, by the word $3 of `xtask web`; pictures go to $2.
try_in_browser() {
    local chromium scan lumivox
    chromium=$(need_chromium) || exit 1
    scan=$(mktemp -d)
    # By the program that there is already, where there is one.
    lumivox=("${CARGO:-cargo}" run --release --quiet --package lumivox --)
    [ -z "${LUMIVOX_COMMAND:-}" ] || lumivox=("$LUMIVOX_COMMAND")
    "${lumivox[@]}" phantom head --size 32 --out "$scan/head" </dev/null >"$scan/log" 2>&1 ||
        { cat "$scan/log" >&2; rm -rf "$scan"; die "The phantom could not be made, see above."; }
    if xtask web "$3" "$1" "$chromium" "$scan/head" "$2"; then
        rm -rf "$scan"
    else
        rm -rf "$scan"
        return 1
    fi
}
